//! Pieces: subtrees that are asked about, cut, drawn and left out together.

use super::plan::{Placed, Plan};
use crate::Error;
use crate::scene::Scene;
use fcextract::{Part, Stats};
use fcgeom::Sphere;
use fct::{Child, Subtree};
use glam::DVec3;
use rayon::prelude::*;

/// A subtree in one instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Number of the placed instance, which is also its row on the GPU.
    pub(crate) placed: u32,
    /// The subtree.
    pub(crate) part: Part,
    /// A sphere around it, in the model's coordinates.
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
    /// Distance of the eye from the subtree's sphere, in the scene's unit; negative inside.
    pub(crate) near: f64,
    /// That distance in steps: what is drawn first.
    pub(crate) band: i32,
    /// The band of its middle: where an instance that is still whole has most of its triangles.
    pub(crate) middle: i32,
    /// About how many triangles it draws.
    pub(crate) triangles: f64,
    /// Whether it is as small as pieces are made.
    pub(crate) divided: bool,
}

impl Piece {
    /// What pieces are drawn by: nearest band first, then by instance and place in the tree. Depends on the scene and
    /// the view alone, never on culling or threads.
    pub(crate) fn rank(&self) -> (i32, u32, u32) {
        (self.band, self.placed, self.part.subtree.first_face)
    }
}

/// Sorts pieces nearest first.
pub(crate) fn front_to_back(pieces: &mut [Piece]) {
    pieces.sort_unstable_by_key(Piece::rank);
}

/// Divides pieces into ones of about the plan's size, leaving out what the selections cull, in the order given.
///
/// # Errors
/// [`Error::Extract`] if a tree is damaged.
pub(crate) fn divide(
    scene: &Scene,
    plan: &Plan,
    pieces: &[Piece],
    stats: &mut Stats,
) -> Result<Vec<Piece>, Error> {
    let divided: Vec<(Vec<Piece>, Stats)> = pieces
        .par_iter()
        .map(|piece| {
            let mut stats = Stats::default();
            Ok((divide_one(scene, plan, piece, &mut stats)?, stats))
        })
        .collect::<Result<_, Error>>()?;
    for (_, one) in &divided {
        stats.nodes_visited += one.nodes_visited;
        stats.culled_frustum += one.culled_frustum;
        stats.culled_cone += one.culled_cone;
        stats.faces_culled += one.faces_culled;
    }
    Ok(divided.into_iter().flat_map(|(pieces, _)| pieces).collect())
}

fn divide_one(scene: &Scene, plan: &Plan, piece: &Piece, stats: &mut Stats) -> Result<Vec<Piece>, Error> {
    let mut out = Vec::new();
    let Some(placed) = plan.placed.get(piece.placed as usize) else { return Ok(out) };
    let Some(model) = scene.models.get(placed.model) else { return Ok(out) };
    if piece.divided {
        out.push(*piece);
        return Ok(out);
    }
    let Placed { selection, reckoning, .. } = placed;
    let small = |subtree: &Subtree, node: &fct::Node| {
        let (center, radius) = sphere_of(node);
        reckoning.triangles(center, radius, subtree.face_count()) <= plan.piece_triangles
    };
    piece
        .part
        .divide(&model.tree, selection, stats, small, |part, node| {
            let (center, radius) = match node {
                Some(node) => sphere_of(node),
                None => sphere(&model.tree, &part.subtree),
            };
            // Never before what it is a part of, whatever the rounding.
            let near = reckoning.near(center, radius).max(piece.near);
            let triangles = reckoning.triangles(center, radius, part.subtree.face_count());
            let band = reckoning.band(near);
            out.push(Piece {
                part,
                center,
                radius,
                near,
                band,
                middle: band,
                triangles,
                divided: true,
                ..*piece
            });
        })
        .map_err(|source| Error::Extract { model: model.name.clone(), source })?;
    Ok(out)
}

fn sphere_of(node: &fct::Node) -> (DVec3, f64) {
    (DVec3::from_array(node.center.map(f64::from)), f64::from(node.radius))
}

/// A sphere around a subtree, in the model's coordinates: centre and radius.
pub(crate) fn sphere(tree: &fct::Tree, subtree: &Subtree) -> (DVec3, f64) {
    match subtree.child.kind() {
        Child::Node(_) => tree.node(subtree).map_or((DVec3::ZERO, 0.0), |node| sphere_of(&node)),
        Child::Face(_) => {
            let corner =
                |v: u32| tree.vertices().get(v as usize).map_or(glam::Vec3::NAN, |v| v.position().into());
            let around = Sphere::of_points(tree.reader().face(subtree).unwrap_or_default().map(corner));
            (around.center.as_dvec3(), f64::from(around.radius))
        }
    }
}
