//! From a polygon soup to oriented manifold pieces with boundary.

mod attributes;
mod components;
mod dual_graph;
mod fans;
mod group_names;
mod orientation;
pub(crate) mod rounding;
mod shares;
pub(crate) mod units;
mod weld;

pub use components::Components;
pub use dual_graph::{DualGraph, EdgeKind, NONE};
pub(crate) use dual_graph::{next_in_face, origin, prev_in_face};
pub(crate) use fans::fan;
pub use units::Units;
pub use weld::Weld;

use crate::error::Error;
use crate::import::{Group, Soup, Tally};
use attributes::Attributes;
use glam::Vec3;
use rayon::prelude::*;

/// The largest number of faces that half-edge indices below 2^31 allow.
pub const MAX_FACES: u64 = (1 << 31) / 3 - 1;

/// A welded mesh whose every connected piece is an oriented manifold with boundary.
#[derive(Debug)]
pub struct Mesh {
    /// Scale and origin that lead back to the input's coordinates.
    pub units: Units,
    /// Position of each vertex as the file will store it.
    pub stored: Vec<Vec3>,
    /// Position of each vertex, in normal units (see [`Units`]).
    pub positions: Vec<Vec3>,
    /// Unit normal of each vertex as the input gave it, else the area-weighted mean of its faces' normals.
    pub normals: Vec<Vec3>,
    /// Colour of each vertex, sRGB with alpha, when the input had colours.
    pub colors: Option<Vec<[u8; 4]>>,
    /// The welded vertex that each vertex is a copy of: seams and pinches are cut by copying vertices.
    pub weld: Vec<u32>,
    /// Vertex indices of each face, counter-clockwise.
    pub faces: Vec<[u32; 3]>,
    /// Adjacency across edges.
    pub graph: DualGraph,
    /// The group (object of the scene) of each face; empty when there is one group.
    pub face_group: Vec<u32>,
    /// Names of the groups, in order.
    pub group_names: Vec<String>,
    /// What was read, dropped and warned about.
    pub tally: Tally,
}

impl Mesh {
    /// Welds and repairs `soup`; every dropped face is counted in the tally.
    ///
    /// # Errors
    /// Bad input when no face is left.
    pub fn from_soup(soup: Soup, weld: Weld) -> Result<Mesh, Error> {
        let Soup { positions, triangles, normals, colors, groups, mut tally } = soup;
        let (units, mut stored, mut positions, rounding) = Units::normalise(positions, &triangles, weld)?;
        if let Some((faces, message)) = rounding.told() {
            tally.warn("FC298", faces, message);
        }
        let representative = weld::weld(&stored, weld);
        let kept = weld::keep_faces(&triangles, &representative, &mut tally);
        if kept.is_empty() {
            return Err(Error::bad_input(
                "FC290",
                if rounding.collapsed > 0 {
                    "no face is left after repair: single precision cannot tell the corners of faces apart"
                } else {
                    "no face is left after repair: all were degenerate, with a corner twice"
                },
            )
            .remedy(match weld {
                _ if rounding.collapsed > 0 => rounding::REMEDY,
                Weld::Within(_) => "a welding distance larger than the model does that; try --weld exact",
                Weld::Exact | Weld::Off => "export the mesh again, and see that its corners are apart",
            }));
        }
        let mut faces: Vec<[u32; 3]> =
            kept.par_iter().map(|&f| triangles[f as usize].map(|v| representative[v as usize])).collect();
        drop(triangles);
        let (face_group, mut group_names) = group_of_faces(&kept, groups);
        group_names::tell_apart(&mut group_names);
        warn_of_lost_groups(&face_group, &group_names, &mut tally);
        drop(kept);

        let attributes = Attributes::merge(&representative, normals, colors, &mut tally);
        drop(representative);
        let graph = DualGraph::of(&faces, positions.len(), &face_group);
        if orientation::looks_inwards(&positions, &faces, &graph) {
            let message = "the faces look inwards, so that a viewer culls the outside; turn them over with --flip, or draw both \
                 sides with fcview --two-sided";
            tally.warn("FC293", 1, message);
        }
        let copies = fans::split(&mut faces, &graph, positions.len());
        for &v in &copies {
            positions.push(positions[v as usize]);
            stored.push(stored[v as usize]);
        }
        let weld: Vec<u32> = (0..(positions.len() - copies.len()) as u32).chain(copies).collect();
        let normals = attributes.normals_or_mean(&positions, &faces, &weld);
        let colors = attributes.colors_of_copies(&weld);
        Ok(Mesh {
            units,
            stored,
            positions,
            normals,
            colors,
            weld,
            faces,
            graph,
            face_group,
            group_names,
            tally,
        })
    }
}

/// Names the groups of which no face is left, such as a file that is given twice.
fn warn_of_lost_groups(face_group: &[u32], names: &[String], tally: &mut Tally) {
    /// More would fill the screen.
    const NAMED: usize = 5;
    if face_group.is_empty() {
        return;
    }
    let mut has_faces = vec![false; names.len()];
    for &group in face_group {
        has_faces[group as usize] = true;
    }
    let mut lost = names.iter().zip(&has_faces).filter(|(_, has)| !**has).map(|(name, _)| name.as_str());
    let listed: Vec<&str> = lost.by_ref().take(NAMED).collect();
    let more = lost.count();
    let dots = if more > 0 { ", ..." } else { "" };
    let message = format!("groups have no face left and are not in the tree: {}{dots}", listed.join(", "));
    tally.warn("FC297", (listed.len() + more) as u64, message);
}

/// The group index of each kept face, left empty when there is one group only.
fn group_of_faces(kept: &[u32], groups: Vec<Group>) -> (Vec<u32>, Vec<String>) {
    let mut of_face = Vec::new();
    if groups.len() > 1 {
        of_face.reserve_exact(kept.len());
        let mut group = 0;
        for &face in kept {
            while group + 1 < groups.len() && face as usize >= groups[group].triangles.end {
                group += 1;
            }
            of_face.push(group as u32);
        }
    }
    (of_face, groups.into_iter().map(|g| g.name).collect())
}
