//! Drawing without a window: pictures and a stats document.

pub(crate) mod outputs;

use crate::camera::Camera;
use crate::camera_path::CameraPath;
use crate::cli::{CameraFlag, Cli, ColorFlag, OcclusionFlag};
use crate::orbit::{Orbit, fly};
use crate::recovery::Misfortune;
use crate::scene::{Model, Scene};
use crate::stats::{AdapterStats, ModelStats, RunStats, SettingStats, median_total};
use crate::steering::Steering;
use crate::{Error, FrameStats, Gpu, Survivor, Warning};
use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// What a run did.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Counts and times.
    pub stats: RunStats,
    /// The pictures and documents written.
    pub written: Vec<PathBuf>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// Opens the files of a command line and places them: where their coordinates put them, or copies at random.
///
/// # Errors
/// What [`Model::open`] says about the first file that cannot be opened, or is damaged.
pub fn open_scene(cli: &Cli) -> Result<Scene, Error> {
    let models = cli.files.iter().map(|path| Model::open(path)).collect::<Result<Vec<_>, _>>()?;
    Ok(match cli.copies() {
        None => Scene::standing(models),
        Some(count) => Scene::placed(models, count, cli.seed),
    })
}

/// Draws the frames of a command line and writes what it asks for.
///
/// # Errors
/// Any [`Error`]; a lost device is rebuilt up to three times first.
pub fn run(cli: &Cli) -> Result<Outcome, Error> {
    run_watched(cli, &Watch::default(), &mut |_| ())
}

/// How far a run is, for a thread that waits for its end and may have to end the process before.
#[derive(Debug, Default)]
pub struct Watch {
    frames: AtomicU32,
    /// Held while a file is written.
    writing: Mutex<()>,
}

impl Watch {
    /// How many frames are done.
    pub fn frames(&self) -> u32 {
        self.frames.load(Ordering::Relaxed)
    }

    /// Waits until no file is being written; none is begun as long as the guard lives. A process that ends meanwhile
    /// leaves files that are whole, and no temporary.
    pub fn between_files(&self) -> MutexGuard<'_, ()> {
        // Who panicked while writing has removed its temporary.
        self.writing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The same; `tell` is told of the number of frames that are done, before each and after the last, and so is `watch`.
///
/// # Errors
/// As [`run`].
pub fn run_watched(cli: &Cli, watch: &Watch, tell: &mut dyn FnMut(u32)) -> Result<Outcome, Error> {
    let start = Instant::now();
    {
        let _no_end = watch.between_files();
        outputs::check(cli)?;
    }
    let scene = open_scene(cli)?;
    let hollow = Warning::of_hollow(cli, &scene);
    let way = Way::new(cli, &scene)?;
    let mut survivor = Survivor::with_memory(&scene, cli.gpu_memory, gpu)?;
    let info = survivor.gpu().map(Gpu::info);
    let software = survivor.gpu().is_some_and(Gpu::is_software);
    let mut options = cli.frame_options();
    let mut steering = cli.fps.map(Steering::new);
    let adapter = info.map(AdapterStats::from).unwrap_or_default();
    let milliseconds_setup = start.elapsed().as_secs_f64() * 1e3;

    let mut frames: Vec<FrameStats> = Vec::with_capacity(cli.frames as usize);
    let mut written = Vec::new();
    let mut misfortune = Misfortune::new(cli);
    let mut note = |frames: u32| {
        watch.frames.store(frames, Ordering::Relaxed);
        tell(frames);
    };
    for frame in 0..cli.frames {
        note(frame);
        let camera = way.camera(frame, cli.frames, cli.speed);
        let picture = outputs::picture_name(cli, frame);
        if let Some(steering) = &steering {
            options.detail = steering.detail();
        }
        let (mut stats, image) = survivor.draw(&camera, &options, |renderer| {
            misfortune.strike(renderer.gpu());
            let image = picture.as_ref().map(|_| renderer.image(false)).transpose()?;
            renderer.gpu().check()?;
            Ok(image)
        })?;
        stats.frame = frame;
        if let Some(steering) = &mut steering {
            steering.note(stats.milliseconds.total);
        }
        frames.push(stats);
        if let (Some(name), Some(image)) = (picture, image) {
            let _no_end = watch.between_files();
            image.write_png(&name)?;
            written.push(name);
        }
    }

    note(cli.frames);
    let stats = RunStats {
        version: 2,
        generator: concat!("fcview ", env!("CARGO_PKG_VERSION")).to_owned(),
        adapter,
        models: scene.models.iter().map(model_stats).collect(),
        origin: scene.origin.to_array(),
        settings: settings(cli, &scene),
        milliseconds_setup,
        milliseconds_median: median_total(&frames),
        frames,
    };
    if let Some(name) = &cli.stats {
        let _no_end = watch.between_files();
        outputs::write_json(name, &stats)?;
        written.push(name.clone());
    }
    let software = software.then(|| Warning::of_software(&stats.adapter));
    let of_frames = [Warning::of_memory(&stats), Warning::of_budget(&stats), Warning::of_pace(&stats)];
    let warnings = [hollow, software].into_iter().chain(of_frames).flatten().collect();
    Ok(Outcome { stats, written, warnings })
}

/// The camera's way.
enum Way {
    Orbit(Orbit),
    Fly { points: Vec<glam::DVec3>, fov: f64 },
    Recorded(CameraPath),
}

impl Way {
    fn new(cli: &Cli, scene: &Scene) -> Result<Way, Error> {
        let points = scene.extremes();
        let fov = cli.field_of_view();
        let [width, height] = cli.size.map(f64::from);
        Ok(match &cli.camera {
            // One picture may be taken from nearer than a whole round.
            CameraFlag::Orbit if cli.frames == 1 => Way::Orbit(Orbit::facing(&points, fov, width / height)),
            CameraFlag::Orbit => Way::Orbit(Orbit::around(&points, fov, width / height)),
            CameraFlag::Fly => Way::Fly { points, fov },
            CameraFlag::Path(file) => Way::Recorded(CameraPath::read(file)?.about(scene.origin)),
        })
    }

