//! A cut of equally many clusters, whatever the tree, and what its bounds are worth.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use fcgeom::{Cone, Sphere};
use fct::{BoundingPolygon, Child, Error, Node, Subtree, Tree};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Clusters that cover a mesh once.
#[derive(Debug)]
pub(crate) struct Cut {
    /// Clusters of two faces and more.
    clusters: Vec<Cluster>,
    /// Faces that are clusters of their own.
    single_faces: usize,
}

#[derive(Debug)]
struct Cluster {
    subtree: Subtree,
    node: Node,
}

/// What the bounds of a cut are worth; less is better.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Culls {
    /// Cross-sections of the spheres over the area of the clusters.
    pub(crate) sphere: f64,
    /// Mean half angle of the cones in degrees, 180 for one that culls nothing.
    pub(crate) half_angle: f64,
    /// Share of the area turned away that the cones keep.
    pub(crate) kept: f64,
    /// Projected area of the bounding polygons over that of the faces in them; none without a bounding polygon.
    pub(crate) overdraw: Option<f64>,
}

/// Directions to look along, spread evenly.
const DIRECTIONS: usize = 64;

impl Cut {
    /// The cut of `count` clusters that refines the largest budget keys first; fewer if the tree has fewer.
    ///
    /// # Errors
    /// When the tree is damaged.
    pub(crate) fn of(tree: &Tree, count: usize) -> Result<Cut, Error> {
        let mut heap = BinaryHeap::new();
        let mut single_faces = 0;
        let mut add = |heap: &mut BinaryHeap<Waiting>, subtree: Subtree| -> Result<(), Error> {
            match subtree.child.kind() {
                Child::Face(_) => single_faces += 1,
                Child::Node(_) => heap.push(Waiting { node: tree.node(&subtree)?, subtree }),
            }
            Ok(())
        };
        add(&mut heap, tree.whole())?;
        let mut clusters = 1;
        while clusters < count {
            let Some(Waiting { subtree, .. }) = heap.pop() else { break };
            for child in tree.children(&subtree)? {
                add(&mut heap, child)?;
            }
            clusters += 1;
        }
        let clusters = heap.into_iter().map(|w| Cluster { subtree: w.subtree, node: w.node }).collect();
        Ok(Cut { clusters, single_faces })
    }

    /// What is wrong with the cut and its bounds.
    pub(crate) fn wrong(&self, tree: &Tree, faces: &[[u32; 3]]) -> impl Iterator<Item = String> {
        let covered: usize = self.clusters.iter().map(|c| c.subtree.face_count() as usize).sum();
        let covers = covered + self.single_faces == faces.len();
        let covers = (!covers).then(|| "the clusters do not cover the faces once".to_owned());
        let broken = self.clusters.par_iter().filter_map(|c| c.broken(tree, faces));
        covers.into_iter().chain(broken.collect::<Vec<_>>())
    }

    /// Measures the bounds of its clusters of two faces and more.
    pub(crate) fn culls(&self, tree: &Tree, faces: &[[u32; 3]]) -> Culls {
        let directions = directions();
        // In the order of the clusters, so that sums are the same on every run.
        let parts: Vec<Part> =
            self.clusters.par_iter().map(|c| Part::of(c, tree, faces, &directions)).collect();
        let sum = |value: fn(&Part) -> f64| parts.iter().map(value).sum::<f64>();
        let outlined = sum(|p| p.seen_faces);
        Culls {
            sphere: sum(|p| p.cross_section) / sum(|p| p.area),
            half_angle: sum(|p| p.half_angle) / parts.len().max(1) as f64,
            kept: sum(|p| p.kept) / sum(|p| p.turned_away),
            overdraw: (outlined > 0.0).then(|| sum(|p| p.seen_polygon) / outlined),
        }
    }
}

