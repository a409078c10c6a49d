//! Where vertices are drawn in coarse meshes: beside their places, nearer to the planes of the clusters around them.
//!
//! The vertices of a mesh lie on the surface, so polygons between them cut off every bump. At a given tolerance a
//! vertex is shared by some clusters of that cut, each with a plane that fits it in the mean. The vertex goes where
//! the polygons come nearest to these planes: half the way is its own height over a plane, half the mean height of the
//! polygon, so that a saddle, whose corners are right in the mean, stays. It is a least-squares problem of three
//! unknowns for each vertex and tolerance, held at its place where the planes do not tell.

use crate::arcs::ClusterTree;
use crate::arcs::loops::{LAST, Loops};
use crate::bounds::NodeBounds;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use fct::Displacement;
use glam::DVec3;
use pull::{Pull, PullAt, solve, summed};
use rayon::prelude::*;
use std::ops::Range;

pub(crate) mod promised;
mod pull;

const LEVELS: usize = Displacement::AT.len();

/// Subtrees of at most this many faces are one task.
const TASK: usize = 16_384;

/// Finds the displacements of all vertices of a tree whose keys are final; copies along seams get the same.
pub(crate) fn displacements(tree: ClusterTree<'_>) -> Vec<Displacement> {
    let ClusterTree { mesh, splits, loops, nodes: bounds, keys: activity } = tree;
    let keys = activity.iter().map(|a| a.budget).collect();
    let (tasks, above) = tasks(splits, bounds, mesh.faces.len());
    let around = Surroundings { mesh, splits, loops, bounds, keys, shared: shared_vertices(mesh, &tasks) };
    let above = around.above(&above, &tasks);
    // Each task solves for the vertices that none but its own faces touch, and lists the rest.
    let mut solved = vec![Displacement::default(); mesh.weld.len()];
    let mut rest = solved.as_mut_slice();
    let mut places = Vec::with_capacity(tasks.len());
    for task in &tasks {
        // The runs of the tasks follow one another.
        let (own, after) = rest.split_at_mut(mesh.own_vertices(&task.faces).len());
        places.push(own);
        rest = after;
    }
    let mut done: Vec<Task> =
        tasks.into_par_iter().zip(places).map(|(task, own)| around.task(task, &above, own)).collect();
    drop(above);
    for i in 0..done.len() {
        for (vertex, level, pull) in std::mem::take(&mut done[i].foreign) {
            add_to_border(&mut done, vertex, level, &pull);
        }
    }
    for (vertex, pulls) in done.into_iter().flat_map(|task| task.border) {
        solved[vertex] = solve(&pulls, around.keys[vertex]);
    }
    for v in 0..solved.len() {
        solved[v] = solved[mesh.weld[v] as usize];
    }
    solved
}

/// For each vertex whether it has copies along seams, or faces of several tasks.
fn shared_vertices(mesh: &TreeMesh, tasks: &[Subtree]) -> Vec<bool> {
    let mut shared = vec![false; mesh.weld.len()];
    for (v, &w) in mesh.weld.iter().enumerate().filter(|(v, w)| *v != **w as usize) {
        shared[v] = true;
        shared[w as usize] = true;
    }
    for Subtree { faces, .. } in tasks {
        let own = mesh.own_vertices(faces).start;
        for &v in mesh.faces[faces.clone()].as_flattened() {
            if (v as usize) < own {
                shared[v as usize] = true;
            }
        }
    }
    shared
}

/// A subtree and the key of the node above it.
struct Subtree {
    node: usize,
    faces: Range<usize>,
    parent_key: f64,
}

/// What a task has found.
struct Task {
    /// The vertices that its faces are the first to use.
    own: Range<usize>,
    /// Own vertices that others pull at too, ascending.
    border: Vec<(usize, [Pull; LEVELS])>,
    /// Pulls at other vertices.
    foreign: Vec<PullAt>,
}

/// What the nodes above all tasks do to vertices: less memory than the pulls, where whole open boundaries are theirs.
#[derive(Default)]
struct Above {
    /// The normal of each node's plane, and the area of the node.
    planes: Vec<(DVec3, f64)>,
    /// By vertices, and at each in the order of the nodes.
    at: Vec<FromAbove>,
}

/// What one of these nodes does to a vertex.
#[derive(Clone, Copy)]
struct FromAbove {
    vertex: u32,
    plane: u32,
    /// By how much the vertex is to come down.
    height: f64,
    levels: [bool; LEVELS],
}

impl Above {
    /// Shows the pulls at some vertices.
    fn pulls(&self, of: &Range<usize>, mut show: impl FnMut(usize, usize, Pull)) {
        let first = self.at.partition_point(|at| (at.vertex as usize) < of.start);
        for at in self.at[first..].iter().take_while(|at| (at.vertex as usize) < of.end) {
            let (normal, area) = self.planes[at.plane as usize];
            let pull = Pull::plane(normal, at.height, area);
            (0..LEVELS).filter(|level| at.levels[*level]).for_each(|l| show(at.vertex as usize, l, pull));
        }
    }
}

