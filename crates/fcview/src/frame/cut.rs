//! The cut of every instance, in parallel.

use crate::Error;
use crate::camera::View;
use crate::options::{Detail, FrameOptions};
use crate::scene::{Instance, Scene};
use crate::stats::Counts;
use fcextract::{Extraction, Perspective, Selection, Tolerance};
use fcgeom::{Containment, Frustum, Sphere};
use rayon::prelude::*;

/// The cuts of a frame; kept from frame to frame for its memory.
#[derive(Default)]
pub(crate) struct Cuts {
    /// Cuts that do not depend on the view: made once, used by every instance they suit.
    shared: Vec<Slot>,
    /// Cuts of single instances, made anew each frame.
    own: Vec<Slot>,
    own_used: usize,
    /// The instances in sight and their cuts.
    pub(crate) placed: Vec<Placed>,
}

/// An instance in sight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// Its number in the scene.
    pub(crate) instance: usize,
    /// Its cut.
    pub(crate) cut: CutId,
}

/// Names a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CutId {
    Shared(usize),
    Own(usize),
}

/// A cut and what it was made for.
#[derive(Default)]
pub(crate) struct Slot {
    pub(crate) model: usize,
    pub(crate) extraction: Extraction,
    /// The tolerance of a shared cut; 0 for full resolution.
    distance: f64,
}

impl Cuts {
    /// Forgets the cuts; for another scene.
    pub(crate) fn clear(&mut self) {
        *self = Cuts::default();
    }

    /// Makes the cuts of a frame, and counts.
    ///
    /// # Errors
    /// [`Error::Extract`] if a tree is damaged.
    pub(crate) fn make(
        &mut self,
        scene: &Scene,
        view: &View,
        options: &FrameOptions,
        counts: &mut Counts,
    ) -> Result<(), Error> {
        self.placed.clear();
        self.own_used = 0;
        let world = Frustum::from_view_projection(&view.clip_from_world());
        let mut wanted = Vec::new();
        for (number, instance) in scene.instances.iter().enumerate() {
            counts.instances += 1;
            let Some(model) = scene.models.get(instance.model) else { continue };
            let local = world.in_local_space(&instance.matrix());
            let sphere = Sphere { center: model.center.as_vec3(), radius: fcgeom::round_up(model.radius) };
            let frustum = match (options.frustum, local.classify_sphere(&sphere)) {
                (true, Containment::Outside) => {
                    counts.instances_outside += 1;
                    continue;
                }
                (true, Containment::Crossing) => Some(local),
                (true, Containment::Inside) | (false, _) => None,
            };
            let selection = selection(instance, view, options, frustum);
            let cut = match shared_distance(&selection) {
                Some(distance) => CutId::Shared(self.shared_slot(scene, instance.model, distance)?),
                None => {
                    wanted.push((instance.model, selection));
                    CutId::Own(wanted.len() - 1)
                }
            };
            self.placed.push(Placed { instance: number, cut });
        }
        self.own_used = wanted.len();
        if self.own.len() < wanted.len() {
            self.own.resize_with(wanted.len(), Slot::default);
        }
        self.own
            .par_iter_mut()
            .zip(wanted.par_iter())
            .try_for_each(|(slot, (model, selection))| slot.fill(scene, *model, selection))?;
        for placed in &self.placed {
            let Some(slot) = self.slot(placed.cut) else { continue };
            let stats = &slot.extraction.stats;
            counts.nodes_visited += stats.nodes_visited;
            counts.nodes_culled_frustum += stats.culled_frustum;
            counts.nodes_culled_cone += stats.culled_cone;
            counts.clusters += stats.clusters;
            counts.triangles_folded += stats.folded;
            counts.triangles_selected += slot.extraction.indices.len() as u64 / 3;
        }
        Ok(())
    }

    /// A cut.
    pub(crate) fn slot(&self, id: CutId) -> Option<&Slot> {
        match id {
            CutId::Shared(index) => self.shared.get(index),
            CutId::Own(index) => self.own.get(index),
        }
    }

    /// The cuts that this frame uses, each once, in a fixed order.
    pub(crate) fn used(&self) -> impl Iterator<Item = (CutId, &Slot)> {
        let shared = self.shared.iter().enumerate().filter_map(|(index, slot)| {
            let id = CutId::Shared(index);
            self.placed.iter().any(|placed| placed.cut == id).then_some((id, slot))
        });
        let own = self.own.iter().enumerate().take(self.own_used);
        shared.chain(own.map(|(index, slot)| (CutId::Own(index), slot)))
    }

    /// The index of the shared cut for a model and tolerance, made if it is missing.
    fn shared_slot(&mut self, scene: &Scene, model: usize, distance: f64) -> Result<usize, Error> {
        /// Old tolerances are forgotten beyond this many, so that a slider does not fill the memory.
        const KEPT: usize = 4;
        let same = |slot: &Slot| (slot.model, slot.distance.to_bits()) == (model, distance.to_bits());
        if let Some(index) = self.shared.iter().position(same) {
            return Ok(index);
        }
        if self.placed.is_empty() && self.shared.len() >= KEPT {
            self.shared.clear();
        }
        let tolerance = if distance > 0.0 { Tolerance::Uniform { distance } } else { Tolerance::Full };
        let selection = Selection { tolerance, ..Selection::full() };
        let mut slot = Slot { distance, ..Slot::default() };
        slot.fill(scene, model, &selection)?;
        self.shared.push(slot);
        Ok(self.shared.len() - 1)
    }
}

impl Slot {
    fn fill(&mut self, scene: &Scene, model: usize, selection: &Selection) -> Result<(), Error> {
        self.model = model;
        let Some(model) = scene.models.get(model) else { return Ok(()) };
        fcextract::extract(&model.tree, selection, &mut self.extraction)
            .map_err(|source| Error::Extract { model: model.name.clone(), source })
    }
}

/// What an instance shows of its model, in the model's coordinates.
fn selection(
    instance: &Instance,
    view: &View,
    options: &FrameOptions,
    frustum: Option<Frustum>,
) -> Selection {
    let eye = instance.to_model(view.eye);
    let tolerance = match options.detail {
        Detail::Full => Tolerance::Full,
        Detail::Distance(distance) => Tolerance::Uniform { distance: distance / instance.scale },
        // Lengths and distances scale alike, so the slope is the same in the model.
        Detail::Pixels(pixels) => Tolerance::Perspective(Perspective {
            eye,
            axis: instance.direction_to_model(view.forward),
            slope: pixels * view.pixel,
            corner_cos: view.corner_cos,
        }),
    };
    let backface = options.backface && !options.two_sided;
    Selection { tolerance, frustum, backface_eye: backface.then_some(eye), ..Selection::full() }
}

/// The tolerance of a selection that does not depend on the view.
fn shared_distance(selection: &Selection) -> Option<f64> {
    if selection.frustum.is_some() || selection.backface_eye.is_some() {
        return None;
    }
    match selection.tolerance {
        Tolerance::Full => Some(0.0),
        Tolerance::Uniform { distance } if distance > 0.0 => Some(distance),
        Tolerance::Uniform { .. } | Tolerance::Perspective(_) => None,
    }
}
