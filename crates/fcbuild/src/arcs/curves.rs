//! Open boundaries and seams: curves that no split cuts, simplified by the error of leaving a vertex out.
//!
//! Inside a surface, a chord of an arc lies in the slab of the cluster on either side. Along an open boundary there
//! is no cluster beyond, so the polygon's edge could leave the boundary unnoticed; here each vertex of the curve is
//! drawn wherever the chord without it would be farther from the curve than the tolerance. Along a seam all sheets share
//! the curve's records.

use super::activity::{self, Activity};
use super::polyline::{self, Chord, complete_to_three};
use super::uncovered::{Order, WORTH, worth_of_strip};
use crate::mesh::{EdgeKind, NONE};
use crate::tree_order::TreeMesh;
use fcgeom::Sphere;
use glam::Vec3;

/// What a curve asks of a vertex: to be drawn where the tolerance is below its key, anywhere in `sphere`.
#[derive(Clone, Copy, Debug)]
pub struct CurveRecord {
    /// The welded vertex (see [`TreeMesh::weld`]).
    pub vertex: u32,
    /// The key in the order of bounds, in normal units; infinite for a vertex that is in every mesh.
    pub bound: f64,
    /// The same in the budget order.
    pub budget: f64,
    /// Around the part of the curve that the vertex stands for.
    pub sphere: Sphere,
}

/// A stretch of a curve, between vertices that are drawn below a tolerance whatever else is.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Welded vertices, both ends included.
    vertices: Vec<u32>,
    /// Normal units.
    highest: f64,
}

/// What open boundaries and seams ask for, whatever the tree.
#[derive(Clone, Debug, Default)]
pub struct Curves {
    /// The ends of stretches.
    pub ends: Vec<CurveRecord>,
    /// The stretches between them, whose inner vertices depend on what else is drawn: see [`straighten`].
    pub stretches: Vec<Stretch>,
}

/// Raises the records of vertices until the chords of curves are near them: within the tolerance in the order of bounds,
/// and in the budget order where what they cut off is worth a vertex.
pub fn straighten(mesh: &TreeMesh, stretches: &[Stretch], records: &mut [Activity]) {
    // What the budget order asks for makes vertices be drawn in larger spheres, which the order of bounds must know.
    for order in [Order::Budget, Order::Bound] {
        let mut found = Vec::new();
        for stretch in stretches {
            let vertices = &stretch.vertices;
            let points = points_of(mesh, vertices);
            let record = |i: usize| &records[vertices[i] as usize];
            let key = |i: usize| order.of_vertex(record(i));
            let drawn = |i: usize| order.sphere_of(record(i));
            let raised =
                polyline::raise(&points, key, stretch.highest, drawn, |chord| miss(order, &points, chord));
            found.extend(raised.iter().map(|r| order.record(vertices[r.point], r)));
        }
        activity::raise(&found, records);
    }
}

/// What the squared error of a strip that a chord of a curve cuts off comes to, over its length and the cube of its
/// depth: that of a parabola. Half and twice of it are as good in the mean; a sixth leaves larger distances.
const STRIP: f64 = 0.15;

/// What a distance from a chord of a curve counts in the order of bounds, where 1 is enough for the promise. It is
/// measured, while bounds of clusters are about twice what is: without it the farthest points of a mesh are all on its
/// rims, and a few more vertices there let the rest be coarser for the same largest distance.
const FIRMER: f64 = 1.25;

/// The point of a chord that is farthest from it, and its key in an order, if that is worth it.
fn miss(order: Order, points: &[Vec3], chord: Chord) -> Option<(usize, f64)> {
    let (point, distance) = polyline::farthest_from_chord(points, chord.from, chord.to)?;
    if order == Order::Bound {
        return Some((point, FIRMER * distance));
    }
    let length = f64::from(points[chord.from].distance(points[chord.to]));
    let worth = worth_of_strip(STRIP, length, distance);
    (worth > WORTH * chord.lowest).then_some((point, worth))
}

