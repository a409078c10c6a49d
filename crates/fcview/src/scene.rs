//! The scene: models and their placed copies.

use crate::random::Random;
use glam::{DMat4, DQuat, DVec3};
use std::sync::Arc;

/// A model: an opened tree and its name in messages.
#[derive(Clone)]
pub struct Model {
    /// The file's name, for messages.
    pub name: String,
    /// The tree.
    pub tree: Arc<fct::Tree>,
    /// Centre of a sphere around the model, in its own coordinates; exact in 32 bits.
    pub center: DVec3,
    /// That sphere's radius.
    pub radius: f64,
    /// Some of the model's vertices, spread over it, in its own coordinates: for fitting a camera.
    pub samples: Vec<DVec3>,
    /// Half the diagonal of the model's box: its size for placing copies.
    pub reach: f64,
    /// To be added to the model's coordinates for those of the input: [`fct::Meta::origin`].
    pub origin: DVec3,
}

/// A placed copy: rotated and scaled about the model's origin, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Index of the model.
    pub model: usize,
    /// Rotation, unit.
    pub rotation: DQuat,
    /// Uniform scale, positive: the same for every direction, so that normal cones and error bounds stay true.
    pub scale: f64,
    /// Where the model's origin goes.
    pub translation: DVec3,
    /// A hue in 0..1 that tints the copy, or 0 for none.
    pub tint: f32,
}

/// Models and their copies.
#[derive(Clone, Default)]
pub struct Scene {
    /// The models.
    pub models: Vec<Model>,
    /// The copies; an empty scene is fine.
    pub instances: Vec<Instance>,
    /// To be added to the scene's coordinates for those of the input; zero where copies stand at random. Double precision
    /// holds either, but near zero more digits are left for what a camera does.
    pub origin: DVec3,
}

/// The most instances of a scene: 64 MB of instance rows, and as many cuts a frame as anyone will wait for.
pub const MAX_INSTANCES: u32 = 1_000_000;

/// Vertices that stand for a model when a camera is fitted; more would find farther tips by less than the margin
/// that the camera leaves.
const SAMPLES: usize = 512;

impl Model {
    /// A model of an opened tree.
    pub fn new(name: impl Into<String>, tree: Arc<fct::Tree>) -> Model {
        let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
        let bounds = [corner(tree.meta().bounds_min), corner(tree.meta().bounds_max)];
        let (center, radius) = match tree.root().kind() {
            fct::Child::Node(_) => match tree.node(&tree.whole()) {
                Ok(node) => (corner(node.center), f64::from(node.radius)),
                Err(_) => (DVec3::ZERO, 0.0),
            },
            // A single face has no node: the sphere of its box.
            fct::Child::Face(_) => {
                (bounds[0].midpoint(bounds[1]), 0.5 * bounds[0].distance(bounds[1]) * (1.0 + 1e-6))
            }
        };
        // The GPU subtracts the centre in 32 bits, so it must be one of their numbers.
        let rounded = center.as_vec3().as_dvec3();
        let radius = radius + rounded.distance(center);
        let vertices = tree.vertices();
        let samples = vertices
            .iter()
            .step_by(vertices.len().div_ceil(SAMPLES).max(1))
            .map(|v| corner(v.position()))
            .collect();
        let reach = 0.5 * bounds[0].distance(bounds[1]);
        let origin = DVec3::from_array(tree.meta().origin);
        Model { name: name.into(), tree, center: rounded, radius, samples, reach, origin }
    }

    /// Opens a .fct file and checks its bytes: damage is told, and not drawn.
    ///
    /// # Errors
    /// What [`fct::Tree::open`] and [`fct::Tree::check_bytes`] say.
    pub fn open(path: &std::path::Path) -> Result<Model, crate::Error> {
        let tree = fct::Tree::open(path)?;
        tree.check_bytes()?;
        Ok(Model::new(path.display().to_string(), Arc::new(tree)))
    }
}

impl Instance {
    /// A copy of a model whose coordinates are those of the scene.
    pub fn unmoved(model: usize) -> Instance {
        Instance { model, rotation: DQuat::IDENTITY, scale: 1.0, translation: DVec3::ZERO, tint: 0.0 }
    }