/// A cluster that may be refined.
#[derive(Debug)]
struct Waiting {
    node: Node,
    subtree: Subtree,
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let first = |w: &Self| std::cmp::Reverse((w.subtree.first_face, w.subtree.face_end));
        self.node.budget.total_cmp(&other.node.budget).then_with(|| first(self).cmp(&first(other)))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

impl Cluster {
    fn sphere(&self) -> Sphere {
        Sphere { center: Vec3::from(self.node.center), radius: self.node.radius }
    }

    fn cone(&self) -> Cone {
        Cone { axis: Vec3::from(self.node.axis()), cos: self.node.cos() }
    }

    fn polygon(&self, tree: &Tree) -> Option<BoundingPolygon> {
        let Child::Node(index) = self.subtree.child.kind() else { return None };
        tree.bounding_polygon(tree.bounding_polygon_of(index)?, &self.node)
    }

    /// The corners of its faces.
    fn triangles<'a>(&self, tree: &'a Tree, faces: &'a [[u32; 3]]) -> impl Iterator<Item = [DVec3; 3]> + 'a {
        let place = |v: u32| DVec3::from_array(tree.vertices()[v as usize].position().map(f64::from));
        self.subtree.of(faces).iter().map(move |face| face.map(place))
    }

    /// Which of its bounds does not hold its faces.
    fn broken(&self, tree: &Tree, faces: &[[u32; 3]]) -> Option<String> {
        let (sphere, cone, polygon) = (self.sphere(), self.cone(), self.polygon(tree));
        for corners in self.triangles(tree, faces) {
            let normal = normal(&corners);
            let outside_cone = || {
                let cos = normal.normalize_or_zero().dot(cone.axis.as_dvec3().normalize_or_zero());
                cos < f64::from(cone.cos) - 1e-6
            };
            let name = if corners.iter().any(|p| !sphere.contains_point(*p)) {
                "sphere"
            } else if normal != DVec3::ZERO && outside_cone() {
                "cone"
            } else if polygon.as_ref().is_some_and(|polygon| corners.iter().any(|p| !holds(polygon, *p))) {
                "bounding polygon"
            } else {
                continue;
            };
            return Some(format!("the {name} of {} does not hold its faces", self.subtree));
        }
        None
    }
}

/// What one cluster contributes.
struct Part {
    cross_section: f64,
    area: f64,
    half_angle: f64,
    turned_away: f64,
    kept: f64,
    seen_polygon: f64,
    seen_faces: f64,
}

impl Part {
    fn of(cluster: &Cluster, tree: &Tree, faces: &[[u32; 3]], directions: &[DVec3]) -> Part {
        // Half the length of a normal is the area of its face.
        let normals: Vec<DVec3> =
            cluster.triangles(tree, faces).map(|corners| 0.5 * normal(&corners)).collect();
        let (cone, polygon) = (cluster.cone(), cluster.polygon(tree));
        let (mut turned_away, mut kept) = (0.0, 0.0);
        let (mut seen_polygon, mut seen_faces) = (0.0, 0.0);
        for direction in directions {
            let away: f64 = normals.iter().filter(|n| n.dot(*direction) > 0.0).map(|n| n.length()).sum();
            turned_away += away;
            if cone.is_backfacing_along(*direction) {
                continue;
            }
            kept += away;
            if let Some(polygon) = &polygon {
                seen_polygon += shadow(polygon, *direction);
                seen_faces += normals.iter().map(|n| (-n.dot(*direction)).max(0.0)).sum::<f64>();
            }
        }
        let radius = f64::from(cluster.node.radius);
        Part {
            cross_section: std::f64::consts::PI * radius * radius,
            area: normals.iter().map(|n| n.length()).sum(),
            half_angle: f64::from(cone.cos).clamp(-1.0, 1.0).acos().to_degrees(),
            turned_away,
            kept,
            seen_polygon,
            seen_faces,
        }
    }
}

/// Twice the vector area of a triangle.
fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The frame of a prism: its origin and its axes.
fn frame(polygon: &BoundingPolygon) -> (DVec3, [DVec3; 3]) {
    let [origin, normal, tangent] = [polygon.origin, polygon.normal, polygon.tangent].map(DVec3::from_array);
    (origin, [tangent, normal.cross(tangent), normal])
}

/// The outward directions of the prism's eight sides.
fn sides(polygon: &BoundingPolygon) -> [DVec3; 8] {
    let (_, [x, y, _]) = frame(polygon);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    [x, (x + y) * half, y, (y - x) * half, -x, -(x + y) * half, -y, (x - y) * half]
}

/// Whether a point lies in the prism, up to rounding.
fn holds(polygon: &BoundingPolygon, point: DVec3) -> bool {
    let (origin, [_, _, z]) = frame(polygon);
    let p = point - origin;
    let extent =
        polygon.support.iter().fold(polygon.high.abs().max(polygon.low.abs()), |m, s| m.max(s.abs()));
    let slack = 1e-9 * extent;
    let within =
        sides(polygon).iter().zip(polygon.support).all(|(side, support)| side.dot(p) <= support + slack);
    within && (polygon.low - slack..=polygon.high + slack).contains(&z.dot(p))
}

/// The area that the prism covers when it is looked at along a unit vector.
fn shadow(polygon: &BoundingPolygon, direction: DVec3) -> f64 {
    let (_, [_, _, z]) = frame(polygon);
    let height = polygon.high - polygon.low;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (mut base, mut walls) = (0.0, 0.0);
    for (k, side) in sides(polygon).into_iter().enumerate() {
        let support = |k: usize| polygon.support[k % 8];
        let length = ((support(k + 7) + support(k + 1)) / half - 2.0 * support(k)).max(0.0);
        base += 0.5 * support(k) * length;
        walls += length * height * side.dot(direction).max(0.0);
    }
    base * z.dot(direction).abs() + walls
}

/// Unit vectors all around, along a spiral.
fn directions() -> Vec<DVec3> {
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let at = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (turn * i as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * cos, across * sin, z)
    };
    (0..DIRECTIONS).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An octagon of inner radius 1, one high.
    fn prism() -> BoundingPolygon {
        BoundingPolygon {
            origin: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            tangent: [1.0, 0.0, 0.0],
            low: 0.0,
            high: 1.0,
            support: [1.0; 8],
        }
    }

