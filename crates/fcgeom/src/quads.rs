//! Points by fours, and the questions that are asked of many points at once.
//!
//! The coordinates of four points lie side by side, so that a processor answers for four at a time. A last group that
//! is not full repeats its first point, which no minimum and no maximum minds, so there are no rests to deal with.
//! Searches run in `f32` on differences, whose rounding is relative to the difference; heights are in `f64`.

use crate::ball::Cloud;
use glam::{BVec4A, DVec3, Vec3, Vec4};
use std::ops::Range;

/// Points in groups of four.
#[derive(Clone, Debug, Default)]
pub struct Quads {
    quads: Vec<Quad>,
    len: usize,
    /// Sum of the points that fill up groups.
    repeated: DVec3,
}

/// Four points: their x, their y and their z.
#[derive(Clone, Copy, Debug)]
struct Quad {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Quad {
    const ZERO: Quad = Quad { x: Vec4::ZERO, y: Vec4::ZERO, z: Vec4::ZERO };

    #[inline(always)]
    fn of([a, b, c, d]: [Vec3; 4]) -> Quad {
        Quad {
            x: Vec4::new(a.x, b.x, c.x, d.x),
            y: Vec4::new(a.y, b.y, c.y, d.y),
            z: Vec4::new(a.z, b.z, c.z, d.z),
        }
    }

    #[inline(always)]
    fn splat(p: Vec3) -> Quad {
        Quad { x: Vec4::splat(p.x), y: Vec4::splat(p.y), z: Vec4::splat(p.z) }
    }

    fn points(&self) -> [Vec3; 4] {
        let [x, y, z] = [self.x, self.y, self.z].map(|lanes| lanes.to_array());
        std::array::from_fn(|i| Vec3::new(x[i], y[i], z[i]))
    }

    #[inline(always)]
    fn minus(&self, p: &Quad) -> Quad {
        Quad { x: self.x - p.x, y: self.y - p.y, z: self.z - p.z }
    }

    #[inline(always)]
    fn dot(&self, v: &Quad) -> Vec4 {
        v.x * self.x + v.y * self.y + v.z * self.z
    }

    #[inline(always)]
    fn square_distances(&self, p: &Quad) -> Vec4 {
        let d = self.minus(p);
        d.dot(&d)
    }

    #[inline(always)]
    fn select(mask: BVec4A, a: &Quad, b: &Quad) -> Quad {
        Quad {
            x: Vec4::select(mask, a.x, b.x),
            y: Vec4::select(mask, a.y, b.y),
            z: Vec4::select(mask, a.z, b.z),
        }
    }
}

impl Quads {
    /// Forgets the points and keeps the memory.
    pub fn clear(&mut self) {
        self.quads.clear();
        self.len = 0;
        self.repeated = DVec3::ZERO;
    }

