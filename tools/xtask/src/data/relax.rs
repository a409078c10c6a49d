//! Turns the rough triangles of a polygonised field into even ones that keep its creases.
//!
//! Short edges are collapsed, long ones split, badly placed ones flipped, and each vertex is moved to where the tangent planes of the
//! surface around it meet: on a smooth part that is the middle of its neighbours, on a crease the crease itself.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::halfedge::{Surface, area_normal, next, previous};

/// Rounds of collapse, flip and move; more bring little.
const ROUNDS: u32 = 5;

/// Collapses edges shorter than this share of the wanted length, growing so that the worst go first.
const SHORT: [f64; 4] = [0.3, 0.5, 0.65, 0.75];

/// Splits edges longer than this multiple of the wanted length.
const LONG: f64 = 1.6;

/// Last of all, edges shorter than this share go, since flips along creases leave a few needles.
const NEEDLE: f64 = 0.25;

/// A point nearer to the surface than this share of the wanted length lies on it.
const CLOSE: f64 = 0.002;

/// A vertex may not gather more edges than this by a collapse.
const CROWD: usize = 9;

/// Weight of staying in the middle against meeting the tangent planes; larger rounds the creases.
const PULL: f64 = 0.005;

/// Makes the surface even with edges of about `length`, lying on `field = 0`.
pub(crate) fn relax(surface: Surface, field: &(impl Fn(DVec3) -> f64 + Sync), length: f64) -> Surface {
    let mut surface = surface;
    for share in SHORT {
        collapse_short(&mut surface, share * length);
    }
    for round in 0..ROUNDS {
        split_long(&mut surface, LONG * length);
        if round < ROUNDS - 1 {
            collapse_short(&mut surface, 0.6 * length);
        }
        flip_bad(&mut surface, field, length);
        move_to_planes(&mut surface, field, length);
    }
    flip_bad(&mut surface, field, length);
    collapse_short(&mut surface, NEEDLE * length);
    surface
}

/// True when the faces around `v`, but for those that hold `other`, keep their side when `v` moves to `p`.
fn keeps_sides(surface: &Surface, v: u32, other: u32, p: DVec3) -> bool {
    surface.around(v).all(|h| {
        let (b, c) = (surface.to(h), surface.from(previous(h)));
        if b == other || c == other {
            return true;
        }
        let (b, c) = (surface.point(b), surface.point(c));
        let before = area_normal(surface.point(v), b, c);
        let after = area_normal(p, b, c);
        before.dot(after) > 0.3 * before.length() * after.length()
    })
}

fn collapse_short(surface: &mut Surface, limit: f64) {
    for h in 0..surface.half_edges() {
        if !surface.alive(h) {
            continue;
        }
        let (a, b) = (surface.from(h), surface.to(h));
        let (p, q) = (surface.point(a), surface.point(b));
        if (q - p).length_squared() >= limit * limit {
            continue;
        }
        let middle = (p + q) * 0.5;
        if surface.valence(a) + surface.valence(b) <= CROWD + 4
            && surface.can_collapse(h)
            && keeps_sides(surface, a, b, middle)
            && keeps_sides(surface, b, a, middle)
        {
            surface.collapse(h, middle);
        }
    }
}

fn split_long(surface: &mut Surface, limit: f64) {
    // Halves of a split edge come after this bound and wait for the next round.
    for h in 0..surface.half_edges() {
        if !surface.alive(h) || surface.from(h) > surface.to(h) {
            continue;
        }
        let (p, q) = (surface.point(surface.from(h)), surface.point(surface.to(h)));
        if (q - p).length_squared() > limit * limit {
            surface.split(h, (p + q) * 0.5);
        }
    }
}

/// Flips edges whose other diagonal lies nearer to the surface or, where both do, makes rounder triangles.
fn flip_bad(surface: &mut Surface, field: &impl Fn(DVec3) -> f64, length: f64) {
    for _ in 0..2 {
        for h in 0..surface.half_edges() {
            if surface.alive(h) && surface.from(h) < surface.to(h) && wants_flip(surface, field, length, h) {
                surface.flip(h);
            }
        }
    }
}

fn wants_flip(surface: &Surface, field: &impl Fn(DVec3) -> f64, length: f64, h: u32) -> bool {
    let g = surface.twin(h);
    let [a, b] = [surface.from(h), surface.to(h)].map(|v| surface.point(v));
    let [c, d] = [surface.to(next(h)), surface.to(next(g))].map(|v| surface.point(v));
    let (left, right) = (area_normal(a, b, c), area_normal(b, a, d));
    let (one, two) = (area_normal(a, d, c), area_normal(b, c, d));
    let cosine = |m: DVec3, n: DVec3| m.dot(n) / (m.length() * n.length()).max(f64::MIN_POSITIVE);
    let (bent, other) = (cosine(left, right), cosine(one, two));
    // Cotangents of the angles opposite the edge: a negative sum means the other diagonal is the Delaunay one.
    let cotangent =
        |p: DVec3, q: DVec3, r: DVec3| (p - r).dot(q - r) / area_normal(p, q, r).length().max(1e-300);
    let slim = cotangent(a, b, c) + cotangent(b, a, d);
    if bent > 0.95 && other > 0.95 {
        return slim < -1e-6 && surface.can_flip(h);
    }
    if (c - d).length_squared() > (a - b).length_squared().max(6.0 * length * length) {
        return false;
    }
    // The four points are bent: the better diagonal runs along the crease, so its middle lies on the surface.
    let gain = field((a + b) * 0.5).abs() - field((c + d) * 0.5).abs();
    let wanted = if gain.abs() > 0.02 * length { gain > 0.0 } else { slim < -1e-3 && other > bent - 0.1 };
    // A turned pair must not fold over either of the old faces.
    let sum = left + right;
    wanted && one.dot(sum) > 0.0 && two.dot(sum) > 0.0 && other > -0.5 && surface.can_flip(h)
}

