//! The fixed little-endian records that a reader uses in place.
//!
//! Every field is unaligned, so a record can be read at any byte of a map on any machine.

use zerocopy::little_endian::{F32, U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::displacement::Displacement;
use crate::octahedral::{FineNormalRecord, NormalRecord};
use crate::plane::PlaneRecord;
use crate::short_float::ShortFloat;

/// Set in a vertex index that is the last of its loop, where loops are handed to the packer.
pub const LOOP_END: u32 = 1 << 31;

/// The most faces a file may hold: three vertices each must stay below 2^31, where flags begin.
pub const MAX_FACES: u64 = ((1 << 31) - 1) / 3;

/// The most child references on a way from the root to a face.
///
/// Readers may size a stack by it: a depth-first walk holds at most one waiting sibling a level.
pub const MAX_DEPTH: u32 = 96;

/// The most faces of a page: a connected cluster of so many has at most 255 vertices, and as many in its loops.
pub const MAX_PAGE_FACES: u32 = 253;

/// The most vertices of a page: what a local index of one byte can tell.
pub const MAX_PAGE_VERTICES: u32 = 256;

/// The loops of a page's node of at most this many faces are not stored, since they follow from the faces in a moment.
///
/// Larger saves bytes and costs time when such a node is drawn.
pub const SMALL_FACES: u32 = 8;

/// Set in [`NodeRecord::left_faces`] of a small node whose loops are stored all the same.
pub(crate) const STORES_LOOPS: u8 = 0x80;

/// Set in a child of a [`TopRecord`] that is a page, and no top node.
pub(crate) const PAGE_BIT: u32 = 1 << 31;

/// How much more eager than its stored key a vertex is: 2^-16, which no rounding of the test can eat up.
pub(crate) const EAGER: f32 = 1.0 + 1.0 / 65536.0;

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

/// A node above the pages, with all its digits. 68 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct TopRecord {
    /// Centre of the bounding sphere of the cluster. A child's sphere lies inside its parent's.
    pub center: [F32; 3],
    /// Radius of the bounding sphere, rounded up.
    pub radius: F32,
    /// Distance bound (length): how far the drawn cluster may lie from its faces. Never below a child's.
    /// Infinite: the node must always be refined (a virtual node over several components, the root of a closed surface).
    pub bound: F32,
    /// Budget key (length): nodes of larger keys are refined first where triangles are counted. Never below a child's; may be infinite like `bound`.
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
    /// The child that owns the first faces: the index of a top node or, with the top bit set, of a page.
    pub left: U32,
    /// The child that owns the remaining faces, likewise.
    pub right: U32,
    /// The first of the cluster's faces, which are contiguous.
    pub first_face: U32,
    /// The first byte of the node's loops in section `TOPL`.
    pub loop_start: U32,
    /// One past their last byte; the loops of the next top node begin there.
    pub loop_end: U32,
    /// The plane that fits the cluster best.
    pub plane: PlaneRecord,
    /// Reserved, 0.
    pub reserved: u8,
}

/// A subtree of at most [`MAX_PAGE_FACES`] faces, whose nodes, faces and vertices are told in bytes. 40 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct PageRecord {
    /// Where the grid of sphere centres begins; a multiple of the quantum.
    pub origin: [F32; 3],
    /// Width of the grid's steps (length): a power of two.
    pub quantum: F32,
    /// Its first face; its first node is that many less the pages before it.
    pub first_face: U32,
    /// The first of the run of vertices that its faces are the first to use.
    pub first_vertex: U32,
    /// The first of its entries in section `LINK`.
    pub first_link: U32,
    /// The first of its bytes in section `LOOP`.
    pub first_loop: U32,
    /// The length of its run of vertices.
    pub own_vertices: U16,
    /// The number of its entries in section `LINK`.
    pub links: U16,
    /// The number of its bytes in section `LOOP`.
    pub loop_bytes: U16,
    /// The number of its faces.
    pub faces: u8,
    /// Reserved, 0.
    pub reserved: u8,
}

