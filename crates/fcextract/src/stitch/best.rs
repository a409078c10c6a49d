//! The best of all triangulations of a polygon with few corners.
//!
//! It is the one that lies nearest to the plane of the cluster, in the mean of the squared height. It is found by
//! dynamic programming over chords: the best triangulation of the part of the polygon before a chord is a triangle on
//! that chord and the best ones of what is before its other two sides. All chords past equally many corners are
//! worked on at once, side by side in the lanes of the machine's vectors.

/// Up to so many corners the best triangulation is sought: its time grows with the cube of their number.
pub(super) const BEST_UP_TO: usize = 12;

/// Twice the area of the thinnest triangle that counts as valid, over its squared edges.
const THINNEST: f32 = 1e-4;

/// What a long edge costs beside height: it decides where all is flat, and nowhere else.
const WELL_SHAPED: f32 = 1e-8;

/// A number for each corner, and room for lanes that lie beside the polygon.
pub(super) type PerCorner = [f32; 2 * BEST_UP_TO];

/// The corners of a polygon, counter-clockwise, and what is found out about it; keeps its memory.
#[derive(Debug, Default)]
pub(super) struct Best {
    /// Places in a plane.
    pub(super) x: PerCorner,
    pub(super) y: PerCorner,
    /// Over the plane that fits best.
    pub(super) height: PerCorner,
    /// By the number of edges that a chord spans, and where it begins.
    chords: [Chords; BEST_UP_TO],
}

#[derive(Clone, Copy, Debug, Default)]
struct Chords {
    dx: PerCorner,
    dy: PerCorner,
    squared: PerCorner,
    /// Its part of the cost of a triangle, per area. Twelve times the squared height integrated over a triangle is
    /// twice its area times the sum of its sides' parts.
    part: PerCorner,
    /// The least cost of what is before it.
    cost: PerCorner,
    /// The corner opposite to it in the best triangulation of that, in edges from where it begins.
    apex: [u32; 2 * BEST_UP_TO],
}

impl Best {
    /// Shows the triangles of the best triangulation, counter-clockwise; false if none of all is valid.
    #[inline(always)]
    pub(super) fn show(&mut self, corners: usize, show: impl FnMut([usize; 3])) -> bool {
        match corners {
            4 => return self.quad(show),
            5 => return self.pentagon(show),
            6..=BEST_UP_TO => self.find(corners),
            _ => return false,
        }
        self.follow(corners, show)
    }

    /// The better one of two diagonals.
    #[inline(always)]
    fn quad(&mut self, mut show: impl FnMut([usize; 3])) -> bool {
        self.go_around(4);
        // At each corner the triangle of it and the next two.
        let ears = costs::<4>(self, [0, 1, 2]);
        let fans = [ears[0] + ears[2], ears[1] + ears[3]];
        if !fans[0].min(fans[1]).is_finite() {
            return false;
        }
        if fans[0] <= fans[1] {
            show([0, 1, 2]);
            show([0, 2, 3]);
        } else {
            show([0, 1, 3]);
            show([1, 2, 3]);
        }
        true
    }

    /// The best one of five fans.
    #[inline(always)]
    fn pentagon(&mut self, mut show: impl FnMut([usize; 3])) -> bool {
        self.go_around(5);
        let ears = costs::<8>(self, [0, 1, 2]);
        let middles = costs::<8>(self, [0, 2, 3]);
        let mut least = (f32::INFINITY, 0);
        for apex in 0..5 {
            let fan = ears[apex] + middles[apex] + ears[(apex + 3) % 5];
            least = if fan < least.0 { (fan, apex) } else { least };
        }
        let (cost, apex) = least;
        if cost == f32::INFINITY {
            return false;
        }
        let around = |i: usize| (apex + i) % 5;
        for i in 1..4 {
            show([apex, around(i), around(i + 1)]);
        }
        true
    }

    /// Puts the first corners behind the last one once more.
    #[inline]
    fn go_around(&mut self, corners: usize) {
        for of in [&mut self.x, &mut self.y, &mut self.height] {
            for i in 0..4 {
                of[corners + i] = of[i];
            }
        }
    }

    /// The corners from one on.
    #[inline(always)]
    fn corners<const LANES: usize>(&self, first: usize) -> [[f32; LANES]; 3] {
        [lanes(&self.x, first), lanes(&self.y, first), lanes(&self.height, first)]
    }

