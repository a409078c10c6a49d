//! The command line: flags typed by clap, then what they mean.

use crate::options::{ColorMode, Detail, FrameOptions, Occlusion};
use crate::scene::MAX_INSTANCES;
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{CommandFactory as _, FromArgMatches as _, Parser, ValueEnum};
use fct::{MessageFormat, Size};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// What `--help` shows below the flags.
const EXAMPLES: &str = "\
Examples:
  Look around:
    fcview dragon.fct
  A hundred copies, errors of up to two pixels:
    fcview bunny.fct --instances 100 --pixels 2
  A picture, no display needed:
    fcview dragon.fct --headless --screenshot out.png
  A scan that is larger than the graphics memory:
    fcview city.fct --gpu-memory 1G
  Measure a flight through twenty copies:
    fcview dragon.fct --headless --instances 20 --camera fly --frames 60 --stats stats.json
  Pictures along a path recorded in the window with R:
    fcview dragon.fct --headless --camera fcview-path-0.json --frames 250 --screenshot 'f{#}.png'

In the window: drag to turn, drag with Shift or the right button to pan,
wheel to zoom, W A S D Q E to fly, F to see everything, Space to freeze the cut,
P to save a picture, R to record a path, O to open a file or drop one, Esc to
quit. The panel lists all keys.

WGPU_BACKEND (vulkan, gl, metal, dx12) and WGPU_ADAPTER_NAME choose the graphics
adapter.

Exit codes: 0 done, 1 our bug, 2 usage, 3 bad path of a camera, 4 input or
output, 5 a limit, 6 no GPU or display, 7 invalid .fct, 129, 130, 131, 143 or
152 stopped by a signal.";

