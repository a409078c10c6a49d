use super::Rng;
use crate::{SymMat3, eigen, smallest_eigenpair, smallest_eigenvalue};

/// Covariances of three random directions, from round to as thin as a sheet of paper, and thin as a needle.
fn covariances() -> impl Iterator<Item = SymMat3> {
    let mut rng = Rng(31);
    (0..4000).map(move |round| {
        let flatness = [1.0, 1e-1, 1e-3, 1e-5][round % 4];
        let width = [1.0, 1.0, 1e-3][round % 3];
        [1.0, width, flatness].iter().fold(SymMat3::ZERO, |m, f| m + SymMat3::outer(rng.in_cube() * *f))
    })
}

/// Against the exact one: never above it, and near it where it is the smallest by far.
#[test]
fn the_quick_smallest_eigenvalue_is_that_of_jacobi() {
    for m in covariances() {
        let values = eigen(&m).values;
        let quick = smallest_eigenvalue(&m);
        let rounding = 1e-13 * values[0] * (1.0 + values[0] / values[1].max(1e-300));
        assert!(quick >= 0.0 && quick <= values[2] + rounding, "{quick} of {values:?}");
        if values[2] < 1e-2 * values[1] {
            assert!((quick - values[2]).abs() <= 1e-6 * values[2] + rounding, "{quick} of {values:?}");
        }
    }
    assert_eq!(smallest_eigenvalue(&SymMat3::ZERO), 0.0);
}

/// The plane is as good as the best: its error is that of Jacobi's, and so is its direction where there is only one.
#[test]
fn the_quick_smallest_vector_is_that_of_jacobi() {
    for m in covariances() {
        let exact = eigen(&m);
        let [a, b, c] = exact.values;
        let (value, vector) = smallest_eigenpair(&m);
        assert!((vector.length() - 1.0).abs() < 1e-14);
        let rounding = 1e-14 * a;
        assert!((value - c).abs() <= 1e-9 * b + rounding, "{value} of {exact:?}");
        assert!((m.quadratic(vector) - c).abs() <= 1e-9 * b + rounding, "{exact:?}");
        let sine = vector.cross(exact.vectors[2]).length();
        assert!(sine * (b - c) <= 1e-7 * b + rounding, "{sine} of {exact:?}");
    }
}

#[test]
fn without_a_single_smallest_vector_the_pair_is_that_of_jacobi() {
    let line = SymMat3 { xx: 2.0, ..SymMat3::ZERO };
    let disc = SymMat3 { xx: 2.0, yy: 1.0, zz: 1.0, ..SymMat3::ZERO };
    for m in [SymMat3::ZERO, SymMat3::IDENTITY, line, disc, line * 1e-200, line * f64::NAN] {
        let (value, vector) = smallest_eigenpair(&m);
        let exact = eigen(&m).smallest();
        assert_eq!(vector, exact.1);
        assert_eq!(value, exact.0.max(0.0));
    }
}

#[test]
fn scaling_by_a_power_of_two_is_exact() {
    for m in covariances() {
        for scale in [2.0_f64.powi(-40), 2.0_f64.powi(40)] {
            let (value, vector) = smallest_eigenpair(&m);
            assert_eq!(smallest_eigenvalue(&(m * scale)), smallest_eigenvalue(&m) * scale);
            assert_eq!(smallest_eigenpair(&(m * scale)), (value * scale, vector));
        }
    }
}