/// An edge of the boundary graph between welded vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct CurveEdge {
    low: u32,
    high: u32,
    /// How many faces use it forwards and backwards; where this changes, a curve ends.
    forwards: u32,
    backwards: u32,
    is_seam: bool,
}

/// The open boundaries and seams of `mesh`.
///
/// `component` tells the connected component of a face, `components` how many there are: every component with a
/// boundary keeps at least one loop of three vertices in every mesh, so that it cannot vanish.
pub fn find(mesh: &TreeMesh, component: &[u32], components: usize) -> Curves {
    let edges = boundary_edges(mesh);
    if edges.is_empty() {
        return Curves::default();
    }
    let graph = Graph::of(&edges, mesh.positions.len());
    let mut out = Curves::default();
    let mut used = vec![false; edges.len()];
    let mut loops: Vec<Vec<u32>> = Vec::new();
    for &vertex in &graph.vertices {
        if graph.is_junction(vertex, &edges) {
            for &e in graph.edges_at(vertex) {
                if !used[e as usize] {
                    let curve = graph.walk(vertex, e, &edges, &mut used);
                    add_open_curve(mesh, curve, &mut out);
                }
            }
        }
    }
    for e in 0..edges.len() {
        if !used[e] {
            loops.push(graph.walk(edges[e].low, e as u32, &edges, &mut used));
        }
    }
    add_loops(mesh, &edges, &graph, loops, component, components, &mut out);
    out
}

fn boundary_edges(mesh: &TreeMesh) -> Vec<CurveEdge> {
    let mut directed: Vec<(u32, u32, bool, bool)> = Vec::new();
    for h in 0..mesh.opposite.len() as u32 {
        if mesh.opposite[h as usize] == NONE {
            let (a, b) = (mesh.weld[mesh.origin(h) as usize], mesh.weld[mesh.target(h) as usize]);
            directed.push((a.min(b), a.max(b), a < b, mesh.kind(h) == EdgeKind::Seam));
        }
    }
    directed.sort_unstable();
    directed
        .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
        .map(|users| CurveEdge {
            low: users[0].0,
            high: users[0].1,
            forwards: users.iter().filter(|u| u.2).count() as u32,
            backwards: users.iter().filter(|u| !u.2).count() as u32,
            is_seam: users.iter().any(|u| u.3),
        })
        .collect()
}

struct Graph {
    /// Vertices with an edge, ascending.
    vertices: Vec<u32>,
    start: Vec<u32>,
    incident: Vec<u32>,
    index_of: Vec<u32>,
}

impl Graph {
    fn of(edges: &[CurveEdge], vertex_count: usize) -> Graph {
        let mut ends: Vec<(u32, u32)> =
            edges.iter().enumerate().flat_map(|(i, e)| [(e.low, i as u32), (e.high, i as u32)]).collect();
        ends.sort_unstable();
        let mut graph = Graph {
            vertices: Vec::new(),
            start: Vec::new(),
            incident: Vec::new(),
            index_of: vec![NONE; vertex_count],
        };
        for (vertex, edge) in ends {
            if graph.vertices.last() != Some(&vertex) {
                graph.index_of[vertex as usize] = graph.vertices.len() as u32;
                graph.vertices.push(vertex);
                graph.start.push(graph.incident.len() as u32);
            }
            graph.incident.push(edge);
        }
        graph.start.push(graph.incident.len() as u32);
        graph
    }