    /// Finds all costs.
    #[inline]
    fn find(&mut self, corners: usize) {
        // The longer chords are, the fewer there are.
        for span in 1..corners {
            match corners - span {
                ..=4 => self.measure::<4>(span),
                5..=8 => self.measure::<8>(span),
                _ => self.measure::<12>(span),
            }
        }
        for span in 2..corners {
            match corners - span {
                ..=4 => self.join::<4>(span),
                5..=8 => self.join::<8>(span),
                _ => self.join::<12>(span),
            }
        }
    }

    /// Measures the chords past `span` edges, of which there are at most so many.
    #[inline(always)]
    fn measure<const CHORDS: usize>(&mut self, span: usize) {
        let Best { x, y, height, chords } = self;
        let Some(chord) = chords.get_mut(span) else { return };
        let from = [&*x, &*y, &*height].map(|of| lanes::<CHORDS>(of, 0));
        let to = [&*x, &*y, &*height].map(|of| lanes::<CHORDS>(of, span));
        for l in 0..CHORDS {
            let [dx, dy] = [0, 1].map(|c| to[c][l] - from[c][l]);
            let squared = dx * dx + dy * dy;
            let heights = from[2][l] + to[2][l];
            chord.dx[l] = dx;
            chord.dy[l] = dy;
            chord.squared[l] = squared;
            chord.part[l] = 0.5 * heights * heights + WELL_SHAPED * squared;
            chord.cost[l] = 0.0;
        }
    }

    /// Finds the costs of the chords past `span` edges, of which there are at most so many, by those of shorter ones.
    #[inline(always)]
    fn join<const CHORDS: usize>(&mut self, span: usize) {
        let (before, rest) = self.chords.split_at_mut(span);
        let Some(whole) = rest.first_mut() else { return };
        let [dx, dy, squared, part] =
            [&whole.dx, &whole.dy, &whole.squared, &whole.part].map(|of| lanes::<CHORDS>(of, 0));
        let mut least = [f32::INFINITY; CHORDS];
        let mut apex = [0_u32; CHORDS];
        for third in 1..span {
            let (left, right) = (&before[third], &before[span - third]);
            let [lx, ly, left_squared, left_part, left_cost] =
                [&left.dx, &left.dy, &left.squared, &left.part, &left.cost].map(|of| lanes::<CHORDS>(of, 0));
            let [right_squared, right_part, right_cost] =
                [&right.squared, &right.part, &right.cost].map(|of| lanes::<CHORDS>(of, third));
            for l in 0..CHORDS {
                let area = lx[l] * dy[l] - ly[l] * dx[l];
                let squared = left_squared[l] + right_squared[l] + squared[l];
                let parts = left_part[l] + right_part[l] + part[l];
                let cost = left_cost[l] + right_cost[l] + area * parts;
                let better = (area > THINNEST * squared) & (cost < least[l]);
                least[l] = if better { cost } else { least[l] };
                apex[l] = if better { third as u32 } else { apex[l] };
            }
        }
        whole.cost[..CHORDS].copy_from_slice(&least);
        whole.apex[..CHORDS].copy_from_slice(&apex);
    }

    /// Shows what was found.
    #[inline]
    fn follow(&self, corners: usize, mut show: impl FnMut([usize; 3])) -> bool {
        let Some(whole) = corners.checked_sub(1).and_then(|span| self.chords.get(span)) else { return false };
        if !whole.cost[0].is_finite() {
            return false;
        }
        let mut waiting = [(0, 0); BEST_UP_TO];
        waiting[0] = (0, corners - 1);
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (first, span) = waiting[count];
            let third = self.chords[span].apex[first] as usize;
            show([first, first + third, first + span]);
            for (first, span) in [(first, third), (first + third, span - third)] {
                waiting[count] = (first, span);
                count += usize::from(span > 1);
            }
        }
        true
    }
}

/// The costs of the triangles that have their corners so far beyond each corner; infinite for one that is flat or
/// turned over.
#[inline(always)]
fn costs<const LANES: usize>(of: &Best, [a, b, c]: [usize; 3]) -> [f32; LANES] {
    let [ax, ay, ah] = of.corners::<LANES>(a);
    let [bx, by, bh] = of.corners::<LANES>(b);
    let [cx, cy, ch] = of.corners::<LANES>(c);
    let mut costs = [0.0; LANES];
    for l in 0..LANES {
        let (ux, uy, vx, vy) = (bx[l] - ax[l], by[l] - ay[l], cx[l] - ax[l], cy[l] - ay[l]);
        let (wx, wy) = (vx - ux, vy - uy);
        let (ab, bc, ca) = (ah[l] + bh[l], bh[l] + ch[l], ch[l] + ah[l]);
        let area = ux * vy - uy * vx;
        let squared = (ux * ux + uy * uy) + (vx * vx + vy * vy) + (wx * wx + wy * wy);
        let whole = area * (0.5 * (ab * ab + bc * bc + ca * ca) + WELL_SHAPED * squared);
        costs[l] = if area > THINNEST * squared { whole } else { f32::INFINITY };
    }
    costs
}

