use super::reference::smallest_ball;
use super::{Rng, to_f32};
use crate::{Cone, Glance, Side, Sphere};
use glam::{DVec3, Vec3};

/// The cosine as the stored cone has it, with nothing but the definition.
fn cos_to_axis(cone: &Cone, n: Vec3) -> f64 {
    let (a, n) = (cone.axis.as_dvec3(), n.as_dvec3());
    a.dot(n) / (a.length() * n.length())
}

fn degrees(cos: f64) -> f64 {
    cos.clamp(-1.0, 1.0).acos().to_degrees()
}

/// Every normal lies within; and against the smallest cone, which is that of the smallest ball, little is wasted.
#[test]
fn holds_all_normals_tightly() {
    let mut rng = Rng(60);
    let (mut worst, mut sum, mut count, mut full) = (0.0f64, 0.0, 0.0, 0);
    for _ in 0..1500 {
        let (axis, angle) = (rng.direction(), rng.range(0.01, 1.5));
        let len = 1 + rng.index(11);
        let normals = to_f32(&(0..len).map(|_| rng.direction_near(axis, angle)).collect::<Vec<_>>());
        let cone = Cone::of_normals(&normals);
        assert!((cone.axis.length() - 1.0).abs() < 1.0e-6);
        if cone == Cone::FULL {
            full += 1;
            continue;
        }
        for &n in &normals {
            // The last digits of a quotient and of a product with the inverse differ.
            assert!(cos_to_axis(&cone, n) >= f64::from(cone.cos) - 1.0e-15, "{cone:?} {n}");
        }
        let (center, _) = smallest_ball(&normals.iter().map(|n| n.as_dvec3()).collect::<Vec<_>>());
        let best = normals.iter().map(|n| n.as_dvec3().dot(center) / center.length()).fold(1.0, f64::min);
        let mean = normals.iter().map(|n| n.as_dvec3()).sum::<DVec3>().normalize_or_zero();
        let about_mean = normals.iter().map(|n| n.as_dvec3().dot(mean)).fold(1.0, f64::min);
        assert!(f64::from(cone.cos) >= about_mean - 1.0e-5, "wider than about the mean normal");
        let excess = degrees(f64::from(cone.cos)) - degrees(best);
        assert!(excess > -0.03, "narrower than the narrowest: the reference is wrong");
        if degrees(best) > 1.0 {
            let ratio = degrees(f64::from(cone.cos)) / degrees(best);
            worst = worst.max(ratio);
            sum += ratio;
            count += 1.0;
        }
    }
    println!("cones of normals: mean {:.4} worst {worst:.4}, {full} full", sum / count);
    assert!(worst < 1.15, "{worst}");
    assert!(sum / count < 1.02, "{}", sum / count);
    assert!(full < 30, "{full}");
}

/// A fan of normals crowded at one end: the mean leans there, the ball does not.
#[test]
fn is_no_wider_than_about_the_mean_normal() {
    let mut rng = Rng(61);
    let mut gain = 0.0;
    for _ in 0..300 {
        let axis = rng.direction();
        let mut normals: Vec<DVec3> = (0..20).map(|_| rng.direction_near(axis, 0.1)).collect();
        normals.extend((0..2).map(|_| rng.direction_near(axis, 1.0)));
        let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
        let about_mean = normals.iter().map(|n| n.dot(mean)).fold(1.0, f64::min);
        let cone = Cone::of_normals(to_f32(&normals));
        assert!(f64::from(cone.cos) >= about_mean - 1.0e-5);
        gain += degrees(about_mean) / degrees(f64::from(cone.cos));
    }
    assert!(gain / 300.0 > 1.2, "{}", gain / 300.0);
}

#[test]
fn no_cone_is_the_full_one() {
    let full = |normals: &[Vec3]| assert_eq!(Cone::of_normals(normals), Cone::FULL, "{normals:?}");
    full(&[]);
    full(&[Vec3::ZERO; 3]);
    full(&[Vec3::X, Vec3::NEG_X]);
    full(&[Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)]);
    full(&[Vec3::X, Vec3::NAN]);
    full(&[Vec3::X, Vec3::INFINITY]);
    assert!(!Cone::FULL.is_backfacing(&Sphere { center: Vec3::Z, radius: 0.1 }, DVec3::ZERO));
    assert!(!Cone::FULL.is_backfacing_along(DVec3::Z));
}

