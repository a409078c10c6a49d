//! A walk through a field of instances, step by step and in jumps.
//!
//! # Paper
//! `[Tsuji07]` 6.3: the time of a frame depends on its triangles, not on how far the viewpoint has moved.

use std::error::Error;
use std::time::Instant;

use fcextract::{Extraction, Order, Selection};
use fct::Tree;
use glam::DVec3;

use super::speed::bounds;
use super::view::View;

/// Instances on a side of the field.
const SIDE: usize = 10;

/// Frames of a walk. The way has as many steps times [`Walk::speed`], and leads around the field as often.
const FRAMES: usize = 200;

/// How much faster the jumping walk is.
pub(crate) const JUMP: usize = 100;

/// The frames of a walk at one speed.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    /// Steps from frame to frame.
    pub(crate) speed: usize,
    /// Triangles and nanoseconds of each frame; the least time of the rounds.
    pub(crate) frames: Vec<(u64, f64)>,
}

impl Walk {
    /// Nanoseconds a triangle over all frames.
    pub(crate) fn per_triangle(&self) -> f64 {
        let sums = self.frames.iter().fold((0, 0.0), |sum, frame| (sum.0 + frame.0, sum.1 + frame.1));
        sums.1 / sums.0.max(1) as f64
    }

    /// Triangles of a frame, in the mean.
    pub(crate) fn triangles(&self) -> f64 {
        self.frames.iter().map(|f| f.0 as f64).sum::<f64>() / self.frames.len().max(1) as f64
    }
}

/// Walks in both speeds, in turns frame by frame, so that what else the machine does meets both alike.
///
/// The way is a ring around the middle of the field with [`FRAMES`] times [`JUMP`] steps, of which the slow walk takes
/// the part that it gets to: so it is cut into pieces that begin where the fast walk's frames are.
///
/// # Errors
/// When the tree is damaged.
pub(crate) fn walks(tree: &Tree, rounds: u32) -> Result<[Walk; 2], Box<dyn Error>> {
    let mut walks = [1, JUMP].map(|speed| Walk { speed, frames: vec![(0, f64::INFINITY); FRAMES] });
    let mut meshes: [Vec<Extraction>; 2] =
        [1, JUMP].map(|_| (0..SIDE * SIDE).map(|_| Extraction::default()).collect());
    for _ in 0..rounds {
        for frame in 0..FRAMES {
            for (walk, meshes) in walks.iter_mut().zip(&mut meshes) {
                // The slow walk stays on a stretch for ten frames before it goes on to the next, so that both see all.
                let step = if walk.speed == 1 { frame / 10 * 10 * JUMP + frame % 10 } else { frame * JUMP };
                let view = along(tree, step as f64 / (FRAMES * JUMP) as f64);
                let start = Instant::now();
                let triangles = frame_of(tree, &view, meshes)?;
                let time = start.elapsed().as_nanos() as f64;
                if let Some(slot) = walk.frames.get_mut(frame) {
                    *slot = (triangles, slot.1.min(time));
                }
            }
        }
    }
    Ok(walks)
}

/// The view at a part of the way around.
fn along(tree: &Tree, part: f64) -> View {
    let [low, high] = bounds(tree);
    let size = (high - low).length();
    let (sin, cos) = (std::f64::consts::TAU * part).sin_cos();
    let radius = 0.35 * SIDE as f64 * size;
    View { eye: DVec3::new(radius * cos, 0.15 * size, radius * sin), axis: DVec3::new(-sin, 0.0, cos) }
}

/// Extracts all instances in sight at one pixel; returns the number of triangles.
fn frame_of(tree: &Tree, view: &View, meshes: &mut [Extraction]) -> Result<u64, Box<dyn Error>> {
    let [low, high] = bounds(tree);
    let (center, size) = (low.midpoint(high), (high - low).length());
    let mut triangles = 0;
    for (i, mesh) in meshes.iter_mut().enumerate() {
        let middle = 0.5 * (SIDE as f64 - 1.0);
        let place = DVec3::new((i % SIDE) as f64 - middle, 0.0, (i / SIDE) as f64 - middle) * size;
        // The eye in the instance's coordinates: instances are moved, not turned.
        let seen = View { eye: view.eye - place + center, axis: view.axis };
        let selection = Selection {
            frustum: Some(seen.frustum(size)),
            backface_eye: Some(seen.eye),
            ..Selection::perspective(seen.tolerance(1.0), Order::Bound)
        };
        fcextract::extract(tree, &selection, mesh)?;
        triangles += mesh.stats.triangles;
    }
    Ok(triangles)
}
