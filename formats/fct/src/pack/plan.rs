//! Which subtrees become pages.

use super::{Clusters, PackError, Packed, PageRun, page};
use crate::records::{MAX_PAGE_FACES, MAX_PAGE_VERTICES, PAGE_BIT};
use std::ops::Range;

/// The subtrees that become pages, and the nodes above them.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    pub(super) pages: Vec<PlannedPage>,
    pub(super) tops: Vec<PlannedTop>,
}

/// A subtree that becomes a page.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlannedPage {
    /// Its root in preorder, unless it is a single face.
    pub(super) node: u32,
    pub(super) first_face: u32,
    pub(super) faces: u32,
    /// The first vertex that its faces are the first to use, and how many there are.
    pub(super) first_vertex: u32,
    pub(super) own_vertices: u32,
}

/// A node above the pages.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlannedTop {
    pub(super) node: u32,
    pub(super) first_face: u32,
    /// The children as a top record names them.
    pub(super) children: [u32; 2],
}

impl Plan {
    /// Divides a tree into pages of at most `page_faces` faces, itself at most [`crate::MAX_PAGE_FACES`].
    ///
    /// A subtree becomes a page as soon as its faces and vertices are few enough to be told in a byte. A connected
    /// one of so few faces always is; one that joins components may have too many vertices.
    ///
    /// # Errors
    /// [`PackError::NoTree`] when a node has no faces on one side, a face uses a vertex that is not there, or vertices
    /// do not stand in order of first use.
    pub fn new(clusters: &impl Clusters, page_faces: u32) -> Result<Self, PackError> {
        let faces = clusters.faces();
        let count = u32::try_from(faces.len()).map_err(|_too_long| PackError::TooLong("section FACE"))?;
        let most = page_faces.clamp(1, MAX_PAGE_FACES);
        let mut plan = Self::default();
        let mut seen = Seen { page: vec![0; clusters.vertex_count()], now: 0 };
        let mut first_vertex = 0;
        if count == 0 {
            return Err(PackError::NoTree("there are no faces".to_owned()));
        }
        // The top node whose child it is and on which side, the node, its first face and its faces.
        let mut stack = vec![(None::<(usize, usize)>, 0, 0, count)];
        while let Some((parent, node, first_face, faces_here)) = stack.pop() {
            let cluster = &faces[first_face as usize..(first_face + faces_here) as usize];
            let vertices = if faces_here <= most { seen.count(cluster, first_vertex)? } else { None };
            let name = if let Some((_, own_vertices)) = vertices {
                plan.pages.push(PlannedPage {
                    node,
                    first_face,
                    faces: faces_here,
                    first_vertex,
                    own_vertices,
                });
                first_vertex += own_vertices;
                (plan.pages.len() as u32 - 1) | PAGE_BIT
            } else {
                let top = plan.tops.len();
                plan.tops.push(PlannedTop { node, first_face, children: [0; 2] });
                let left = clusters.left_faces(node);
                if left == 0 || left >= faces_here {
                    return Err(PackError::NoTree(format!(
                        "node {node} has {left} of {faces_here} faces on the left"
                    )));
                }
                stack.push((Some((top, 1)), node + left, first_face + left, faces_here - left));
                stack.push((Some((top, 0)), node + 1, first_face, left));
                top as u32
            };
            if let Some((parent, side)) = parent {
                plan.tops[parent].children[side] = name;
            }
        }
        if first_vertex as usize != clusters.vertex_count() {
            return Err(PackError::NoTree(format!(
                "the faces use {first_vertex} of {} vertices",
                clusters.vertex_count()
            )));
        }
        Ok(plan)
    }

    /// The number of pages.
    pub fn page_count(&self) -> usize {
        self.pages.len()
    }

    /// Packs some of the pages. Pages do not depend on each other, so runs may be packed on many threads.
    ///
    /// # Errors
    /// What [`PackError`] lists.
    ///
    /// # Panics
    /// If the range leaves the plan, or the plan is not of these clusters.
    pub fn pack_pages(&self, clusters: &impl Clusters, pages: Range<usize>) -> Result<PageRun, PackError> {
        let mut packed = Packed::default();
        let mut packer = page::Packer::default();
        for planned in &self.pages[pages] {
            packer.pack(clusters, planned, &mut packed)?;
        }
        Ok(PageRun(packed))
    }
}

/// Marks vertices with the cluster that was looked at last.
struct Seen {
    page: Vec<u32>,
    now: u32,
}

impl Seen {
    /// All vertices of a cluster, and those from `first_vertex` on, which it is the first to use; none if there are
    /// too many for a page.
    fn count(&mut self, cluster: &[[u32; 3]], first_vertex: u32) -> Result<Option<(u32, u32)>, PackError> {
        self.now += 1;
        let (mut all, mut own) = (0, 0);
        for &vertex in cluster.iter().flatten() {
            let Some(mark) = self.page.get_mut(vertex as usize) else {
                return Err(PackError::NoTree(format!("a face uses vertex {vertex} of {}", self.page.len())));
            };
            if *mark == self.now {
                continue;
            }
            *mark = self.now;
            all += 1;
            if vertex >= first_vertex {
                if vertex != first_vertex + own {
                    return Err(PackError::NoTree(format!("vertex {vertex} is not in order of first use")));
                }
                own += 1;
            }
        }
        Ok((all <= MAX_PAGE_VERTICES).then_some((all, own)))
    }
}
