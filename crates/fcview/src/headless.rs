//! Drawing without a window: pictures and a stats document.

use crate::camera::Camera;
use crate::cli::{CameraFlag, Cli, OcclusionFlag};
use crate::orbit::{Orbit, fly};
use crate::scene::{Model, Scene};
use crate::stats::{AdapterStats, ModelStats, RunStats, SettingStats, median_total};
use crate::{Error, FrameStats, Gpu, Renderer};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// How often a lost device is rebuilt before the run gives up.
pub(crate) const REBUILDS: u32 = 3;

/// What a run did.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Counts and times.
    pub stats: RunStats,
    /// The pictures and documents written.
    pub written: Vec<PathBuf>,
    /// Whether the adapter is a program on the CPU.
    pub software: bool,
}

/// Opens the files of a command line and places their copies.
///
/// # Errors
/// What [`fct::Tree::open`] says about the first file that cannot be opened.
pub fn open_scene(cli: &Cli) -> Result<Scene, Error> {
    let models = cli.files.iter().map(|path| Model::open(path)).collect::<Result<Vec<_>, _>>()?;
    Ok(Scene::placed(models, cli.instance_count(), cli.seed))
}

/// Draws the frames of a command line and writes what it asks for.
///
/// # Errors
/// Any [`Error`]; a lost device is rebuilt up to three times first.
pub fn run(cli: &Cli) -> Result<Outcome, Error> {
    let start = Instant::now();
    let scene = open_scene(cli)?;
    let mut renderer = Renderer::new(Gpu::headless()?, &scene)?;
    let software = renderer.gpu().is_software();
    let options = cli.frame_options();
    let adapter = AdapterStats::from(renderer.gpu().info());
    let path = CameraPath::new(cli, &scene);
    let milliseconds_setup = start.elapsed().as_secs_f64() * 1e3;

    let mut frames: Vec<FrameStats> = Vec::with_capacity(cli.frames as usize);
    let mut written = Vec::new();
    let mut rebuilds = 0;
    for frame in 0..cli.frames {
        let camera = path.camera(f64::from(frame) / f64::from(cli.frames));
        let mut stats = loop {
            match renderer.draw(&scene, &camera, &options) {
                Ok(stats) => break stats,
                Err(Error::DeviceLost { .. }) if rebuilds < REBUILDS => {
                    rebuilds += 1;
                    renderer = Renderer::new(Gpu::headless()?, &scene)?;
                }
                Err(error) => return Err(error),
            }
        };
        stats.frame = frame;
        frames.push(stats);
        if let Some(name) = screenshot_name(cli, frame) {
            renderer.image(false)?.write_png(&name)?;
            written.push(name);
        }
    }

    let stats = RunStats {
        version: 1,
        generator: concat!("fcview ", env!("CARGO_PKG_VERSION")).to_owned(),
        adapter,
        models: scene.models.iter().map(model_stats).collect(),
        settings: settings(cli),
        milliseconds_setup,
        milliseconds_median: median_total(&frames),
        frames,
    };
    if let Some(name) = &cli.stats {
        write_json(name, &stats)?;
        written.push(name.clone());
    }
    Ok(Outcome { stats, written, software })
}

/// The camera's way.
enum CameraPath {
    Orbit(Orbit),
    Fly { points: Vec<glam::DVec3>, fov: f64 },
}

impl CameraPath {
    fn new(cli: &Cli, scene: &Scene) -> CameraPath {
        let points = scene.extremes();
        let [width, height] = cli.size.map(f64::from);
        match cli.camera {
            // One picture may be taken from nearer than a whole round.
            CameraFlag::Orbit if cli.frames == 1 => {
                CameraPath::Orbit(Orbit::facing(&points, cli.field_of_view(), width / height))
            }
            CameraFlag::Orbit => {
                CameraPath::Orbit(Orbit::around(&points, cli.field_of_view(), width / height))
            }
            CameraFlag::Fly => CameraPath::Fly { points, fov: cli.field_of_view() },
        }
    }

    /// The camera after a part of one round.
    fn camera(&self, part: f64) -> Camera {
        match self {
            CameraPath::Orbit(orbit) => {
                let mut turned = *orbit;
                turned.turn(-TAU * part, 0.0);
                turned.camera()
            }
            CameraPath::Fly { points, fov } => fly(points, *fov, part),
        }
    }
}

/// The file for a frame's picture, if it gets one.
fn screenshot_name(cli: &Cli, frame: u32) -> Option<PathBuf> {
    let name = cli.screenshot.as_ref()?;
    match name.to_str() {
        Some(text) if text.contains("{n}") => Some(PathBuf::from(text.replace("{n}", &frame.to_string()))),
        // Names that are not Unicode hold no placeholder.
        _ => (frame + 1 == cli.frames).then(|| name.clone()),
    }
}

fn model_stats(model: &Model) -> ModelStats {
    ModelStats {
        name: model.name.clone(),
        faces: model.tree.faces().len() as u64,
        vertices: model.tree.vertices().len() as u64,
    }
}

fn settings(cli: &Cli) -> SettingStats {
    SettingStats {
        size: cli.size,
        samples: cli.samples,
        pixels: (!cli.no_lod).then_some(cli.pixels),
        lod: !cli.no_lod,
        frustum: !cli.no_frustum,
        backface: !cli.no_backface && !cli.two_sided,
        occlusion: match cli.occlusion {
            OcclusionFlag::Exact => "exact",
            OcclusionFlag::Off => "off",
        },
        seed: cli.seed,
        fov: cli.fov,
    }
}

fn write_json(path: &Path, stats: &RunStats) -> Result<(), Error> {
    let failed = |source| Error::Write { path: path.to_path_buf(), source };
    let mut text = serde_json::to_string_pretty(stats).map_err(|error| failed(error.into()))?;
    text.push('\n');
    std::fs::write(path, text).map_err(failed)
}
