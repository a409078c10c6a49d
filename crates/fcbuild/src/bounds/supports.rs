//! A cluster between planes that its border lies over and under.
//!
//! Whichever vertices of a border are drawn, the polygon lies in the convex hull of the border: over each plane that the
//! border lies over, and under each that it lies under. A slab has one plane of either kind, level along its direction. Of
//! a cluster that bends up one way and down the other, the lowest vertices of the border are far below where the cluster
//! is high, and a plane that leans is nearer there. So every part of the surface takes the planes that are nearest to it:
//! each face of the cluster, and what is seen of each face beyond it in the hulls of its arcs.

use super::beyond::Beyond;
use super::gaze::{Gaze, Seen};
use super::leaning::{Leaning, MOST};
use super::node::Cluster;
use super::slab::{Points, Slab};
use super::support::{STEPS, Slope, Support, farther};
use crate::arcs::loops::LAST;
use crate::tree_order::TreeMesh;
use glam::{BVec4A, DVec2, Vec3, Vec4};

/// The memory of measurements, one after the other.
#[derive(Debug, Default)]
pub(super) struct Supports {
    slopes: Vec<Slope>,
    /// For each slope, how far what was measured between its planes is above the polygon, and the polygon above it.
    apart: [Vec4; 2],
    leaning: Leaning,
}

impl Supports {
    /// How far the surface may be above the polygon of a cluster with this slab, and the polygon above the surface, as
    /// heights of the slab count.
    pub(super) fn measure(
        &mut self,
        mesh: &TreeMesh,
        at: &Cluster<'_>,
        slab: &Slab,
        points: &Points<'_>,
        beyond: &Beyond,
    ) -> [f64; 2] {
        let place = |v: u32| mesh.positions[v as usize];
        let border = at.loops.iter().map(|h| place(mesh.origin(h & !LAST)));
        let faces = mesh.faces[at.faces.clone()].iter().map(|face| face.map(place));
        self.measure_parts(border, faces, slab, points, beyond)
    }

    /// The same of the vertices of a border, faces and points.
    fn measure_parts(
        &mut self,
        border: impl Iterator<Item = Vec3>,
        faces: impl Iterator<Item = [Vec3; 3]>,
        slab: &Slab,
        points: &Points<'_>,
        beyond: &Beyond,
    ) -> [f64; 2] {
        let gaze = Gaze::along(slab.direction);
        let (slopes, apart) = self.leaning.slopes(gaze, points, beyond.corners());
        self.slopes.clear();
        self.slopes.extend_from_slice(slopes);
        let planes = Planes::around(border, gaze, slopes, slab);
        // Parts are larger than points, so that one of them will be as far away.
        let apart = apart.map(|apart| apart * 0.999);
        let mut nearest = Nearest { planes: &planes, of: [Vec4::NEG_INFINITY; 2], apart };
        for face in faces {
            let [a, b, c] = face.map(|p| planes.heights(p));
            nearest.add(a.min(b).min(c), a.max(b).max(c));
        }
        let origin = gaze.see(planes.origin.as_dvec3());
        for part in beyond.parts() {
            let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
            for seen in part {
                let h = planes.heights_seen(seen, &origin);
                (low, high) = (low.min(h), high.max(h));
            }
            nearest.add(low, high);
        }
        self.apart = nearest.of;
        nearest.apart.map(f64::from)
    }

    /// What the last cluster was measured between; `all` is what came of it.
    pub(super) fn found(&self, place: u16, all: [f64; 2]) -> impl Iterator<Item = Support> {
        let apart = self.apart.map(|apart| apart.to_array());
        let support = move |(k, slope): (usize, &Slope)| {
            let share = |side: usize| match f64::from(apart[side][k]) {
                f64::NEG_INFINITY => 0,
                // Nothing is farther than 0 where all is 0.
                apart => (apart / all[side] * STEPS).ceil().min(STEPS) as u8 + 1,
            };
            Support { place, slope: *slope, apart: [share(0), share(1)] }
        };
        self.slopes.iter().enumerate().map(support).filter(|support| support.apart != [0; 2])
    }
}

