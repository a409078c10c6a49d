use super::reference::{Sample, covariances, samples, subdivided};
use super::{Rng, assert_close, assert_close_mat};
use crate::{FaceMoments, Moments, PlaneFit, SymMat3, cca_axis, pca_axis, point_covariance};
use glam::{DMat3, DVec3, Vec3};

fn moments_of(triangles: &[[DVec3; 3]]) -> Moments {
    let mut sum = Moments::ZERO;
    for &[a, b, c] in triangles {
        sum += Moments::of_triangle(a, b, c);
    }
    sum
}

fn numbers(m: &Moments) -> Vec<f64> {
    let (s, n) = (m.second, m.normal_second);
    let mut all = vec![m.area, s.xx, s.xy, s.xz, s.yy, s.yz, s.zz, n.xx, n.xy, n.xz, n.yy, n.yz, n.zz];
    all.extend(m.first.to_array());
    all.extend(m.normal.to_array());
    all.extend(m.cross.to_cols_array());
    all
}

#[track_caller]
fn assert_close_moments(a: &Moments, b: &Moments, tolerance: f64) {
    for (i, (x, y)) in numbers(a).into_iter().zip(numbers(b)).enumerate() {
        assert!((x - y).abs() <= tolerance, "number {i}: {x} is not {y} within {tolerance}");
    }
}

/// Equations 8, 11 and 14 against the integrals 3, 9 and 12 that they stand for.
#[test]
fn covariances_equal_their_definitions() {
    let mut rng = Rng(1);
    for count in [1, 2, 3, 10, 100] {
        for _ in 0..20 {
            let triangles = rng.triangles(count);
            let m = moments_of(&triangles);
            let (rr, nn, rn) = covariances(&samples(&triangles));
            assert_close_mat(m.position_covariance().to_dmat3(), rr, 1.0e-13);
            assert_close_mat(m.normal_covariance().to_dmat3(), nn, 1.0e-13);
            assert_close_mat(m.cross_covariance(), rn, 1.0e-13);
        }
    }
}

/// The same by brute force, in case the exact quadrature of the reference shares a mistake: a triangle as 128 * 128
/// points.
#[test]
fn a_triangle_is_the_limit_of_dense_points() {
    let mut rng = Rng(2);
    for _ in 0..5 {
        let triangle = rng.triangle();
        let points: Vec<Sample> = subdivided(&[triangle], 128)
            .iter()
            .map(|[a, b, c]| Sample { weight: 1.0, r: (a + b + c) / 3.0, n: DVec3::Z })
            .collect();
        let (rr, _, _) = covariances(&points);
        assert_close_mat(moments_of(&[triangle]).position_covariance().to_dmat3(), rr, 1.0e-4);
    }
}

/// Equation 6 as printed, with its 1/6 and 1/12.
#[test]
fn second_moment_equals_the_printed_sum() {
    let mut rng = Rng(3);
    for _ in 0..50 {
        let v = rng.triangle();
        let area = 0.5 * (v[1] - v[0]).cross(v[2] - v[0]).length();
        let mut sum = DMat3::ZERO;
        for j in 0..3 {
            for k in 0..3 {
                let m = if j == k { 1.0 / 6.0 } else { 1.0 / 12.0 };
                sum += super::reference::outer(v[j], v[k]) * (m * area);
            }
        }
        assert_close_mat(moments_of(&[v]).second.to_dmat3(), sum, 1.0e-14);
    }
}

#[test]
fn moving_the_surface_moves_only_the_centroid() {
    let mut rng = Rng(4);
    let triangles = rng.triangles(30);
    let by = DVec3::new(3.0, -2.0, 0.5);
    let (m, moved) = (
        moments_of(&triangles),
        moments_of(&triangles.clone().into_iter().map(|t| t.map(|p| p + by)).collect::<Vec<_>>()),
    );
    assert_close_moments(&m.translated(by), &moved, 1.0e-12 * moved.area * 10.0);
    assert!((moved.centroid() - m.centroid() - by).length() < 1.0e-13);
    assert_close_mat(moved.position_covariance().into(), m.position_covariance().into(), 1.0e-13);
    assert_close_mat(moved.cross_covariance(), m.cross_covariance(), 1.0e-13);
}

