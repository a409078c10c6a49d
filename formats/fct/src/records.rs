//! The fixed little-endian records that a reader uses in place.
//!
//! Every field is unaligned, so a record can be read at any byte of a map on any machine.

use zerocopy::little_endian::{F32, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Set in an entry of section `LOOP` that is the last vertex of its loop.
pub const LOOP_END: u32 = 1 << 31;

/// The most faces a file may hold: three vertices each must stay below 2^31, where flags begin.
pub const MAX_FACES: u64 = ((1 << 31) - 1) / 3;

/// The most child references on a way from the root to a face.
///
/// Readers may size a stack by it: a depth-first walk holds at most one waiting sibling a level.
pub const MAX_DEPTH: u32 = 96;

/// Makes three stored floats of three native ones.
pub const fn pack(v: [f32; 3]) -> [F32; 3] {
    let [x, y, z] = v;
    [F32::new(x), F32::new(y), F32::new(z)]
}

/// Makes three native floats of three stored ones.
pub const fn unpack(v: [F32; 3]) -> [f32; 3] {
    let [x, y, z] = v;
    [x.get(), y.get(), z.get()]
}

/// An interior node: a cluster of two faces or more. 64 bytes, one cache line.
///
/// What a cut reads stands first. The number of faces is not stored: see [`crate::Tree::children`].
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct NodeRecord {
    /// Centre of the bounding sphere of the cluster. A child's sphere lies inside its parent's.
    pub center: [F32; 3],
    /// Radius of the bounding sphere, rounded up.
    pub radius: F32,
    /// Distance bound (length): how far the drawn cluster may lie from its faces. Never above the parent's.
    /// Infinite: the node must always be refined (a virtual node over several components, the root of a closed surface).
    pub bound: F32,
    /// Budget key (length): the square root of the largest `epsilon` in the subtree. Never above the parent's; may be infinite like `bound`.
    pub budget: F32,
    /// Axis of the normal cone, a unit vector.
    pub axis: [F32; 3],
    /// Cosine of the half angle of the normal cone, rounded down. -1: the cone holds every direction and culls nothing.
    pub cos: F32,
    /// Modelling error: the mean square distance of the cluster from its plane (length squared). Raw, so not monotone.
    ///
    /// # Paper
    /// [Tsuji07, eq. 8]: the smallest eigenvalue of the area-integrated covariance.
    pub epsilon: F32,
    /// The child that owns the first faces, a [`crate::ChildRef`].
    pub left: U32,
    /// The child that owns the remaining faces, a [`crate::ChildRef`].
    pub right: U32,
    /// The first of the cluster's faces, which are contiguous.
    pub first_face: U32,
    /// The first of the node's entries in section `LOOP`.
    pub loop_start: U32,
    /// The number of the node's entries in section `LOOP`; 0 for a closed surface.
    pub loop_len: U32,
}

/// A vertex and its activity record. 36 bytes.
///
/// A vertex is active when its key passes the same test that refines nodes.
/// A key of +inf: always active. A key of 0: needed by no split.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct VertexRecord {
    /// Position relative to [`crate::Meta::origin`].
    pub position: [F32; 3],
    /// The largest distance bound of the nodes that register this vertex as a corner (length).
    pub bound: F32,
    /// The largest budget key of the nodes that register this vertex as a corner (length).
    pub budget: F32,
    /// Centre of a sphere that holds the spheres of the nodes that register this vertex.
    pub center: [F32; 3],
    /// Radius of that sphere.
    pub radius: F32,
}

/// A triangle. 12 bytes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct FaceRecord {
    /// Vertex indices, counter-clockwise seen from outside.
    pub vertices: [U32; 3],
}

impl FaceRecord {
    /// The three vertex indices as native numbers.
    pub const fn indices(&self) -> [u32; 3] {
        let [a, b, c] = self.vertices;
        [a.get(), b.get(), c.get()]
    }
}

impl From<[u32; 3]> for FaceRecord {
    fn from([a, b, c]: [u32; 3]) -> Self {
        Self { vertices: [U32::new(a), U32::new(b), U32::new(c)] }
    }
}

/// Says that a vertex is a copy made by cutting a seam. 8 bytes, sorted by `vertex`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct WeldRecord {
    /// The copy.
    pub vertex: U32,
    /// The vertex it is a copy of, itself no copy, with an equal [`VertexRecord`].
    pub representative: U32,
}

/// A flat octagonal prism around a cluster. 84 bytes, sorted by `node`, at most one a node.
///
/// With `b = normal x tangent`, the cluster lies in the points `origin + x tangent + y b + z normal` where
/// `low <= z <= high` and, for k in 0..8, `x cos(k 45 deg) + y sin(k 45 deg) <= support[k]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct BoundingPolygonRecord {
    /// The node whose cluster is enclosed.
    pub node: U32,
    /// Reserved, 0.
    pub flags: U32,
    /// Origin of the prism's frame.
    pub origin: [F32; 3],
    /// Unit normal of the cluster's plane.
    pub normal: [F32; 3],
    /// Unit vector at right angles to `normal`.
    pub tangent: [F32; 3],
    /// Lowest height along the normal (length).
    pub low: F32,
    /// Greatest height along the normal (length).
    pub high: F32,
    /// The octagon's support (length) in the directions k times 45 degrees from `tangent` towards `b`.
    pub support: [F32; 8],
}

/// A component group: a mesh of the input scene. 16 bytes, sorted by `first_face`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct GroupRecord {
    /// The subtree that holds the group, a [`crate::ChildRef`].
    pub root: U32,
    /// The first face of the group.
    pub first_face: U32,
    /// The number of faces of the group.
    pub face_count: U32,
    /// Index of the group's name in [`crate::Meta::group_names`].
    pub name: U32,
}

// The sizes are the format: SPEC.md quotes them.
const _: () = assert!(size_of::<NodeRecord>() == 64);
const _: () = assert!(size_of::<VertexRecord>() == 36);
const _: () = assert!(size_of::<FaceRecord>() == 12);
const _: () = assert!(size_of::<WeldRecord>() == 8);
const _: () = assert!(size_of::<BoundingPolygonRecord>() == 84);
const _: () = assert!(size_of::<GroupRecord>() == 16);