/// Adds a pull at a vertex on the border of the task that owns it.
fn add_to_border(tasks: &mut [Task], vertex: usize, level: usize, pull: &Pull) {
    let place = tasks.partition_point(|t| t.own.end <= vertex);
    let Some(Task { border, .. }) = tasks.get_mut(place) else { return };
    if let Ok(i) = border.binary_search_by_key(&vertex, |b| b.0) {
        border[i].1[level].add(pull);
    }
}

struct Surroundings<'a> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    loops: &'a Loops,
    bounds: &'a [NodeBounds],
    /// The budget key of each vertex; copies along a seam have the same.
    keys: Vec<f32>,
    /// Which vertices others than the task that owns them may pull at.
    shared: Vec<bool>,
}

/// Memory for the loops of one node: half-edges, what there is to know of their starts, and of those that the node pulls
/// at their heights over its plane.
#[derive(Default)]
struct Scratch {
    entries: Vec<u32>,
    starts: Vec<Start>,
    pulled: Vec<(Start, f64)>,
}

/// A vertex on the boundary of a node.
#[derive(Clone, Copy)]
struct Start {
    vertex: u32,
    key: f32,
    /// The levels at which the node pulls at it.
    levels: [bool; LEVELS],
}

impl Start {
    fn is_pulled(&self) -> bool {
        self.levels != [false; LEVELS]
    }
}

/// Subtrees for tasks in order, and the nodes above them.
fn tasks(splits: &[Split], bounds: &[NodeBounds], faces: usize) -> (Vec<Subtree>, Vec<Subtree>) {
    let (mut tasks, mut above) = (Vec::new(), Vec::new());
    let mut stack = vec![Subtree { node: 0, faces: 0..faces, parent_key: f64::INFINITY }];
    while let Some(s) = stack.pop() {
        if s.faces.len() <= TASK {
            tasks.push(s);
            continue;
        }
        let [left, right] = children(splits, bounds, &s);
        above.push(s);
        stack.push(right);
        stack.push(left);
    }
    (tasks, above)
}

fn children(splits: &[Split], bounds: &[NodeBounds], s: &Subtree) -> [Subtree; 2] {
    let left = splits[s.node].left_faces as usize;
    let middle = s.faces.start + left;
    let parent_key = f64::from(bounds[s.node].budget);
    [
        Subtree { node: s.node + 1, faces: s.faces.start..middle, parent_key },
        Subtree { node: s.node + left, faces: middle..s.faces.end, parent_key },
    ]
}

