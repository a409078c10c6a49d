//! Colours between the corners of a triangle.

use glam::{DVec3, DVec4, Vec3};

/// A colour; opaque black and white are 1 apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Color(DVec4);

impl Color {
    pub(crate) fn of(bytes: [u8; 4]) -> Color {
        Color(DVec4::from(bytes.map(f64::from)) / (255.0 * 3.0_f64.sqrt()))
    }

    /// Between three, by weights that sum to 1.
    pub(crate) fn between([a, b, c]: [Color; 3], weights: DVec3) -> Color {
        Color(a.0 * weights.x + b.0 * weights.y + c.0 * weights.z)
    }

    pub(crate) fn squared_difference(self, other: Color) -> f64 {
        (self.0 - other.0).length_squared()
    }
}

/// The weights of the corners at the place of a triangle that is nearest to `p`.
pub(crate) fn nearest_weights(p: DVec3, corners: &[Vec3; 3]) -> DVec3 {
    let at = corners.map(|v| v.as_dvec3());
    let [a, b, c] = at;
    let n = (b - a).cross(c - a);
    let area = n.length_squared();
    let part = |i: usize| (at[(i + 2) % 3] - at[(i + 1) % 3]).cross(p - at[(i + 1) % 3]).dot(n) / area;
    let inside = DVec3::new(part(0), part(1), part(2));
    if area > 0.0 && inside.min_element() >= 0.0 {
        return inside / (inside.x + inside.y + inside.z);
    }
    // On the nearest of the sides.
    let on_side = |i: usize| {
        let (from, along) = (at[i], at[(i + 1) % 3] - at[i]);
        let length = along.length_squared();
        let t = if length > 0.0 { ((p - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = DVec3::ZERO;
        weights[i] = 1.0 - t;
        weights[(i + 1) % 3] = t;
        ((from + along * t - p).length_squared(), weights)
    };
    let nearer = |a: (f64, DVec3), b: (f64, DVec3)| if b.0 < a.0 { b } else { a };
    nearer(nearer(on_side(0), on_side(1)), on_side(2)).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::unit;
    use crate::squared_distance;

    #[test]
    fn weights_are_those_of_the_nearest_place() {
        for i in 0..4000 {
            let random = |k: u64| unit(i, k, 7) * 2.0 - 1.0;
            let point = |k: u64| DVec3::new(random(k), random(k + 1), random(k + 2));
            let mut corners = [point(0), point(3), point(6)].map(|p| p.as_vec3());
            if i % 5 == 4 {
                corners[2] = corners[i as usize % 2];
            }
            let p = point(9);
            let weights = nearest_weights(p, &corners);
            let [a, b, c] = corners.map(|v| v.as_dvec3());
            let place = a * weights.x + b * weights.y + c * weights.z;
            assert!((weights.x + weights.y + weights.z - 1.0).abs() < 1e-9 && weights.min_element() >= 0.0);
            let (found, due) = (place.distance(p), squared_distance(p, &corners).sqrt());
            assert!((found - due).abs() < 1e-9, "{i}: {found} {due}");
        }
    }

    #[test]
    fn black_and_white_are_one_apart() {
        let [black, white] = [[0, 0, 0, 255], [255; 4]].map(Color::of);
        assert!((black.squared_difference(white) - 1.0).abs() < 1e-12);
        let gray = Color::between([black, white, white], DVec3::new(0.5, 0.25, 0.25));
        assert!((gray.squared_difference(black) - 0.25).abs() < 1e-12);
    }
}
