use super::{Rng, assert_close_mat};
use crate::symmetric::with_fixed_sign;
use crate::{Eigen, SymMat3, eigen};
use glam::{DMat3, DVec3};
use proptest::prelude::*;

/// Everything that an eigensystem promises, relative to the size of the matrix.
#[track_caller]
fn check(m: &SymMat3) -> Eigen {
    let e = eigen(m);
    let size = m.max_abs().max(f64::MIN_POSITIVE);
    let [a, b, c] = e.vectors;
    assert!(e.values[0] >= e.values[1] && e.values[1] >= e.values[2], "descending: {e:?}");
    for (value, vector) in e.values.into_iter().zip(e.vectors) {
        assert!(value.is_finite() && vector.is_finite(), "{m:?} {e:?}");
        // Scaled, so that neither the product of matrix and vector nor its squared length leave the range.
        let residual = ((*m * 0.125).mul_vec(vector) - vector * (value * 0.125)) / size;
        assert!(residual.length() <= 1.0e-15, "{m:?}: {residual}");
        assert!((vector.length() - 1.0).abs() < 1.0e-15);
    }
    assert!(a.dot(b).abs() < 1.0e-15 && b.dot(c).abs() < 1.0e-15 && c.dot(a).abs() < 1.0e-15);
    assert!(a.cross(b).dot(c) > 0.9, "right-handed");
    assert_eq!([a, b], [with_fixed_sign(a), with_fixed_sign(b)], "signed by the rule");
    e
}

fn random(rng: &mut Rng) -> SymMat3 {
    SymMat3::symmetric_part(&DMat3::from_cols(rng.in_cube(), rng.in_cube(), rng.in_cube()))
}

/// A rotated diagonal.
fn with_values(values: DVec3, turn: &DMat3) -> SymMat3 {
    SymMat3::symmetric_part(&(*turn * DMat3::from_diagonal(values) * turn.transpose()))
}

#[test]
fn solves_random_matrices() {
    let mut rng = Rng(20);
    for _ in 0..3000 {
        check(&random(&mut rng));
    }
}

#[test]
fn finds_the_values_it_was_made_of() {
    let mut rng = Rng(21);
    for values in [
        DVec3::new(3.0, 2.0, 1.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, 1.0e-9, 1.0e-18),
        DVec3::new(2.0, -1.0, -1.0),
        DVec3::new(1.0, 1.0 - 1.0e-13, 1.0 - 2.0e-13),
        DVec3::new(0.0, 0.0, -5.0),
    ] {
        for _ in 0..50 {
            let found = check(&with_values(values, &rng.rotation())).values;
            for (found, value) in found.into_iter().zip(values.to_array()) {
                assert!(
                    (found - value).abs() < 2.0e-15 * values.abs().max_element(),
                    "{found} is not {value}"
                );
            }
        }
    }
}

/// The determinant of a matrix with rows and columns scaled by 1, 2^-20, 2^-40 is known exactly, and is lost if the
/// smallest value is found only to the precision of the largest.
#[test]
fn small_values_of_a_graded_matrix_keep_their_digits() {
    let mut rng = Rng(22);
    for _ in 0..200 {
        let m = with_values(DVec3::new(3.0, 2.0, 1.0), &rng.rotation());
        let (p, q) = (2.0f64.powi(-20), 2.0f64.powi(-40));
        let graded = SymMat3 {
            xx: m.xx,
            xy: m.xy * p,
            xz: m.xz * q,
            yy: m.yy * p * p,
            yz: m.yz * p * q,
            zz: m.zz * q * q,
        };
        let [a, b, c] = check(&graded).values;
        let determinant = a * b * c * 2.0f64.powi(120);
        assert!((determinant - 6.0).abs() < 1.0e-12, "{determinant}");
    }
}

#[test]
fn zero_and_diagonal_matrices_keep_the_axes_in_order() {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    assert_eq!(eigen(&SymMat3::ZERO), Eigen { values: [0.0; 3], vectors: axes });
    assert_eq!(eigen(&(SymMat3::IDENTITY * -2.0)), Eigen { values: [-2.0; 3], vectors: axes });
    let d = SymMat3 { xx: 1.0, yy: 3.0, zz: 2.0, ..SymMat3::ZERO };
    assert_eq!(check(&d).vectors, [DVec3::Y, DVec3::Z, DVec3::X]);
}

