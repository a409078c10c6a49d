//! Vectors of three f64: differences of stored f32 are exact or nearly so in them.

pub(crate) type Vector = [f64; 3];

pub(crate) fn widen(v: [f32; 3]) -> Vector {
    v.map(f64::from)
}

pub(crate) fn sub([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ax - bx, ay - by, az - bz]
}

pub(crate) fn dot([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> f64 {
    ax * bx + ay * by + az * bz
}

pub(crate) fn cross([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> Vector {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

pub(crate) fn length(v: Vector) -> f64 {
    dot(v, v).sqrt()
}