    /// The camera of one of `frames` frames that are spread over `speed` rounds.
    fn camera(&self, frame: u32, frames: u32, speed: f64) -> Camera {
        let part = |frames: u32| speed * f64::from(frame) / f64::from(frames.max(1));
        match self {
            // The frame after the last of a round would be the first again.
            Way::Orbit(orbit) => {
                let mut turned = *orbit;
                turned.turn(-TAU * part(frames), 0.0);
                turned.camera()
            }
            Way::Fly { points, fov } => fly(points, *fov, part(frames).fract()),
            // A recorded path has two ends.
            Way::Recorded(path) => {
                let part = part(frames.saturating_sub(1));
                path.camera(if part > 1.0 { part.fract() } else { part })
            }
        }
    }
}

/// A device without a display; where there is none, the error says whether the environment is why.
fn gpu() -> Result<Gpu, Error> {
    Gpu::headless().map_err(Error::with_backends_asked_for)
}

fn model_stats(model: &Model) -> ModelStats {
    ModelStats {
        name: model.name.clone(),
        faces: model.tree.face_count() as u64,
        vertices: model.tree.vertices().len() as u64,
    }
}

fn settings(cli: &Cli, scene: &Scene) -> SettingStats {
    SettingStats {
        size: cli.size,
        samples: cli.samples,
        pixels: (!cli.no_lod && cli.triangles.is_none() && cli.fps.is_none()).then_some(cli.pixels),
        triangles: cli.triangles,
        fps: cli.fps,
        gpu_memory: cli.gpu_memory,
        lod: !cli.no_lod,
        frustum: !cli.no_frustum,
        backface: !cli.no_backface && !cli.two_sided,
        two_sided: cli.two_sided,
        occlusion: match cli.occlusion {
            OcclusionFlag::Exact => "exact",
            OcclusionFlag::Queries => "queries",
            OcclusionFlag::Off => "off",
        },
        queries: cli.queries,
        color: match cli.color {
            ColorFlag::Shaded => "shaded",
            ColorFlag::Clusters => "clusters",
            ColorFlag::Depth => "depth",
            ColorFlag::Level => "level",
        },
        wireframe: cli.wireframe,
        camera: match &cli.camera {
            CameraFlag::Orbit => "orbit",
            CameraFlag::Fly => "fly",
            CameraFlag::Path(_) => "path",
        },
        camera_path: match &cli.camera {
            CameraFlag::Path(file) => Some(file.display().to_string()),
            _ => None,
        },
        frames: cli.frames,
        speed: cli.speed,
        instances: scene.instances.len() as u64,
        seed: cli.seed,
        fov: cli.fov,
    }
}
