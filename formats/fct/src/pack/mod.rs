//! From plain clusters to the records of a file: pages, quantised towards safety.
//!
//! In three steps, so that the second can run on many threads: [`Plan`] finds the subtrees that become pages,
//! [`Plan::pack_pages`] makes a run of them, and [`Packed::assemble`] puts the runs together and adds the nodes above.
//! [`Packed::new`] does all three.
//!
//! What is packed is read back as decoded: bounds, keys and spheres are a little larger. Whoever computes vertex
//! records must take the decoded numbers, see [`Packed::decoded`], and [`crate::VertexRecord::eager`].
#![allow(
    clippy::indexing_slicing,
    clippy::arithmetic_side_effects,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "these numbers are the caller's, not a file's, and the plan checks their ranges first"
)]

mod ball;
mod cone;
mod error_code;
mod loops;
mod page;
mod plain;
mod plan;
mod polygon;
mod spheres;
mod top;
mod vertex;

pub(crate) use loops::{encode_top, push_varint};
pub use plain::PlainClusters;
pub use plan::Plan;

use crate::node::Node;
use crate::records::{FaceRecord, NodeRecord, PageRecord, TopRecord};
use zerocopy::little_endian::U32;

/// A cluster before it is packed. Spheres are found here, from the faces up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClusterData {
    /// Distance bound (length), may be infinite; raised where it is below a child's.
    pub bound: f32,
    /// Budget key (length), may be infinite; raised where it is below a child's.
    pub budget: f32,
    /// Axis of the normal cone.
    pub axis: [f32; 3],
    /// Cosine of the half angle of the normal cone.
    pub cos: f32,
    /// Mean square distance of the cluster from its plane (length squared).
    pub epsilon: f32,
    /// Unit normal of that plane; zero if there is none.
    pub plane: [f32; 3],
    /// `plane . x` for its points x.
    pub offset: f64,
}

/// A tree of clusters as its builder has it: nodes in preorder, faces in tree order, vertices in order of first use.
pub trait Clusters {
    /// Vertex indices of each face.
    fn faces(&self) -> &[[u32; 3]];
    /// Number of vertices; all indices are below it.
    fn vertex_count(&self) -> usize;
    /// Position of a vertex.
    fn position(&self, vertex: u32) -> [f32; 3];
    /// Faces of the left child of a node: at least one, and fewer than the node has.
    fn left_faces(&self, node: u32) -> u32;
    /// The cluster of a node.
    fn cluster(&self, node: u32) -> ClusterData;
    /// Appends the boundary loops of a node's cluster, the cluster on their left, with [`crate::LOOP_END`] set in the
    /// last vertex of each. Not asked for nodes of infinite bound, which are never drawn.
    fn boundary(&self, node: u32, out: &mut Vec<u32>);
}

/// Why clusters could not be packed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PackError {
    /// A sphere does not fit in single precision.
    #[error("the sphere of node {0} leaves the range of single precision; scale the model")]
    Range(u32),
    /// A section would not fit in 32-bit offsets.
    #[error("{0} would take more than 2^32 bytes; split the model")]
    TooLong(&'static str),
    /// The clusters contradict themselves.
    #[error("the clusters are no tree: {0}")]
    NoTree(String),
}

/// Packed pages in a row, to be put together by [`Packed::assemble`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageRun(Packed);

/// The sections that hold nodes, faces and loops.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Packed {
    /// Section `TOPN`.
    pub tops: Vec<TopRecord>,
    /// Section `TOPL`.
    pub top_loops: Vec<u8>,
    /// Section `PAGE`.
    pub pages: Vec<PageRecord>,
    /// Section `NODE`.
    pub nodes: Vec<NodeRecord>,
    /// Section `FACE`.
    pub faces: Vec<FaceRecord>,
    /// Section `LOOP`.
    pub loops: Vec<u8>,
    /// Section `LINK`.
    pub links: Vec<U32>,
}

