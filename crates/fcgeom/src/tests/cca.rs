use super::Rng;
use super::reference::{covariances, samples, subdivided};
use crate::{Moments, cca_axis, pca_axis};
use glam::{DMat3, DVec3};

fn moments_of(triangles: &[[DVec3; 3]]) -> Moments {
    let mut sum = Moments::ZERO;
    for &[a, b, c] in triangles {
        sum += Moments::of_triangle(a, b, c);
    }
    sum
}

/// A square cut into triangles, bent by a map.
fn patch(cells: usize, map: impl Fn(DVec3) -> DVec3) -> Vec<[DVec3; 3]> {
    let [a, b, c, d] =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    subdivided(&[[a, b, c], [a, c, d]], cells).into_iter().map(|t| t.map(&map)).collect()
}

/// Equation 15 as printed, with the same ridges: full inverses, and the largest eigenvector by power iteration on the
/// matrix that is not symmetric. Also by how much the iteration still turned, which tells whether there is one.
fn power_iteration(triangles: &[[DVec3; 3]]) -> (DVec3, f64) {
    let (mut rr, mut nn, rn) = covariances(&samples(triangles));
    rr += DMat3::IDENTITY * (1.0e-2 * (rr.x_axis.x + rr.y_axis.y + rr.z_axis.z));
    nn += DMat3::IDENTITY * (1.0e-4 * (nn.x_axis.x + nn.y_axis.y + nn.z_axis.z));
    let b = rr.inverse() * rn * nn.inverse() * rn.transpose();
    let mut v = DVec3::new(0.6, 0.5, 0.7);
    let mut turned = 1.0;
    for _ in 0..2000 {
        let next = (b * v).normalize_or_zero();
        turned = (next - v).length();
        v = next;
    }
    (v, turned)
}

#[test]
fn axis_is_the_principal_vector_of_the_printed_matrix() {
    let mut rng = Rng(30);
    let mut compared = 0;
    for _ in 0..200 {
        let turn = rng.rotation();
        let (p, q, r, stretch) =
            (rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(-0.5, 0.5), rng.range(0.2, 5.0));
        let triangles = patch(6, |v| {
            let (x, y) = (v.x * stretch, v.y);
            turn * DVec3::new(x, y, p * x * x + q * x * y + r * y * y + 0.1 * x * x * y)
        });
        let (expected, turned) = power_iteration(&triangles);
        if turned > 1.0e-12 {
            continue;
        }
        let axis = cca_axis(&moments_of(&triangles)).expect("a curved patch has an axis");
        assert!(axis.dot(expected).abs() > 1.0 - 1.0e-8, "{axis} is not {expected}");
        assert!((axis.length() - 1.0).abs() < 1.0e-15);
        assert!(axis.abs().max_element() == axis.max_element(), "the leading component is positive");
        compared += 1;
    }
    assert!(compared > 150, "only {compared} had a clear principal vector");
}

/// Along a long half pipe nothing turns, across it everything does: there CCA and PCA differ.
#[test]
fn a_half_pipe_is_cut_along_its_length() {
    let mut rng = Rng(31);
    for _ in 0..20 {
        let turn = rng.rotation();
        let triangles = patch(12, |v| {
            let angle = v.x * 1.2;
            turn * DVec3::new(angle.sin(), v.y * 10.0, angle.cos())
        });
        let m = moments_of(&triangles);
        assert!(pca_axis(&m).dot(turn * DVec3::Y).abs() > 0.999);
        assert!(cca_axis(&m).expect("it is curved").dot(turn * DVec3::X).abs() > 0.999);
    }
}

#[test]
fn flat_surfaces_have_no_axis() {
    let mut rng = Rng(32);
    for _ in 0..50 {
        let turn = rng.rotation();
        let single: Vec<_> = patch(5, |v| turn * v + DVec3::new(3.0, 4.0, 5.0));
        assert_eq!(cca_axis(&moments_of(&single)), None);
        assert_eq!(cca_axis(&moments_of(&[rng.triangle()])), None);
    }
}

/// Every face with its reverse: the normals say nothing about where they are.
#[test]
fn uncorrelated_normals_have_no_axis() {
    let mut triangles = Rng(33).triangles(10);
    let reversed: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    triangles.extend(reversed);
    let m = moments_of(&triangles);
    assert!(m.normal_covariance().trace() > 0.1);
    assert_eq!(cca_axis(&m), None);
}

/// Numbers that are broken or out of range give no axis or a unit one, never NaN.
#[test]
fn odd_moments_never_give_a_broken_axis() {
    let mut rng = Rng(34);
    let (mut found, odd) = (0, [0.0, -1.0, 1.0e300, 1.0e-300, f64::NAN, f64::INFINITY]);
    for _ in 0..5000 {
        let triangles = rng.triangles(3);
        let mut m = moments_of(&triangles);
        let value = odd[rng.index(odd.len())];
        match rng.index(6) {
            0 => m.area = value,
            1 => m.second.xx = value,
            2 => m.normal_second.yz = value,
            3 => m.cross.x_axis.y = value,
            4 => m.first.z = value,
            _ => m.normal.x = value,
        }
        if let Some(axis) = cca_axis(&m) {
            assert!((axis.length() - 1.0).abs() < 1.0e-14, "{m:?}");
            found += 1;
        }
    }
    assert!(found > 500, "{found}");
}