    /// Adds the points of `items` in groups of their own; returns the place of the first group after them.
    pub fn extend<T>(&mut self, items: &[T], point: impl Fn(&T) -> Vec3) -> usize {
        self.len += items.len();
        let (fours, rest) = items.as_chunks::<4>();
        self.quads
            .extend(fours.iter().map(|[a, b, c, d]| Quad::of([point(a), point(b), point(c), point(d)])));
        if let Some(first) = rest.first() {
            let mut four = [point(first); 4];
            for (place, item) in four.iter_mut().zip(rest) {
                *place = point(item);
            }
            self.repeated += four[0].as_dvec3() * (4 - rest.len()) as f64;
            self.quads.push(Quad::of(four));
        }
        self.quads.len()
    }

    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// The groups of all points.
    #[must_use]
    pub fn groups(&self) -> Range<usize> {
        0..self.quads.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The first point.
    #[must_use]
    pub fn first(&self) -> Option<Vec3> {
        Some(self.quads.first()?.points()[0])
    }

    /// Products of three vectors with the points' ways from an origin, group by group.
    pub fn products(
        &self,
        groups: Range<usize>,
        step: usize,
        vectors: [Vec3; 3],
        origin: Vec3,
    ) -> impl Iterator<Item = [Vec4; 3]> {
        let (vectors, origin) = (vectors.map(Quad::splat), Quad::splat(origin));
        self.quads[groups].iter().step_by(step).map(move |quad| {
            let way = quad.minus(&origin);
            [way.dot(&vectors[0]), way.dot(&vectors[1]), way.dot(&vectors[2])]
        })
    }

    /// The points if there are just two.
    pub(crate) fn pair(&self) -> Option<[Vec3; 2]> {
        let [p, q, ..] = self.quads.first()?.points();
        (self.len == 2 && self.quads.len() == 1).then_some([p, q])
    }

    /// The sum of the points as vectors.
    #[must_use]
    pub fn sum(&self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        // Single precision is enough for some of them.
        for some in self.quads.chunks(64) {
            let mut sums = Quad::ZERO;
            for quad in some {
                sums = Quad { x: sums.x + quad.x, y: sums.y + quad.y, z: sums.z + quad.z };
            }
            let [a, b, c, d] = sums.points().map(|p| p.as_dvec3());
            sum += (a + b) + (c + d);
        }
        sum - self.repeated
    }

    /// The lowest and the highest of some groups' points along a direction, as products with it in `f64`; infinite
    /// for no group, and for groups that are not there.
    #[must_use]
    pub fn extent(&self, groups: Range<usize>, direction: DVec3) -> (f64, f64) {
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        for quad in self.quads.get(groups).unwrap_or_default() {
            let (x, y, z) = (quad.x.to_array(), quad.y.to_array(), quad.z.to_array());
            for i in 0..4 {
                let h = direction.x * f64::from(x[i])
                    + direction.y * f64::from(y[i])
                    + direction.z * f64::from(z[i]);
                low[i] = if h < low[i] { h } else { low[i] };
                high[i] = if h > high[i] { h } else { high[i] };
            }
        }
        (
            low.into_iter().fold(f64::INFINITY, |a, b| if b < a { b } else { a }),
            high.into_iter().fold(f64::NEG_INFINITY, |a, b| if b > a { b } else { a }),
        )
    }

    /// The lowest and the highest of some groups' points along a direction, the first ones of each.
    #[must_use]
    pub fn extremes(&self, groups: Range<usize>, direction: DVec3) -> Option<[DVec3; 2]> {
        let quads = self.quads.get(groups)?;
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        let (mut lowest, mut highest) = ([0_usize; 4], [0_usize; 4]);
        for (at, quad) in quads.iter().enumerate() {
            let (x, y, z) = (quad.x.to_array(), quad.y.to_array(), quad.z.to_array());
            for i in 0..4 {
                let h = direction.x * f64::from(x[i])
                    + direction.y * f64::from(y[i])
                    + direction.z * f64::from(z[i]);
                (low[i], lowest[i]) = if h < low[i] { (h, at) } else { (low[i], lowest[i]) };
                (high[i], highest[i]) = if h > high[i] { (h, at) } else { (high[i], highest[i]) };
            }
        }
        let point = |lane: usize, at: usize| Some(quads.get(at)?.points()[lane].as_dvec3());
        let least = (0..4).reduce(|a, b| if low[b] < low[a] { b } else { a })?;
        let most = (0..4).reduce(|a, b| if high[b] > high[a] { b } else { a })?;
        Some([point(least, lowest[least])?, point(most, highest[most])?])
    }

    /// The largest of all points' square distances to the nearest of `sites`, in `f32`; 0 for no points.
    #[must_use]
    pub fn farthest_from_sites(&self, sites: &[Vec3]) -> f32 {
        let mut farthest = Vec4::ZERO;
        for quad in &self.quads {
            let mut nearest = Vec4::INFINITY;
            for site in sites {
                nearest = nearest.min(quad.square_distances(&Quad::splat(*site)));
            }
            farthest = farthest.max(nearest);
        }
        farthest.max_element()
    }
}

impl Cloud for Quads {
    /// The distance is from `p` rounded to `f32`, and off by at most 2e-7 of itself unless it is tiny.
    fn farthest_from(&self, p: DVec3) -> Option<(DVec3, f64)> {
        let p = Quad::splat(p.as_vec3());
        let mut far = Vec4::NEG_ONE;
        let mut at = Quad::ZERO;
        for quad in &self.quads {
            let d = quad.square_distances(&p);
            at = Quad::select(d.cmpgt(far), quad, &at);
            far = far.max(d);
        }
        let farthest = far.max_element();
        let lane = far.cmpeq(Vec4::splat(farthest)).bitmask().trailing_zeros() as usize;
        let [x, y, z] = [at.x, at.y, at.z].map(|lanes| lanes.to_array().get(lane).copied());
        (farthest >= 0.0).then_some((Vec3::new(x?, y?, z?).as_dvec3(), f64::from(farthest)))
    }
}