impl Packed {
    /// Packs clusters on this thread, in pages as large as can be.
    ///
    /// # Errors
    /// What [`PackError`] lists.
    pub fn new(clusters: &impl Clusters) -> Result<Self, PackError> {
        let plan = Plan::new(clusters, crate::records::MAX_PAGE_FACES)?;
        let run = plan.pack_pages(clusters, 0..plan.page_count())?;
        Self::assemble(clusters, &plan, [Ok(run)])
    }

    /// Puts runs of pages together, which are all pages of the plan in order, and packs the nodes above them.
    ///
    /// # Errors
    /// What [`PackError`] lists.
    pub fn assemble(
        clusters: &impl Clusters,
        plan: &Plan,
        runs: impl IntoIterator<Item = Result<PageRun, PackError>>,
    ) -> Result<Self, PackError> {
        let mut all = Self::default();
        all.reserve(plan);
        for run in runs {
            all.append(run?.0)?;
        }
        if all.pages.len() != plan.page_count() {
            return Err(PackError::NoTree(format!(
                "{} of {} pages were packed",
                all.pages.len(),
                plan.page_count()
            )));
        }
        top::pack(clusters, plan, &mut all)?;
        Ok(all)
    }

    /// Takes the memory whose size is known.
    fn reserve(&mut self, plan: &Plan) {
        let faces = plan.pages.last().map_or(0, |page| (page.first_face + page.faces) as usize);
        self.pages.reserve_exact(plan.page_count());
        self.nodes.reserve_exact(faces - plan.page_count());
        self.faces.reserve_exact(faces);
    }

    fn append(&mut self, run: Self) -> Result<(), PackError> {
        let links =
            u32::try_from(self.links.len()).map_err(|_too_long| PackError::TooLong("section LINK"))?;
        let loops =
            u32::try_from(self.loops.len()).map_err(|_too_long| PackError::TooLong("section LOOP"))?;
        let shifted = |x: U32, by: u32, section| {
            x.get().checked_add(by).map(U32::new).ok_or(PackError::TooLong(section))
        };
        for mut page in run.pages {
            page.first_link = shifted(page.first_link, links, "section LINK")?;
            page.first_loop = shifted(page.first_loop, loops, "section LOOP")?;
            self.pages.push(page);
        }
        self.nodes.extend(run.nodes);
        self.faces.extend(run.faces);
        self.loops.extend(run.loops);
        self.links.extend(run.links);
        Ok(())
    }

    /// The nodes as a reader decodes them.
    pub fn decoded<'a>(&'a self, plan: &'a Plan) -> Decoded<'a> {
        Decoded { packed: self, plan, page: 0 }
    }
}

/// The nodes of packed clusters as a reader decodes them, by their place in preorder.
///
/// Quick for nodes of one page in a row.
#[derive(Clone, Copy, Debug)]
pub struct Decoded<'a> {
    packed: &'a Packed,
    plan: &'a Plan,
    /// The page of the last node.
    page: usize,
}

impl Decoded<'_> {
    /// The node that stands at this place in preorder; none if there is no such place.
    pub fn node(&mut self, index: u32) -> Option<Node> {
        if let Some(node) = self.in_page(index) {
            return Some(node);
        }
        // A page of a single face has no node, and a number that it shares with a page or a node after it.
        let after = self.plan.pages.partition_point(|page| page.node <= index);
        self.page = after.saturating_sub(1);
        self.in_page(index).or_else(|| {
            let top = self.plan.tops.binary_search_by_key(&index, |top| top.node).ok()?;
            Some(Node::of_top(self.packed.tops.get(top)?))
        })
    }

    fn in_page(&self, index: u32) -> Option<Node> {
        let planned = self.plan.pages.get(self.page)?;
        let local = index.checked_sub(planned.node).filter(|local| local + 1 < planned.faces)?;
        // Pages before it have one node less than faces.
        let record = planned.first_face as usize - self.page + local as usize;
        Some(Node::of_page(self.packed.pages.get(self.page)?, self.packed.nodes.get(record)?))
    }
}