/// Draws .fct files: level of detail by an error in pixels, culling of what does not show.
#[derive(Clone, Debug, Parser)]
#[command(name = "fcview", version, about, after_help = EXAMPLES, max_term_width = 100)]
pub struct Cli {
    /// Files to draw, made by fcbuild
    #[arg(required = true, value_name = "FILE.fct")]
    pub files: Vec<PathBuf>,
    /// Copies of the files, in turn, placed and turned at random, at least one of each [default: one of each, where
    /// its coordinates put it]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_INSTANCES)))]
    pub instances: Option<u32>,
    /// Seed of the random places
    #[arg(long, value_name = "S", default_value_t = 1, requires = "instances")]
    pub seed: u64,
    /// Errors of up to this many pixels on screen
    #[arg(long, value_name = "P", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive, conflicts_with = "no_lod")]
    pub pixels: f64,
    /// Draw every face of the input
    #[arg(long)]
    pub no_lod: bool,
    /// At most so many triangles in all copies together, spent where they lower the error on screen the most
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..), conflicts_with_all = ["no_lod", "pixels"])]
    pub triangles: Option<u64>,
    /// As many triangles as are drawn in time for so many frames a second
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = positive, conflicts_with_all = ["no_lod", "pixels", "triangles"])]
    pub fps: Option<f64>,
    /// Memory of the graphics card for the models' vertices, such as 800M, 6GiB or 1.5GB; what does not fit is drawn
    /// coarser [default: as much as they take and the card has]
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true, value_parser = bytes)]
    pub gpu_memory: Option<u64>,
    /// Do not leave out what lies outside the view
    #[arg(long)]
    pub no_frustum: bool,
    /// Do not leave out clusters that face away as a whole
    #[arg(long)]
    pub no_backface: bool,
    /// Draw back faces too; switches the test of --no-backface off as well
    #[arg(long)]
    pub two_sided: bool,
    /// Leave out what other parts hide, without changing a pixel; queries asks the driver even where it is a program, and
    /// its depth sooner looked at
    #[arg(long, value_enum, value_name = "exact|queries|off", default_value_t = OcclusionFlag::Exact, hide_possible_values = true)]
    pub occlusion: OcclusionFlag,
    /// Size of the picture or window, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub size: [u32; 2],
    /// Samples a pixel; 4 smooths edges
    #[arg(long, value_name = "1|4", default_value = "4", value_parser = samples)]
    pub samples: u32,
    /// What colours the surface: its light; clusters, a colour for each; depth, from yellow for the nearest in sight over
    /// pink to dark blue for the farthest; level, from blue for clusters of one face over green and yellow to red for a million
    #[arg(long, value_enum, value_name = "shaded|clusters|depth|level", default_value_t = ColorFlag::Shaded, hide_possible_values = true)]
    pub color: ColorFlag,
    /// Draw the edges of all triangles too
    #[arg(long)]
    pub wireframe: bool,
    /// Vertical field of view, degrees; a recorded path has its own
    #[arg(long, value_name = "DEG", default_value_t = 40.0, allow_negative_numbers = true, value_parser = field_of_view)]
    pub fov: f64,
    /// Draw without a window
    #[arg(long)]
    pub headless: bool,
    /// Path of the camera: around the scene, through it, or as recorded in the window
    #[arg(long, value_name = "orbit|fly|PATH.json", default_value = "orbit", value_parser = camera, requires = "headless")]
    pub camera: CameraFlag,
    /// Frames, spread evenly over the path of the camera
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000), requires = "headless")]
    pub frames: u32,
    /// How many rounds of the camera the frames are spread over: more is faster
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive, requires_all = ["headless", "frames"])]
    pub speed: f64,
    /// Draw only the nearest part, which is drawn first and hides the rest
    #[arg(long, requires = "headless")]
    pub only_occluders: bool,
    /// About so many occlusion queries a frame: more hide more and take longer [default: 1024, or 8192 where a look at the
    /// depth answers]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub queries: Option<u32>,
    /// Draw the polygons that occlusion queries ask about: red around what is hidden, blue around what may show
    #[arg(long)]
    pub show_questions: bool,
    /// Write a PNG picture of the last frame, or of each frame, if the name holds {#} for its number, padded with
    /// zeros; existing pictures are replaced
    #[arg(long, value_name = "OUT.png", requires = "headless")]
    pub screenshot: Option<PathBuf>,
    /// Write counts and times of all frames; stats that are there are replaced, other files are not
    #[arg(long, value_name = "OUT.json", requires = "headless")]
    pub stats: Option<PathBuf>,
    /// Form of errors and warnings: for people, or one JSON object a line
    #[arg(long, value_name = "human|json", default_value = "human")]
    pub message_format: MessageFormat,
    /// Show the files anew when they are replaced
    #[arg(long, conflicts_with = "headless")]
    pub watch: bool,
    /// For tests: lose the graphics device at each of the first N attempts to draw
    #[arg(long, value_name = "N", default_value_t = 0, hide = true)]
    pub lose_device: u32,
    /// For tests: run out of graphics memory at each of the first N attempts to draw
    #[arg(long, value_name = "N", default_value_t = 0, hide = true)]
    pub exhaust_memory: u32,
}

/// `--occlusion`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OcclusionFlag {
    /// By occlusion queries, or a look at the depth where a program draws and that is sooner done.
    Exact,
    /// By occlusion queries.
    Queries,
    /// Not at all.
    Off,
}

/// `--color`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColorFlag {
    /// Lit.
    Shaded,
    /// A colour for each cluster.
    Clusters,
    /// A colour for each distance.
    Depth,
    /// A colour for each size of clusters.
    Level,
}

/// `--camera`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraFlag {
    /// Around the scene.
    Orbit,
    /// Through the scene.
    Fly,
    /// Along a recorded path.
    Path(PathBuf),
}

/// The text of a usage error, or of help and version.
///
/// The library takes the placeholder of names for the end of a line, so that help has another sign in its place.
pub fn said(error: &clap::Error) -> String {
    error.render().to_string().replace("{#}", "{n}")
}

