//! Directed rounding from `f64` to `f32`: what is stored must err on the safe side.

/// The smallest `f32` that is not less than `x`: for radii and errors.
///
/// Beyond `f32::MAX` this is infinity, below `f32::MIN` it is `f32::MIN`; NaN stays NaN.
#[must_use]
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The largest `f32` that is not greater than `x`: for cosines of half angles.
///
/// Beyond `f32::MAX` this is `f32::MAX`, below `f32::MIN` it is minus infinity; NaN stays NaN.
#[must_use]
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}
