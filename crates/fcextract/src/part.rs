//! Parts of a cut: subtrees that are asked about, extracted and drawn one by one, in any order and on any thread.

use crate::extraction::{Stats, sphere_of};
use crate::{Error, Selection};
use fcgeom::{Cone, Containment, Glance, Side, Sphere};
use fct::{Branch, Child, ConeFrame, Node, Page, Subtree, Tree};

/// A subtree that meets the cut: no node above it is in the cut, so that all it draws is drawn below it.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// The subtree.
    pub subtree: Subtree,
    /// What is known of it as a whole.
    pub settled: Settled,
}

/// What holds for a subtree as a whole, so that nothing below it is tested for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settled {
    /// It lies inside the selection's frustum.
    pub inside: bool,
    /// No face of it turns its back on the selection's eye.
    pub facing: bool,
}

/// What a selection makes of a node.
pub(crate) enum Sight {
    /// Nothing of it shows.
    Culled,
    /// It is in the cut: drawn as one polygon.
    Drawn,
    /// Its children are looked at in its place.
    Refined { settled: Settled },
}

impl Part {
    /// The whole tree.
    pub fn whole(tree: &Tree, selection: &Selection) -> Part {
        Part { subtree: tree.whole(), settled: selection.settled() }
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
            match selection.sight(&subtree, &node, part.settled, stats) {
                Sight::Culled => {}
                Sight::Drawn => each(part, Some(&node)),
                Sight::Refined { settled } if stop(&subtree, &node) => {
                    each(Part { subtree, settled }, Some(&node))
                }
                Sight::Refined { settled } => {
                    let [left, right] = reader.children(&subtree)?;
                    stack.push(Part { subtree: right, settled });
                    stack.push(Part { subtree: left, settled });
                }
            }
        }
        Ok(())
    }
}

impl Settled {
    /// Whether nothing is left to be tested.
    #[inline]
    pub(crate) fn is_shown(self) -> bool {
        self.inside && self.facing
    }
}

impl Selection {
    /// What holds for every tree.
    pub(crate) fn settled(&self) -> Settled {
        Settled { inside: self.frustum.is_none(), facing: self.backface_eye.is_none() }
    }

    /// What becomes of a node none of whose ancestors is in the cut or left out.
    #[inline]
    pub(crate) fn sight(&self, subtree: &Subtree, node: &Node, settled: Settled, stats: &mut Stats) -> Sight {
        stats.nodes_visited += 1;
        let Some(settled) = self.shows(node, subtree.face_count(), settled, stats) else {
            return Sight::Culled;
        };
        if self.refines_node(subtree.child, node) { Sight::Refined { settled } } else { Sight::Drawn }
    }

    /// What is known of a node of so many faces; none if nothing of it shows, which is counted.
    #[inline]
    pub(crate) fn shows(
        &self,
        node: &Node,
        faces: u32,
        mut settled: Settled,
        stats: &mut Stats,
    ) -> Option<Settled> {
        if let Some(frustum) = self.frustum.as_ref().filter(|_| !settled.inside) {
            match frustum.classify_sphere(&sphere_of(node)) {
                Containment::Outside => {
                    stats.culled_frustum += 1;
                    stats.faces_culled += u64::from(faces);
                    return None;
                }
                Containment::Inside => settled.inside = true,
                Containment::Crossing => {}
            }
        }
        if let Some(eye) = self.backface_eye.filter(|_| !settled.facing) {
            let cone = Cone { axis: node.axis().into(), cos: node.cos() };
            return turned(cone.side(&sphere_of(node), eye), faces, settled, stats);
        }
        Some(settled)
    }

    /// The same for a node of a page, mostly by a glance at its cone; none if it is not there.
    #[inline]
    pub(crate) fn shows_of_page(
        &self,
        page: &Page<'_>,
        branch: &Branch,
        settled: Settled,
        stats: &mut Stats,
    ) -> Option<Option<Settled>> {
        if let Some(eye) = self.backface_eye.filter(|_| settled.inside) {
            let Some(ConeFrame { center, radius, axis, sin_cos }) = page.cone(branch) else {
                return Some(Some(settled));
            };
            let sphere = Sphere { center: center.into(), radius };
            if let Glance::Clear(side) = Cone::side_at_a_glance(axis.into(), sin_cos, &sphere, eye) {
                return Some(turned(side, branch.face_count(), settled, stats));
            }
        }
        Some(self.shows(&page.node(branch)?, branch.face_count(), settled, stats))
    }
}

/// What is known of a node of so many faces all of which turn that side to the eye; none if it is the back, which is
/// counted.
#[inline]
fn turned(side: Option<Side>, faces: u32, settled: Settled, stats: &mut Stats) -> Option<Settled> {
    match side {
        Some(Side::Back) => {
            stats.culled_cone += 1;
            stats.faces_culled += u64::from(faces);
            None
        }
        Some(Side::Front) => Some(Settled { facing: true, ..settled }),
        None => Some(settled),
    }
}
