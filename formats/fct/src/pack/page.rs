//! One page: local indices, nodes on a grid, loops in bytes.

use super::loops::{Stored, page_loops};
use super::plan::PlannedPage;
use super::{ClusterData, Clusters, PackError, Packed, cone, error_code, spheres};
use crate::node::cosine_of;
use crate::octahedral::NormalRecord;
use crate::plane::PlaneRecord;
use crate::records::{FaceRecord, NodeRecord, PageRecord, SMALL_FACES, STORES_LOOPS, pack};
use crate::short_float::ShortFloat;
use zerocopy::little_endian::U32;

/// Packs pages one after the other; keeps its memory from one to the next.
#[derive(Default)]
pub(super) struct Packer {
    data: Vec<ClusterData>,
    nodes: Vec<Place>,
    links: Vec<u32>,
    entries: Vec<u32>,
}

/// Where a node of a page stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its first face, counted from the page's.
    pub(super) first: usize,
    /// Its faces, and those of its left child.
    pub(super) faces: usize,
    pub(super) left: usize,
}

/// A child of a node of a page.
#[derive(Clone, Copy, Debug)]
pub(super) enum Below {
    Node(usize),
    Face(usize),
}

impl Place {
    /// The children of the node that stands at `index` in its page.
    pub(super) fn children(&self, index: usize) -> [Below; 2] {
        let right = self.faces - self.left;
        [
            if self.left > 1 { Below::Node(index + 1) } else { Below::Face(self.first) },
            if right > 1 { Below::Node(index + self.left) } else { Below::Face(self.first + self.left) },
        ]
    }
}

/// Vertex indices of a page: its own run first, then those that earlier pages have too.
pub(super) struct Names<'a> {
    first_vertex: u32,
    own_vertices: u32,
    links: &'a [u32],
}

impl Names<'_> {
    /// The local index of a vertex of the page.
    pub(super) fn local(&self, vertex: u32) -> Option<u8> {
        let own = vertex.wrapping_sub(self.first_vertex);
        let local = if own < self.own_vertices {
            own
        } else {
            self.own_vertices + self.links.binary_search(&vertex).ok()? as u32
        };
        u8::try_from(local).ok()
    }
}

impl Packer {
    /// Appends a page to a run.
    pub(super) fn pack(
        &mut self,
        clusters: &impl Clusters,
        page: &PlannedPage,
        out: &mut Packed,
    ) -> Result<(), PackError> {
        self.place_nodes(clusters, page)?;
        let faces = &clusters.faces()[page.first_face as usize..(page.first_face + page.faces) as usize];
        self.links.clear();
        self.links.extend(faces.iter().flatten().copied().filter(|v| *v < page.first_vertex));
        self.links.sort_unstable();
        self.links.dedup();
        let names =
            Names { first_vertex: page.first_vertex, own_vertices: page.own_vertices, links: &self.links };

        for face in faces {
            let locals = face.map(|v| names.local(v));
            let [Some(a), Some(b), Some(c)] = locals else {
                return Err(PackError::NoTree(format!("a face of node {} is not its page's", page.node)));
            };
            out.faces.push(FaceRecord { vertices: [a, b, c] });
        }
        let corner = |face: usize| faces[face].map(|v| clusters.position(v));
        let grid = spheres::nest(&self.nodes, &corner).ok_or(PackError::Range(page.node))?;

        let (first_link, first_loop) =
            (offset(out.links.len(), "section LINK")?, offset(out.loops.len(), "section LOOP")?);
        let loops_start = out.loops.len();
        let stored =
            page_loops(clusters, page, &self.nodes, &self.data, &names, &mut self.entries, &mut out.loops)?;

        for (index, (data, place)) in self.data.iter().zip(&self.nodes).enumerate() {
            let ball = grid.balls[index];
            let axis = NormalRecord::encode(data.axis);
            let flag = place.faces <= SMALL_FACES as usize && stored[index] == Stored::Yes;
            let width = cone::width(data.axis, data.cos, axis);
            let around = (axis.direction(), f64::from(cosine_of(width)));
            let bound = ShortFloat::up(f64::from(data.bound));
            let first = clusters.position(faces[place.first][0]);
            out.nodes.push(NodeRecord {
                center: ball.center.map(|c| c as u8),
                radius: ball.radius as u8,
                bound,
                budget: ShortFloat::up(f64::from(data.budget)),
                axis,
                width,
                epsilon: error_code::encode(f64::from(data.epsilon), f64::from(grid.quantum)),
                left_faces: place.left as u8 | if flag { STORES_LOOPS } else { 0 },
                plane: PlaneRecord::encode(data.plane, data.offset, first, around, bound.get()),
            });
        }
        out.pages.push(PageRecord {
            origin: pack(grid.origin),
            quantum: grid.quantum.into(),
            first_face: page.first_face.into(),
            first_vertex: page.first_vertex.into(),
            first_link,
            first_loop,
            own_vertices: (page.own_vertices as u16).into(),
            links: (self.links.len() as u16).into(),
            // At most some 50,000: a node's loops have one and a half times its faces and a few.
            loop_bytes: u16::try_from(out.loops.len() - loops_start)
                .map_err(|_too_long| PackError::TooLong("the loops of a page"))?
                .into(),
            faces: page.faces as u8,
            reserved: 0,
        });
        out.links.extend(self.links.iter().map(|v| U32::new(*v)));
        Ok(())
    }

    /// Finds the place of each node, and its cluster with keys that never grow towards the leaves.
    fn place_nodes(&mut self, clusters: &impl Clusters, page: &PlannedPage) -> Result<(), PackError> {
        let count = page.faces as usize - 1;
        self.nodes.clear();
        self.data.clear();
        self.nodes.resize(count, Place { first: 0, faces: page.faces as usize, left: 0 });
        for index in 0..count {
            let node = page.node + index as u32;
            let left = clusters.left_faces(node) as usize;
            let Place { first, faces, .. } = self.nodes[index];
            if left == 0 || left >= faces {
                return Err(PackError::NoTree(format!(
                    "node {node} has {left} of {faces} faces on the left"
                )));
            }
            self.nodes[index].left = left;
            if left > 1 {
                self.nodes[index + 1] = Place { first, faces: left, left: 0 };
            }
            if faces - left > 1 {
                self.nodes[index + left] = Place { first: first + left, faces: faces - left, left: 0 };
            }
            self.data.push(clusters.cluster(node));
        }
        for index in (0..count).rev() {
            for child in self.nodes[index].children(index) {
                if let Below::Node(child) = child {
                    self.data[index].bound = self.data[index].bound.max(self.data[child].bound);
                    self.data[index].budget = self.data[index].budget.max(self.data[child].budget);
                }
            }
        }
        Ok(())
    }
}

pub(super) fn offset(at: usize, section: &'static str) -> Result<U32, PackError> {
    u32::try_from(at).map(U32::new).map_err(|_too_long| PackError::TooLong(section))
}