#[test]
fn faces_without_area_do_not_matter() {
    let cone = Cone::of_normals([Vec3::Z, Vec3::ZERO]);
    assert_eq!(cone, Cone { axis: Vec3::Z, cos: 1.0 });
}

/// A cosine is that of an angle, whatever the length of the vectors.
#[test]
fn lengths_do_not_change_an_angle() {
    let mut rng = Rng(64);
    for _ in 0..500 {
        let axis = rng.direction();
        let normals: Vec<Vec3> =
            (0..9).map(|_| (rng.direction_near(axis, 0.5) * rng.range(0.5, 2.0)).as_vec3()).collect();
        let cone = Cone::of_normals(&normals);
        assert!(normals.iter().all(|&n| cos_to_axis(&cone, n) >= f64::from(cone.cos) - 1.0e-15));
    }
    let tiny = Cone::of_normals([Vec3::X * f32::from_bits(1)]);
    assert_eq!(tiny, Cone { axis: Vec3::X, cos: 1.0 });
}

/// One way: what is culled, no point with any normal faces the eye. The other way: what clearly could be culled, is.
#[test]
fn culls_exactly_what_faces_away() {
    let mut rng = Rng(62);
    let (mut culled, mut kept) = (0, 0);
    for _ in 0..20_000 {
        let (axis, half) = (rng.direction(), rng.range(0.0, 1.5));
        let cone = Cone { axis: axis.as_vec3(), cos: half.cos() as f32 };
        let eye = rng.in_cube() * 3.0;
        let sphere = Sphere { center: rng.in_cube().as_vec3(), radius: rng.range(0.0, 1.0) as f32 };
        let to_center = sphere.center.as_dvec3() - eye;
        let (distance, radius) = (to_center.length(), f64::from(sphere.radius));
        let ratio = radius / distance;
        let total = if ratio < 1.0 {
            degrees(to_center.dot(axis) / distance) + half.to_degrees() + ratio.asin().to_degrees()
        } else {
            f64::INFINITY
        };
        let back = cone.is_backfacing(&sphere, eye);
        if back {
            culled += 1;
            for _ in 0..20 {
                let p = sphere.center.as_dvec3() + rng.direction() * radius;
                let n = rng.direction_near(axis, half);
                assert!(n.dot(p - eye) >= 0.0, "a face at {p} with normal {n} faces {eye}");
            }
        } else {
            kept += 1;
        }
        assert_eq!(back, if back { total <= 90.0 } else { total <= 90.0 - 0.02 }, "{total} degrees");
        let front = cone.side(&sphere, eye) == Some(Side::Front);
        assert!(!(front && back), "both sides");
        assert_eq!(
            front,
            Cone { axis: -cone.axis, ..cone }.is_backfacing(&sphere, eye),
            "the cone turned round"
        );
    }
    assert!(culled > 1000 && kept > 1000, "{culled} {kept}");
}

/// What is clear at a glance is so, most is clear, and what lies at the edge is not.
#[test]
fn a_glance_agrees() {
    let mut rng = Rng(66);
    let (mut clear, mut sides) = (0, [0; 2]);
    let rounds = 200_000;
    for round in 0..rounds {
        let (axis, half, sphere_angle) = (rng.direction(), rng.range(0.0, 1.7), rng.range(0.0, 1.5));
        // Every other one next to the edge.
        let is_near = round % 2 == 0;
        let slack = if is_near { rng.range(-2.0e-5, 2.0e-5) } else { rng.range(-1.0, 1.0) };
        let tilt = std::f64::consts::FRAC_PI_2 - half - sphere_angle + slack;
        let side = axis.any_orthonormal_vector();
        let turned = if rng.unit() < 0.5 { 1.0 } else { -1.0 };
        let to_center = (axis * tilt.cos() + side * tilt.sin()) * rng.range(0.5, 20.0) * turned;
        let eye = rng.in_cube() * 10.0;
        let center = (eye + to_center).as_vec3();
        let sphere = Sphere { center, radius: (to_center.length() * sphere_angle.sin()) as f32 };
        let cone = Cone { axis: axis.as_vec3(), cos: half.cos() as f32 };
        let cos = f64::from(cone.cos);
        let sin_cos = [((1.0 - cos) * (1.0 + cos)).sqrt() as f32, cone.cos];
        let exact = cone.side_exactly(&sphere, eye);
        if let Glance::Clear(seen) = Cone::side_at_a_glance(cone.axis, sin_cos, &sphere, eye) {
            assert_eq!(seen, exact, "{cone:?} {sphere:?} {eye}");
            clear += u32::from(!is_near);
        }
        assert_eq!(cone.side(&sphere, eye), exact);
        sides = [Side::Front, Side::Back]
            .map(|s| u32::from(exact == Some(s)) + sides[usize::from(s == Side::Back)]);
    }
    assert!(f64::from(clear) > 0.85 * f64::from(rounds / 2), "{clear}");
    assert!(sides.iter().all(|n| *n > 1000), "{sides:?}");
}