#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let mut rng = Rng(23);
    for _ in 0..200 {
        let m = random(&mut rng);
        let e = eigen(&m);
        for exponent in [-500, -1, 1, 900] {
            let scale = 2.0f64.powi(exponent);
            assert_eq!(eigen(&(m * scale)), Eigen { values: e.values.map(|v| v * scale), ..e });
        }
    }
}

#[test]
fn extreme_sizes_are_solved() {
    let mut rng = Rng(24);
    for _ in 0..200 {
        let m = random(&mut rng);
        for scale in [1.0e-300, 1.0e-150, 1.0e150, 1.0e307] {
            check(&(m * scale));
        }
        // Of subnormals a few digits are left, and still nothing breaks.
        let e = eigen(&(m * 1.0e-320));
        assert!(e.vectors.iter().all(|v| (v.length() - 1.0).abs() < 1.0e-15));
    }
    let d = SymMat3 { xx: 1.0e308, yy: 1.7e308, zz: 1.0, ..SymMat3::ZERO };
    assert_eq!(check(&d).values, [1.7e308, 1.0e308, 1.0]);
    let all = |x: f64| SymMat3 { xx: x, xy: x, xz: x, yy: x, yz: x, zz: x };
    assert_eq!(eigen(&all(f64::MAX)).values[0], f64::MAX, "three times the entry is out of range");
    assert!(eigen(&all(f64::NAN)).values.iter().all(|v| v.is_nan()));
    assert!(eigen(&SymMat3 { xy: f64::INFINITY, ..SymMat3::ZERO }).vectors.iter().all(|v| v.is_finite()));
}

proptest! {
    /// Entries of wildly different sizes, exact zeros among them.
    #[test]
    fn any_finite_matrix_is_finite_and_orthonormal(entries in proptest::array::uniform6(proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO)) {
        let [xx, xy, xz, yy, yz, zz] = entries;
        let e = eigen(&SymMat3 { xx, xy, xz, yy, yz, zz });
        prop_assert!(e.values.iter().all(|v| v.is_finite()));
        let frame = DMat3::from_cols(e.vectors[0], e.vectors[1], e.vectors[2]);
        prop_assert!((frame.transpose() * frame).abs_diff_eq(DMat3::IDENTITY, 1.0e-14), "{:?}", e);
    }

    #[test]
    fn graded_by_small_exponents_is_solved(entries in proptest::array::uniform6((-1.0f64..1.0, -30i32..30))) {
        let [xx, xy, xz, yy, yz, zz] = entries.map(|(x, e)| x * 2.0f64.powi(e));
        check(&SymMat3 { xx, xy, xz, yy, yz, zz });
    }
}

#[test]
fn operations_equal_those_of_full_matrices() {
    let mut rng = Rng(25);
    for _ in 0..50 {
        let (a, b, v, w) = (random(&mut rng), random(&mut rng), rng.in_cube(), rng.in_cube());
        let (full_a, full_b) = (a.to_dmat3(), b.to_dmat3());
        assert_close_mat((a + b).into(), full_a + full_b, 0.0);
        assert_close_mat((a - b).into(), full_a - full_b, 0.0);
        assert_close_mat(a.scale(3.0).into(), full_a * 3.0, 0.0);
        assert!((a.mul_vec(v) - full_a * v).length() < 1.0e-15);
        assert!((a.quadratic(v) - v.dot(full_a * v)).abs() < 1.0e-15);
        assert_eq!(a.trace(), full_a.x_axis.x + full_a.y_axis.y + full_a.z_axis.z);
        let pair = super::reference::outer(v, w) + super::reference::outer(w, v);
        assert_close_mat(SymMat3::outer_pair(v, w).into(), pair, 1.0e-16);
        assert_eq!(SymMat3::outer(v) * 2.0, SymMat3::outer_pair(v, v));
    }
}

#[test]
fn the_sign_rule_takes_the_first_of_the_largest() {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    assert_eq!(with_fixed_sign(v(-1.0, 1.0, 1.0)), v(1.0, -1.0, -1.0));
    assert_eq!(with_fixed_sign(v(0.5, -1.0, 1.0)), v(-0.5, 1.0, -1.0));
    assert_eq!(with_fixed_sign(v(0.5, 0.5, -0.6)), v(-0.5, -0.5, 0.6));
    assert_eq!(with_fixed_sign(DVec3::ZERO), DVec3::ZERO);
}
