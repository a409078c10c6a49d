//! What a subtree is drawn with: the loops of its root, the corners of a face. All are checked.

use zerocopy::little_endian::U32;

use crate::child::ChildRef;
use crate::error::{Error, Violation};
use crate::loops::{Loops, read_stored, read_top};
use crate::records::{NodeRecord, PageRecord, SMALL_FACES, STORES_LOOPS};
use crate::rule::Rule;
use crate::small_loops::follow_faces;
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader, to_index};

impl<'a> Reader<'a> {
    /// Reads the boundary loops of a subtree's root, a single face included. A node that is never drawn may have none.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the loops leave their section or do not end, or when a vertex index is out of range.
    #[inline]
    pub fn read_loops(&self, subtree: &Subtree, out: &mut Loops) -> Result<(), Error> {
        self.load_loops(subtree, out).map_err(|violation| violation.at(self.path))
    }

    pub(crate) fn load_loops(&self, subtree: &Subtree, out: &mut Loops) -> Result<(), Broken> {
        out.clear();
        match subtree.place {
            Place::Top { record } => {
                let top = self.top(record)?;
                let range = to_index(top.loop_start.get()).zip(to_index(top.loop_end.get()));
                range
                    .and_then(|(start, end)| self.top_loops.get(start..end))
                    .and_then(|bytes| read_top(bytes, out))
                    .ok_or_else(|| loops_do_not_end(subtree))?;
                // The largest alone is looked at: all others are in range if it is.
                self.check_vertex(out.vertices.iter().copied().max().unwrap_or(0), || subtree.to_string())
            }
            Place::Page { page, loops, .. } => {
                let faces = subtree.face_count();
                let page = self.page_of(page, subtree)?;
                let locals = self.locals(page, subtree)?;
                let mut strange = None;
                let mut push = |out: &mut Loops, local| match locals.global(local) {
                    Some(vertex) => out.vertices.push(vertex),
                    None => strange = Some(local),
                };
                if faces <= SMALL_FACES && !self.small_stores_loops(subtree)? {
                    follow_faces(self.faces_of(subtree), |local, last| {
                        push(out, local);
                        if last {
                            out.close();
                        }
                    });
                } else {
                    let own = self.stored_loops(page, loops, subtree)?;
                    let mut show = |entries: &[u8]| {
                        for local in entries {
                            push(out, *local);
                        }
                        out.close();
                    };
                    own.get(2..)
                        .and_then(|own| read_stored(own, &mut show))
                        .ok_or_else(|| loops_do_not_end(subtree))?;
                }
                match strange {
                    None => Ok(()),
                    Some(local) => Err(locals.violation(local, subtree)),
                }
            }
        }
    }

    /// The vertex indices of a single face, which are in range.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the subtree is no face of its page, or uses vertices that are not there.
    #[inline]
    pub fn face(&self, subtree: &Subtree) -> Result<[u32; 3], Error> {
        self.corners(subtree).map_err(|violation| violation.at(self.path))
    }

    /// The first corner of a subtree's first face, from which [`crate::Node::plane`] counts heights.
    ///
    /// # Errors
    /// As [`Reader::face`].
    #[inline]
    pub fn first_corner(&self, subtree: &Subtree) -> Result<u32, Error> {
        self.corner_of(subtree).map_err(|violation| violation.at(self.path))
    }

    #[inline]
    pub(crate) fn corner_of(&self, subtree: &Subtree) -> Result<u32, Broken> {
        let face = match subtree.place {
            Place::Page { page, .. } => Subtree {
                child: ChildRef::face(subtree.first_face),
                face_end: subtree.first_face.saturating_add(1),
                place: Place::Page { page, record: 0, loops: 0 },
                ..*subtree
            },
            Place::Top { record } => match to_index(record).and_then(|i| self.top_corners.get(i)) {
                Some(corner) => return Ok(corner.get()),
                None => self.single(subtree.first_face),
            },
        };
        self.corners(&face).map(|[first, ..]| first)
    }

    #[inline]
    pub(crate) fn corners(&self, subtree: &Subtree) -> Result<[u32; 3], Broken> {
        let Place::Page { page, .. } = subtree.place else {
            return Err(no_such_face(subtree));
        };
        let page = self.page_of(page, subtree)?;
        let locals = self.locals(page, subtree)?;
        let [face] = self.faces_of(subtree) else {
            return Err(no_such_face(subtree));
        };
        let [a, b, c] = *face;
        match (locals.global(a), locals.global(b), locals.global(c)) {
            (Some(a), Some(b), Some(c)) => Ok([a, b, c]),
            _ => Err(locals.violation(a.max(b).max(c), subtree)),
        }
    }

