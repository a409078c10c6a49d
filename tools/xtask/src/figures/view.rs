//! Where a model is seen from, and how it fits the picture.

use glam::DVec3;

/// An orthographic view: three unit vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// To the right of the picture.
    pub(crate) right: DVec3,
    /// To its top.
    pub(crate) up: DVec3,
    /// Out of it, to whoever looks.
    pub(crate) toward: DVec3,
}

impl View {
    /// From the direction `toward`, which is not vertical, with Y upright.
    pub(crate) fn from(toward: [f64; 3]) -> View {
        let toward = DVec3::from(toward).normalize_or(DVec3::Z);
        let right = DVec3::Y.cross(toward).normalize_or(DVec3::X);
        View { right, up: toward.cross(right), toward }
    }
}

impl View {
    /// From the side of a cut across `axis`, and somewhat from where this view looks: the cut runs away from the eye
    /// instead of along its picture plane.
    pub(crate) fn beside(&self, axis: DVec3) -> View {
        let side = axis.cross(DVec3::Y).normalize_or(self.toward);
        let side = if side.dot(self.toward) < 0.0 { -side } else { side };
        View::from((side + self.toward * 0.35).to_array())
    }
}

/// Share of the picture's width that stays free on either side.
const MARGIN: f64 = 0.03;

/// A view with its scale: the same for all pictures of a model, so that they can be compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// Where from.
    pub(crate) view: View,
    /// Pixels.
    pub(crate) width: usize,
    /// Pixels.
    pub(crate) height: usize,
    /// Pixels per unit of length.
    scale: f64,
    /// What is in the middle of the picture, along `right` and `up`.
    middle: [f64; 2],
}

impl Frame {
    /// As large as `points` fit into `width` pixels, and at most `height`; the height is cut to what they need.
    pub(crate) fn around(
        view: View,
        points: impl Iterator<Item = DVec3>,
        width: usize,
        height: usize,
    ) -> Frame {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points {
            for (k, x) in [p.dot(view.right), p.dot(view.up)].into_iter().enumerate() {
                low[k] = low[k].min(x);
                high[k] = high[k].max(x);
            }
        }
        let free = 2.0 * MARGIN * width as f64;
        let extent = [0, 1].map(|k| (high[k] - low[k]).max(f64::MIN_POSITIVE));
        let scale = ((width as f64 - free) / extent[0]).min((height as f64 - free) / extent[1]);
        let needed = (extent[1] * scale + free).ceil() as usize;
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        Frame { view, width, height: needed.clamp(1, height), scale, middle }
    }

    /// The place of a point in a picture with `sub` times as many pixels on a side: x, y and depth.
    pub(crate) fn place(&self, p: DVec3, sub: usize) -> [f64; 3] {
        let sub = sub as f64;
        let x = (p.dot(self.view.right) - self.middle[0]) * self.scale + 0.5 * self.width as f64;
        let y = 0.5 * self.height as f64 - (p.dot(self.view.up) - self.middle[1]) * self.scale;
        [x * sub, y * sub, -p.dot(self.view.toward)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_up_and_near_is_near() {
        let cube = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let frame = Frame::around(View::from([0.3, 0.4, 1.0]), cube, 200, 200);
        let [low, high] = [DVec3::ZERO, DVec3::Y].map(|p| frame.place(p, 1));
        assert!(high[1] < low[1], "Y is upright");
        let [left, right] = [DVec3::ZERO, DVec3::X].map(|p| frame.place(p, 1));
        assert!(left[0] < right[0]);
        let [far, near] = [DVec3::ZERO, DVec3::Z].map(|p| frame.place(p, 1));
        assert!(near[2] < far[2]);
    }

    #[test]
    fn a_cut_is_seen_from_its_side() {
        let front = View::from([0.1, 0.2, 1.0]);
        assert!(front.toward.dot(DVec3::Z) > 0.95);
        let beside = front.beside(DVec3::new(0.1, 0.3, 1.0));
        assert!(beside.toward.dot(DVec3::Z).abs() < 0.5 && beside.up.y > 0.9, "{beside:?}");
        let unturned = front.beside(DVec3::Y);
        assert!(unturned.toward.distance(front.toward) < 1e-12);
    }

    #[test]
    fn everything_is_in_the_picture() {
        let points: Vec<DVec3> =
            (0..50).map(|i| DVec3::new(f64::from(i % 7), f64::from(i % 11), f64::from(i % 3))).collect();
        for (width, height) in [(300, 500), (500, 90)] {
            let frame = Frame::around(View::from([1.0, 0.2, -0.4]), points.iter().copied(), width, height);
            assert!(frame.height <= height);
            for p in &points {
                let [x, y, _] = frame.place(*p, 3);
                assert!(x > 0.0 && x < 3.0 * width as f64 && y > 0.0 && y < 3.0 * frame.height as f64);
            }
        }
    }
}