/// What sets the area-integrated form apart from that of equations 1 and 2.
#[test]
fn subdividing_changes_nothing_though_it_changes_the_points() {
    let mut rng = Rng(5);
    let triangles = rng.triangles(6);
    // Only the first half is cut finer, so the points crowd there.
    let mut uneven = subdivided(&triangles[..3], 7);
    uneven.extend(&triangles[3..]);
    let (coarse, fine) = (moments_of(&triangles), moments_of(&uneven));
    assert_close_moments(&coarse, &fine, 1.0e-13);
    assert_close(coarse.epsilon(), fine.epsilon(), 1.0e-14);

    let points = |t: &[[DVec3; 3]]| point_covariance(&t.concat());
    let (coarse, fine) = (points(&triangles), points(&uneven));
    assert!((coarse.trace() - fine.trace()).abs() > 0.1 * coarse.trace(), "the points should notice");
}

/// Equation 1 against equation 2, and the cases that equation 1 divides by zero in.
#[test]
fn point_covariance_follows_equation_two() {
    let mut rng = Rng(6);
    let points: Vec<DVec3> = (0..40).map(|_| rng.in_cube()).collect();
    let n = points.len() as f64;
    let mean = points.iter().sum::<DVec3>() / n;
    let squares = points.iter().fold(SymMat3::ZERO, |sum, &p| sum + SymMat3::outer(p));
    let expected = (squares - SymMat3::outer(mean) * n) * (1.0 / (n - 1.0));
    assert_close_mat(point_covariance(&points).into(), expected.into(), 1.0e-14);
    assert_eq!(point_covariance(&[]), SymMat3::ZERO);
    assert_eq!(point_covariance(&points[..1]), SymMat3::ZERO);
}

/// A unit square, and its copy above: the best plane lies between, half the gap from each.
#[test]
fn epsilon_is_the_mean_square_distance() {
    let quad = |z: f64| {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z));
        [[a, b, c], [a, c, d]]
    };
    let mut rng = Rng(7);
    for gap in [0.0, 0.125, 0.01] {
        let turn = rng.rotation();
        let triangles: Vec<_> = quad(0.0).into_iter().chain(quad(gap)).map(|t| t.map(|p| turn * p)).collect();
        let m = moments_of(&triangles);
        let PlaneFit { centroid, normal, epsilon } = m.plane();
        assert_close(epsilon, gap * gap / 4.0, 1.0e-15);
        assert_close(m.epsilon(), epsilon, 0.0);
        assert!(m.epsilon() >= 0.0);
        assert!((normal - turn * DVec3::Z).length() < 1.0e-12, "on the side of the mean normal");
        assert!((centroid - turn * DVec3::new(0.5, 0.5, gap / 2.0)).length() < 1.0e-14);
        let plane = m.plane().plane();
        let mean_square =
            samples(&triangles).iter().map(|s| s.weight * plane.signed_distance(s.r).powi(2)).sum::<f64>()
                / m.area;
        assert_close(mean_square, epsilon, 1.0e-15);
    }
}

#[test]
fn pca_axis_is_the_longest_extent() {
    let mut rng = Rng(8);
    for _ in 0..20 {
        let turn = rng.rotation();
        let long = |p: DVec3| turn * (p * DVec3::new(5.0, 1.0, 1.0));
        let triangles: Vec<_> = rng.triangles(400).into_iter().map(|t| t.map(long)).collect();
        let axis = pca_axis(&moments_of(&triangles));
        assert!(axis.dot(turn * DVec3::X).abs() > 0.99);
        assert!(axis.abs().max_element() == axis.max_element(), "the leading component is positive");
    }
}

/// Unions add up, in any order, to within rounding.
#[test]
fn parts_add_up() {
    let triangles = Rng(9).triangles(40);
    let mut sum = moments_of(&triangles[..13]);
    sum.add(&moments_of(&triangles[13..]));
    assert_close_moments(&sum, &moments_of(&triangles), 1.0e-13);
}