impl Cli {
    /// What a command line says; the first word is the program.
    ///
    /// # Errors
    /// One that makes no sense, flags among them that another one leaves nothing to do for; also for `--help` and
    /// `--version`.
    pub fn parsed<T: Into<OsString> + Clone>(words: impl IntoIterator<Item = T>) -> Result<Cli, clap::Error> {
        let mut command = Cli::command();
        let matches = command.try_get_matches_from_mut(words)?;
        let cli = Cli::from_arg_matches(&matches)?;
        let given = |flag: &str| matches.value_source(flag) == Some(ValueSource::CommandLine);
        let follows_path = matches!(cli.camera, CameraFlag::Path(_));
        let asks_nothing = cli.occlusion == OcclusionFlag::Off;
        for (flag, id, is_useless, why) in [
            ("--fov", "fov", follows_path, "a path of the camera, which has a field of view of its own"),
            ("--show-questions", "show_questions", asks_nothing, "--occlusion off, which asks none"),
            ("--queries", "queries", asks_nothing, "--occlusion off, which asks none"),
            ("--only-occluders", "only_occluders", asks_nothing, "--occlusion off, which looks for none"),
        ] {
            if is_useless && given(id) {
                let text = format!("the argument '{flag}' cannot be used with {why}");
                return Err(command.error(ErrorKind::ArgumentConflict, text));
            }
        }
        Ok(cli)
    }

    /// The copies to place at random, at least one of each file; `None` where each file stands as it is.
    pub fn copies(&self) -> Option<u32> {
        let files = u32::try_from(self.files.len()).unwrap_or(MAX_INSTANCES);
        self.instances.map(|count| count.max(files))
    }

    /// Vertical field of view, radians.
    pub fn field_of_view(&self) -> f64 {
        self.fov.to_radians()
    }

    /// How frames are drawn.
    pub fn frame_options(&self) -> FrameOptions {
        FrameOptions {
            size: self.size,
            samples: self.samples,
            detail: match self.triangles {
                _ if self.no_lod => Detail::Full,
                Some(triangles) => Detail::Triangles(triangles),
                None => Detail::Pixels(self.pixels),
            },
            frustum: !self.no_frustum,
            backface: !self.no_backface,
            two_sided: self.two_sided,
            occlusion: match self.occlusion {
                OcclusionFlag::Exact => Occlusion::Exact,
                OcclusionFlag::Queries => Occlusion::Queries,
                OcclusionFlag::Off => Occlusion::Off,
            },
            color: match self.color {
                ColorFlag::Shaded => ColorMode::Shaded,
                ColorFlag::Clusters => ColorMode::Clusters,
                ColorFlag::Depth => ColorMode::Depth,
                ColorFlag::Level => ColorMode::Level,
            },
            wireframe: self.wireframe,
            only_occluders: self.only_occluders,
            show_questions: self.show_questions,
            queries: self.queries.map(|queries| queries as usize),
            measure: self.headless,
            ..FrameOptions::default()
        }
    }
}

fn camera(text: &str) -> Result<CameraFlag, String> {
    match text {
        "orbit" => Ok(CameraFlag::Orbit),
        "fly" => Ok(CameraFlag::Fly),
        file if Path::new(file).extension().is_some_and(|extension| extension == "json") => {
            Ok(CameraFlag::Path(file.into()))
        }
        _ => Err("expected orbit, fly, or a file that ends in .json".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("expected a number above 0".to_owned()),
    }
}

fn bytes(text: &str) -> Result<u64, String> {
    Ok(text.parse::<Size>()?.bytes())
}

fn field_of_view(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (1.0..=170.0).contains(&number) => Ok(number),
        _ => Err("expected degrees from 1 to 170".to_owned()),
    }
}