    /// Takes a position of the model to the scene.
    pub fn to_world(&self, p: DVec3) -> DVec3 {
        self.rotation * (p * self.scale) + self.translation
    }

    /// Takes a position of the scene to the model.
    pub fn to_model(&self, p: DVec3) -> DVec3 {
        self.rotation.inverse() * (p - self.translation) / self.scale
    }

    /// Takes a direction of the scene to the model.
    pub fn direction_to_model(&self, d: DVec3) -> DVec3 {
        self.rotation.inverse() * d
    }

    /// The matrix from the model to the scene.
    pub fn matrix(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(DVec3::splat(self.scale), self.rotation, self.translation)
    }
}

impl Scene {
    /// Each model once, where the coordinates of its input put it: a scan and its reduction lie on top of one another, the
    /// tiles of a survey side by side. The scene's origin is that of the first. Several are tinted, to be told apart.
    pub fn standing(models: Vec<Model>) -> Scene {
        let several = models.len() > 1;
        let tint = |index: usize| if several { (index as f32 + 0.5) / models.len() as f32 } else { 0.0 };
        let origin = models.first().map_or(DVec3::ZERO, |first| first.origin);
        let instances = models
            .iter()
            .enumerate()
            .map(|(index, model)| Instance {
                tint: tint(index),
                translation: model.origin - origin,
                ..Instance::unmoved(index)
            })
            .collect();
        Scene { models, instances, origin }
    }

    /// The same scene in coordinates that begin at another origin.
    #[must_use]
    pub fn about(mut self, origin: DVec3) -> Scene {
        for instance in &mut self.instances {
            instance.translation += self.origin - origin;
        }
        self.origin = origin;
        self
    }

    /// `count` copies of the models in turn, in a box, with random rotations; one copy stands as in its file.
    ///
    /// The copies stand in the cells of a lattice, each moved within its cell, so that from any side some hide
    /// others while few touch. Models of different sizes are scaled to that of the first.
    ///
    /// # Paper
    /// [Tsuji07, fig. 15]: a scene of many copies of one model, placed at random.
    pub fn placed(models: Vec<Model>, count: u32, seed: u64) -> Scene {
        let Some(first) = models.first() else { return Scene::default() };
        if count == 1 {
            let origin = first.origin;
            return Scene { models, instances: vec![Instance::unmoved(0)], origin };
        }
        let reach = if first.reach > 0.0 { first.reach } else { 1.0 };
        let mut random = Random::new(seed);
        let cells = lattice(count, &mut random);
        // Two would keep the copies apart; less makes them overlap in depth and hide one another.
        let cell = 1.25 * reach;
        let instances = cells
            .into_iter()
            .zip(0_u32..)
            .map(|(place, number)| {
                let index = number as usize % models.len();
                let model = models.get(index).unwrap_or(first);
                let scale = if model.reach > 0.0 { reach / model.reach } else { 1.0 };
                let rotation = random.rotation();
                let jitter = DVec3::from_array([(); 3].map(|()| 0.6 * random.unit() - 0.3));
                let center = cell * (place + jitter);
                Instance {
                    model: index,
                    rotation,
                    scale,
                    translation: center - rotation * (model.center * scale),
                    tint: random.unit() as f32,
                }
            })
            .collect();
        Scene { models, instances, origin: DVec3::ZERO }
    }

    /// The faces of all instances at full resolution.
    pub fn face_count(&self) -> u64 {
        let faces = |instance: &Instance| {
            self.models.get(instance.model).map_or(0, |model| model.tree.face_count() as u64)
        };
        self.instances.iter().map(faces).sum()
    }

    /// The centre and radius of an instance's sphere in the scene; `None` if it names no model.
    pub fn sphere(&self, instance: &Instance) -> Option<(DVec3, f64)> {
        let model = self.models.get(instance.model)?;
        Some((instance.to_world(model.center), model.radius * instance.scale))
    }

