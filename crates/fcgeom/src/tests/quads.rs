use super::{Rng, to_f32};
use crate::{Cone, Quads};
use glam::{DVec3, Vec3};

/// Points in two runs of any length, and the groups of the first.
fn runs(rng: &mut Rng, make: impl Fn(&mut Rng) -> DVec3) -> (Vec<Vec3>, Quads, usize) {
    let mut quads = Quads::default();
    let mut points = Vec::new();
    let mut ends = [0; 2];
    for end in &mut ends {
        let len = rng.index(150);
        let run = to_f32(&(0..len).map(|_| make(rng)).collect::<Vec<_>>());
        *end = quads.extend(&run, |p| *p);
        points.extend(run);
    }
    (points, quads, ends[0])
}

/// Groups that are not full count for nothing more than the points in them.
#[test]
fn answers_are_those_of_the_points_one_by_one() {
    let mut rng = Rng(70);
    for _ in 0..300 {
        let (points, quads, first) = runs(&mut rng, |rng| rng.in_cube() * 3.0);
        let direction = rng.direction();
        let heights = |points: &[Vec3]| {
            let h = points.iter().map(|p| {
                let p = p.as_dvec3();
                direction.x * p.x + direction.y * p.y + direction.z * p.z
            });
            (h.clone().fold(f64::INFINITY, f64::min), h.fold(f64::NEG_INFINITY, f64::max))
        };
        assert_eq!(quads.len(), points.len());
        assert_eq!(quads.is_empty(), points.is_empty());
        assert_eq!(quads.extent(0..usize::MAX, direction), (f64::INFINITY, f64::NEG_INFINITY));
        let groups = points.len().div_ceil(4) + 1;
        let both = [
            quads.extent(0..first, direction),
            (first..groups).fold((f64::INFINITY, f64::NEG_INFINITY), |e, i| {
                let one = quads.extent(i..i + 1, direction);
                (e.0.min(one.0), e.1.max(one.1))
            }),
        ];
        assert_eq!((both[0].0.min(both[1].0), both[0].1.max(both[1].1)), heights(&points));

        assert_eq!(quads.extent(quads.groups(), direction), heights(&points));
        let extremes = quads.extremes(quads.groups(), direction);
        assert_eq!(extremes.is_some(), !points.is_empty());
        if let Some(extremes) = extremes {
            let of = extremes.map(|p| direction.x * p.x + direction.y * p.y + direction.z * p.z);
            assert_eq!((of[0], of[1]), heights(&points));
            assert!(extremes.iter().all(|p| points.contains(&p.as_vec3())));
        }
        assert!(quads.extremes(groups..usize::MAX, direction).is_none());

        let sum: DVec3 = points.iter().map(|p| p.as_dvec3()).sum();
        assert!(quads.sum().distance(sum) < 1.0e-3, "{} {sum}", quads.sum());

        let sites: Vec<Vec3> = (0..1 + rng.index(5)).map(|_| rng.in_cube().as_vec3()).collect();
        let nearest = |p: &Vec3| sites.iter().map(|s| s.distance_squared(*p)).fold(f32::INFINITY, f32::min);
        let farthest = points.iter().map(nearest).fold(0.0, f32::max);
        assert!((quads.farthest_from_sites(&sites) - farthest).abs() <= 1.0e-5 * farthest);
    }
}

/// Cones as narrow as single precision allows still hold every normal.
#[test]
fn cones_hold_their_normals_at_all_angles() {
    let mut rng = Rng(72);
    for _ in 0..2000 {
        let (axis, angle) = (rng.direction(), 1.5 * 10.0f64.powi(-(rng.index(8) as i32)));
        let (normals, quads, _) = runs(&mut rng, |rng| rng.direction_near(axis, angle));
        let cone = Cone::of_quads(&quads);
        for n in &normals {
            let (a, n) = (cone.axis.as_dvec3(), n.as_dvec3());
            let cos = a.dot(n) / (a.length() * n.length());
            assert!(cos >= f64::from(cone.cos) - 1.0e-15, "{cone:?} {n} {cos}");
        }
        let start = rng.direction_near(axis, angle).as_vec3();
        let (near, least) = Cone::of_quads_near(&quads, start);
        let naive = normals.iter().map(|n| n.dot(start)).fold(f32::INFINITY, f32::min);
        assert!(least == naive || (least - naive).abs() < 1.0e-6, "{least} {naive}");
        for n in &normals {
            let cos = near.axis.as_dvec3().dot(n.as_dvec3()) / near.axis.as_dvec3().length();
            assert!(cos / n.as_dvec3().length() >= f64::from(near.cos) - 1.0e-15, "{near:?} {n} {cos}");
        }
    }
}