impl Surroundings<'_> {
    /// `solved` is for the vertices that the subtree's faces are the first to use.
    fn task(&self, root: Subtree, above: &Above, solved: &mut [Displacement]) -> Task {
        let own = self.mesh.own_vertices(&root.faces);
        let first_face = root.faces.start;
        let mut areas = vec![0.0];
        let mut area = 0.0;
        for face in root.faces.clone() {
            area += self.area(face);
            areas.push(area);
        }
        let mut pulls = vec![[Pull::NONE; LEVELS]; own.len()];
        let mut foreign = Vec::new();
        let mut add = |vertex: usize, level: usize, pull: Pull| match vertex
            .checked_sub(own.start)
            .and_then(|v| pulls.get_mut(v))
        {
            Some(levels) => levels[level].add(&pull),
            None => foreign.push((vertex, level, pull)),
        };
        let mut scratch = Scratch::default();
        let mut stack = vec![root];
        while let Some(s) = stack.pop() {
            let area = areas[s.faces.end - first_face] - areas[s.faces.start - first_face];
            if s.faces.len() == 1 {
                self.pull_of_face(&s, area, &mut add);
            } else {
                let normal = self.splits[s.node].normal.as_dvec3();
                self.pull_of_node(&s, &mut scratch, |start, height| {
                    let pull = Pull::plane(normal, height, area);
                    self.at_levels(start, |v, level| add(v, level, pull));
                });
                let [left, right] = children(self.splits, self.bounds, &s);
                stack.push(right);
                stack.push(left);
            }
        }
        above.pulls(&own, add);
        let (keys, shared) = (&self.keys[own.clone()], &self.shared[own.clone()]);
        // A vertex of another key is not displaced, whatever pulls.
        let is_border = |v: &usize| shared[*v] && keys[*v] > 0.0 && keys[*v].is_finite();
        let mut border = Vec::with_capacity((0..own.len()).filter(is_border).count());
        border.extend((0..own.len()).filter(is_border).map(|v| (own.start + v, pulls[v])));
        for ((solved, levels), key) in solved.iter_mut().zip(&pulls).zip(keys) {
            *solved = solve(levels, *key);
        }
        Task { own, border, foreign: summed(foreign) }
    }

    /// What the nodes above all tasks do.
    fn above(&self, nodes: &[Subtree], tasks: &[Subtree]) -> Above {
        let area = |task: &Subtree| task.faces.clone().fold(0.0, |sum, face| sum + self.area(face));
        let areas: Vec<f64> = tasks.par_iter().map(area).collect();
        let mut before = vec![0.0];
        let mut sum = 0.0;
        for area in areas {
            sum += area;
            before.push(sum);
        }
        let area_before = |face: usize| before[tasks.partition_point(|t| t.faces.start < face)];
        let (mut above, mut scratch) = (Above::default(), Scratch::default());
        for s in nodes {
            let area = area_before(s.faces.end) - area_before(s.faces.start);
            let plane = above.planes.len() as u32;
            above.planes.push((self.splits[s.node].normal.as_dvec3(), area));
            self.pull_of_node(s, &mut scratch, |start, height| {
                let vertex = self.mesh.weld[start.vertex as usize];
                above.at.push(FromAbove { vertex, plane, height, levels: start.levels });
            });
        }
        above.at.sort_by_key(|at| at.vertex);
        above
    }

    /// Shows what the plane of a single face, which is its own, does to its corners.
    fn pull_of_face(&self, s: &Subtree, area: f64, mut show: impl FnMut(usize, usize, Pull)) {
        let corners = self.mesh.faces[s.faces.start].map(|v| self.start(v, 0.0, s.parent_key));
        if corners.iter().any(Start::is_pulled) {
            let normal = self.mesh.normal_of_face(s.faces.start).as_dvec3();
            let pull = Pull::plane(normal, 0.0, area);
            for corner in &corners {
                self.at_levels(corner, |v, level| show(v, level, pull));
            }
        }
    }

    /// Shows the vertices on the boundary of a node that its plane pulls at as long as the node is drawn, and by how much
    /// they are to come down.
    fn pull_of_node(&self, s: &Subtree, scratch: &mut Scratch, mut show: impl FnMut(&Start, f64)) {
        let (split, key) = (&self.splits[s.node], f64::from(self.bounds[s.node].budget));
        if !key.is_finite() || key >= s.parent_key {
            return;
        }
        let Scratch { entries, starts, pulled } = scratch;
        let entries = self.loops.read(s.node, entries);
        starts.clear();
        starts.extend(entries.iter().map(|h| self.start(self.mesh.origin(h & !LAST), key, s.parent_key)));
        if !starts.iter().any(Start::is_pulled) {
            return;
        }
        let normal = split.normal.as_dvec3();
        // The polygon in the middle of its life.
        let middle = if s.parent_key.is_finite() { 0.5 * (key + s.parent_key) } else { 1.5 * key };
        let (mut sum, mut length) = (0.0, 0.0);
        let mut ends = (None, None);
        pulled.clear();
        for (h, start) in entries.iter().zip(&*starts) {
            let is_corner = f64::from(start.key) > middle;
            if is_corner || start.is_pulled() {
                let place = self.mesh.positions[start.vertex as usize].as_dvec3();
                let height = normal.dot(place) - f64::from(split.offset);
                if start.is_pulled() {
                    pulled.push((*start, height));
                }
                if is_corner {
                    let to = (place, height);
                    if let Some(from) = ends.1 {
                        add_edge(from, to, &mut sum, &mut length);
                    }
                    ends = (ends.0.or(Some(to)), Some(to));
                }
            }
            if h & LAST != 0 {
                if let (Some(first), Some(last)) = ends {
                    add_edge(last, first, &mut sum, &mut length);
                }
                ends = (None, None);
            }
        }
        let mean = if length > 0.0 { sum / length } else { 0.0 };
        for (start, height) in &*pulled {
            show(start, 0.5 * (height + mean));
        }
    }

    /// A vertex on the boundary of a cluster with this key.
    #[inline]
    fn start(&self, vertex: u32, key: f64, parent_key: f64) -> Start {
        let own = self.keys[vertex as usize];
        let levels = Displacement::AT.map(|share| {
            let tolerance = share * f64::from(own);
            tolerance >= key && tolerance < parent_key && own.is_finite()
        });
        Start { vertex, key: own, levels }
    }

    /// The levels of a vertex at which a cluster is drawn; copies along a seam count as one vertex.
    #[inline]
    fn at_levels(&self, start: &Start, mut show: impl FnMut(usize, usize)) {
        for (level, is_drawn) in start.levels.into_iter().enumerate() {
            if is_drawn {
                show(self.mesh.weld[start.vertex as usize] as usize, level);
            }
        }
    }

    fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.mesh.faces[face].map(|v| self.mesh.positions[v as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    }
}

/// Adds an edge of a polygon, between places at some heights, to the integral of the height and to the length.
fn add_edge(from: (DVec3, f64), to: (DVec3, f64), sum: &mut f64, length: &mut f64) {
    let edge = from.0.distance(to.0);
    *sum += 0.5 * edge * (from.1 + to.1);
    *length += edge;
}
