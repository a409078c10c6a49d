//! How far a surface and a drawn mesh lie apart, both ways, by dense sampling.

use crate::distance::{Surface, position};
use crate::random::Random;
use fcextract::{Extraction, Order, Selection, Tolerance, extract};
use fct::{Child, Tree};
use glam::DVec3;
use rayon::prelude::*;

/// A cluster of a cut, as it is drawn.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Its faces, in the order of the tree.
    pub faces: std::ops::Range<usize>,
    /// Its triangles in the extraction.
    pub triangles: std::ops::Range<usize>,
    /// What the file says of it; 0 for a face.
    pub bound: f64,
    /// What was measured of it: from its faces to the mesh, and from its triangles to the surface.
    pub measured: [f64; 2],
}

/// One direction: distances over what the selection allows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Way {
    /// The largest ratio of a distance to what is allowed at that point.
    pub worst: f64,
    /// The cluster that it belongs to.
    pub cluster: usize,
    /// Where it is.
    pub at: DVec3,
    /// Points that are farther off than allowed.
    pub beyond: usize,
    /// Points looked at.
    pub points: usize,
}

/// What is measured of one selection.
#[derive(Clone, Debug)]
pub struct Deviation {
    /// From the surface to the mesh, and from the mesh to the surface.
    pub ways: [Way; 2],
    /// The cut.
    pub clusters: Vec<Drawn>,
    /// Triangles drawn.
    pub triangles: u64,
}

impl Deviation {
    /// The median over the clusters of the bound that the file says over the larger distance that is measured, where
    /// there is one.
    pub fn looseness(&self) -> f64 {
        let measured = |c: &Drawn| c.measured[0].max(c.measured[1]);
        // Flat clusters, whose bound is rounding, say nothing.
        let is_off = |c: &&Drawn| c.bound > 0.0 && measured(c) > 1e-3 * c.bound;
        let mut all: Vec<f64> = self.clusters.iter().filter(is_off).map(|c| c.bound / measured(c)).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(1.0)
    }

    /// The larger of the two worst ratios.
    pub fn worst(&self) -> f64 {
        self.ways[0].worst.max(self.ways[1].worst)
    }
}

/// A tree's faces with points spread over them.
#[derive(Debug)]
pub struct Probe<'a> {
    tree: &'a Tree,
    surface: Surface,
    /// Points with the face that each lies on, face after face.
    points: Vec<(DVec3, usize)>,
    /// Positions are single precision: rounding of their own size is no error of the mesh.
    rounding: f64,
}

/// Points on the drawn mesh are so many at least, and four a triangle.
const POINTS_ON_MESH: f64 = 200_000.0;

