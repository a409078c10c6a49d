//! What to extract.

use crate::extra::Extra;
use crate::region::{self, Region};
use crate::{Error, Perspective, Tolerance};
use fcgeom::Frustum;
use fct::{ChildRef, Node, Reader, ShortFloat, VertexRecord};
use glam::DVec3;

/// Which of the two stored keys a tolerance is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The distance bound: no point of the surface is farther from the mesh than the tolerance, and no point of the mesh
    /// from the surface.
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
    /// Where another error is allowed than `tolerance` says.
    pub regions: Vec<Region>,
    /// Draws vertices beside their places where that fits the surface better, see [`Selection::position`].
    pub displaced: bool,
    /// Leaves out clusters whose spheres lie outside; never changes a pixel of the image.
    pub frustum: Option<Frustum>,
    /// Leaves out clusters all of whose faces turn their back on this eye; changes no pixel but those of the few triangles
    /// that face the eye though no face of their cluster does.
    pub backface_eye: Option<DVec3>,
    /// What is refined and drawn beyond that; found by [`crate::fit`] and [`crate::by_epsilon`].
    pub extra: Extra,
}

impl Selection {
    /// The input's faces, all of them.
    pub fn full() -> Selection {
        Selection {
            tolerance: Tolerance::Full,
            order: Order::Bound,
            regions: Vec::new(),
            displaced: false,
            frustum: None,
            backface_eye: None,
            extra: Extra::default(),
        }
    }

    /// One tolerance everywhere, nothing culled.
    pub fn uniform(distance: f64, order: Order) -> Selection {
        Selection { tolerance: Tolerance::Uniform { distance }, order, ..Selection::full() }
    }

    /// A shape for [`crate::fit`]: the same tolerance everywhere, the order of the least mean error, and vertices
    /// displaced.
    pub fn by_budget() -> Selection {
        Selection { displaced: true, ..Selection::uniform(1.0, Order::Budget) }
    }

    /// A tolerance that grows with the distance from an eye, nothing culled.
    pub fn perspective(view: Perspective, order: Order) -> Selection {
        Selection { tolerance: Tolerance::Perspective(view), order, ..Selection::full() }
    }

    /// Where to draw a vertex, in the tree's coordinates.
    ///
    /// It is the vertex's own place, unless the selection is `displaced`: then it may lie beside it, by a distance that
    /// follows from the vertex and the tolerance alone and vanishes with the tolerance. A mesh drawn so is as free of
    /// cracks, and its mean error smaller by up to a fifth. In [`Order::Bound`] it keeps to the tolerance as it would in
    /// place, and where its sphere crosses the border of a region, so that clusters around it are allowed other errors, it
    /// stays; that takes a tree that says how far vertices may go, see [`fct::Tree::promises_displaced`]. In
    /// [`Order::Budget`] its distance bound is [`Selection::bound`] and the longest such step.
    pub fn position(&self, vertex: &VertexRecord) -> DVec3 {
        let place = DVec3::from_array(vertex.position().map(f64::from));
        if !self.displaced {
            return place;
        }
        let (center, radius) = (DVec3::from_array(vertex.center()), vertex.radius());
        if self.order == Order::Bound && region::crosses(&self.regions, center, radius) {
            return place;
        }
        let allowed = self.allowed(|| (center, radius)).unwrap_or(0.0);
        place
            + DVec3::from_array(match self.order {
                Order::Bound => vertex.displaced_by_bound(allowed),
                Order::Budget => vertex.displaced_by_budget(allowed),
            })
    }

    /// Refuses numbers that no mesh follows from.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.tolerance.check()?;
        self.regions.iter().enumerate().try_for_each(|(number, region)| region.check(number))?;
        match self.backface_eye.filter(|eye| !eye.is_finite()) {
            Some(eye) => Err(Error::Selection(format!("its backface_eye is {eye}, which is not finite"))),
            None => Ok(()),
        }
    }

    /// Whether the tolerance alone decides about all that shows.
    pub(crate) fn is_plain(&self) -> bool {
        self.regions.is_empty() && self.extra.is_empty()
    }

    /// Whether the cut goes on below the node of this name, as far as it is in sight.
    #[inline]
    pub fn refines_node(&self, child: ChildRef, node: &Node) -> bool {
        let sphere = || (DVec3::from_array(node.center.map(f64::from)), f64::from(node.radius));
        self.refines(self.order.of_node(node), sphere) || self.extra.nodes.has(child.raw())
    }

    /// Whether the vertex of this index is drawn.
    #[inline]
    pub(crate) fn activates(&self, index: u32, vertex: &VertexRecord) -> bool {
        let sphere = || (DVec3::from_array(vertex.center()), vertex.radius());
        self.refines(self.order.of_vertex(vertex), sphere) || self.extra.has_vertex(index)
    }

    /// Whether the vertex of this index is drawn; not if there is none.
    #[inline]
    pub(crate) fn draws(&self, reader: &Reader<'_>, index: u32) -> bool {
        reader.vertices().get(index as usize).is_some_and(|vertex| self.activates(index, vertex))
    }

    /// A node's key, and the factor on the tolerance `shape` below which it is refined: its key over what is allowed.
    ///
    /// Infinite where nothing is allowed, or less in a region; zero where a region allows it.
    pub(crate) fn level_of_node(&self, shape: &Tolerance, node: &Node) -> (f32, f64) {
        let key = self.order.of_node(node);
        let (center, radius) = (DVec3::from_array(node.center.map(f64::from)), f64::from(node.radius));
        let (length, over) = (f64::from(key), |is_over: bool| if is_over { f64::INFINITY } else { 0.0 });
        if let Some(allowed) = region::least(&self.regions, center, radius, || None) {
            return (key, over(length > allowed));
        }
        let nearby = region::least(&self.regions, center, radius, || Some(f64::INFINITY));
        if nearby.is_some_and(|allowed| length > allowed) {
            return (key, f64::INFINITY);
        }
        let allowed = shape.allowed(|| (center, radius)).unwrap_or(0.0);
        let level = length / allowed;
        (key, if level.is_nan() { over(length > 0.0) } else { level })
    }

    #[inline]
    fn refines(&self, key: f32, sphere: impl FnOnce() -> (DVec3, f64)) -> bool {
        if self.regions.is_empty() {
            return self.tolerance.refines(key, sphere);
        }
        Tolerance::is_over(key, self.allowed(sphere))
    }

    /// The least error allowed in a sphere; none for the input's faces.
    #[inline]
    pub(crate) fn allowed(&self, sphere: impl FnOnce() -> (DVec3, f64)) -> Option<f64> {
        if self.regions.is_empty() {
            return self.tolerance.allowed(sphere);
        }
        let (center, radius) = sphere();
        region::least(&self.regions, center, radius, || self.tolerance.allowed(|| (center, radius)))
            .map(|allowed| allowed.min(f64::MAX))
    }
}