/// A node within a page: a cluster of two faces or more. 16 bytes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct NodeRecord {
    /// Centre of the bounding sphere, in steps of the page's grid. A child's sphere lies inside its parent's.
    pub center: [u8; 3],
    /// Radius of the bounding sphere in the same steps.
    pub radius: u8,
    /// Distance bound, see [`TopRecord::bound`].
    pub bound: ShortFloat,
    /// Budget key, see [`TopRecord::budget`].
    pub budget: ShortFloat,
    /// Axis of the normal cone.
    pub axis: NormalRecord,
    /// The width of the cone: its cosine is 1 - (width / 256)^2, and -1 for 255.
    pub width: u8,
    /// The root of the modelling error in the page's quantum, as a float of 5 bits of exponent and 3 of digits.
    pub epsilon: u8,
    /// The number of faces of the left child; the top bit is a flag in nodes of at most [`SMALL_FACES`] faces.
    pub left_faces: u8,
    /// The plane that fits the cluster best.
    pub plane: PlaneRecord,
}

/// A triangle. 3 bytes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct FaceRecord {
    /// Local indices of vertices in its page, counter-clockwise seen from outside.
    pub vertices: [u8; 3],
}

/// A vertex and its activity record. 27 bytes.
///
/// A vertex is active when its key passes the same test that refines nodes.
/// A key of +inf: always active. A key of 0: needed by no split.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct VertexRecord {
    /// Position relative to [`crate::Meta::origin`].
    pub position: [F32; 3],
    /// The largest distance bound of the nodes that register this vertex as a corner (length).
    pub bound: ShortFloat,
    /// The largest budget key of the nodes that register this vertex as a corner (length).
    pub budget: ShortFloat,
    /// Radius of a sphere that holds the spheres of the nodes that register this vertex.
    pub radius: ShortFloat,
    /// The centre of that sphere less the position, in 1/128 of the radius.
    pub offset: [i8; 3],
    /// Where to draw the vertex in coarse meshes, less the position.
    pub displacement: Displacement,
}

impl VertexRecord {
    /// The position as native numbers.
    #[inline]
    pub fn position(&self) -> [f32; 3] {
        unpack(self.position)
    }

    /// The bound that the test of activity takes: a little more than what is stored.
    #[inline]
    pub fn bound(&self) -> f32 {
        self.bound.get() * EAGER
    }

    /// The budget key that the test of activity takes: a little more than what is stored.
    #[inline]
    pub fn budget(&self) -> f32 {
        self.budget.get() * EAGER
    }

    /// Centre of the sphere.
    #[inline]
    pub fn center(&self) -> [f64; 3] {
        let step = f64::from(self.radius.get()) / 128.0;
        let [x, y, z] = self.position();
        let [i, j, k] = self.offset;
        [
            f64::from(x) + step * f64::from(i),
            f64::from(y) + step * f64::from(j),
            f64::from(z) + step * f64::from(k),
        ]
    }

    /// Radius of the sphere.
    #[inline]
    pub fn radius(&self) -> f64 {
        f64::from(self.radius.get())
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

/// A flat octagonal prism around a cluster. 28 bytes, sorted by `node`, at most one a node.
///
/// See [`crate::BoundingPolygon`] for what the numbers mean.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub struct BoundingPolygonRecord {
    /// The node whose cluster is enclosed, in preorder of the whole tree.
    pub node: U32,
    /// Unit normal of the cluster's plane.
    pub normal: FineNormalRecord,
    /// Lowest height along the normal (length), rounded down.
    pub low: ShortFloat,
    /// Greatest height along the normal (length), rounded up.
    pub high: ShortFloat,
    /// The octagon's support (length) in the directions k times 45 degrees, rounded up.
    pub support: [ShortFloat; 8],
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
const _: () = assert!(size_of::<TopRecord>() == 68);
const _: () = assert!(size_of::<PageRecord>() == 40);
const _: () = assert!(size_of::<NodeRecord>() == 16);
const _: () = assert!(size_of::<VertexRecord>() == 27);
const _: () = assert!(size_of::<FaceRecord>() == 3);
const _: () = assert!(size_of::<WeldRecord>() == 8);
const _: () = assert!(size_of::<BoundingPolygonRecord>() == 28);
const _: () = assert!(size_of::<GroupRecord>() == 16);
