//! Corners that loops get only because a polygon needs three.
//!
//! They are far apart, and best where clusters will meet soon: there a vertex is drawn anyway once one of the splits below
//! is made. A point of a loop where none ends stays a corner of its own, between the same two clusters.

use super::loops::LAST;
use super::polyline;
use crate::mesh::{NONE, fan, prev_in_face};
use crate::partition::{Split, Subtree};
use crate::tree_order::TreeMesh;
use fcgeom::Sphere;
use glam::Vec3;

/// What the distance of a point counts where no cluster will begin before the tolerance is much finer. With 0.1 it is the
/// same, with 0.5 mean errors are 0.4 % larger.
const LEAST: f64 = 0.3;

/// So many corners around a vertex are looked at, lest a vertex of a million faces takes all the time.
const MOST_CORNERS: usize = 64;

/// Completes the chosen ones of a loop's entries to three, along the cut of a node or beside it.
///
/// Each is as far as possible from the chosen ones; distances count in proportion to the key at which a third cluster
/// appears there, over the largest such key of the loop or that of the node.
pub(super) fn complete(
    mesh: &TreeMesh,
    splits: &[Split],
    node: usize,
    entries: &[u32],
    chosen: &mut Vec<usize>,
) {
    if chosen.len() >= 3 {
        return;
    }
    let points = places(mesh, entries);
    let own = f64::from(splits[node].key);
    let keys: Vec<f64> =
        entries.iter().map(|&h| f64::from(key_of_junction(mesh, splits, h & !LAST)).min(own)).collect();
    let most = keys.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    polyline::complete_to_three(&points, chosen, |i| (keys[i] / most).max(LEAST));
}

/// The largest key of a node whose split makes three clusters meet where a half-edge starts: the third largest of
/// the edges there, each with that of the node that is cut along it.
fn key_of_junction(mesh: &TreeMesh, splits: &[Split], half_edge: u32) -> f32 {
    let mut largest = [0.0_f32; 3];
    let mut add = |key: f32| {
        let place = largest.partition_point(|k| *k >= key);
        if let Some(smaller @ [_, ..]) = largest.get_mut(place..) {
            smaller.rotate_right(1);
            smaller[0] = key;
        }
    };
    for h in fan(&mesh.opposite, half_edge).take(MOST_CORNERS) {
        let across = mesh.opposite[h as usize];
        add(if across == NONE { f32::INFINITY } else { key_of_cut(mesh, splits, [h, across]) });
        // A fan that is open has one edge more.
        if mesh.opposite[prev_in_face(h) as usize] == NONE {
            add(f32::INFINITY);
        }
    }
    largest[2]
}

/// The key of the node whose cut goes between the faces of two half-edges.
fn key_of_cut(mesh: &TreeMesh, splits: &[Split], half_edges: [u32; 2]) -> f32 {
    let [a, b] = half_edges.map(|h| h as usize / 3);
    let mut at = Subtree::whole(mesh.faces.len());
    loop {
        let child = at.child_with(a, splits);
        if !child.faces.contains(&b) {
            return splits[at.node].key;
        }
        at = child;
    }
}

/// A sphere around a loop.
pub(super) fn around(mesh: &TreeMesh, entries: &[u32]) -> Sphere {
    Sphere::of_points(places(mesh, entries))
}

fn places(mesh: &TreeMesh, entries: &[u32]) -> Vec<Vec3> {
    entries.iter().map(|&h| mesh.positions[mesh.origin(h & !LAST) as usize]).collect()
}
