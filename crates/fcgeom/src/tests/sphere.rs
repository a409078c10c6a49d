use super::reference::smallest_ball;
use super::{Rng, to_f32};
use crate::{Sphere, round_up};
use glam::{DVec3, Vec3};

/// Points of many shapes: a cloud, a plate, a rod, a shell, a cap, two heaps, repeated points.
fn shape(rng: &mut Rng, kind: usize, count: usize) -> Vec<DVec3> {
    let turn = rng.rotation();
    let offset = rng.in_cube() * 3.0;
    (0..count)
        .map(|i| {
            let p = match kind {
                0 => rng.in_cube(),
                1 => rng.in_cube() * DVec3::new(1.0, 1.0, 0.01),
                2 => rng.in_cube() * DVec3::new(1.0, 0.01, 0.01),
                3 => rng.direction(),
                4 => rng.direction_near(DVec3::Z, 0.4),
                5 => rng.in_cube() * 0.2 + DVec3::X * (i % 2) as f64,
                _ => DVec3::splat((i % 2) as f64),
            };
            turn * p + offset
        })
        .collect()
}

/// Never too small, and not much too large, against the smallest ball.
#[test]
fn encloses_tightly() {
    let mut rng = Rng(50);
    let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    for round in 0..1400 {
        let len = 1 + rng.index(11);
        let points = to_f32(&shape(&mut rng, round % 7, len));
        let sphere = Sphere::of_points(&points);
        assert!(points.iter().all(|p| sphere.contains_point(p.as_dvec3())), "{points:?}");
        let (_, smallest) = smallest_ball(&points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>());
        if smallest > 1.0e-3 {
            let ratio = f64::from(sphere.radius) / smallest;
            assert!(ratio > 1.0 - 1.0e-6, "smaller than the smallest: the reference is wrong");
            worst = worst.max(ratio);
            sum += ratio;
            count += 1.0;
        }
    }
    println!("spheres of points: mean {:.4} worst {worst:.4}", sum / count);
    assert!(worst < 1.12, "{worst}");
    assert!(sum / count < 1.02, "{}", sum / count);
}

/// With many points the smallest ball of a cube's, a sphere's or a plate's cloud is known well enough.
#[test]
fn encloses_large_sets_tightly() {
    let mut rng = Rng(51);
    let cube: Vec<DVec3> = (0..20_000).map(|_| rng.in_cube()).collect();
    let shell: Vec<DVec3> = (0..20_000).map(|_| rng.direction()).collect();
    for (points, smallest) in [(cube, 3.0f64.sqrt()), (shell, 1.0)] {
        let points = to_f32(&points);
        let sphere = Sphere::of_points(&points);
        assert!(points.iter().all(|p| sphere.contains_point(p.as_dvec3())));
        assert!(f64::from(sphere.radius) < smallest * 1.03, "{} {smallest}", sphere.radius);
    }
}

#[test]
fn one_point_or_none() {
    let p = Vec3::new(0.1, -7.0, 3.3);
    assert_eq!(Sphere::of_points([p]), Sphere { center: p, radius: 0.0 });
    assert_eq!(Sphere::of_points([p; 9]), Sphere { center: p, radius: 0.0 });
    let none = Sphere::of_points(&[] as &[Vec3]);
    assert_eq!(none, Sphere::EMPTY);
    assert!(none.is_empty() && !none.contains_point(DVec3::ZERO));
    assert_eq!(none.grown_to_contain([p]), Sphere { center: p, radius: 0.0 });
    let other = Sphere { center: p, radius: 2.0 };
    assert_eq!(Sphere::enclosing(&none, &other), other);
    assert_eq!(Sphere::enclosing(&other, &none), other);
    assert!(other.contains_sphere(&none) && !none.contains_sphere(&other));
}

