//! The nearest triangle of a mesh, by a tree of boxes.
//!
//! Boxes are compared in single precision with a margin, distances are computed in double precision from the exact
//! corners, so that the answer is that of a search through all triangles.

use crate::Surface;
use crate::color::{Color, nearest_weights};
use glam::{DVec3, Vec3, Vec3A};

/// Triangles in a leaf: fewer cost more boxes, more cost more triangles a question. Either way only time.
const LEAF: usize = 4;

/// Below so many triangles a subtree is built by one thread.
const SERIAL: usize = 8192;

/// Marks a leaf among the references of a node.
const LEAF_BIT: u32 = 1 << 31;

/// Finds the triangle that is nearest to a point.
#[derive(Debug)]
pub struct Nearest {
    /// In the order of the leaves.
    triangles: Vec<[Vec3; 3]>,
    /// Of their corners; empty if the mesh has none.
    colors: Vec<[Color; 3]>,
    nodes: Vec<Node>,
    root: u32,
    /// Largest coordinate: the scale of rounding errors.
    extent: f32,
}

/// An inner node: both children with their boxes.
#[derive(Debug, Clone, Copy)]
struct Node {
    boxes: [Bounds; 2],
    /// The offset to a node that follows, or [`LEAF_BIT`] and the leaf's first triangle.
    children: [u32; 2],
}

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: Vec3A,
    high: Vec3A,
}

#[derive(Debug, Clone, Copy)]
struct Item {
    center: Vec3A,
    id: u32,
}

/// The nearest triangle to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The squared distance; infinite when the mesh has no triangle.
    pub squared: f64,
    /// A hint for a question nearby.
    pub triangle: u32,
}

impl Nearest {
    /// Over all faces of a mesh.
    pub fn of(mesh: Surface<'_>) -> Nearest {
        let corners = |id: u32| mesh.faces.get(id as usize).map_or([Vec3::NAN; 3], |face| mesh.corners(face));
        let mut items: Vec<Item> = (0..mesh.faces.len() as u32)
            .map(|id| {
                let [a, b, c] = corners(id);
                Item { center: Vec3A::from(a + b + c), id }
            })
            .collect();
        let mut nodes = Vec::new();
        let mut root = LEAF_BIT;
        if items.len() > LEAF {
            nodes = build(&mut items, 0, &corners).0;
            root = 0;
        }
        let triangles: Vec<[Vec3; 3]> = items.iter().map(|item| corners(item.id)).collect();
        let extent = triangles
            .iter()
            .flatten()
            .map(|p| p.abs().max_element())
            .fold(0.0_f32, |a, b| if b > a { b } else { a });
        let face = |item: &Item| mesh.colors(mesh.faces.get(item.id as usize)?);
        let colors = items.iter().map(face).collect::<Option<_>>().unwrap_or_default();
        Nearest { triangles, colors, nodes, root, extent }
    }

    /// The colour at the place of an answer's triangle that is nearest to `p`, if the mesh has colours.
    pub(crate) fn color(&self, p: DVec3, hit: Hit) -> Option<Color> {
        let place = hit.triangle as usize;
        let weights = nearest_weights(p, self.triangles.get(place)?);
        self.colors.get(place).map(|colors| Color::between(*colors, weights))
    }

    /// The triangle nearest to `p`; `hint` is one that may be near, from the last answer, or any number.
    pub fn find(&self, p: DVec3, hint: u32) -> Hit {
        let mut hit = Hit { squared: f64::INFINITY, triangle: 0 };
        if let Some(corners) = self.triangles.get(hint as usize) {
            hit = Hit { squared: squared_distance(p, corners), triangle: hint };
        }
        let rounded = Vec3A::from(p.as_vec3());
        // Rounding moves the point and the differences below by a few units in the last place of the coordinates.
        let margin = f64::from(4.0 * f32::EPSILON * self.extent.max(rounded.abs().max_element()));
        let limit = |squared: f64| ((squared.sqrt() + margin).powi(2) * (1.0 + 1e-6)) as f32;
        let mut within = limit(hit.squared);
        // Halving 2^31 triangles leaves no path longer than 32.
        let mut stack = [(0_u32, 0.0_f32); 64];
        let mut top = 1;
        stack[0] = (self.root, 0.0);
        while top > 0 {
            top -= 1;
            let (reference, at) = stack[top];
            if at > within {
                continue;
            }
            if reference & LEAF_BIT != 0 {
                let first = (reference & !LEAF_BIT) as usize;
                for (i, corners) in self.triangles.iter().enumerate().skip(first).take(LEAF) {
                    let squared = squared_distance(p, corners);
                    if squared < hit.squared {
                        hit = Hit { squared, triangle: i as u32 };
                        within = limit(squared);
                    }
                }
                continue;
            }
            let node = &self.nodes[reference as usize];
            let [left, right] = node.boxes.map(|b| b.squared_distance(rounded));
            let [to_left, to_right] =
                node.children.map(|c| if c & LEAF_BIT == 0 { reference + c } else { c });
            let ordered = if left < right {
                [(to_right, right), (to_left, left)]
            } else {
                [(to_left, left), (to_right, right)]
            };
            for step in ordered {
                if step.1 <= within {
                    stack[top] = step;
                    top += 1;
                }
            }
        }
        hit
    }
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn with(self, p: Vec3A) -> Bounds {
        Bounds { low: self.low.min(p), high: self.high.max(p) }
    }

