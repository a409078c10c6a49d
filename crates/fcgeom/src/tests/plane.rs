use super::{Rng, assert_close};
use crate::{Plane, tangent_frame};
use glam::{DMat3, DVec3};

#[test]
fn a_plane_through_three_points_holds_them_and_faces_the_right_way() {
    let mut rng = Rng(40);
    for _ in 0..500 {
        let [a, b, c] = rng.triangle();
        let plane = Plane::from_points(a, b, c).expect("random points make a triangle");
        for p in [a, b, c] {
            assert_close(plane.signed_distance(p), 0.0, 1.0e-14);
        }
        let above = (a + b + c) / 3.0 + (b - a).cross(c - a).normalize_or_zero() * 0.25;
        assert_close(plane.signed_distance(above), 0.25, 1.0e-13);
        let foot = plane.project(above);
        assert!((foot - (a + b + c) / 3.0).length() < 1.0e-13);
    }
}

#[test]
fn points_on_a_line_have_no_plane() {
    let (a, d) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.7, -0.3, 1.1));
    assert_eq!(Plane::from_points(a, a, a), None);
    assert_eq!(Plane::from_points(a, d, d), None);
    assert_eq!(Plane::from_points(a, a + d * 0.3, a + d * 0.9), None);
    assert_eq!(Plane::from_points(a, d, DVec3::NAN), None);
}

#[test]
fn a_frame_is_orthonormal_and_right_handed_everywhere() {
    let mut rng = Rng(41);
    let near =
        [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(1.0e-9, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0e-300)];
    let random: Vec<DVec3> = (0..2000).map(|_| rng.direction()).collect();
    for n in random.into_iter().chain(near) {
        for normal in [n, n * 1.0e-6, n * 1.0e6] {
            let (t, b) = tangent_frame(normal);
            let frame = DMat3::from_cols(t, b, n.normalize_or_zero());
            assert!((frame.transpose() * frame).abs_diff_eq(DMat3::IDENTITY, 1.0e-14), "{n}");
            assert_close(frame.determinant(), 1.0, 1.0e-14);
        }
    }
}

#[test]
fn no_direction_gives_the_default_frame() {
    for n in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(tangent_frame(n), (DVec3::X, DVec3::Y));
    }
}
