//! By which polygon a piece is asked about.

use super::cut::Cuts;
use super::outline::{Octagon, Screen};
use super::pieces::{Piece, sphere};
use crate::bounding_polygon::{Prism, sphere_polygon, to_clip};
use crate::camera::View;
use crate::gpu::occlusion::PolygonList;
use crate::scene::{Instance, Scene};
use fct::Child;
use glam::DVec3;
use rayon::prelude::*;

/// Pieces of at most this many triangles are outlined corner by corner; larger ones by what the tree stores, which
/// costs the same for any number of triangles.
const MOST_CORNERS: u32 = 128;

/// The polygon of a piece in clip space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Question {
    Octagon(Octagon),
    Square([[f32; 4]; 4]),
}

impl Question {
    /// Adds the polygon to a list.
    pub(crate) fn ask(&self, polygons: &mut PolygonList) {
        match self {
            Question::Octagon(corners) => polygons.push(corners),
            Question::Square(corners) => polygons.push(corners),
        }
    }
}

/// A question about each piece, or none where no polygon is safe or the piece has fewer than `fewest` triangles; it
/// then counts as visible.
pub(crate) fn questions(
    scene: &Scene,
    view: &View,
    cuts: &Cuts,
    pieces: &[Piece],
    fewest: u32,
) -> Vec<Option<Question>> {
    let places: Vec<_> = cuts.placed.iter().map(|placed| Place::new(scene, view, placed.instance)).collect();
    let ask = |scratch: &mut Vec<DVec3>, piece: &Piece| {
        if piece.index_count < 3 * fewest {
            return None;
        }
        places.get(piece.placed as usize)?.as_ref()?.question(view, cuts, piece, scratch)
    };
    pieces.par_iter().map_init(Vec::new, ask).collect()
}

/// An instance and what its pieces share.
struct Place<'a> {
    tree: &'a fct::Tree,
    instance: &'a Instance,
    eye: DVec3,
    screen: Screen,
}

impl<'a> Place<'a> {
    fn new(scene: &'a Scene, view: &View, instance: usize) -> Option<Place<'a>> {
        let instance = scene.instances.get(instance)?;
        let tree = &scene.models.get(instance.model)?.tree;
        let (center, radius) = scene.sphere(instance)?;
        let screen = Screen::new(view, instance.matrix(), center.distance(view.eye) + radius);
        Some(Place { tree, instance, eye: instance.to_model(view.eye), screen })
    }

    fn question(
        &self,
        view: &View,
        cuts: &Cuts,
        piece: &Piece,
        scratch: &mut Vec<DVec3>,
    ) -> Option<Question> {
        let tree = self.tree;
        if piece.index_count <= 3 * MOST_CORNERS {
            let start = piece.first_index as usize;
            let indices = &cuts.slot(piece.cut)?.extraction.indices;
            let corners = indices.get(start..start + piece.index_count as usize)?.iter().map(|v| {
                let vertex = tree.vertices().get(*v as usize);
                vertex.map_or(DVec3::NAN, |v| DVec3::from_array(v.position().map(f64::from)))
            });
            return self.screen.octagon(corners, scratch).map(Question::Octagon);
        }
        let eye = self.eye;
        let from_eye = |p: DVec3| self.instance.rotation * ((p - eye) * self.instance.scale);
        let polygon = match piece.subtree.child.kind() {
            Child::Node(node) => tree.bounding_polygon_of(node).and_then(|place| {
                let node = tree.node(&piece.subtree).ok()?;
                tree.bounding_polygon(place, &node)
            }),
            Child::Face(_) => None,
        };
        let octagon = polygon.and_then(|polygon| Prism::from(&polygon).polygon(eye, view.pixel));
        if let Some(clip) = octagon.and_then(|corners| to_clip(&corners.map(from_eye), view)) {
            return Some(Question::Octagon(clip));
        }
        let (center, radius) = sphere(tree, &piece.subtree);
        let square = sphere_polygon(center, radius, eye, view.pixel)?;
        Some(Question::Square(to_clip(&square.map(from_eye), view)?))
    }
}