    /// Points of all instances, in the scene: a camera that sees them sees about everything.
    pub fn extremes(&self) -> Vec<DVec3> {
        /// Enough for a good fit, few enough for a million instances.
        const POINTS: usize = 100_000;
        let each = (POINTS / self.instances.len().max(1)).clamp(1, SAMPLES);
        let mut points = Vec::new();
        for instance in &self.instances {
            let Some(model) = self.models.get(instance.model) else { continue };
            let step = model.samples.len().div_ceil(each).max(1);
            points.extend(model.samples.iter().step_by(step).map(|p| instance.to_world(*p)));
        }
        points
    }

    /// Whether a camera that shows the other scene well shows this one too: neither is twice as large as the other, and
    /// their middles are no farther apart than the other is large.
    pub fn fills_the_view_of(&self, other: &Scene) -> bool {
        let [(middle, size), (other_middle, other_size)] = [self, other].map(|scene| {
            let points = scene.extremes();
            let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            (low.midpoint(high), low.distance(high))
        });
        size <= 2.0 * other_size && other_size <= 2.0 * size && middle.distance(other_middle) <= other_size
    }

    /// The distance at which the near plane may stand for an eye: before everything, but never so near that an
    /// eye inside a model sees depth without precision.
    pub fn near(&self, eye: DVec3) -> f64 {
        let mut near = f64::INFINITY;
        let mut smallest = f64::INFINITY;
        for (center, radius) in self.instances.iter().filter_map(|instance| self.sphere(instance)) {
            near = near.min(center.distance(eye) - radius);
            if radius > 0.0 {
                smallest = smallest.min(radius);
            }
        }
        let least = if smallest.is_finite() { 1e-4 * smallest } else { 1e-3 };
        if near.is_finite() { (0.5 * near).max(least) } else { least }
    }
}

/// `count` cells of a lattice around the origin, wider than high, chosen and ordered by the generator.
fn lattice(count: u32, random: &mut Random) -> Vec<DVec3> {
    let root = f64::from(count).cbrt();
    let rows = (0.75 * root).round().max(1.0);
    let layers = root.round().max(1.0);
    let columns = (f64::from(count) / (rows * layers)).ceil().max(1.0);
    let (nx, ny, nz) = (columns as u32, rows as u32, layers as u32);
    let middle = 0.5 * DVec3::new(columns - 1.0, rows - 1.0, layers - 1.0);
    let mut cells = Vec::with_capacity(nx as usize * ny as usize * nz as usize);
    for x in 0..nx {
        for y in 0..ny {
            for z in 0..nz {
                cells.push(DVec3::new(f64::from(x), f64::from(y), f64::from(z)) - middle);
            }
        }
    }
    // A partial shuffle: the first `count` of a random order.
    let total = cells.len();
    for i in 0..total.min(count as usize) {
        let other = i + random.below((total - i) as u64) as usize;
        cells.swap(i, other);
    }
    cells.truncate(count as usize);
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_has_as_many_different_cells_as_asked_for() {
        for count in [0, 1, 2, 3, 7, 20, 100, 1000] {
            let cells = lattice(count, &mut Random::new(5));
            assert_eq!(cells.len(), count as usize);
            let mut seen: Vec<_> = cells.iter().map(|c| c.to_array().map(|v| (2.0 * v) as i64)).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), count as usize, "{count} cells repeat");
        }
    }

    #[test]
    fn to_world_and_back_is_where_it_was() {
        let mut random = Random::new(11);
        let instance = Instance {
            model: 0,
            rotation: random.rotation(),
            scale: 2.5,
            translation: DVec3::new(1.0, -2.0, 3.0),
            tint: 0.0,
        };
        let p = DVec3::new(0.3, 0.4, -0.5);
        assert!(instance.to_model(instance.to_world(p)).distance(p) < 1e-12);
        assert!(instance.matrix().transform_point3(p).distance(instance.to_world(p)) < 1e-12);
    }

    #[test]
    fn an_empty_scene_has_a_near_plane_and_no_extremes() {
        let scene = Scene::placed(Vec::new(), 20, 0);
        assert!(scene.instances.is_empty() && scene.extremes().is_empty());
        assert!(scene.near(DVec3::ZERO) > 0.0);
    }
}
