//! What each instance in sight shows: its selection, and how much of the picture it is about.

use super::pieces::Piece;
use crate::Error;
use crate::camera::View;
use crate::options::{Detail, FrameOptions};
use crate::scene::{Instance, Scene};
use crate::stats::{BudgetStats, FrameStats};
use fcextract::{Budget, Fitter, Order, Part, Perspective, Selection, Shown, Tolerance};
use fcgeom::{Containment, Frustum, Sphere};
use glam::DVec3;

/// The instances of a frame.
#[derive(Default)]
pub(crate) struct Plan {
    /// The instances in sight; the others are not looked at.
    pub(crate) placed: Vec<Placed>,
    /// About so many pieces.
    pub(crate) pieces: usize,
    /// Pieces are divided until they draw about this many triangles.
    pub(crate) piece_triangles: f64,
}

/// An instance in sight.
pub(crate) struct Placed {
    /// Its number in the scene.
    pub(crate) instance: usize,
    /// Its model.
    pub(crate) model: usize,
    /// What it shows of its model, in the model's coordinates.
    pub(crate) selection: Selection,
    /// How much a part of it may draw.
    pub(crate) reckoning: Reckoning,
}

/// Triangles per pixel that a cut at a tolerance of one pixel has about, for dividing frames evenly: measured on scans,
/// where it lies between a twentieth and an eighth.
const TRIANGLES_PER_PIXEL: f64 = 1.0 / 12.0;

/// Distances are sorted into so many bands between the nearest and the farthest of the view. What lies in one band is drawn
/// instance by instance, which takes fewer draws, and is of one round.
const BANDS: f64 = 128.0;

/// No piece is made smaller than this on purpose: one triangle is cut and drawn sooner than asked about.
const FEWEST_TRIANGLES: f64 = 1.0;

impl Plan {
    /// Plans a frame: detail and culling follow `chooser`, order and division follow `view`.
    pub(crate) fn new(
        scene: &Scene,
        chooser: &View,
        view: &View,
        options: &FrameOptions,
        fitter: &mut Fitter,
        stats: &mut FrameStats,
    ) -> Result<Plan, Error> {
        let counts = &mut stats.counts;
        let mut plan = Plan::default();
        let world = Frustum::from_view_projection(&chooser.clip_from_world());
        let mut in_view = Vec::new();
        let mut span = [f64::INFINITY, view.near];
        for (number, instance) in scene.instances.iter().enumerate() {
            counts.instances += 1;
            let Some(model) = scene.models.get(instance.model) else { continue };
            let local = world.in_local_space(&instance.matrix());
            let sphere = Sphere { center: model.center.as_vec3(), radius: fcgeom::round_up(model.radius) };
            let containment = local.classify_sphere(&sphere);
            let reckoning = Reckoning::new(instance, view, options);
            // The division must not depend on what is culled, or pieces at the same depth would change places.
            if containment != Containment::Outside {
                let near = reckoning.near(model.center, model.radius);
                let far = near + 2.0 * model.radius * instance.scale;
                span = [span[0].min(near), span[1].max(far)];
                in_view.push((reckoning, model));
            }
            let frustum = match (options.frustum, containment) {
                (true, Containment::Outside) => {
                    counts.instances_outside += 1;
                    continue;
                }
                (true, Containment::Crossing) => Some(local),
                (true, Containment::Inside) | (false, _) => None,
            };
            let selection = selection(instance, chooser, options, frustum);
            plan.placed.push(Placed { instance: number, model: instance.model, selection, reckoning });
        }
        let mut density = density(options.detail);
        if let Detail::Triangles(budget) = options.detail {
            let pixels = plan.fit(scene, fitter, budget, stats)?;
            density = density_at(pixels);
        }
        let triangles: f64 = in_view
            .iter()
            .map(|(reckoning, model)| {
                let faces = model.tree.face_count() as u32;
                Reckoning { density, ..*reckoning }.triangles(model.center, model.radius, faces)
            })
            .sum();
        let bands = BANDS / (span[1] / span[0].max(view.near)).ln().max(1e-6);
        for placed in &mut plan.placed {
            placed.reckoning.near = span[0].max(view.near);
            placed.reckoning.bands = bands;
            placed.reckoning.density = density;
        }
        plan.pieces = options.queries.unwrap_or(FrameOptions::QUERIES).max(1);
        plan.piece_triangles = (triangles / plan.pieces as f64).max(FEWEST_TRIANGLES);
        Ok(plan)
    }