impl<'a> Probe<'a> {
    /// Spreads points over the faces: corners and the middles of edges, and `per_face` more.
    pub fn new(tree: &'a Tree, per_face: usize) -> Probe<'a> {
        let faces = tree.faces().unwrap_or_else(|e| panic!("{e}"));
        let mut random = Random::new(11);
        let mut points = Vec::with_capacity(faces.len() * (per_face + 2));
        for (i, face) in faces.iter().enumerate() {
            let [a, b, c] = face.map(|v| position(tree, v));
            points.push(((a + b) * 0.5, i));
            points.push((c, i));
            points.extend((0..per_face).map(|_| (random.in_triangle([a, b, c]), i)));
        }
        let rounding = 1e-6 * points.iter().map(|p| p.0.length()).fold(0.0, f64::max);
        Probe { tree, surface: Surface::of(tree, faces.as_flattened()), points, rounding }
    }

    /// Measures the mesh of a selection against what is allowed at each point: by the tolerance in the guaranteed
    /// order, else by the bound of the mesh with the longest displacement added.
    pub fn measure(&self, selection: &Selection) -> Deviation {
        let mut mesh = Extraction::default();
        extract(self.tree, selection, &mut mesh).unwrap_or_else(|e| panic!("{e}"));
        let corner = |v: &u32| selection.position(&self.tree.vertices()[*v as usize]);
        let displaced =
            mesh.indices.iter().map(|v| corner(v).distance(position(self.tree, *v))).fold(0.0, f64::max);
        let bound = selection.bound(self.tree, &mesh.stats).unwrap_or_else(|e| panic!("{e}"));
        let promised = f64::from(bound) + displaced;
        let outside = |p: DVec3| match selection.tolerance {
            _ if selection.order == Order::Budget => promised,
            Tolerance::Full => 0.0,
            Tolerance::Uniform { distance } => distance,
            Tolerance::Perspective(view) => view.at(p, 0.0),
        };
        let allowed = |p: DVec3| {
            let around = selection.regions.iter().filter(|region| region.center.distance(p) <= region.radius);
            around.map(|region| region.distance).reduce(f64::min).unwrap_or_else(|| outside(p))
        };
        let triangles: Vec<[DVec3; 3]> =
            mesh.indices.chunks_exact(3).map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])]).collect();
        let mut clusters = self.clusters(selection, &mesh);
        let on_mesh = points_on(&triangles);
        let drawn = Surface::of_triangles(triangles);
        let ways = [(&self.points, &drawn), (&on_mesh, &self.surface)];
        let found = ways.map(|(points, to)| self.distances(points, to));
        let mut result = [Way::default(); 2];
        for (k, (way, distances)) in result.iter_mut().zip(&found).enumerate() {
            way.points = distances.len();
            let mut at = 0;
            for ((p, owner), d) in ways[k].0.iter().zip(distances) {
                let owns = |c: &Drawn| if k == 0 { c.faces.end } else { c.triangles.end };
                while at + 1 < clusters.len() && owns(&clusters[at]) <= *owner {
                    at += 1;
                }
                if let Some(c) = clusters.get_mut(at) {
                    c.measured[k] = c.measured[k].max(*d);
                }
                let ratio = d / allowed(*p).max(self.rounding);
                way.beyond += usize::from(ratio > 1.0);
                if ratio > way.worst {
                    (way.worst, way.at, way.cluster) = (ratio, *p, at);
                }
            }
        }
        Deviation { ways: result, clusters, triangles: mesh.stats.triangles }
    }

    fn distances(&self, points: &[(DVec3, usize)], to: &Surface) -> Vec<f64> {
        let of_run = |run: &[(DVec3, usize)]| {
            let mut last: Option<(DVec3, f64)> = None;
            let mut out = Vec::with_capacity(run.len());
            for (p, _) in run {
                // Neighbouring points are nearly as far away.
                let limit = last.map_or(f64::INFINITY, |(q, d)| (d + q.distance(*p)) * (1.0 + 1e-9) + 1e-300);
                let d = to.distance_below(*p, limit);
                last = Some((*p, d));
                out.push((d - self.rounding).max(0.0));
            }
            out
        };
        points.par_chunks(4096).flat_map_iter(of_run).collect()
    }

    /// The clusters of the cut, in the order in which they are drawn.
    fn clusters(&self, selection: &Selection, mesh: &Extraction) -> Vec<Drawn> {
        let reader = self.tree.reader();
        let mut out: Vec<Drawn> = Vec::with_capacity(mesh.clusters.len());
        let mut stack = vec![reader.whole()];
        while let Some(subtree) = stack.pop() {
            let mut bound = 0.0;
            if let Child::Node(_) = subtree.child.kind() {
                let node = reader.node(&subtree).unwrap_or_else(|e| panic!("{e}"));
                if selection.refines_node(subtree.child, &node) {
                    let [left, right] = reader.children(&subtree).unwrap_or_else(|e| panic!("{e}"));
                    stack.extend([right, left]);
                    continue;
                }
                bound = f64::from(node.bound);
            }
            let start = mesh.clusters[out.len()] as usize;
            let end = mesh.clusters.get(out.len() + 1).map_or(mesh.indices.len() / 3, |e| *e as usize);
            let faces = subtree.first_face as usize..subtree.face_end as usize;
            out.push(Drawn { faces, triangles: start..end, bound, measured: [0.0; 2] });
        }
        assert_eq!(out.len(), mesh.clusters.len(), "the cut that was walked is the cut that was drawn");
        out
    }
}

/// Points on triangles, with the triangle that each lies on: middles of edges, the centroid, and more where it is large.
fn points_on(triangles: &[[DVec3; 3]]) -> Vec<(DVec3, usize)> {
    let area = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).length();
    let density = POINTS_ON_MESH / triangles.iter().map(area).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut random = Random::new(12);
    let mut out = Vec::new();
    for (i, t) in triangles.iter().enumerate() {
        let [a, b, c] = *t;
        out.extend([(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5, (a + b + c) / 3.0].map(|p| (p, i)));
        out.extend((0..(area(t) * density) as usize).map(|_| (random.in_triangle(*t), i)));
    }
    out
}