/// The sphere around two touches both from inside; around one in the other it is the other.
#[test]
fn two_spheres_are_enclosed_by_the_smallest() {
    let mut rng = Rng(52);
    let mut sphere = || {
        let reach = 10.0f64.powf(rng.range(-6.0, 3.0));
        Sphere { center: (rng.in_cube() * reach).as_vec3(), radius: (reach * rng.unit()) as f32 }
    };
    for _ in 0..20_000 {
        let (a, b) = (sphere(), sphere());
        let both = Sphere::enclosing(&a, &b);
        assert!(both.contains_sphere(&a) && both.contains_sphere(&b), "{a:?} {b:?}");
        let distance = a.center.as_dvec3().distance(b.center.as_dvec3());
        let (ra, rb) = (f64::from(a.radius), f64::from(b.radius));
        let smallest = (0.5 * (distance + ra + rb)).max(ra).max(rb);
        // A centre is rounded relative to how far it lies from the origin.
        let slack = 2.0e-7 * (smallest + f64::from(both.center.length()));
        assert!(f64::from(both.radius) <= smallest + slack, "{a:?} {b:?}: {both:?}, smallest {smallest}");
        if distance + rb <= ra {
            assert_eq!(both, a);
        }
    }
}

#[test]
fn a_chain_of_unions_stays_nested() {
    let mut rng = Rng(53);
    let mut all = Vec::new();
    let mut sphere = Sphere::EMPTY;
    for _ in 0..300 {
        let points = to_f32(&[rng.in_cube() * 100.0, rng.in_cube() * 100.0]);
        sphere = Sphere::enclosing(&sphere, &Sphere::of_points(&points));
        all.extend(points);
        assert!(all.iter().all(|p: &Vec3| sphere.contains_point(p.as_dvec3())));
    }
}

#[test]
fn growing_keeps_the_centre_and_goes_no_farther_than_needed() {
    let mut rng = Rng(54);
    for _ in 0..500 {
        let points = to_f32(&shape(&mut rng, 0, 5));
        let start = Sphere { center: rng.in_cube().as_vec3(), radius: rng.unit() as f32 };
        let grown = start.grown_to_contain(&points);
        let farthest =
            points.iter().map(|p| p.as_dvec3().distance(start.center.as_dvec3())).fold(0.0, f64::max);
        assert_eq!(grown.center, start.center);
        assert_eq!(grown.radius, start.radius.max(round_up(farthest)));
        assert!(points.iter().all(|p| grown.contains_point(p.as_dvec3())) && grown.contains_sphere(&start));
    }
}

/// What is not finite is enclosed by everything, and what is huge by what is huge.
#[test]
fn odd_points_make_infinite_spheres() {
    let mut rng = Rng(55);
    let odd = [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, f32::from_bits(1), 0.0, 1.0];
    for _ in 0..5000 {
        let points: Vec<Vec3> =
            (0..3).map(|_| Vec3::from_array([0; 3].map(|_| odd[rng.index(odd.len())]))).collect();
        let sphere = Sphere::of_points(&points);
        assert!(sphere.center.is_finite() && sphere.radius >= 0.0, "{points:?}: {sphere:?}");
        if points.iter().all(|p| p.is_finite()) {
            assert!(points.iter().all(|p| sphere.contains_point(p.as_dvec3())), "{points:?}: {sphere:?}");
        } else {
            assert_eq!(sphere.radius, f32::INFINITY, "{points:?}");
        }
        let one = Sphere { center: Vec3::ONE, radius: 1.0 };
        assert!(Sphere::enclosing(&sphere, &one).contains_sphere(&one));
        for broken in [Sphere { radius: f32::NAN, ..one }, Sphere { center: Vec3::NAN, ..one }] {
            assert_eq!(Sphere::enclosing(&broken, &one).radius, f32::INFINITY);
            assert_eq!(Sphere::enclosing(&one, &broken).radius, f32::INFINITY);
        }
    }
}

/// Scaling by a power of two changes no digit.
#[test]
fn scaling_by_a_power_of_two_is_exact() {
    let mut rng = Rng(56);
    for _ in 0..100 {
        let points = to_f32(&shape(&mut rng, 0, 20));
        let sphere = Sphere::of_points(&points);
        let scaled = Sphere::of_points(points.iter().map(|p| *p * 64.0));
        assert_eq!(scaled, Sphere { center: sphere.center * 64.0, radius: sphere.radius * 64.0 });
    }
}