/// Pairs of parallel planes between which a border lies, side by side; there are four, or some stand there twice.
///
/// Heights are in single precision, from the first vertex of the border.
struct Planes {
    origin: Vec3,
    /// Heights are products with these vectors: their x, y and z.
    across: [Vec4; 3],
    slopes: [Vec4; 2],
    farther: Vec4,
    /// The heights of the border.
    low: Vec4,
    high: Vec4,
    /// More than a difference of two heights may be off.
    rounding: f32,
}

/// A height is a sum of three products: with five roundings of 2^-24 each way, of the lengths of a point's way from the
/// origin and of a vector that is no longer than 2.3, a difference of two is off by 1.4e-6 of that way at most.
const ROUNDING: f64 = 4e-6;

impl Planes {
    fn around(border: impl Iterator<Item = Vec3>, gaze: Gaze, slopes: &[Slope], slab: &Slab) -> Planes {
        let slope = |k: usize| slopes.get(k).or(slopes.first()).map_or(DVec2::ZERO, |slope| slope.get());
        let slopes: [DVec2; MOST] = std::array::from_fn(slope);
        let side_by_side = |part: &dyn Fn(DVec2) -> f64| Vec4::from(slopes.map(|slope| part(slope) as f32));
        let mut border = border.peekable();
        let mut planes = Planes {
            origin: border.peek().copied().unwrap_or(Vec3::ZERO),
            across: [0, 1, 2].map(|axis| side_by_side(&|slope| gaze.leant(slope)[axis])),
            slopes: [0, 1].map(|axis| side_by_side(&|slope| slope[axis])),
            farther: side_by_side(&farther),
            low: Vec4::INFINITY,
            high: Vec4::NEG_INFINITY,
            rounding: 0.0,
        };
        let mut square = 0.0_f32;
        for p in border {
            let h = planes.heights(p);
            (planes.low, planes.high) = (planes.low.min(h), planes.high.max(h));
            square = square.max(p.distance_squared(planes.origin));
        }
        // Along the direction all points are seen in the hull of the border, and their heights are in the slab's extent.
        planes.rounding = (ROUNDING * (f64::from(square).sqrt() + slab.thickness())) as f32;
        planes
    }

    #[inline(always)]
    fn heights(&self, p: Vec3) -> Vec4 {
        let way = p - self.origin;
        self.across[0] * way.x + self.across[1] * way.y + self.across[2] * way.z
    }

    /// The same of a point that is seen there, if it is known where the origin is seen.
    #[inline(always)]
    fn heights_seen(&self, seen: &Seen, origin: &Seen) -> Vec4 {
        let at = (seen.at - origin.at).as_vec2();
        Vec4::splat((seen.height - origin.height) as f32) - self.slopes[0] * at.x - self.slopes[1] * at.y
    }
}

/// Parts of a surface, each between planes that are near enough to it.
struct Nearest<'a> {
    planes: &'a Planes,
    /// For each pair of planes, how far the farthest part between them is above the polygon, and the polygon above it.
    of: [Vec4; 2],
    /// The same of all.
    apart: [f32; 2],
}

/// The first of four.
const LEVEL: BVec4A = BVec4A::new(true, false, false, false);

