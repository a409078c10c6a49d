//! What a cluster drawn as one polygon loses of its colours, and keys that hold it.
//!
//! A polygon is coloured by its corners, and what lies between them is interpolated. So nothing is lost where colours
//! are linear in space, and where they are not, as on a painted wall, a flat cluster is as wrong as a bent one.
//!
//! The loss of a cluster is a length, the root of the integral of the squared difference of colour over its area: a
//! patch of the wrong colour counts with its width, and a faint one with a part of it. Then a tolerance in pixels
//! means for colours what it means for places: what is drawn wrong is no wider. In the budget order, where errors are
//! areas times squared distances, what is drawn in the wrong colour counts as if it were some way off.

mod moments;

pub use moments::{Coloring, Colors, Part};

use crate::arcs::loops::{LAST, Loops};
use crate::bounds::NodeBounds;
use crate::mesh::Mesh;
use crate::partition::{Split, Subtree};
use crate::tree_order::TreeMesh;
use fcgeom::round_up;
use glam::{DVec4, Vec3};

/// What colours count in the two orders of a tree.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// The width of a patch that is black in place of white counts so many times.
    width: f64,
    /// In budgets such a patch is so far off, times the same.
    distance: f64,
}

/// The distance that a wrong colour counts as in the budget order, against the root of the mesh's area.
const DISTANCE: f64 = 0.02;

impl Weights {
    /// None if the mesh has no colours, or they count nothing.
    pub fn of(mesh: &Mesh, weight: f64) -> Option<Weights> {
        mesh.colors.as_ref().filter(|_| weight > 0.0)?;
        let area = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| mesh.positions[v as usize].as_dvec3());
            0.5 * (b - a).cross(c - a).length()
        };
        let area: f64 = mesh.faces.iter().map(area).sum();
        Some(Weights { width: weight, distance: DISTANCE * area.sqrt() })
    }

    /// Colours whose loss is an area times a squared distance.
    pub fn for_budgets(self, of_vertex: &[[u8; 4]]) -> Weighed<'_> {
        Weighed::new(of_vertex, self.width * self.distance)
    }
}

/// The colours of vertices as they count.
#[derive(Clone, Copy, Debug)]
pub struct Weighed<'a> {
    of_vertex: &'a [[u8; 4]],
    /// What one step of a channel counts.
    step: f64,
}

impl<'a> Weighed<'a> {
    /// Opaque black and white are `contrast` apart.
    fn new(of_vertex: &'a [[u8; 4]], contrast: f64) -> Weighed<'a> {
        Weighed { of_vertex, step: contrast / (255.0 * 3.0_f64.sqrt()) }
    }

    fn get(&self, vertex: u32) -> DVec4 {
        DVec4::from(self.of_vertex[vertex as usize].map(f64::from)) * self.step
    }

    /// A face.
    pub fn of_face(&self, positions: &[Vec3], vertices: [u32; 3]) -> Part {
        Part::of_triangle(vertices.map(|v| positions[v as usize].as_dvec3()), vertices.map(|v| self.get(v)))
    }
}

/// Raises the keys of all nodes to what they lose of the colours, for both orders, and nests them.
///
/// The budget keys know of colours already, as their merges do: only what borders lose is added.
pub fn raise_keys(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    weights: Weights,
    nodes: &mut [NodeBounds],
) {
    if let Some(colors) = mesh.colors.as_deref() {
        let colors = Weighed::new(colors, weights.width);
        let walk = Walk { mesh, colors, distance: weights.distance, splits, loops };
        walk.raise(Subtree::whole(mesh.faces.len()), nodes);
    }
}

struct Walk<'a> {
    mesh: &'a TreeMesh,
    colors: Weighed<'a>,
    distance: f64,
    splits: &'a [Split],
    loops: &'a Loops,
}

/// What the walk knows of a subtree.
struct Below {
    part: Part,
    /// The square of the loss, times that of the distance.
    cost: f64,
}

/// Below this many faces a subtree stays on one thread.
const SERIAL_BELOW: usize = 4096;

/// Triangles that a node of two polygons draws more than one of one.
const SAVED: f64 = 2.0;

impl Walk<'_> {
    fn raise(&self, at: Subtree, nodes: &mut [NodeBounds]) -> Below {
        let Some((own, below)) = nodes.split_first_mut() else {
            let face = self.mesh.faces[at.faces.start];
            return Below { part: self.colors.of_face(&self.mesh.positions, face), cost: 0.0 };
        };
        let [left, right] = at.children(self.splits);
        let (nodes_l, nodes_r) = below.split_at_mut(left.faces.len() - 1);
        let (l, r) = if at.faces.len() < SERIAL_BELOW {
            (self.raise(left, nodes_l), self.raise(right, nodes_r))
        } else {
            rayon::join(|| self.raise(left, nodes_l), || self.raise(right, nodes_r))
        };
        let part = l.part.and(&r.part);
        let squared = self.squared_loss(&part, at.node);
        let cost = self.distance * self.distance * squared;
        let rise = (cost - l.cost - r.cost).max(0.0);
        let loss = round_up(squared.sqrt());
        if loss.is_finite() {
            own.raise_bound(loss);
            // Keys of merges are fourth roots of an area times a squared distance a triangle saved.
            own.budget = own.budget.max(round_up((rise / SAVED).sqrt().sqrt()));
        }
        own.nest([nodes_l.first(), nodes_r.first()]);
        Below { part, cost }
    }

    /// The square of what a node loses: of its faces, and of its border, which colours all of its polygon.
    fn squared_loss(&self, part: &Part, node: usize) -> f64 {
        let fit = part.fit();
        let mut memory = Vec::new();
        let border = self.loops.read(node, &mut memory);
        let of_start = |h: &u32| {
            let v = self.mesh.origin(h & !LAST);
            fit.squared_difference(self.mesh.positions[v as usize].as_dvec3(), self.colors.get(v))
        };
        // A few corners colour much of a polygon: the root of the mean square of squares counts them for more.
        let beside = border.iter().map(of_start).map(|d| d * d).sum::<f64>() / border.len().max(1) as f64;
        part.squared_loss() + part.area * beside.sqrt()
    }
}
