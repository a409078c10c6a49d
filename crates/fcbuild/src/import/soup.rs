//! The triangle soup that every reader yields: nothing welded, every index checked.

use std::ops::Range;

use super::number::narrow;
use super::tally::Tally;
use crate::mesh::Weld;
use crate::mesh::rounding::Rounding;
use glam::DVec3;

/// Vertex positions in the precision that the file stores.
///
/// A glTF scene gives `F32` when every node transform is the identity and `F64` otherwise, because
/// its transforms are applied in `f64`.
#[derive(Clone, Debug, PartialEq)]
pub enum Positions {
    /// Single precision, as most files store them.
    F32(Vec<[f32; 3]>),
    /// Double precision: PLY `double`, transformed glTF, and text with digits that `f32` would lose.
    F64(Vec<[f64; 3]>),
}

impl Positions {
    /// The number of vertices.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(v) => v.len(),
            Self::F64(v) => v.len(),
        }
    }

    /// True when there is no vertex.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Stores numbers that were read from text in `f32`, unless that would lose detail.
    ///
    /// Rounding may move a coordinate by at most 2^-20 of the model's largest extent, a millimetre in a
    /// kilometre, and not by much beside the faces, whose corners are given; coordinates far from the origin, as in
    /// maps, stay in `f64`.
    pub(super) fn narrow_if_harmless(points: Vec<[f64; 3]>, faces: impl Iterator<Item = [usize; 3]>) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        let mut moved = 0.0f64;
        for p in points.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            for ((x, low), high) in p.iter().zip(&mut low).zip(&mut high) {
                *low = low.min(*x);
                *high = high.max(*x);
                moved = moved.max((f64::from(narrow(*x)) - x).abs());
            }
        }
        let extent = low.iter().zip(&high).map(|(l, h)| h - l).fold(0.0, f64::max);
        let is_fine = || {
            let mut rounding = Rounding::default();
            for corners in faces.map(|face| face.map(|v| points.get(v).copied())) {
                if let [Some(a), Some(b), Some(c)] = corners {
                    let exact = [a, b, c].map(DVec3::from);
                    rounding.add(exact, exact.map(|p| p.as_vec3().as_dvec3()), Weld::Exact);
                }
            }
            !rounding.matters()
        };
        if moved == 0.0 || moved <= extent / 1_048_576.0 && is_fine() {
            Self::F32(points.iter().map(|p| p.map(narrow)).collect())
        } else {
            Self::F64(points)
        }
    }

    /// The position of vertex `index` in double precision; `None` past the end.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<[f64; 3]> {
        match self {
            Self::F32(v) => v.get(index).map(|p| p.map(f64::from)),
            Self::F64(v) => v.get(index).copied(),
        }
    }
}

/// A named run of triangles: one mesh instance of a scene, one object of an OBJ, one solid of an STL.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// The name in the file, or the file's stem where it gives none.
    pub name: String,
    /// The triangles that belong to it; the groups of a [`Soup`] cover its triangles in order.
    pub triangles: Range<usize>,
}

/// Triangles with shared vertices as the file gives them, before welding.
///
/// Every index is below `positions.len()`, every used position is finite, and there is at least one
/// vertex. Triangles may be degenerate or double; that is for the welding to decide.
#[derive(Clone, Debug, PartialEq)]
pub struct Soup {
    /// One position per vertex; those that no triangle uses may be non-finite.
    pub positions: Positions,
    /// Vertex indices, counter-clockwise seen from outside as far as the file keeps to that.
    pub triangles: Vec<[u32; 3]>,
    /// One normal per vertex, as stored: of any length, possibly zero.
    pub normals: Option<Vec<[f32; 3]>>,
    /// One RGBA colour per vertex.
    pub colors: Option<Vec<[u8; 4]>>,
    /// The groups, in file order, without gaps; never empty.
    pub groups: Vec<Group>,
    /// What was read, dropped and warned about.
    pub tally: Tally,
}

impl Soup {
    /// Turns every face over, its normals too, so that a surface that looks inwards looks outwards.
    pub fn flip(&mut self) {
        for [_, b, c] in &mut self.triangles {
            std::mem::swap(b, c);
        }
        for x in self.normals.as_mut().map_or(&mut [][..], |normals| normals.as_flattened_mut()) {
            *x = -*x;
        }
    }

    /// Makes one group of all, of the first one's name, so that the surface is not cut where they meet.
    pub fn join_groups(&mut self) {
        self.groups.truncate(1);
        if let Some(all) = self.groups.first_mut() {
            all.triangles = 0..self.triangles.len();
        }
    }
}
