//! Detail that is steered to a time per frame.
//!
//! Nothing is known of the machine but the times of the frames drawn. Triangles grow about as fast as the tolerance shrinks,
//! and a frame takes some time whatever it draws. So a tolerance that changes by a factor changes the time by about that or
//! less: cautious steps do not go too far, only not far enough.
//!
//! Times jitter. A frame's time stands for its tolerance only as the median of a few, a tolerance is left alone while its
//! time is about right, and once it was right it takes a clear miss to move it again.

use crate::options::Detail;

/// Times whose median counts: one odd frame of three has no say.
const FRAMES: usize = 3;

/// How far off, as a part of the time asked for, the time may be before the tolerance moves again.
const LEAVE: f64 = 0.15;

/// How near the time must come before the tolerance rests.
const ARRIVE: f64 = 0.05;

/// The most that a tolerance changes in one step.
const STEP: f64 = 2.0;

/// Steps are this power of what would be right if the time fell as the tolerance grows: it may fall somewhat faster, and
/// then a full step would go too far.
const CAUTION: f64 = 0.7;

/// The finest and the coarsest tolerance, pixels: finer is not seen, coarser not recognised.
const PIXELS: std::ops::RangeInclusive<f64> = 0.1..=64.0;

/// Steers the tolerance in pixels that a budget of time comes to.
#[derive(Clone, Debug)]
pub struct Steering {
    /// Milliseconds a frame may take.
    target: f64,
    pixels: f64,
    /// The last times with this tolerance.
    times: Vec<f64>,
    resting: bool,
}

impl Steering {
    /// Steers to `fps` frames a second.
    pub fn new(fps: f64) -> Steering {
        Steering { target: 1e3 / fps, pixels: 2.0, times: Vec::with_capacity(FRAMES), resting: false }
    }

    /// The detail of the next frame.
    pub fn detail(&self) -> Detail {
        Detail::Gain(self.pixels)
    }

    /// Learns that a frame of this detail took so many milliseconds. Returns whether another frame may move it, for who
    /// draws only when something changes.
    pub fn note(&mut self, milliseconds: f64) -> bool {
        if !(milliseconds > 0.0 && milliseconds.is_finite()) {
            return false;
        }
        self.times.push(milliseconds);
        if self.times.len() < FRAMES {
            return !self.resting;
        }
        self.times.sort_by(f64::total_cmp);
        let typical = self.times.get(FRAMES / 2).copied().unwrap_or(self.target);
        self.times.clear();
        let off = typical / self.target - 1.0;
        self.resting = off.abs() <= if self.resting { LEAVE } else { ARRIVE };
        if self.resting {
            return false;
        }
        let before = self.pixels;
        self.pixels = (before * (1.0 + off).powf(CAUTION).clamp(1.0 / STEP, STEP))
            .clamp(*PIXELS.start(), *PIXELS.end());
        self.pixels != before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// What a machine takes for a frame: `fixed` ms, and `each` ms at one pixel, falling with a power of the tolerance.
    #[derive(Clone, Copy, Debug)]
    struct Load {
        fixed: f64,
        each: f64,
        power: f64,
    }

    impl Load {
        fn time(&self, pixels: f64) -> f64 {
            self.fixed + self.each * pixels.powf(-self.power)
        }
    }

    /// Draws frames, whose times jitter by a part of them. Returns their tolerances and exact times.
    fn run(
        steering: &mut Steering,
        frames: usize,
        load: Load,
        jitter: f64,
        random: &mut Random,
    ) -> Vec<(f64, f64)> {
        let one = |_| {
            let pixels = steering.pixels;
            let exact = load.time(pixels);
            steering.note(exact * (1.0 + jitter * (2.0 * random.unit() - 1.0)));
            (pixels, exact)
        };
        (0..frames).map(one).collect()
    }

    /// How often the tolerance turns round.
    fn turns(frames: &[(f64, f64)]) -> usize {
        let moved = frames.windows(2).filter(|pair| pair[0].0 != pair[1].0);
        let mut ups: Vec<bool> = moved.map(|pair| pair[0].0 < pair[1].0).collect();
        ups.dedup();
        ups.len().saturating_sub(1)
    }

    #[test]
    fn fast_and_slow_machines_come_to_the_time_asked_for_and_rest() {
        let mut random = Random::new(3);
        for (fixed, each) in [(1.0, 10.0), (5.0, 200.0), (20.0, 60.0), (0.0, 300.0), (30.0, 20.0)] {
            for power in [0.6, 0.8, 1.0, 1.2] {
                let load = Load { fixed, each, power };
                let mut steering = Steering::new(25.0);
                let frames = run(&mut steering, 300, load, 0.0, &mut random);
                let (last, time) = frames[299];
                assert!((time / 40.0 - 1.0).abs() <= ARRIVE, "{time} ms with {load:?}");
                assert_eq!(turns(&frames), 0, "{load:?}: it went too far");
                assert!(frames[200..].iter().all(|(pixels, _)| *pixels == last), "{load:?} never rests");
            }
        }
    }

    #[test]
    fn jitter_does_not_make_it_oscillate() {
        let mut random = Random::new(4);
        let load = Load { fixed: 8.0, each: 40.0, power: 0.9 };
        let mut steering = Steering::new(30.0);
        run(&mut steering, 100, load, 0.1, &mut random);
        let frames = run(&mut steering, 600, load, 0.1, &mut random);
        assert!(turns(&frames) <= 2, "{} turns in 600 frames", turns(&frames));
        for (pixels, time) in &frames {
            assert!((time * 30.0 / 1e3 - 1.0).abs() < 0.2, "{time} ms at {pixels} pixels");
        }
    }

    #[test]
    fn one_slow_frame_changes_nothing() {
        let mut random = Random::new(5);
        let load = Load { fixed: 8.0, each: 40.0, power: 0.9 };
        let mut steering = Steering::new(30.0);
        run(&mut steering, 120, load, 0.0, &mut random);
        let before = steering.pixels;
        for _ in 0..10 {
            steering.note(900.0);
            run(&mut steering, 5, load, 0.0, &mut random);
        }
        assert_eq!(steering.pixels, before);
    }

    #[test]
    fn it_follows_when_the_load_changes() {
        let mut random = Random::new(6);
        let mut steering = Steering::new(20.0);
        for each in [40.0, 200.0, 20.0, 40.0] {
            let load = Load { fixed: 5.0, each, power: 0.9 };
            let frames = run(&mut steering, 120, load, 0.02, &mut random);
            let (_, time) = frames[119];
            assert!((time / 50.0 - 1.0).abs() <= LEAVE + 0.01, "{time} ms with {load:?}");
            assert!(turns(&frames) <= 1, "{load:?}");
        }
    }

    #[test]
    fn what_cannot_be_reached_ends_at_the_limits() {
        let mut random = Random::new(7);
        let mut slow = Steering::new(60.0);
        run(&mut slow, 200, Load { fixed: 100.0, each: 10.0, power: 1.0 }, 0.0, &mut random);
        assert_eq!(slow.detail(), Detail::Gain(64.0));
        let mut fast = Steering::new(10.0);
        run(&mut fast, 200, Load { fixed: 1.0, each: 1.0, power: 1.0 }, 0.0, &mut random);
        assert_eq!(fast.detail(), Detail::Gain(0.1));
        for odd in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!fast.note(odd));
        }
        assert_eq!(fast.detail(), Detail::Gain(0.1));
    }
}