    #[test]
    fn a_prism_covers_its_base_from_above_and_its_width_from_the_side() {
        let tan = (std::f64::consts::PI / 8.0).tan();
        assert!((shadow(&prism(), DVec3::Z) - 8.0 * tan).abs() < 1e-12);
        assert!((shadow(&prism(), DVec3::Y) - 2.0).abs() < 1e-12);
        assert!((shadow(&prism(), -DVec3::X) - 2.0).abs() < 1e-12);
        // A square: the diagonal sides have no length.
        let mut square = prism();
        for k in [1, 3, 5, 7] {
            square.support[k] = 2.0_f64.sqrt();
        }
        assert!((shadow(&square, DVec3::Z) - 4.0).abs() < 1e-12);
        assert!(holds(&square, DVec3::new(1.0, -1.0, 0.5)) && !holds(&prism(), DVec3::new(1.0, -1.0, 0.5)));
        assert!(!holds(&square, DVec3::new(0.0, 0.0, 1.1)));
    }

    #[test]
    fn directions_are_spread_evenly() {
        let all = directions();
        assert!(all.iter().all(|d| (d.length() - 1.0).abs() < 1e-12));
        assert!(all.iter().sum::<DVec3>().length() < 1.0);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let mean = all.iter().map(|d| d.dot(axis) * d.dot(axis)).sum::<f64>() / all.len() as f64;
            assert!((mean - 1.0 / 3.0).abs() < 0.01, "{mean}");
        }
    }
}
