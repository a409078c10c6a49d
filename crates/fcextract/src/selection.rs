//! What to extract.

use crate::{Error, Perspective, Tolerance};
use fcgeom::Frustum;
use fct::{Node, VertexRecord};
use glam::DVec3;

/// Which of the two stored keys a tolerance is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The distance bound: no point of the surface is farther from the mesh than the tolerance.
    Bound,
    /// The budget key, what refining a cluster gains: no guarantee, but a lower mean error for the
    /// same number of triangles.
    Budget,
}

/// A cut of the tree, described in the tree's own coordinates.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The error allowed.
    pub tolerance: Tolerance,
    /// The key it is held against.
    pub order: Order,
    /// Draws vertices beside their places where that fits the surface better, see [`Selection::position`].
    pub displaced: bool,
    /// Leaves out clusters whose spheres lie outside; never changes a pixel of the image.
    pub frustum: Option<Frustum>,
    /// Leaves out clusters all of whose faces turn their back on this eye; changes no pixel but those of folded
    /// triangles.
    pub backface_eye: Option<DVec3>,
}

impl Selection {
    /// The input's faces, all of them.
    pub fn full() -> Selection {
        Selection {
            tolerance: Tolerance::Full,
            order: Order::Bound,
            displaced: false,
            frustum: None,
            backface_eye: None,
        }
    }

    /// One tolerance everywhere, nothing culled.
    pub fn uniform(distance: f64, order: Order) -> Selection {
        Selection { tolerance: Tolerance::Uniform { distance }, order, ..Selection::full() }
    }

    /// A tolerance that grows with the distance from an eye, nothing culled.
    pub fn perspective(view: Perspective, order: Order) -> Selection {
        Selection { tolerance: Tolerance::Perspective(view), order, ..Selection::full() }
    }

    /// Where to draw a vertex, in the tree's coordinates.
    ///
    /// It is the vertex's own place, unless the selection is `displaced` and in [`Order::Budget`]: then it may lie
    /// beside it, by a distance that follows from the vertex and the tolerance alone and vanishes with the tolerance.
    /// A mesh drawn so is as free of cracks, and its mean error about a fifth smaller; its distance bound is
    /// [`crate::Stats::bound`] and the longest such step.
    pub fn position(&self, vertex: &VertexRecord) -> DVec3 {
        let place = DVec3::from_array(vertex.position().map(f64::from));
        if !self.displaced || self.order != Order::Budget {
            return place;
        }
        let sphere = || (DVec3::from_array(vertex.center()), vertex.radius());
        let allowed = self.tolerance.allowed(sphere).unwrap_or(0.0);
        place + DVec3::from_array(vertex.displaced(allowed))
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let usable = match self.tolerance {
            Tolerance::Full => true,
            Tolerance::Uniform { distance } => distance >= 0.0,
            Tolerance::Perspective(p) => {
                p.eye.is_finite()
                    && p.axis.is_finite()
                    && p.slope >= 0.0
                    && (-1.0..=1.0).contains(&p.corner_cos)
            }
        };
        if !usable {
            return Err(Error::Selection("its tolerance is negative or not a number"));
        }
        if self.backface_eye.is_some_and(|e| !e.is_finite()) {
            return Err(Error::Selection("its eye is not a number"));
        }
        Ok(())
    }

    #[inline]
    pub(crate) fn refines_node(&self, node: &Node) -> bool {
        let key = match self.order {
            Order::Bound => node.bound,
            Order::Budget => node.budget,
        };
        let sphere = || (DVec3::from_array(node.center.map(f64::from)), f64::from(node.radius));
        self.tolerance.refines(key, sphere)
    }

    #[inline]
    pub(crate) fn activates(&self, vertex: &VertexRecord) -> bool {
        let key = match self.order {
            Order::Bound => vertex.bound(),
            Order::Budget => vertex.budget(),
        };
        self.tolerance.refines(key, || (DVec3::from_array(vertex.center()), vertex.radius()))
    }
}
