//! By which polygon a piece, or a whole instance, is asked about before it is cut.

use super::depths::Depths;
use super::outline::{Octagon, Screen};
use super::pieces::Piece;
use super::plan::Plan;
use crate::bounding_polygon::{Prism, sphere_polygon, to_clip};
use crate::camera::View;
use crate::scene::{Instance, Scene};
use fct::{Branch, Child, Page};
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

/// What may be asked about the pieces of a frame.
pub(crate) struct Asking<'a> {
    view: &'a View,
    places: Vec<Option<Place<'a>>>,
}

impl<'a> Asking<'a> {
    pub(crate) fn new(scene: &'a Scene, view: &'a View, plan: &Plan) -> Asking<'a> {
        let places = plan.placed.iter().map(|placed| Place::new(scene, view, placed.instance)).collect();
        Asking { view, places }
    }

    /// A question about each piece, or none where no polygon is safe; the piece then counts as visible.
    pub(crate) fn questions(&self, pieces: &[Piece]) -> Vec<Option<Question>> {
        let ask =
            |scratch: &mut Scratch, piece: &Piece| self.place(piece)?.question(self.view, piece, scratch);
        pieces.par_iter().map_init(Scratch::default, ask).collect()
    }

    /// The same with answers, by a depth that is at hand. Few pieces take a closer look: most show at their middle, or are
    /// hidden with all of their sphere. Only who `wants_all` gets the questions about those that show too.
    pub(crate) fn answered(
        &self,
        pieces: &[Piece],
        depths: &Depths,
        wants_all: bool,
    ) -> Vec<(Option<Question>, bool)> {
        let ask = |scratch: &mut Scratch, piece: &Piece| {
            let Some(place) = self.place(piece) else { return (None, true) };
            if place.screen.clip(piece.center).is_some_and(|clip| depths.is_open_at(clip)) {
                let question = wants_all.then(|| place.question(self.view, piece, scratch));
                return (question.flatten(), true);
            }
            let rough = place.square(self.view, piece);
            if let Some(rough) = rough
                && !depths.show(rough.corners())
            {
                return (Some(rough), false);
            }
            let question = place.question(self.view, piece, scratch);
            let is_shown = question.is_none_or(|question| depths.show(question.corners()));
            (question, is_shown)
        };
        pieces.par_iter().map_init(Scratch::default, ask).collect()
    }

    fn place(&self, piece: &Piece) -> Option<&Place<'a>> {
        self.places.get(piece.placed as usize)?.as_ref()
    }
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
        scratch.points.clear();
        self.outline(&piece.part.subtree, scratch)?;
        match self.screen.octagon(scratch.points.iter().copied(), &mut scratch.projected) {
            Some(octagon) => Some(Question::Octagon(octagon)),
            None => self.square(view, piece),
        }
    }

    /// The square before a piece's sphere.
    fn square(&self, view: &View, piece: &Piece) -> Option<Question> {
        let from_eye = |p: DVec3| self.instance.rotation * ((p - self.eye) * self.instance.scale);
        let square = sphere_polygon(piece.center, piece.radius, self.eye, view.pixel)?;
        Some(Question::Square(to_clip(&square.map(from_eye), view)?))
    }

    /// Collects points in whose hull all lies that is drawn of a subtree, whatever its detail: the corners of its stored
    /// prism, or, tighter, its vertices where they are few.
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
            if let Some((page, branch)) = reader.page(&subtree) {
                add_vertices(&page, &branch, &mut scratch.points)?;
                continue;
            }
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

/// Adds the vertices of a branch, each once; none if the page does not have what it says.
fn add_vertices(page: &Page<'_>, branch: &Branch, points: &mut Vec<DVec3>) -> Option<()> {
    let mut added = [0_u64; 4];
    for local in page.faces(branch)?.as_flattened() {
        let (word, bit) = (usize::from(local / 64), 1 << (local % 64));
        if added[word] & bit == 0 {
            added[word] |= bit;
            let (_, record) = page.vertex(*local)?;
            points.push(DVec3::from_array(record.position().map(f64::from)));
        }
    }
    Some(())
}

/// Subtrees of at most this many faces are outlined corner by corner, which is tight and takes a few microseconds. Larger
/// ones are outlined by the polygons that files store from 64 faces on, or asked about by their spheres.
const MOST_FACES: u32 = 128;