    fn edges_at(&self, vertex: u32) -> &[u32] {
        let i = self.index_of[vertex as usize] as usize;
        &self.incident[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// A curve passes through a vertex only if exactly two edges meet there that the same sheets use.
    fn is_junction(&self, vertex: u32, edges: &[CurveEdge]) -> bool {
        let [a, b] = *self.edges_at(vertex) else { return true };
        let users = |e: u32| {
            let edge = &edges[e as usize];
            let leaving = edge.low == vertex;
            if leaving { (edge.forwards, edge.backwards) } else { (edge.backwards, edge.forwards) }
        };
        let (out_a, in_a) = users(a);
        let (out_b, in_b) = users(b);
        (out_a, in_a) != (in_b, out_b)
    }

    /// The vertices from `from` along `edge` to the next junction, or around the loop back to `from`.
    fn walk(&self, from: u32, edge: u32, edges: &[CurveEdge], used: &mut [bool]) -> Vec<u32> {
        let mut curve = vec![from];
        let (mut at, mut along) = (from, edge);
        loop {
            used[along as usize] = true;
            let e = &edges[along as usize];
            at = if e.low == at { e.high } else { e.low };
            curve.push(at);
            if at == from || self.is_junction(at, edges) {
                return curve;
            }
            match self.edges_at(at).iter().find(|&&e| !used[e as usize]) {
                Some(&e) => along = e,
                None => return curve,
            }
        }
    }
}

fn points_of(mesh: &TreeMesh, curve: &[u32]) -> Vec<Vec3> {
    curve.iter().map(|&v| mesh.positions[v as usize]).collect()
}

/// Both ends are junctions, drawn always; what lies between goes by its deviation.
fn add_open_curve(mesh: &TreeMesh, curve: Vec<u32>, out: &mut Curves) {
    for &vertex in [curve.first(), curve.last()].into_iter().flatten() {
        let sphere = Sphere::of_points(points_of(mesh, &[vertex]));
        out.ends.push(CurveRecord { vertex, bound: f64::INFINITY, budget: f64::INFINITY, sphere });
    }
    out.stretches.push(Stretch { vertices: curve, highest: f64::INFINITY });
}

/// Loops without a junction get three anchors: drawn always on a seam and on the widest loop of a component, else
/// wherever the tolerance is below the width of the loop.
fn add_loops(
    mesh: &TreeMesh,
    edges: &[CurveEdge],
    graph: &Graph,
    loops: Vec<Vec<u32>>,
    component: &[u32],
    components: usize,
    out: &mut Curves,
) {
    let mut component_of_vertex = vec![NONE; mesh.positions.len()];
    for (face, corners) in mesh.faces.iter().enumerate() {
        for &v in corners {
            component_of_vertex[mesh.weld[v as usize] as usize] = component[face];
        }
    }
    let mut has_anchor = vec![false; components];
    for r in out.ends.iter().filter(|r| r.bound == f64::INFINITY) {
        has_anchor[component_of_vertex[r.vertex as usize] as usize] = true;
    }
    let sphere_of = |curve: &[u32]| Sphere::of_points(points_of(mesh, curve));
    let mut widest: Vec<Option<(f32, usize)>> = vec![None; components];
    for (i, curve) in loops.iter().enumerate() {
        let c = component_of_vertex[curve[0] as usize] as usize;
        let radius = sphere_of(curve).radius;
        if !has_anchor[c] && widest[c].is_none_or(|(r, _)| radius > r) {
            widest[c] = Some((radius, i));
        }
    }
    for (i, curve) in loops.iter().enumerate() {
        let c = component_of_vertex[curve[0] as usize] as usize;
        // The walk ends where it began.
        let ring = &curve[..curve.len() - 1];
        let mut chosen = Vec::new();
        complete_to_three(&points_of(mesh, ring), &mut chosen, |_| 1.0);
        chosen.sort_unstable();
        let sphere = sphere_of(ring);
        let is_seam = graph.edges_at(ring[0]).iter().any(|&e| edges[e as usize].is_seam);
        let always = is_seam || widest[c].is_some_and(|(_, w)| w == i);
        let error = if always { f64::INFINITY } else { 2.0 * f64::from(sphere.radius) };
        for &k in &chosen {
            out.ends.push(CurveRecord { vertex: ring[k], bound: error, budget: error, sphere });
        }
        for k in 0..chosen.len() {
            let (from, to) = (chosen[k], chosen[(k + 1) % chosen.len()]);
            let vertices = if from < to {
                ring[from..=to].to_vec()
            } else {
                ring[from..].iter().chain(&ring[..=to]).copied().collect()
            };
            // Not before the loop itself appears.
            out.stretches.push(Stretch { vertices, highest: error });
        }
    }
}