impl Order {
    /// Its one of a bound and a budget key.
    #[inline]
    pub(crate) fn of(self, [bound, budget]: [ShortFloat; 2]) -> ShortFloat {
        match self {
            Order::Bound => bound,
            Order::Budget => budget,
        }
    }

    /// A node's key.
    #[inline]
    pub(crate) fn of_node(self, node: &Node) -> f32 {
        match self {
            Order::Bound => node.bound,
            Order::Budget => node.budget,
        }
    }

    /// A vertex's key.
    #[inline]
    pub(crate) fn of_vertex(self, vertex: &VertexRecord) -> f32 {
        match self {
            Order::Bound => vertex.bound(),
            Order::Budget => vertex.budget(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a user reads names the field and shows the number.
    #[test]
    fn numbers_that_no_mesh_follows_from_are_named() {
        let view = Perspective::new(DVec3::ONE, DVec3::Z, 1.0, [16.0, 9.0], 1.0);
        let seen = |view| Selection::perspective(view, Order::Bound);
        let region = Region { center: DVec3::ZERO, radius: 1.0, distance: 1.0 };
        let within = |bad| Selection { regions: vec![region, bad], ..Selection::full() };
        let fov = |fov: f64| seen(Perspective::new(DVec3::ONE, DVec3::Z, fov, [16.0, 9.0], 1.0));
        for (selection, said) in [
            (Selection::uniform(-1.0, Order::Bound), "tolerance is a distance of -1;"),
            (Selection::uniform(f64::NAN, Order::Bound), "tolerance is a distance of NaN;"),
            (seen(Perspective { eye: DVec3::NAN, ..view }), "an eye of [NaN, NaN, NaN]"),
            (seen(Perspective { eye: DVec3::INFINITY, ..view }), "an eye of [inf, inf, inf]"),
            (seen(Perspective { axis: DVec3::NAN, ..view }), "an axis of [NaN, NaN, NaN]"),
            (seen(Perspective { axis: 2.0 * DVec3::X, ..view }), "an axis of [2, 0, 0], of length 2;"),
            (seen(Perspective { axis: 0.9 * DVec3::X, ..view }), "of length 0.9;"),
            (seen(Perspective::new(DVec3::ONE, DVec3::NAN, 1.0, [1.0; 2], 1.0)), "an axis of [NaN"),
            (seen(Perspective { slope: -2.0, ..view }), "a slope of -2;"),
            (seen(Perspective { corner_cos: 2.0, ..view }), "a corner_cos of 2;"),
            (seen(Perspective { corner_cos: f64::NAN, ..view }), "a corner_cos of NaN;"),
            (fov(4.0), "a slope of -"),
            (fov(-1.0), "a slope of -"),
            (fov(f64::NAN), "a slope of NaN;"),
            (within(Region { center: DVec3::NAN, ..region }), "regions[1] has a center of [NaN"),
            (within(Region { radius: -3.0, ..region }), "regions[1] has a radius of -3;"),
            (within(Region { radius: f64::INFINITY, ..region }), "regions[1] has a radius of inf;"),
            (within(Region { distance: -0.5, ..region }), "regions[1] has a distance of -0.5;"),
            (
                Selection { backface_eye: Some(DVec3::NAN), ..Selection::full() },
                "backface_eye is [NaN, NaN, NaN]",
            ),
        ] {
            let text = selection.check().expect_err(said).to_string();
            assert!(text.contains(said), "{text}");
        }
    }

    #[test]
    fn what_a_view_may_be_is_taken() {
        let view = Perspective::new(DVec3::ONE, 7.0 * DVec3::Z, 1.0, [16.0, 9.0], 1.0);
        assert_eq!(view.axis, DVec3::Z);
        let rounded = DVec3::new(0.6, 0.0, 0.8).as_vec3().as_dvec3();
        assert_ne!(rounded.length(), 1.0);
        let views = [
            view,
            Perspective { axis: DVec3::ZERO, ..view },
            Perspective { axis: rounded, ..view },
            Perspective { slope: f64::INFINITY, ..view },
            Perspective { slope: 0.0, corner_cos: -1.0, ..view },
        ];
        for view in views {
            assert!(Selection::perspective(view, Order::Bound).check().is_ok(), "{view:?}");
        }
        assert!(Selection::uniform(f64::INFINITY, Order::Bound).check().is_ok());
    }
}
