use super::Rng;
use crate::{Containment, Frustum, Sphere};
use glam::{DMat4, DVec3, DVec4, Vec3};

/// Projections with z from 0 to 1 to the near side first, written out: perspective, the same with z reversed, one
/// without far plane, one without far plane and reversed, orthographic.
fn projection(kind: usize, near: f64, far: f64, aspect: f64) -> DMat4 {
    let focal = 1.7;
    let (a, b) = match kind {
        0 => (far / (near - far), near * far / (near - far)),
        1 => (near / (far - near), near * far / (far - near)),
        2 => (-1.0, -near),
        3 => (0.0, near),
        _ => {
            let depth = 1.0 / (near - far);
            return DMat4::from_cols(
                DVec4::X * 0.4 / aspect,
                DVec4::Y * 0.4,
                DVec4::Z * depth,
                DVec4::new(0.0, 0.0, near * depth, 1.0),
            );
        }
    };
    DMat4::from_cols(
        DVec4::X * (focal / aspect),
        DVec4::Y * focal,
        DVec4::new(0.0, 0.0, a, -1.0),
        DVec4::new(0.0, 0.0, b, 0.0),
    )
}

fn camera(rng: &mut Rng, kind: usize) -> DMat4 {
    let near = rng.range(0.01, 0.5);
    let far = near + rng.range(1.0, 8.0);
    let view = DMat4::from_mat3(rng.rotation()) * DMat4::from_translation(rng.in_cube() * 2.0);
    let aspect = rng.range(0.5, 2.0);
    projection(kind, near, far, aspect) * view
}

/// How far within clip space a point is: negative outside.
fn clip_depth(m: &DMat4, p: DVec3) -> f64 {
    let DVec4 { x, y, z, w } = *m * p.extend(1.0);
    [w + x, w - x, w + y, w - y, z, w - z].into_iter().fold(f64::INFINITY, f64::min)
}

/// Against projecting points of the sphere by the matrix.
#[test]
fn classifies_as_projected_points_do() {
    let mut rng = Rng(70);
    let mut seen = [0; 3];
    for round in 0..20_000 {
        let m = camera(&mut rng, round % 5);
        let frustum = Frustum::from_view_projection(&m);
        let sphere = Sphere { center: (rng.in_cube() * 4.0).as_vec3(), radius: rng.range(0.0, 0.8) as f32 };
        let found = frustum.classify_sphere(&sphere);
        seen[found as usize] += 1;
        for _ in 0..10 {
            let p = sphere.center.as_dvec3() + rng.direction() * (f64::from(sphere.radius) * rng.unit());
            let depth = clip_depth(&m, p);
            match found {
                Containment::Outside => assert!(depth < 1.0e-9, "{p} is seen"),
                Containment::Inside => assert!(depth > -1.0e-9, "{p} is not seen"),
                Containment::Crossing => {}
            }
        }
    }
    assert!(seen.iter().all(|&n| n > 500), "{seen:?}");
}

/// A point is never in doubt unless it lies on a plane.
#[test]
fn points_are_decided() {
    let mut rng = Rng(71);
    for round in 0..20_000 {
        let m = camera(&mut rng, round % 5);
        let point = (rng.in_cube() * 4.0).as_vec3();
        let depth = clip_depth(&m, point.as_dvec3());
        let expected = if depth > 1.0e-9 {
            Containment::Inside
        } else if depth < -1.0e-9 {
            Containment::Outside
        } else {
            continue;
        };
        let sphere = Sphere { center: point, radius: 0.0 };
        assert_eq!(Frustum::from_view_projection(&m).classify_sphere(&sphere), expected, "{depth}");
    }
}

/// A sphere that crosses one plane only is known exactly: it crosses up to its radius and no farther.
#[test]
fn spheres_cross_a_plane_within_their_radius() {
    let m = projection(0, 1.0, 1000.0, 1.0);
    let frustum = Frustum::from_view_projection(&m);
    let at = |z: f32| frustum.classify_sphere(&Sphere { center: Vec3::new(0.0, 0.0, z), radius: 0.25 });
    assert_eq!(at(-0.749), Containment::Outside);
    assert_eq!(at(-0.751), Containment::Crossing);
    assert_eq!(at(-1.249), Containment::Crossing);
    assert_eq!(at(-1.251), Containment::Inside);
    assert_eq!(at(-999.7), Containment::Inside);
    assert_eq!(at(-1000.0), Containment::Crossing);
    assert_eq!(at(-1000.3), Containment::Outside);
}

/// In an instance's space a sphere lies where its image lies in the world.
#[test]
fn local_space_agrees_with_world_space() {
    let mut rng = Rng(72);
    for round in 0..5000 {
        let m = camera(&mut rng, round % 5);
        let scale = rng.range(0.1, 5.0);
        let to_world = DMat4::from_translation(rng.in_cube())
            * DMat4::from_mat3(rng.rotation())
            * DMat4::from_scale(DVec3::splat(scale));
        let local = Frustum::from_view_projection(&m).in_local_space(&to_world);
        let sphere =
            Sphere { center: (rng.in_cube() * 4.0 / scale).as_vec3(), radius: (rng.unit() / scale) as f32 };
        assert_eq!(
            local.classify_sphere(&sphere),
            Frustum::from_view_projection(&(m * to_world)).classify_sphere(&sphere)
        );
    }
}

/// A matrix whose z is the same everywhere has no near plane: all or nothing lies behind it.
#[test]
fn a_plane_at_infinity_takes_all_or_nothing() {
    let mut m = DMat4::from_scale(DVec3::new(0.1, 0.1, 0.0));
    let sphere = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 1.0 };
    for (z, expected) in
        [(0.5, Containment::Inside), (-0.5, Containment::Outside), (1.5, Containment::Outside)]
    {
        m.w_axis.z = z;
        let frustum = Frustum::from_view_projection(&m);
        assert_eq!(frustum.classify_sphere(&sphere), expected);
        let moved = DMat4::from_translation(DVec3::ONE);
        assert_eq!(frustum.in_local_space(&moved).classify_sphere(&sphere), expected);
    }
}

#[test]
fn crosses_when_in_doubt() {
    let m = projection(0, 0.1, 10.0, 1.0);
    let frustum = Frustum::from_view_projection(&m);
    let sphere = Sphere { center: Vec3::new(0.0, 0.0, -2.0), radius: 0.1 };
    assert_eq!(frustum.classify_sphere(&sphere), Containment::Inside);
    let odd = [
        Sphere { center: Vec3::NAN, ..sphere },
        Sphere { radius: f32::NAN, ..sphere },
        Sphere { radius: f32::INFINITY, ..sphere },
    ];
    for odd in odd {
        assert_eq!(frustum.classify_sphere(&odd), Containment::Crossing, "{odd:?}");
    }
    let mut broken = m;
    broken.x_axis.x = f64::NAN;
    assert_eq!(Frustum::from_view_projection(&broken).classify_sphere(&sphere), Containment::Crossing);
    assert_eq!(frustum.in_local_space(&broken).classify_sphere(&sphere), Containment::Crossing);
    assert_eq!(frustum.classify_sphere(&Sphere::EMPTY), Containment::Outside);
}