fn samples(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "4" => Ok(4),
        _ => Err("expected 1 or 4".to_owned()),
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some([width, height]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("expected two numbers such as 1280x720".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parse(words: &str) -> Result<Cli, clap::Error> {
        Cli::parsed(std::iter::once("fcview").chain(words.split_whitespace()))
    }

    #[test]
    fn the_flags_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_flag_means_what_it_says() {
        let cli = parse(
            "a.fct b.fct --instances 7 --seed 9 --no-lod --no-frustum --no-backface --two-sided --occlusion off \
             --size 64x48 --samples 1 --color clusters --wireframe --fov 90 --headless --camera fly --frames 3 \
             --screenshot x{n}.png --stats s.json",
        )
        .unwrap();
        assert_eq!(cli.files.len(), 2);
        assert_eq!((cli.copies(), cli.seed, cli.frames), (Some(7), 9, 3));
        assert!((cli.field_of_view() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let expected = FrameOptions {
            size: [64, 48],
            samples: 1,
            detail: Detail::Full,
            frustum: false,
            backface: false,
            two_sided: true,
            occlusion: Occlusion::Off,
            color: ColorMode::Clusters,
            wireframe: true,
            measure: true,
            ..FrameOptions::default()
        };
        assert_eq!(cli.frame_options(), expected);
        let asking = parse("a.fct --show-questions --queries 99").unwrap().frame_options();
        assert!(asking.show_questions && asking.queries == Some(99));
        assert_eq!(cli.camera, CameraFlag::Fly);
        let recorded = parse("a.fct --headless --camera way.json").unwrap();
        assert_eq!(recorded.camera, CameraFlag::Path("way.json".into()));
        assert_eq!(parse("a.fct b.fct").unwrap().copies(), None);
        assert_eq!(parse("a.fct b.fct --instances 1").unwrap().copies(), Some(2));
        let triangles = parse("a.fct --triangles 7000").unwrap().frame_options().detail;
        assert_eq!(triangles, Detail::Triangles(7000));
        assert_eq!(parse("a.fct --fps 30").unwrap().fps, Some(30.0));
        for (size, bytes) in [("256M", 256 << 20), ("1.5GiB", 3 << 29), ("2kB", 2000), ("17", 17)] {
            assert_eq!(parse(&format!("a.fct --gpu-memory {size}")).unwrap().gpu_memory, Some(bytes));
        }
        assert_eq!(parse("a.fct").unwrap().gpu_memory, None);
        assert_eq!(parse("a.fct --pixels 2.5").unwrap().frame_options().detail, Detail::Pixels(2.5));
    }

    #[test]
    fn nonsense_is_a_usage_error() {
        for words in [
            "",
            "a.fct --pixels 0",
            "a.fct --pixels nan",
            "a.fct --pixels 2 --no-lod",
            "a.fct --size 0x5",
            "a.fct --size 64",
            "a.fct --fov 0",
            "a.fct --fov 180",
            "a.fct --samples 3",
            "a.fct --instances 1000001",
            "a.fct --instances -1",
            "a.fct --instances 0",
            "a.fct --headless --frames 0",
            "a.fct --screenshot x.png",
            "a.fct --occlusion maybe",
            "a.fct --headless --camera round",
            "a.fct --camera fly",
            "a.fct --headless --watch",
            "a.fct --triangles 0",
            "a.fct --triangles 9 --pixels 2",
            "a.fct --queries 0",
            "a.fct --gpu-memory 0",
            "a.fct --gpu-memory -1",
            "a.fct --gpu-memory lots",
            "a.fct --gpu-memory 1X",
            "a.fct --fps 0",
            "a.fct --fps 30 --triangles 9",
            // What would do nothing.
            "a.fct --seed 3",
            "a.fct --occlusion off --queries 9",
            "a.fct --occlusion off --show-questions",
            "a.fct --headless --occlusion off --only-occluders",
            "a.fct --headless --camera way.json --fov 90",
            "a.fct --headless --speed 2",
        ] {
            let error = parse(words).expect_err(words);
            assert_eq!(error.exit_code(), 2, "{words}");
        }
        let error = parse("a.fct --headless --camera way.json --fov 90").unwrap_err().to_string();
        assert!(error.contains("'--fov'") && error.contains("a path of the camera"), "{error}");
    }
}