    fn join(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn squared_distance(&self, p: Vec3A) -> f32 {
        (self.low - p).max(p - self.high).max(Vec3A::ZERO).length_squared()
    }
}

/// The nodes over some items, the root first, and their box; none for a leaf. `first` is the place of the first item.
///
/// Every leaf but the last holds [`LEAF`] triangles, because every cut is at a multiple.
fn build(
    items: &mut [Item],
    first: usize,
    corners: &(impl Fn(u32) -> [Vec3; 3] + Sync),
) -> (Vec<Node>, Bounds) {
    if items.len() <= LEAF {
        let all = items.iter().flat_map(|item| corners(item.id));
        return (Vec::new(), all.fold(Bounds::EMPTY, |b, p| b.with(p.into())));
    }
    let spread = items.iter().fold(Bounds::EMPTY, |b, item| b.with(item.center));
    let size = (spread.high - spread.low).to_array();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let middle = items.len().div_ceil(LEAF) / 2 * LEAF;
    items.select_nth_unstable_by(middle, |a, b| {
        a.center[axis].total_cmp(&b.center[axis]).then(a.id.cmp(&b.id))
    });
    let parallel = items.len() > SERIAL;
    let (low, high) = items.split_at_mut(middle);
    let ((left, left_box), (right, right_box)) = if parallel {
        rayon::join(|| build(low, first, corners), || build(high, first + middle, corners))
    } else {
        (build(low, first, corners), build(high, first + middle, corners))
    };
    let refer = |nodes: &[Node], offset: usize, first: usize| {
        if nodes.is_empty() { LEAF_BIT | first as u32 } else { offset as u32 }
    };
    let children = [refer(&left, 1, first), refer(&right, 1 + left.len(), first + middle)];
    let mut nodes = Vec::with_capacity(1 + left.len() + right.len());
    nodes.push(Node { boxes: [left_box, right_box], children });
    nodes.extend(left);
    nodes.extend(right);
    (nodes, left_box.join(right_box))
}

/// Squared distance of a point from a triangle, which may be a segment or a point.
pub fn squared_distance(p: DVec3, corners: &[Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|v| v.as_dvec3() - p);
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let n = bc.cross(ab);
    let area = n.length_squared();
    // From outside the nearest place is on an edge that the point is beyond.
    let beyond = |from: DVec3, edge: DVec3| edge.cross(from).dot(n) < 0.0 || area == 0.0;
    let segment = |from: DVec3, edge: DVec3| {
        let length = edge.length_squared();
        let t = if length > 0.0 { (-from.dot(edge) / length).clamp(0.0, 1.0) } else { 0.0 };
        (from + edge * t).length_squared()
    };
    let mut nearest = f64::INFINITY;
    for (from, edge) in [(a, ab), (b, bc), (c, ca)] {
        if beyond(from, edge) {
            nearest = nearest.min(segment(from, edge));
        }
    }
    if nearest < f64::INFINITY { nearest } else { a.dot(n).powi(2) / area }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::unit;
    use crate::tests::Mesh;

    /// Random triangles, some of them slivers, segments and points, far from the origin.
    fn soup(faces: usize) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..faces as u64 {
            let random = |k: u64| unit(i, k, 3) * 2.0 - 1.0;
            let center = DVec3::new(random(0), random(1), random(2)) + 40.0;
            let thin = [1.0, 1.0, 1e-5, 0.0][i as usize % 4];
            let long = if i % 7 == 6 { 0.0 } else { 0.3 };
            let side = DVec3::new(random(3), random(4), random(5)) * long;
            let up = DVec3::new(random(6), random(7), random(8)) * 0.3 * thin;
            let first = mesh.positions.len() as u32;
            for p in [center, center + side, center + side * 0.4 + up] {
                mesh.vertex(p);
            }
            mesh.faces.push([first, first + 1, first + 2]);
        }
        mesh
    }

    /// The nearest of many points of the triangle: an upper estimate of the distance.
    fn by_points(p: DVec3, t: &[Vec3; 3]) -> f64 {
        let [a, b, c] = t.map(|v| v.as_dvec3());
        let n = 200;
        let mut best = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                best = best.min((a + (b - a) * u + (c - a) * v - p).length());
            }
        }
        best
    }

    #[test]
    fn distance_to_a_triangle_is_that_to_its_nearest_point() {
        let mesh = soup(56);
        for (i, f) in mesh.faces.iter().enumerate() {
            let t = f.map(|v| Vec3::from_array(mesh.positions[v as usize]));
            for k in 0..4 {
                let random = |c: u64| unit(i as u64, 8 * k + c, 5) - 0.5;
                let p = t[0].as_dvec3() + DVec3::new(random(0), random(1), random(2));
                let (found, expected) = (squared_distance(p, &t).sqrt(), by_points(p, &t));
                assert!(found <= expected + 1e-12 && found >= expected - 3e-3, "{i}: {found} {expected}");
            }
        }
    }

    #[test]
    fn the_tree_finds_what_a_search_through_all_finds() {
        for faces in [0, 1, 4, 5, 13, 900, 20_000] {
            let mesh = soup(faces);
            let tree = Nearest::of(mesh.surface());
            let mut hint = u32::MAX;
            for i in 0..60 {
                let random = |c: u64| unit(i, c, 11) * 3.0 - 1.5;
                let p = DVec3::new(random(0), random(1), random(2)) + 40.0;
                let all = mesh
                    .faces
                    .iter()
                    .map(|f| squared_distance(p, &f.map(|v| Vec3::from_array(mesh.positions[v as usize]))));
                let hit = tree.find(p, hint);
                assert_eq!(hit.squared, all.fold(f64::INFINITY, f64::min));
                hint = hit.triangle;
            }
        }
    }
}