    /// A face by its index. Where pages do not ascend, some face or none.
    pub(crate) fn single(&self, face: u32) -> Subtree {
        let page = self.pages.partition_point(|p| p.first_face.get() <= face).saturating_sub(1);
        let page = u32::try_from(page).unwrap_or(u32::MAX);
        let place = Place::Page { page, record: 0, loops: 0 };
        Subtree { child: ChildRef::face(face), first_face: face, face_end: face.saturating_add(1), place }
    }

    #[inline]
    fn small_stores_loops(&self, subtree: &Subtree) -> Result<bool, Broken> {
        match subtree.place {
            Place::Page { page, record, .. } if subtree.face_count() > 1 => {
                let (_, node) = self.page_node(page, record, subtree)?;
                Ok(stores_loops(node, subtree.face_count()))
            }
            _ => Ok(false),
        }
    }

    /// The bytes of a page's loops from one of them on.
    #[inline]
    pub(crate) fn stored_loops(
        &self,
        page: &PageRecord,
        from: u32,
        subtree: &Subtree,
    ) -> Result<&'a [u8], Broken> {
        let first = page.first_loop.get();
        let end = first.saturating_add(u32::from(page.loop_bytes.get()));
        let range = to_index(first.saturating_add(from)).zip(to_index(end));
        range.and_then(|(start, end)| self.loops.get(start..end)).ok_or_else(|| loops_do_not_end(subtree))
    }

    /// The faces of a subtree of a page that owns them.
    #[inline]
    fn faces_of(&self, subtree: &Subtree) -> &'a [[u8; 3]] {
        // A face record is nothing but its three bytes.
        zerocopy::transmute_ref!(subtree.of(self.faces))
    }

    /// What the local indices of a page stand for.
    #[inline]
    fn locals(&self, page: &PageRecord, subtree: &Subtree) -> Result<Locals<'a>, Broken> {
        let first = to_index(page.first_link.get());
        let links =
            first.and_then(|first| self.links.get(first..first.checked_add(usize::from(page.links.get()))?));
        let Some(links) = links else {
            return Err(no_such_links(page, self.links.len(), subtree));
        };
        Ok(Locals {
            first_vertex: page.first_vertex.get(),
            own: u32::from(page.own_vertices.get()),
            links,
            vertices: u32::try_from(self.vertices.len()).unwrap_or(u32::MAX),
        })
    }

    fn check_vertex(&self, vertex: u32, place: impl FnOnce() -> String) -> Result<(), Broken> {
        if to_index(vertex).is_some_and(|v| v < self.vertices.len()) {
            return Ok(());
        }
        Err(Violation::new(
            Rule::VertexIndex,
            place(),
            format!("it uses vertex {vertex} of {}", self.vertices.len()),
        ))
    }
}

/// What the local indices of a page stand for: its own run of vertices, then those that its links name.
struct Locals<'a> {
    first_vertex: u32,
    own: u32,
    links: &'a [U32],
    vertices: u32,
}

impl Locals<'_> {
    #[inline]
    fn global(&self, local: u8) -> Option<u32> {
        let local = u32::from(local);
        let vertex = match local.checked_sub(self.own) {
            None => self.first_vertex.checked_add(local)?,
            Some(link) => self.links.get(to_index(link)?)?.get(),
        };
        (vertex < self.vertices).then_some(vertex)
    }

    #[cold]
    fn violation(&self, local: u8, subtree: &Subtree) -> Broken {
        Violation::new(
            Rule::VertexIndex,
            subtree.to_string(),
            format!(
                "it uses vertex {local} of its page, which has {} from {} on and {} links, of {} in all",
                self.own,
                self.first_vertex,
                self.links.len(),
                self.vertices
            ),
        )
    }
}

/// Whether a node of a page has loops in section `LOOP`.
#[inline]
pub(crate) fn stores_loops(node: &NodeRecord, faces: u32) -> bool {
    faces > SMALL_FACES || node.left_faces & STORES_LOOPS != 0
}

#[cold]
fn no_such_links(page: &PageRecord, links: usize, subtree: &Subtree) -> Broken {
    let found = format!("its page has {} links from {} on, of {links}", page.links, page.first_link);
    Violation::new(Rule::VertexIndex, subtree.to_string(), found)
}

#[cold]
pub(crate) fn loops_do_not_end(subtree: &Subtree) -> Broken {
    Violation::new(
        Rule::LoopRange,
        subtree.to_string(),
        "its loops leave their section or do not end".to_owned(),
    )
}

#[cold]
fn no_such_face(subtree: &Subtree) -> Broken {
    Violation::new(Rule::ChildPlace, subtree.to_string(), "it is not a single face of a page".to_owned())
}