    /// Divides a budget among the instances. Returns the tolerance that it comes to, in pixels and by the budget's order,
    /// which promises nothing.
    fn fit(
        &mut self,
        scene: &Scene,
        fitter: &mut Fitter,
        budget: u64,
        stats: &mut FrameStats,
    ) -> Result<f64, Error> {
        let mut places = Vec::with_capacity(self.placed.len());
        let mut shown = Vec::with_capacity(self.placed.len());
        for (place, placed) in self.placed.iter_mut().enumerate() {
            let Some(model) = scene.models.get(placed.model) else { continue };
            let selection = std::mem::replace(&mut placed.selection, Selection::full());
            shown.push(Shown { tree: &model.tree, selection });
            places.push(place);
        }
        // The first model stands for all of them in the message: which one is damaged, its reader says.
        let name = || scene.models.first().map_or_else(String::new, |model| model.name.clone());
        let fitted = fitter
            .fit(&mut shown, Budget::Triangles(budget))
            .map_err(|source| Error::Extract { model: name(), source })?;
        for (place, one) in places.into_iter().zip(shown) {
            if let Some(placed) = self.placed.get_mut(place) {
                placed.selection = one.selection;
            }
        }
        stats.budget = Some(BudgetStats { wanted: budget, selected: fitted.count, within: fitted.within });
        Ok(fitted.factor)
    }

    /// Every instance in sight as one piece.
    pub(crate) fn whole(&self, scene: &Scene) -> Vec<Piece> {
        let piece = |(placed, number): (&Placed, u32)| {
            let model = scene.models.get(placed.model)?;
            let near = placed.reckoning.near(model.center, model.radius);
            let faces = model.tree.face_count() as u32;
            Some(Piece {
                placed: number,
                part: Part::whole(&model.tree, &placed.selection),
                center: model.center,
                radius: model.radius,
                near,
                band: placed.reckoning.band(near),
                middle: placed.reckoning.band(near + placed.reckoning.scale * model.radius),
                triangles: placed.reckoning.triangles(model.center, model.radius, faces),
                divided: false,
            })
        };
        self.placed.iter().zip(0_u32..).filter_map(piece).collect()
    }
}

/// Guesses how many triangles a part of an instance draws, and measures how far it is. The guesses decide what is
/// divided and asked together, never what is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reckoning {
    /// The eye in the model's coordinates.
    pub(crate) eye: DVec3,
    scale: f64,
    /// Where the bands of distances begin, and their number for each factor e of distance.
    near: f64,
    bands: f64,
    pixel: f64,
    picture: f64,
    /// Triangles a pixel, or infinite where they depend on the faces alone.
    density: f64,
}

impl Reckoning {
    fn new(instance: &Instance, view: &View, options: &FrameOptions) -> Reckoning {
        Reckoning {
            eye: instance.to_model(view.eye),
            scale: instance.scale,
            near: view.near,
            bands: 0.0,
            pixel: view.pixel,
            picture: f64::from(options.size[0]) * f64::from(options.size[1]),
            density: f64::INFINITY,
        }
    }

    /// Distance of the eye from a sphere of the model, in the scene's unit; negative inside.
    pub(crate) fn near(&self, center: DVec3, radius: f64) -> f64 {
        self.scale * (center.distance(self.eye) - radius)
    }

    /// The band of a distance.
    pub(crate) fn band(&self, near: f64) -> i32 {
        // Converted with saturation: what is not a number is near, what is infinite far.
        (self.bands * (near / self.near).max(1.0).ln()) as i32
    }

    /// About how many triangles a subtree of so many faces draws.
    pub(crate) fn triangles(&self, center: DVec3, radius: f64, faces: u32) -> f64 {
        let distance = center.distance(self.eye);
        let pixels = if distance > radius {
            let across = radius / (distance * self.pixel);
            (std::f64::consts::PI * across * across).min(self.picture)
        } else {
            self.picture
        };
        f64::from(faces).min(self.density * pixels)
    }
}

/// About how many triangles a pixel has at a tolerance: their number falls about as fast as the tolerance grows.
fn density_at(pixels: f64) -> f64 {
    TRIANGLES_PER_PIXEL / pixels
}

/// The same for any way to say how much detail is drawn; infinite where only the faces of the input limit it.
fn density(detail: Detail) -> f64 {
    match detail {
        Detail::Pixels(pixels) | Detail::Gain(pixels) => density_at(pixels),
        Detail::Full | Detail::Distance(_) | Detail::Triangles(_) => f64::INFINITY,
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
    let perspective = |pixels: f64| {
        // Lengths and distances scale alike, so the slope is the same in the model.
        Tolerance::Perspective(Perspective {
            eye,
            axis: instance.direction_to_model(view.forward),
            slope: pixels * view.pixel,
            corner_cos: view.corner_cos,
        })
    };
    let tolerance = match options.detail {
        Detail::Full => Tolerance::Full,
        Detail::Distance(distance) => Tolerance::Uniform { distance: distance / instance.scale },
        Detail::Pixels(pixels) | Detail::Gain(pixels) => perspective(pixels),
        // A pixel of error weighs the same everywhere; by how much the tolerances are multiplied, the budget says.
        Detail::Triangles(_) => perspective(1.0),
    };
    let order = match options.detail {
        Detail::Triangles(_) | Detail::Gain(_) => Order::Budget,
        Detail::Full | Detail::Distance(_) | Detail::Pixels(_) => Order::Bound,
    };
    let backface = options.backface && !options.two_sided;
    Selection { tolerance, order, frustum, backface_eye: backface.then_some(eye), ..Selection::full() }
}
