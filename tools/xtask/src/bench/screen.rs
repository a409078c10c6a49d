//! How far drawn meshes are from where they belong, in pixels, and what cluster LOD needs for the same.

use std::error::Error;
use std::time::Instant;

use fcextract::{Extraction, Order, Selection};
use fct::Tree;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::input::weld;
use super::peers::ClusterLod;
use super::speed::bounds;
use super::view::View;
use crate::data::ply_out::Mesh;
use fcmeasure::{Nearest, sample};

/// Views around the mesh over which errors and triangles are taken.
const VIEWS: usize = 3;

/// Points on either surface, beside its vertices.
const SAMPLES: usize = 50_000;

/// Halvings of the range of the peer's threshold: to about a percent.
const HALVINGS: usize = 8;

/// Both programs at one true error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compared {
    /// Pixels that our selection allows.
    pub(crate) pixels: f64,
    /// Pixels that a point is off at most, in our meshes and in the peer's.
    pub(crate) error: [f64; 2],
    /// Triangles over all views.
    pub(crate) triangles: [u64; 2],
    /// Nanoseconds a triangle for finding the peer's cut, without its indices.
    pub(crate) peer_cut: f64,
}

impl Compared {
    pub(crate) fn ratio(&self) -> f64 {
        self.triangles[0] as f64 / self.triangles[1] as f64
    }
}

/// A surface and points on it.
struct Surface<'a> {
    mesh: &'a Mesh,
    points: Vec<DVec3>,
    nearest: Nearest,
}

/// Finds the coarsest cuts of cluster LOD that are no farther off in any view than ours for `pixels`.
///
/// # Errors
/// When the tree is damaged.
pub(crate) fn compare(
    tree: &Tree,
    mesh: &Mesh,
    lod: &ClusterLod,
    pixels: f64,
) -> Result<Compared, Box<dyn Error>> {
    let surface = Surface { mesh, points: points(mesh), nearest: Nearest::of(mesh.surface()) };
    let [low, high] = bounds(tree);
    let views = View::around(low, high, VIEWS);
    let mut ours = (0.0_f64, 0);
    for view in &views {
        let mut cut = Extraction::default();
        fcextract::extract(tree, &Selection::perspective(view.tolerance(pixels), Order::Bound), &mut cut)?;
        let positions: Vec<[f32; 3]> = tree.vertices().iter().map(|v| v.position()).collect();
        let drawn = weld(&positions, cut.indices.as_chunks::<3>().0);
        ours = (ours.0.max(surface.error(view, &drawn)), ours.1 + cut.stats.triangles);
    }
    let theirs = |threshold: f64| {
        views.iter().fold((0.0_f64, 0), |(error, triangles), view| {
            let drawn =
                lod.seen(&|center, radius| view.tolerance(threshold).at(center, radius), surface.mesh);
            (error.max(surface.error(view, &drawn)), triangles + drawn.faces.len() as u64)
        })
    };
    // Its error is about its threshold; the range is far wider.
    let (mut fine, mut coarse) = ((ours.0 / 30.0).ln(), (ours.0 * 3.0).ln());
    let mut best = None;
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(fine, coarse);
        let found = theirs(middle.exp());
        if found.0 <= ours.0 {
            fine = middle;
            best = Some((found, middle.exp()));
        } else {
            coarse = middle;
        }
    }
    let (found, threshold) = best.unwrap_or_else(|| (theirs(fine.exp()), fine.exp()));
    let mut clusters = Vec::new();
    let mut least = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        for view in &views {
            let tolerance = view.tolerance(threshold);
            lod.select(&|center, radius| tolerance.at(center, radius), &mut clusters);
        }
        least = least.min(start.elapsed().as_nanos() as f64);
    }
    Ok(Compared {
        pixels,
        error: [ours.0, found.0],
        triangles: [ours.1, found.1],
        peer_cut: least / found.1.max(1) as f64,
    })
}

fn points(mesh: &Mesh) -> Vec<DVec3> {
    let vertices = mesh.positions.iter().map(|p| Vec3::from_array(*p).as_dvec3());
    sample(mesh.surface(), SAMPLES).into_iter().chain(vertices).collect()
}

impl Surface<'_> {
    /// Pixels between the surface and a drawn mesh, at most, either way.
    fn error(&self, view: &View, drawn: &Mesh) -> f64 {
        let there = farthest(view, &self.points, &Nearest::of(drawn.surface()));
        there.max(farthest(view, &points(drawn), &self.nearest))
    }
}

fn farthest(view: &View, points: &[DVec3], other: &Nearest) -> f64 {
    let run = |run: &[DVec3]| {
        let mut hint = u32::MAX;
        run.iter().fold(0.0_f64, |most, p| {
            let hit = other.find(*p, hint);
            hint = hit.triangle;
            most.max(view.pixels(*p, hit.squared.sqrt()))
        })
    };
    points.par_chunks(1024).map(run).reduce(|| 0.0, f64::max)
}