impl Nearest<'_> {
    /// Adds a part that reaches from some lowest to some highest heights.
    ///
    /// It goes to level planes, which are the first ones, if another part is as far away from its own: they leave displaced
    /// vertices most.
    #[inline(always)]
    fn add(&mut self, low: Vec4, high: Vec4) {
        let planes = self.planes;
        let above = (high - planes.low + planes.rounding) * planes.farther;
        let below = (planes.high - low + planes.rounding) * planes.farther;
        for (side, apart) in [above, below].into_iter().enumerate() {
            let (of, all) = (&mut self.of[side], &mut self.apart[side]);
            let mut own = LEVEL;
            if apart.x > *all {
                let least = apart.min_element();
                own = apart.cmple(Vec4::splat(least));
                *all = all.max(least);
            }
            *of = of.max(Vec4::select(own, apart, Vec4::NEG_INFINITY));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::slab;
    use fcgeom::Quads;
    use proptest::prelude::*;

    /// How far points may be from polygons between the vertices of a border, seen along z: by level planes and by leaning
    /// ones; the pairs of planes, and what is kept of them.
    fn measured(border: &[Vec3], inside: &[Vec3]) -> ([f64; 2], [f64; 2], Vec<Support>) {
        let mut all = Quads::default();
        let first = all.extend(border, |p| *p);
        let end = all.extend(inside, |p| *p);
        let points = Points { all: &all, border: 0..first, inside: first..end };
        let slab = slab::slab(std::iter::once(Vec3::Z), &points).unwrap();
        let mut supports = Supports::default();
        let parts = border.iter().chain(inside).map(|p| [*p; 3]);
        let apart = supports.measure_parts(border.iter().copied(), parts, &slab, &points, &Beyond::default());
        (slab.apart(), apart, supports.found(0, apart).collect())
    }

    #[test]
    fn a_disc_that_rises_from_one_side_to_the_other_is_near_to_a_plane_that_leans() {
        let place = |i: u16, r: f32| {
            let (y, x) = (0.1 * f32::from(i)).sin_cos();
            Vec3::new(r * x, r * y, 0.1 * r * x * (r * x).abs())
        };
        let border: Vec<Vec3> = (0..63).map(|i| place(i, 1.0)).collect();
        let inside: Vec<Vec3> = (0..400).map(|i| place(i, (f32::from(i) / 400.0).sqrt())).collect();
        let (level, apart, supports) = measured(&border, &inside);
        assert!(level.iter().all(|apart| (apart - 0.2).abs() < 1e-3), "{level:?}");
        assert!(apart.iter().all(|apart| *apart < 0.1), "{apart:?}");
        assert!(supports.len() > 1);
    }

    proptest! {
        /// No triangle of the border's vertices is farther from a point above or below it than is said; nor is it when each
        /// vertex moves along the direction as far as what is kept of the planes allows.
        #[test]
        fn no_polygon_is_farther_than_measured(
            points in prop::collection::vec([-1.0_f32..1.0, -1.0_f32..1.0, -0.3_f32..0.3], 6..40),
            border in 4_usize..12,
            shares in prop::collection::vec(0.0_f64..1.0, 12),
        ) {
            let points: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
            let (border, inside) = points.split_at(border.min(points.len()));
            let (level, apart, supports) = measured(border, inside);
            for side in 0..2 {
                prop_assert!(apart[side] <= level[side] + 1e-5, "{apart:?} {level:?}");
            }
            // How far each vertex may go up.
            let allowed = apart[1] + 0.1;
            let gaze = Gaze::along(glam::DVec3::Z);
            let room = |v: Vec3| {
                let of = |support: &Support| {
                    let along = gaze.leant(support.slope());
                    let high = border.iter().map(|p| along.dot(p.as_dvec3())).fold(f64::NEG_INFINITY, f64::max);
                    let below = support.apart(apart)[1];
                    allowed - (below - farther(support.slope()) * (high - along.dot(v.as_dvec3())))
                };
                supports.iter().map(of).fold(f64::INFINITY, f64::min) / 1.2
            };
            let n = border.len();
            for (i, j, k) in (0..n).flat_map(|i| (0..i).flat_map(move |j| (0..j).map(move |k| (i, j, k)))) {
                let corners = [i, j, k].map(|i| border[i].as_dvec3());
                let [a, b, c] = corners;
                let area = (b - a).truncate().perp_dot((c - a).truncate());
                for p in points.iter().map(|p| p.as_dvec3()) {
                    let cross = |u: glam::DVec3, v: glam::DVec3| (u - p).truncate().perp_dot((v - p).truncate());
                    let weights = [cross(b, c), cross(c, a), cross(a, b)].map(|w| w / area);
                    if area.abs() < 1e-3 || weights.iter().any(|w| *w < 0.0) {
                        continue;
                    }
                    let mean = |of: [f64; 3]| weights[0] * of[0] + weights[1] * of[1] + weights[2] * of[2];
                    let height = mean(corners.map(|c| c.z));
                    prop_assert!(p.z - height <= apart[0] + 1e-6 && height - p.z <= apart[1] + 1e-6);
                    let step = |i: usize| shares[i] * room(border[i]);
                    prop_assert!(height + mean([step(i), step(j), step(k)]) - p.z <= allowed + 1e-6);
                }
            }
        }
    }
}
