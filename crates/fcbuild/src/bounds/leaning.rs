//! Which planes below and above a border are worth a look.
//!
//! Whatever is chosen here, what is measured between the planes holds; so single precision is enough.

use super::gaze::{Gaze, Seen};
use super::slab::Points;
use super::support::{Slope, farther};
use glam::{Vec2, Vec3, Vec4};

/// Slopes at most, with the level one.
pub(super) const MOST: usize = 4;

/// Of more points about so many fours are looked at: which ones of large clusters are far away, some of them tell.
const MOST_FOURS: usize = 24;

/// How often a plane is leant to come nearer to a point.
const LEANS: u32 = 6;

/// By what share a lean would bring a plane nearer if it touched the border at the same vertex.
const NEARER_BY: f32 = 0.5;

/// Slopes are added as long as one brings the farthest point nearer than this share.
const WORTH: f32 = 0.97;

/// No plane is steeper: beyond, what chords see of points would no longer be bounded.
const STEEPEST: f32 = 2.0;

/// Four points as they are seen from one of the border's.
#[derive(Clone, Copy, Debug)]
struct Four {
    x: Vec4,
    y: Vec4,
    height: Vec4,
}

impl Four {
    /// How high they are over a plane through the origin.
    #[inline(always)]
    fn over(&self, slope: Vec2) -> Vec4 {
        self.height - slope.x * self.x - slope.y * self.y
    }
}

/// The memory of choices, one after the other.
#[derive(Debug, Default)]
pub(super) struct Leaning {
    fours: Vec<Four>,
    /// How far each point is over the highest plane below the border, and under the lowest one above.
    apart: Vec<[Vec4; 2]>,
    slopes: Vec<Slope>,
}

impl Leaning {
    /// The slopes of planes over and under a cluster's border that come near its points and others; the level one first.
    /// And about how far the farthest point above the polygon is then, and the farthest below.
    pub(super) fn slopes(
        &mut self,
        gaze: Gaze,
        points: &Points<'_>,
        beyond: &[Seen],
    ) -> (&[Slope], [f32; 2]) {
        self.slopes.clear();
        self.slopes.push(Slope::default());
        self.gather(gaze, points, beyond);
        let border = points.border.end;
        let mut slope = Vec2::ZERO;
        loop {
            let apart = self.bring_near(border, slope);
            let side = usize::from(apart[1] > apart[0]);
            let next =
                if self.slopes.len() < MOST { self.lean(border, side, apart[side], slope) } else { None };
            let Some(next) = next else { return (&self.slopes, apart) };
            slope = next.get().as_vec2();
            self.slopes.push(next);
        }
    }

    /// Takes the points in, those of the border first.
    fn gather(&mut self, gaze: Gaze, points: &Points<'_>, beyond: &[Seen]) {
        self.fours.clear();
        let Some(origin) = points.all.first() else { return };
        let rows = gaze.rows().map(|row| row.as_vec3());
        let four = |[x, y, height]: [Vec4; 3]| Four { x, y, height };
        self.fours.extend(points.all.products(points.border.clone(), 1, rows, origin).map(four));
        let step = (points.inside.len() / MOST_FOURS).max(1);
        self.fours.extend(points.all.products(points.inside.clone(), step, rows, origin).map(four));
        let origin = gaze.see(origin.as_dvec3());
        let (fours, rest) = beyond.as_chunks::<4>();
        let four = |four: [&Seen; 4]| {
            let from =
                |part: fn(&Seen) -> f64| Vec4::from(four.map(|seen| (part(seen) - part(&origin)) as f32));
            Four { x: from(|seen| seen.at.x), y: from(|seen| seen.at.y), height: from(|seen| seen.height) }
        };
        let step = (fours.len() / MOST_FOURS).max(1);
        self.fours.extend(fours.iter().step_by(step).map(|[a, b, c, d]| four([a, b, c, d])));
        self.fours.extend(rest.iter().map(|seen| four([seen; 4])));
        self.apart.clear();
        self.apart.resize(self.fours.len(), [Vec4::INFINITY; 2]);
    }

    /// Adds planes with a slope. Returns how far the farthest points above and below still are.
    fn bring_near(&mut self, border: usize, slope: Vec2) -> [f32; 2] {
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for four in &self.fours[..border] {
            let h = four.over(slope);
            low = low.min(h);
            high = high.max(h);
        }
        let (low, high) = (Vec4::splat(low.min_element()), Vec4::splat(high.max_element()));
        let factor = farther(slope.as_dvec2()) as f32;
        let mut most = [Vec4::ZERO; 2];
        for (four, [above, below]) in self.fours.iter().zip(&mut self.apart) {
            let h = four.over(slope);
            *above = above.min((h - low) * factor);
            *below = below.min((high - h) * factor);
            most = [most[0].max(*above), most[1].max(*below)];
        }
        most.map(Vec4::max_element)
    }

    /// The first of the farthest points on a side, all of which are this far.
    fn farthest(&self, side: usize, far: f32) -> Option<Vec3> {
        let is_farthest = |sides: &[Vec4; 2]| sides[side].cmpeq(Vec4::splat(far)).bitmask();
        let group = self.apart.iter().position(|sides| is_farthest(sides) != 0)?;
        let lane = is_farthest(&self.apart[group]).trailing_zeros() as usize;
        let Four { x, y, height } = self.fours[group];
        Some(Vec3::from([x, y, height].map(|lanes| lanes.to_array()[lane])))
    }

    /// A slope at which planes come nearer to a point that is `now` far above the border, on side 0, or below it; they turn
    /// away from the vertex that they touch.
    fn lean(&self, border: usize, side: usize, now: f32, from: Vec2) -> Option<Slope> {
        let point = self.farthest(side, now)?;
        let (at, sign) = (point.truncate(), if side == 0 { 1.0 } else { -1.0 });
        // How far planes with a slope are, and the vertex of the border that they touch.
        let look = |slope: Vec2| {
            let over = Vec4::splat(point.z - slope.dot(at));
            let (mut most, mut x, mut y) = (Vec4::NEG_INFINITY, Vec4::ZERO, Vec4::ZERO);
            for four in &self.fours[..border] {
                let far = (over - four.over(slope)) * sign;
                let is_more = far.cmpgt(most);
                most = Vec4::select(is_more, far, most);
                x = Vec4::select(is_more, four.x, x);
                y = Vec4::select(is_more, four.y, y);
            }
            let far = most.max_element();
            let lane = most.cmpeq(Vec4::splat(far)).bitmask().trailing_zeros().min(3) as usize;
            (far * farther(slope.as_dvec2()) as f32, Vec2::new(x.to_array()[lane], y.to_array()[lane]))
        };
        let mut slope = from;
        let (mut far, mut touched) = look(slope);
        let mut share = NEARER_BY;
        for _ in 0..LEANS {
            let across = at - touched;
            let next = slope + across * (sign * share * far / across.length_squared());
            // Not a number where the point is that vertex.
            if next.is_nan() {
                break;
            }
            if next.length_squared() > STEEPEST * STEEPEST {
                share *= 0.5;
                continue;
            }
            let (there, vertex) = look(next);
            if there < far {
                (slope, far, touched) = (next, there, vertex);
            } else {
                share *= 0.5;
            }
        }
        (far < WORTH * now).then_some(Slope::near(slope))
    }
}