/// Right at 90 degrees, where rounding would decide: never over it, nor so little under it that the rounding of
/// normals could be at fault, and always clearly under it.
#[test]
fn decides_the_edge_for_safety() {
    let mut rng = Rng(65);
    for _ in 0..20_000 {
        let (axis, half, sphere_angle) = (rng.direction(), rng.range(0.2, 0.6), rng.range(0.0, 0.6));
        let slack = if rng.unit() < 0.5 { rng.range(-1.0e-7, 1.0e-5) } else { rng.range(-1.0e-4, -1.0e-5) };
        let tilt = std::f64::consts::FRAC_PI_2 - half - sphere_angle + slack;
        let side = axis.any_orthonormal_vector();
        let to_center = (axis * tilt.cos() + side * tilt.sin()) * rng.range(0.5, 20.0);
        let sphere = Sphere { center: Vec3::ZERO, radius: (to_center.length() * sphere_angle.sin()) as f32 };
        let cone = Cone { axis: axis.as_vec3(), cos: half.cos() as f32 };
        assert_eq!(cone.is_backfacing(&sphere, -to_center), slack <= -1.0e-5, "{slack} beyond 90 degrees");
        let tilt = tilt + sphere_angle;
        let view = axis * tilt.cos() + side * tilt.sin();
        assert_eq!(cone.is_backfacing_along(view), slack <= -1.0e-5, "{slack} beyond 90 degrees");
    }
}

#[test]
fn culls_along_a_direction_what_faces_away() {
    let mut rng = Rng(63);
    for _ in 0..20_000 {
        let (axis, half) = (rng.direction(), rng.range(0.0, 1.5));
        let cone = Cone { axis: axis.as_vec3(), cos: half.cos() as f32 };
        let view = rng.direction() * rng.range(0.01, 100.0);
        let total = degrees(axis.dot(view) / view.length()) + half.to_degrees();
        let back = cone.is_backfacing_along(view);
        assert_eq!(back, if back { total <= 90.0 } else { total <= 90.0 - 0.02 }, "{total} degrees");
    }
}

#[test]
fn is_not_backfacing_when_in_doubt() {
    let cone = Cone { axis: Vec3::Z, cos: 1.0 };
    let sphere = Sphere { center: Vec3::new(0.0, 0.0, 10.0), radius: 1.0 };
    assert!(cone.is_backfacing(&sphere, DVec3::ZERO), "looking at its back");
    assert!(!cone.is_backfacing(&sphere, DVec3::Z * 20.0), "looking at its front");
    assert!(!cone.is_backfacing(&sphere, DVec3::Z * 9.5), "inside");
    assert!(!cone.is_backfacing(&sphere, DVec3::Z * 9.0), "on the sphere");
    assert!(!cone.is_backfacing(&sphere, DVec3::NAN));
    assert!(!cone.is_backfacing(&sphere, DVec3::INFINITY));
    assert!(!cone.is_backfacing(&Sphere { radius: f32::NAN, ..sphere }, DVec3::ZERO));
    assert!(!cone.is_backfacing(&Sphere { radius: f32::INFINITY, ..sphere }, DVec3::ZERO));
    assert!(!cone.is_backfacing(&Sphere { center: Vec3::NAN, ..sphere }, DVec3::ZERO));
    assert!(!cone.is_backfacing(&Sphere::EMPTY, DVec3::Z * -5.0));
    assert!(!Cone { axis: Vec3::NAN, ..cone }.is_backfacing(&sphere, DVec3::ZERO));
    assert!(!Cone { axis: Vec3::ZERO, ..cone }.is_backfacing(&sphere, DVec3::ZERO));
    assert!(!Cone { cos: f32::NAN, ..cone }.is_backfacing(&sphere, DVec3::ZERO));
    assert!(!Cone { cos: f32::NAN, ..cone }.is_backfacing_along(DVec3::Z));
    assert!(!cone.is_backfacing_along(DVec3::ZERO) && !cone.is_backfacing_along(DVec3::NAN));
}
