//! Planes, and frames within them.

use glam::{DVec3, DVec4};

/// The points where `normal . p + d = 0`; the normal points to the positive side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The unit normal.
    pub normal: DVec3,
    /// The signed distance of the origin. Unit: length.
    pub d: f64,
}

impl Plane {
    /// The plane through a point with a unit normal.
    #[must_use]
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        Self { normal, d: -normal.dot(point) }
    }

    /// The plane through three points, its normal by the right-hand rule; `None` if they lie on a line.
    #[must_use]
    pub fn from_points(a: DVec3, b: DVec3, c: DVec3) -> Option<Self> {
        let (u, v) = (b - a, c - a);
        let cross = u.cross(v);
        // Below this the cross product of parallel edges is rounding; see the moments of a triangle.
        let has_area = cross.length() > 1.0e-15 * u.length() * v.length();
        has_area.then(|| cross.try_normalize()).flatten().map(|normal| Self::through(a, normal))
    }

    /// How far a point lies on the positive side. Unit: length.
    #[inline]
    #[must_use]
    pub fn signed_distance(&self, p: DVec3) -> f64 {
        self.normal.dot(p) + self.d
    }

    /// The point of the plane nearest to `p`.
    #[must_use]
    pub fn project(&self, p: DVec3) -> DVec3 {
        p - self.normal * self.signed_distance(p)
    }

    /// The coefficients `(normal, d)`.
    #[must_use]
    pub fn to_vec4(&self) -> DVec4 {
        self.normal.extend(self.d)
    }
}

/// Two unit vectors `(t, b)` so that `t`, `b` and the normal are a right-handed orthonormal frame.
///
/// The same for every platform: no trigonometry, and a jump only where the normal's z changes sign. The normal may
/// have any length; of one without direction the frame is x, y.
#[must_use]
pub fn tangent_frame(normal: DVec3) -> (DVec3, DVec3) {
    let n = normal.try_normalize().unwrap_or(DVec3::Z);
    // The reflection that takes the pole on the normal's side to the normal, applied to x and y. The pole keeps
    // 1 + |z| away from zero.
    let sign = 1.0f64.copysign(n.z);
    let k = -1.0 / (sign + n.z);
    let xy = n.x * n.y * k;
    let t = DVec3::new(1.0 + sign * n.x * n.x * k, sign * xy, -sign * n.x);
    let b = DVec3::new(xy, sign + n.y * n.y * k, -n.y);
    (t, b)
}
