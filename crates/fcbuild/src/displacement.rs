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
use fcgeom::SymMat3;
use fct::{Displacement, ShortFloat};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::ops::Range;

pub(crate) mod promised;

const LEVELS: usize = Displacement::AT.len();

/// Subtrees of at most this many faces are one task.
const TASK: usize = 16_384;

/// Holds a vertex to its place as a plane of this share of the clusters' area would in every direction: less lets
/// vertices slide along nearly parallel planes, more leaves them where they are.
const HOLD: f64 = 0.01;

/// Finds the displacements of all vertices of a tree whose keys are final; copies along seams get the same.
pub(crate) fn displacements(tree: ClusterTree<'_>) -> Vec<Displacement> {
    let ClusterTree { mesh, splits, loops, nodes: bounds, keys: activity } = tree;
    let keys = activity.iter().map(|a| a.budget).collect();
    let around = Surroundings { mesh, splits, loops, bounds, keys, shared: shared_vertices(mesh) };
    let (tasks, above) = tasks(splits, bounds, mesh.faces.len());
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
        tasks.into_par_iter().zip(places).map(|(task, own)| around.task(task, own)).collect();
    let mut foreign = around.above(&above, &done);
    for task in &mut done {
        foreign.append(&mut task.foreign);
    }
    for (vertex, level, pull) in foreign {
        let place = done.partition_point(|t| t.own.end <= vertex);
        let Some(task) = done.get_mut(place) else { continue };
        if let Ok(i) = task.border.binary_search_by_key(&vertex, |b| b.0) {
            task.border[i].1[level].add(&pull);
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

/// For each vertex whether it has copies along seams; empty if none has.
fn shared_vertices(mesh: &TreeMesh) -> Vec<bool> {
    let mut shared = Vec::new();
    for (v, &w) in mesh.weld.iter().enumerate().filter(|(v, w)| *v != **w as usize) {
        shared.resize(mesh.weld.len(), false);
        shared[v] = true;
        shared[w as usize] = true;
    }
    shared
}

/// What planes do to a vertex: the normal equations of its least squares.
#[derive(Clone, Copy, Debug)]
struct Pull {
    matrix: SymMat3,
    right: DVec3,
    weight: f64,
}

impl Pull {
    const NONE: Pull = Pull { matrix: SymMat3::ZERO, right: DVec3::ZERO, weight: 0.0 };

    /// A plane of this normal, of which the vertex is to come down by `height`.
    fn plane(normal: DVec3, height: f64, weight: f64) -> Pull {
        Pull { matrix: SymMat3::outer(normal) * weight, right: normal * (-height * weight), weight }
    }

    fn add(&mut self, other: &Pull) {
        self.matrix += other.matrix;
        self.right += other.right;
        self.weight += other.weight;
    }

    fn solve(&self) -> DVec3 {
        let hold = SymMat3::IDENTITY * (HOLD * self.weight);
        let matrix: DMat3 = (self.matrix + hold).to_dmat3();
        let solved = matrix.inverse() * self.right;
        if solved.is_finite() { solved } else { DVec3::ZERO }
    }
}

/// What pulls at a vertex make of it, which has this budget key.
fn solve(pulls: &[Pull; LEVELS], key: f32) -> Displacement {
    let displaced = pulls.each_ref().map(|pull| pull.solve().to_array());
    Displacement::encode(displaced, ShortFloat::up(f64::from(key)))
}

/// A vertex, a level, and what happens to it there.
type PullAt = (usize, usize, Pull);

/// Adds up pulls at the same vertex and level, in their order.
fn summed(mut pulls: Vec<PullAt>) -> Vec<PullAt> {
    pulls.sort_by_key(|(vertex, level, _)| (*vertex, *level));
    pulls.dedup_by(|next, sum| {
        let same = (next.0, next.1) == (sum.0, sum.1);
        if same {
            sum.2.add(&next.2);
        }
        same
    });
    pulls.shrink_to_fit();
    pulls
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
    first_face: usize,
    area: f64,
}

struct Surroundings<'a> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    loops: &'a Loops,
    bounds: &'a [NodeBounds],
    /// The budget key of each vertex; copies along a seam have the same.
    keys: Vec<f32>,
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
    fn task(&self, root: Subtree, solved: &mut [Displacement]) -> Task {
        let own = self.mesh.own_vertices(&root.faces);
        let first_face = root.faces.start;
        let mut areas = vec![0.0];
        let mut area = 0.0;
        for face in root.faces.clone() {
            area += self.area(face);
            areas.push(area);
        }
        let is_border = self.is_border(&root, &own);
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
                self.pull_of_node(&s, area, &mut scratch, &mut add);
                let [left, right] = children(self.splits, self.bounds, &s);
                stack.push(right);
                stack.push(left);
            }
        }
        let border = (0..pulls.len()).filter(|v| is_border[*v]).map(|v| (own.start + v, pulls[v])).collect();
        for ((solved, levels), key) in solved.iter_mut().zip(&pulls).zip(&self.keys[own.clone()]) {
            *solved = solve(levels, *key);
        }
        Task { own, border, foreign: summed(foreign), first_face, area }
    }

    /// Which of the own vertices of a subtree others may pull at.
    fn is_border(&self, root: &Subtree, own: &Range<usize>) -> Vec<bool> {
        let mut is_border = match self.shared.get(own.clone()) {
            Some(shared) => shared.to_vec(),
            None => vec![false; own.len()],
        };
        let mut mark = |vertex: u32| {
            if let Some(b) = (vertex as usize).checked_sub(own.start).and_then(|v| is_border.get_mut(v)) {
                *b = true;
            }
        };
        if root.faces.len() == 1 {
            self.mesh.faces[root.faces.start].into_iter().for_each(mark);
        } else {
            self.loops
                .read(root.node, &mut Vec::new())
                .iter()
                .for_each(|h| mark(self.mesh.origin(h & !LAST)));
        }
        is_border
    }

    /// The pulls of the nodes above all tasks.
    fn above(&self, nodes: &[Subtree], tasks: &[Task]) -> Vec<PullAt> {
        let mut before = vec![0.0];
        let mut sum = 0.0;
        for t in tasks {
            sum += t.area;
            before.push(sum);
        }
        let area_before = |face: usize| before[tasks.partition_point(|t| t.first_face < face)];
        let (mut pulls, mut scratch) = (Vec::new(), Scratch::default());
        for s in nodes {
            let area = area_before(s.faces.end) - area_before(s.faces.start);
            self.pull_of_node(s, area, &mut scratch, |v, level, pull| pulls.push((v, level, pull)));
        }
        pulls
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

    /// Shows what the plane of a node does to the vertices on its boundary, as long as the node is drawn.
    fn pull_of_node(
        &self,
        s: &Subtree,
        area: f64,
        scratch: &mut Scratch,
        mut show: impl FnMut(usize, usize, Pull),
    ) {
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
            let pull = Pull::plane(normal, 0.5 * (height + mean), area);
            self.at_levels(start, |v, level| show(v, level, pull));
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