/// Numbers that lie side by side, from one on.
#[inline(always)]
fn lanes<const N: usize>(of: &PerCorner, first: usize) -> [f32; N] {
    of[first..].first_chunk().map_or([0.0; N], |lanes| *lanes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// x, y and height.
    type Corner = [f32; 3];

    fn cost([a, b, c]: [Corner; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let squared = |p: [f64; 3], q: [f64; 3]| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
        let edges = squared(a, b) + squared(b, c) + squared(c, a);
        if area <= f64::from(THINNEST) * edges {
            return f64::INFINITY;
        }
        let [h, i, j] = [a[2], b[2], c[2]];
        area * (h * h + i * i + j * j + h * i + i * j + j * h + f64::from(WELL_SHAPED) * edges)
    }

    /// Tries all triangulations, one by one.
    fn naive(corners: &[Corner]) -> f64 {
        let last = corners.len() - 1;
        if last < 2 {
            return 0.0;
        }
        let with = |j: usize| {
            cost([corners[0], corners[j], corners[last]]) + naive(&corners[..=j]) + naive(&corners[j..])
        };
        (1..last).map(with).fold(f64::INFINITY, f64::min)
    }

    fn found(corners: &[Corner]) -> Option<Vec<[usize; 3]>> {
        let mut best = Best::default();
        // What a larger polygon has left must not matter.
        best.x.fill(7.0);
        best.height.fill(-3.0);
        for (i, [x, y, h]) in corners.iter().enumerate() {
            (best.x[i], best.y[i], best.height[i]) = (*x, *y, *h);
        }
        let mut triangles = Vec::new();
        let is_found = best.show(corners.len(), |t| triangles.push(t));
        assert!(is_found || triangles.is_empty());
        is_found.then_some(triangles)
    }

    proptest! {
        /// Around a circle, dented and shaken: convex polygons, others, and some that have no triangulation.
        #[test]
        fn the_best_of_all_triangulations_is_found(
            shape in prop::collection::vec((0.2_f32..1.0, 0.0_f32..0.9, -0.3_f32..0.3), 4..=9)
        ) {
            let n = shape.len() as f32;
            let corner = |(i, (r, turn, h)): (usize, &(f32, f32, f32))| {
                let angle = std::f32::consts::TAU * (i as f32 + turn) / n;
                [r * angle.cos(), r * angle.sin(), *h]
            };
            let corners: Vec<Corner> = shape.iter().enumerate().map(corner).collect();
            let least = naive(&corners);
            match found(&corners) {
                None => prop_assert!(least == f64::INFINITY, "there is one of cost {least}"),
                Some(triangles) => {
                    let sum: f64 = triangles.iter().map(|t| cost(t.map(|k| corners[k]))).sum();
                    prop_assert!((sum - least).abs() < 1e-4 * least, "{sum} instead of {least}");
                    prop_assert_eq!(triangles.len(), corners.len() - 2);
                    for [a, b, c] in triangles {
                        prop_assert!(a < b && b < c || corners.len() == 5);
                    }
                }
            }
        }
    }

    #[test]
    fn every_number_of_corners_has_its_way() {
        for n in 4..=BEST_UP_TO {
            let corner = |i: usize| {
                let angle = std::f32::consts::TAU * i as f32 / n as f32;
                [angle.cos(), angle.sin(), ((i * i * 7 + 3) % 11) as f32 - 5.0]
            };
            let corners: Vec<Corner> = (0..n).map(corner).collect();
            let triangles = found(&corners).unwrap();
            assert_eq!(triangles.len(), n - 2);
            let sum: f64 = triangles.iter().map(|t| cost(t.map(|k| corners[k]))).sum();
            assert!((sum - naive(&corners)).abs() < 1e-4 * sum, "{n}");
        }
        assert!(found(&[[0.0; 3]; 3]).is_none() && found(&[[0.0; 3]; BEST_UP_TO]).is_none());
    }
}