/// Slope of the field by four samples close to `p`.
fn slope(field: &impl Fn(DVec3) -> f64, p: DVec3, length: f64) -> DVec3 {
    let reach = 0.02 * length;
    [DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::ONE]
        .iter()
        .fold(DVec3::ZERO, |sum, k| sum + *k * field(p + *k * reach))
        / (4.0 * reach)
}

/// The point of the surface near `p`, found by one step along the slope and moved by at most 0.3 `length`.
fn project(field: &impl Fn(DVec3) -> f64, p: DVec3, length: f64) -> DVec3 {
    let value = field(p);
    if value.abs() < CLOSE * length { p } else { stepped(p, value, slope(field, p, length), length) }
}

fn stepped(p: DVec3, value: f64, slope: DVec3, length: f64) -> DVec3 {
    // A slope near zero, at the middle line of a thin part, would send the point far away.
    let move_by = slope * (value / slope.length_squared().max(0.1));
    p - move_by * (0.3 * length / move_by.length().max(0.3 * length))
}

/// A point of the surface near `p` and the unit normal there.
fn tangent_plane(field: &impl Fn(DVec3) -> f64, p: DVec3, length: f64) -> (DVec3, DVec3) {
    let value = field(p);
    let here = slope(field, p, length);
    if value.abs() < CLOSE * length {
        return (p, here.normalize_or_zero());
    }
    let q = stepped(p, value, here, length);
    (q, slope(field, q, length).normalize_or_zero())
}

fn move_to_planes(surface: &mut Surface, field: &(impl Fn(DVec3) -> f64 + Sync), length: f64) {
    // One plane for each face: a point of the surface near its middle, the unit normal there, its weight.
    let still = &*surface;
    let planes: Vec<(DVec3, DVec3, f64)> = (0..still.half_edges() / 3)
        .into_par_iter()
        .map(|f| {
            if !still.alive(3 * f) {
                return (DVec3::ZERO, DVec3::ZERO, 0.0);
            }
            let [a, b, c] = still.corners(f);
            let (p, normal) = tangent_plane(field, (a + b + c) / 3.0, length);
            (p, normal, area_normal(a, b, c).length())
        })
        .collect();
    let moved: Vec<DVec3> = (0..still.points.len() as u32)
        .into_par_iter()
        .map(|v| {
            let old = still.point(v);
            let (mut weight, mut mean) = (0.0, DVec3::ZERO);
            for h in still.around(v) {
                let (p, _, w) = planes[(h / 3) as usize];
                weight += w;
                mean += p * w;
            }
            if weight <= 0.0 {
                return old;
            }
            mean /= weight;
            let mut matrix = DMat3::from_diagonal(DVec3::splat(PULL * weight));
            let mut pull = DVec3::ZERO;
            for h in still.around(v) {
                let (p, n, w) = planes[(h / 3) as usize];
                matrix += DMat3::from_cols(n * n.x, n * n.y, n * n.z) * w;
                pull += n * (w * n.dot(p - mean));
            }
            let goal = mean + matrix.inverse() * pull;
            let step = goal - old;
            let goal = old + step * (0.8 * length / step.length().max(0.8 * length));
            project(field, goal, length)
        })
        .collect();
    surface.points = moved;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::distance::cuboid;
    use crate::data::polygonise::polygonise;

    /// The eight corners of a tilted box come out where they belong although no grid point lies on them.
    #[test]
    fn creases_and_corners_are_found() {
        let (x, y, z) = (DVec3::new(0.6, 0.0, 0.8), DVec3::Y, DVec3::new(-0.8, 0.0, 0.6));
        let field = |p: DVec3| cuboid(DVec3::new(p.dot(x), p.dot(y), p.dot(z)), DVec3::new(1.0, 0.7, 0.8));
        let (points, faces) = polygonise(&field, DVec3::splat(-1.63), 3.26, 0.08);
        let surface = relax(Surface::new(points, &faces).unwrap(), &field, 0.1);
        let (points, faces) = surface.into_faces();
        for k in 0..8 {
            let s = |bit: i32| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let corner = x * s(0) + y * (0.7 * s(1)) + z * (0.8 * s(2));
            let nearest = points.iter().map(|p| (*p - corner).length()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.01, "corner {k}: {nearest}");
        }
        // No face cuts across an edge of the box.
        let worst = faces
            .iter()
            .map(|f| field(f.map(|v| points[v as usize]).iter().sum::<DVec3>() / 3.0).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.012, "{worst}");
    }
}
