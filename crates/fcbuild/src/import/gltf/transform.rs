//! The placement of a node: an affine map in double precision.

use gltf::json::Node;

/// An affine map: three rows of a linear part, and a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform {
    linear: [[f64; 3]; 3],
    shift: [f64; 3],
}

impl Transform {
    pub(super) const IDENTITY: Self =
        Self { linear: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };

    /// The map that a node declares; an error message when it is not affine or not finite.
    pub(super) fn of(node: &Node) -> Result<Self, &'static str> {
        let map = match node.matrix {
            Some(m) => {
                let [a, b, c, d, e, f, g, h, i, j, k, l, x, y, z, w] = m.map(f64::from);
                if [d, h, l, w] != [0.0, 0.0, 0.0, 1.0] {
                    return Err("the last row of the matrix is not 0 0 0 1");
                }
                Self { linear: [[a, e, i], [b, f, j], [c, g, k]], shift: [x, y, z] }
            }
            None => Self::from_parts(node)?,
        };
        let numbers = map.linear.iter().flatten().chain(&map.shift);
        if numbers.into_iter().all(|x| x.is_finite()) {
            Ok(map)
        } else {
            Err(
                "the transform has a number that is not finite, or beyond 3.4e38, where single precision ends",
            )
        }
    }

    fn from_parts(node: &Node) -> Result<Self, &'static str> {
        let shift = node.translation.unwrap_or([0.0; 3]).map(f64::from);
        let [sx, sy, sz] = node.scale.unwrap_or([1.0; 3]).map(f64::from);
        let Some(rotation) = node.rotation else {
            return Ok(Self { linear: [[sx, 0.0, 0.0], [0.0, sy, 0.0], [0.0, 0.0, sz]], shift });
        };
        let [x, y, z, w] = rotation.0.map(f64::from);
        let square = x * x + y * y + z * z + w * w;
        if square.is_nan() || square <= 0.0 {
            return Err("the rotation is no quaternion");
        }
        // Files store quaternions in single precision: dividing by the square makes up for the rounding.
        let s = 2.0 / square;
        let rows = [
            [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
        ];
        Ok(Self { linear: rows.map(|[a, b, c]| [a * sx, b * sy, c * sz]), shift })
    }

    /// This map after `inner`.
    pub(super) fn after(&self, inner: &Self) -> Self {
        let [a, b, c] = inner.linear;
        let linear = self.linear.map(|[x, y, z]| {
            let mut row = [0.0; 3];
            for (r, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(&b).zip(&c)) {
                *r = x * a + y * b + z * c;
            }
            row
        });
        Self { linear, shift: self.point(inner.shift) }
    }

    /// Moves a point.
    pub(super) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = apply(&self.linear, p);
        let [a, b, c] = self.shift;
        [x + a, y + b, z + c]
    }

    /// Turns a normal by the inverse transpose; unit length, or zero where it has none.
    pub(super) fn normal(&self, n: [f64; 3]) -> [f64; 3] {
        let sign = if self.determinant() < 0.0 { -1.0 } else { 1.0 };
        let turned = apply(&self.cofactors(), n);
        let length = turned.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length.is_finite() && length > 0.0 { turned.map(|x| sign * x / length) } else { [0.0; 3] }
    }

    /// The factor of volumes: negative for a mirror, zero when everything is flattened.
    pub(super) fn determinant(&self) -> f64 {
        let ([[p, q, r], _, _], [[x, y, z], _, _]) = (self.cofactors(), self.linear);
        x * p + y * q + z * r
    }

    fn cofactors(&self) -> [[f64; 3]; 3] {
        let [a, b, c] = self.linear;
        [cross(b, c), cross(c, a), cross(a, b)]
    }
}

fn apply(rows: &[[f64; 3]; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    rows.map(|[a, b, c]| a * x + b * y + c * z)
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}
