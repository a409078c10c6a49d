//! Parts of a cut: subtrees that are asked about, extracted and drawn one by one, in any order and on any thread.

use crate::extraction::{Stats, sphere_of};
use crate::{Error, Selection};
use fcgeom::{Cone, Containment};
use fct::{Child, Node, Subtree, Tree};

/// A subtree that meets the cut: no node above it is in the cut, so that all it draws is drawn below it.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// The subtree.
    pub subtree: Subtree,
    /// Whether it lies inside the selection's frustum as a whole; then so does all below it, and nothing is tested.
    pub inside: bool,
}

/// What a selection makes of a node.
pub(crate) enum Sight {
    /// Nothing of it shows.
    Culled,
    /// It is in the cut: drawn as one polygon.
    Drawn,
    /// Its children are looked at in its place; all of it lies inside the frustum if `inside`.
    Refined { inside: bool },
}

impl Part {
    /// The whole tree.
    pub fn whole(tree: &Tree, selection: &Selection) -> Part {
        Part { subtree: tree.whole(), inside: selection.frustum.is_none() }
    }

    /// Divides the part into smaller ones, in the order of the tree: goes down from it, leaves out what the selection
    /// culls and stops where the cut is or `stop` says so.
    ///
    /// Together the new parts draw what this one draws. What was looked at and left out is added to `stats`.
    ///
    /// # Errors
    /// [`Error::Tree`] when the file is damaged where the walk comes by.
    pub fn divide(
        &self,
        tree: &Tree,
        selection: &Selection,
        stats: &mut Stats,
        mut stop: impl FnMut(&Subtree, &Node) -> bool,
        mut each: impl FnMut(Part, Option<&Node>),
    ) -> Result<(), Error> {
        let reader = tree.reader();
        let mut stack = vec![*self];
        while let Some(part) = stack.pop() {
            let subtree = part.subtree;
            if let Child::Face(_) = subtree.child.kind() {
                each(part, None);
                continue;
            }
            let node = reader.node(&subtree)?;
            match selection.sight(&subtree, &node, part.inside, stats) {
                Sight::Culled => {}
                Sight::Drawn => each(part, Some(&node)),
                Sight::Refined { inside } if stop(&subtree, &node) => {
                    each(Part { subtree, inside }, Some(&node))
                }
                Sight::Refined { inside } => {
                    let [left, right] = reader.children(&subtree)?;
                    stack.push(Part { subtree: right, inside });
                    stack.push(Part { subtree: left, inside });
                }
            }
        }
        Ok(())
    }
}

impl Selection {
    /// What becomes of a node none of whose ancestors is in the cut or left out.
    #[inline]
    pub(crate) fn sight(&self, subtree: &Subtree, node: &Node, inside: bool, stats: &mut Stats) -> Sight {
        stats.nodes_visited += 1;
        let Some(inside) = self.shows(node, subtree.face_count(), inside, stats) else {
            return Sight::Culled;
        };
        if self.refines_node(subtree.child, node) { Sight::Refined { inside } } else { Sight::Drawn }
    }

    /// Whether a node of so many faces lies inside the frustum as a whole; none if nothing of it shows, which is counted.
    #[inline]
    pub(crate) fn shows(&self, node: &Node, faces: u32, inside: bool, stats: &mut Stats) -> Option<bool> {
        let mut inside = inside;
        if let Some(frustum) = self.frustum.as_ref().filter(|_| !inside) {
            match frustum.classify_sphere(&sphere_of(node)) {
                Containment::Outside => {
                    stats.culled_frustum += 1;
                    stats.faces_culled += u64::from(faces);
                    return None;
                }
                Containment::Inside => inside = true,
                Containment::Crossing => {}
            }
        }
        if let Some(eye) = self.backface_eye {
            let cone = Cone { axis: node.axis().into(), cos: node.cos() };
            if cone.is_backfacing(&sphere_of(node), eye) {
                stats.culled_cone += 1;
                stats.faces_culled += u64::from(faces);
                return None;
            }
        }
        Some(inside)
    }
}
