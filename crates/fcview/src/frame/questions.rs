//! By which polygon a piece, or a whole instance, is asked about before it is cut.

use super::outline::{Octagon, Screen};
use super::pieces::{Piece, sphere};
use super::plan::Plan;
use crate::bounding_polygon::{Prism, sphere_polygon, to_clip};
use crate::camera::View;
use crate::scene::{Instance, Scene};
use fct::Child;
use glam::DVec3;
use rayon::prelude::*;

/// The polygon of a piece in clip space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Question {
    Octagon(Octagon),
    Square([[f32; 4]; 4]),
}

impl Question {
    /// The corners of the polygon, in order.
    pub(crate) fn corners(&self) -> &[[f32; 4]] {
        match self {
            Question::Octagon(corners) => corners,
            Question::Square(corners) => corners,
        }
    }
}

/// A question about each piece, or none where no polygon is safe; the piece then counts as visible.
pub(crate) fn questions(scene: &Scene, view: &View, plan: &Plan, pieces: &[Piece]) -> Vec<Option<Question>> {
    let places: Vec<_> = plan.placed.iter().map(|placed| Place::new(scene, view, placed.instance)).collect();
    let ask = |scratch: &mut Scratch, piece: &Piece| {
        places.get(piece.placed as usize)?.as_ref()?.question(view, piece, scratch)
    };
    pieces.par_iter().map_init(Scratch::default, ask).collect()
}

#[derive(Default)]
struct Scratch {
    points: Vec<DVec3>,
    projected: Vec<DVec3>,
    stack: Vec<fct::Subtree>,
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

    fn question(&self, view: &View, piece: &Piece, scratch: &mut Scratch) -> Option<Question> {
        let tree = self.tree;
        let subtree = &piece.part.subtree;
        scratch.points.clear();
        self.outline(subtree, scratch)?;
        if let Some(octagon) = self.screen.octagon(scratch.points.iter().copied(), &mut scratch.projected) {
            return Some(Question::Octagon(octagon));
        }
        let from_eye = |p: DVec3| self.instance.rotation * ((p - self.eye) * self.instance.scale);
        let (center, radius) = sphere(tree, subtree);
        let square = sphere_polygon(center, radius, self.eye, view.pixel)?;
        Some(Question::Square(to_clip(&square.map(from_eye), view)?))
    }

    /// Collects points in whose hull all lies that is drawn of a subtree, whatever its detail: the corners of its stored
    /// prism, or, tighter, of its faces where they are few.
    fn outline(&self, subtree: &fct::Subtree, scratch: &mut Scratch) -> Option<()> {
        let reader = self.tree.reader();
        if subtree.face_count() > MOST_FACES
            && let Child::Node(node) = subtree.child.kind()
            && let Some(place) = self.tree.bounding_polygon_of(node)
        {
            // What is drawn of a cluster has its corners in the cluster, so it lies in the cluster's prism.
            let polygon = self.tree.bounding_polygon(place, &reader.node(subtree).ok()?)?;
            scratch.points.extend(Prism::from(&polygon).corners());
            return Some(());
        }
        if subtree.face_count() > MOST_FACES {
            return Some(());
        }
        scratch.stack.clear();
        scratch.stack.push(*subtree);
        while let Some(subtree) = scratch.stack.pop() {
            match subtree.child.kind() {
                Child::Node(_) => scratch.stack.extend(reader.children(&subtree).ok()?),
                Child::Face(_) => {
                    for vertex in reader.face(&subtree).ok()? {
                        let place = reader.vertices().get(vertex as usize)?.position();
                        scratch.points.push(DVec3::from_array(place.map(f64::from)));
                    }
                }
            }
        }
        Some(())
    }
}

/// Subtrees of at most this many faces are outlined corner by corner, which is tight and takes a few microseconds. Larger
/// ones are outlined by the polygons that files store from 64 faces on, or asked about by their spheres.
const MOST_FACES: u32 = 128;