#[test]
fn a_triangle_without_area_contributes_nothing() {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let a = p(0.1, 0.2, 0.3);
    let d = p(0.7, -0.3, 1.1);
    for [a, b, c] in [
        [a, a, a],
        [a, a, d],
        [a, a + d, a + d * 3.0],
        [a, a + d * 0.1, a - d * 0.7],
        [a, d, p(f64::NAN, 0.0, 0.0)],
        [a, d, p(f64::INFINITY, 0.0, 0.0)],
        [a, p(1.0e200, 0.0, 0.0), p(0.0, 1.0e200, 0.0)],
    ] {
        assert_eq!(Moments::of_triangle(a, b, c), Moments::ZERO, "{a} {b} {c}");
    }
    // A sliver on a fine grid is thin, not degenerate.
    let fine = f64::from(1 << 24);
    let sliver = Moments::of_triangle(DVec3::ZERO, p(fine, fine - 1.0, 0.0), p(fine - 1.0, fine - 2.0, 0.0));
    assert_eq!(sliver.area, 0.5);
    assert_eq!(sliver.normal, p(0.0, 0.0, -0.5));
}

#[test]
fn all_of_nothing_is_zero() {
    let nothing = Moments::default();
    assert_eq!(nothing, Moments::ZERO);
    assert_eq!(nothing.cross, DMat3::ZERO);
    assert_eq!(nothing.centroid(), DVec3::ZERO);
    assert_eq!(nothing.mean_normal(), DVec3::ZERO);
    assert_eq!(nothing.position_covariance(), SymMat3::ZERO);
    assert_eq!(nothing.normal_covariance(), SymMat3::ZERO);
    assert_eq!(nothing.cross_covariance(), DMat3::ZERO);
    assert_eq!(nothing.plane(), PlaneFit { centroid: DVec3::ZERO, normal: DVec3::Z, epsilon: 0.0 });
    assert_eq!(pca_axis(&nothing), DVec3::X);
    assert_eq!(cca_axis(&nothing), None);
}

/// The record that the builder keeps is the triangle, up to the precision of f32.
#[test]
fn face_records_sum_to_the_moments() {
    let mut rng = Rng(10);
    let origin = DVec3::new(20.0, -10.0, 5.0);
    let triangles: Vec<[DVec3; 3]> =
        (0..200).map(|_| rng.triangle().map(|p| (p + origin).as_vec3().as_dvec3())).collect();
    let mut sum = Moments::ZERO;
    for [a, b, c] in &triangles {
        sum.accumulate(&FaceMoments::of_triangle(a.as_vec3(), b.as_vec3(), c.as_vec3()), origin);
    }
    let expected = moments_of(&triangles).translated(-origin);
    assert_close_moments(&sum, &expected, 3.0e-7 * 20.0 * expected.area);
    assert_close(sum.epsilon(), expected.epsilon(), 1.0e-6);
    assert_eq!(size_of::<FaceMoments>(), 52);
}

#[test]
fn face_records_are_finite_for_any_input() {
    let mut rng = Rng(11);
    let odd = [0.0, -0.0, 1.0, f32::MAX, f32::MIN, f32::from_bits(1), 1.0e19, f32::NAN, f32::INFINITY];
    for _ in 0..20_000 {
        let mut point = || {
            Vec3::from_array([0; 3].map(|_| {
                let any = f32::from_bits(rng.next() as u32);
                if rng.unit() < 0.5 { any } else { odd[rng.index(odd.len())] }
            }))
        };
        let [a, b, c] = [point(), point(), point()];
        let f = FaceMoments::of_triangle(a, b, c);
        assert!(f.centroid.is_finite() && f.normal.is_finite() && f.area.is_finite() && f.area >= 0.0);
        assert!(f.spread.iter().all(|x| x.is_finite()));
        assert!(f.normal == Vec3::ZERO || (f.normal.length() - 1.0).abs() < 1.0e-6);
        let mut sum = Moments::ZERO;
        sum.accumulate(&f, DVec3::ZERO);
        let epsilon = sum.epsilon();
        assert!(epsilon >= 0.0 && epsilon.is_finite(), "{a} {b} {c}: {epsilon}");
    }
}

/// A unit of length that is a power of two changes no digit of anything.
#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let triangles = Rng(12).triangles(50);
    let m = moments_of(&triangles);
    for scale in [2.0f64.powi(-30), 0.5, 1024.0] {
        let scaled = moments_of(&triangles.iter().map(|t| t.map(|p| p * scale)).collect::<Vec<_>>());
        assert_eq!(scaled.epsilon(), m.epsilon() * scale * scale);
        assert_eq!(scaled.plane().normal, m.plane().normal);
        assert_eq!(pca_axis(&scaled), pca_axis(&m));
        assert_eq!(cca_axis(&scaled), cca_axis(&m));
    }
}
