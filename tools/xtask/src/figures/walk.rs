//! A walk through a hundred copies of a model: what level of detail and culling save, and what a jump costs.
//!
//! Drawn by the program `fcview`, as its users run it: this needs a graphics driver, and its times are the machine's.
//!
//! # Paper
//! `[Tsuji07]` figures 7, 8, 13, 14 and 15, and section 6.3.

use super::output::Output;
use super::page::{Panel, panels, table, three, verdict, whole};
use super::plot::{Plot, Scale, Series};
use fcbuild::import::{ImportOptions, import};
use fcbuild::{BuildOptions, Prepared};
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Copies of the model, as in the paper.
const COPIES: &str = "100";

/// Frames of a walk. No factor of a hundred, so that the walk at 100 x speed comes by the same places in another order.
const FRAMES: usize = 61;

/// A walk with some of the methods.
struct Way {
    name: &'static str,
    flags: &'static [&'static str],
    color: &'static str,
    dashes: &'static str,
}

const WAYS: [Way; 4] = [
    Way { name: "both", flags: &[], color: "#c22", dashes: "" },
    Way {
        name: "detail alone",
        flags: &["--no-frustum", "--no-backface", "--occlusion", "off"],
        color: "#27a",
        dashes: "7 4",
    },
    Way { name: "culling alone", flags: &["--no-lod"], color: "#293", dashes: "2 3" },
    Way {
        name: "neither",
        flags: &["--no-lod", "--no-frustum", "--no-backface", "--occlusion", "off"],
        color: "#555",
        dashes: "9 3 2 3",
    },
];

/// What a frame took and drew.
#[derive(Clone, Copy, Debug)]
struct Frame {
    milliseconds: f64,
    triangles: f64,
    cut: f64,
    /// Upload and queries.
    overhead: f64,
}

/// Measures the walk of a mesh file and writes plots, pictures and the table of all frames. Returns the page about them.
///
/// # Errors
/// Those of the builder, and what cargo or `fcview` say when they fail.
pub(crate) fn page(mesh: &Path, out: &Output) -> Result<String, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let tree = folder.path().join("model.fct");
    let mut soup = import(mesh, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} })?;
    let options = BuildOptions::default();
    let mut prepared = Prepared::new(soup.clone(), &options)?;
    // The viewer leaves out back faces, and would show the inside of a scan with the wrong winding.
    let turned = prepared.looks_inwards();
    if turned {
        soup.flip();
        prepared = Prepared::new(soup, &options)?;
    }
    let built = prepared.build(&options)?;
    fct::write(&tree, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 })?;
    let name = mesh.file_stem().map_or_else(|| "mesh".into(), |s| s.to_string_lossy()).into_owned();
    let viewer = Viewer { program: viewer()?, tree, stats: folder.path().join("stats.json") };

    let mut walks = Vec::new();
    let mut adapter = String::new();
    for way in &WAYS {
        eprintln!("walking through {COPIES} copies of {name}: {}", way.name);
        let document = viewer.walk(way.flags)?;
        adapter = text(&document["adapter"]["name"]);
        walks.push(frames(&document)?);
    }
    eprintln!("walking at 100 x speed");
    let fast = frames(&viewer.walk(&["--speed", "100"])?)?;
    let again = frames(&viewer.walk(&[])?)?;
    viewer.pictures(out)?;

    out.write("walk.csv", csv(&walks, &fast).as_bytes())?;
    let plot = |file: &str, y_label: &str, value: &dyn Fn(&Frame) -> f64| {
        let series = WAYS.iter().zip(&walks).map(|(way, walk)| Series {
            name: way.name.to_owned(),
            color: way.color,
            dashes: way.dashes,
            dots: false,
            points: walk.iter().zip(1..).map(|(frame, number)| (f64::from(number), value(frame))).collect(),
        });
        let plot = Plot {
            title: format!("{COPIES} copies of {name}, 1280x720, one pixel"),
            x_label: "frame of the walk".to_owned(),
            y_label: y_label.to_owned(),
            x_scale: Scale::Linear,
            series: series.collect(),
        };
        out.write(file, plot.to_svg().as_bytes())
    };
    plot("walk-time.svg", "milliseconds a frame", &|frame| frame.milliseconds)?;
    plot("walk-triangles.svg", "triangles drawn", &|frame| frame.triangles)?;
    let speed = |name: &str, color, walk: &[Frame]| Series {
        name: name.to_owned(),
        color,
        dashes: "",
        dots: true,
        points: walk.iter().map(|frame| (frame.triangles, frame.milliseconds)).collect(),
    };
    let plot = Plot {
        title: "Both methods at two speeds".to_owned(),
        x_label: "triangles drawn".to_owned(),
        y_label: "milliseconds a frame".to_owned(),
        x_scale: Scale::Linear,
        series: vec![speed("1 x", "#27a", &again), speed("100 x", "#c22", &fast)],
    };
    out.write("walk-speed.svg", plot.to_svg().as_bytes())?;
    Ok(report(&name, turned, &adapter, &walks, &fast, &again))
}

/// `fcview`, and the files that it reads and writes.
struct Viewer {
    program: PathBuf,
    tree: PathBuf,
    stats: PathBuf,
}

impl Viewer {
    fn run(&self, words: &[&str]) -> Result<(), Box<dyn Error>> {
        let mut command = Command::new(&self.program);
        command.arg(&self.tree).args(["--headless", "--instances", COPIES, "--camera", "fly"]).args(words);
        let done = command.stdin(Stdio::null()).output()?;
        if done.status.success() {
            return Ok(());
        }
        Err(format!("fcview: {}", String::from_utf8_lossy(&done.stderr).trim()).into())
    }

    /// The stats of a walk.
    fn walk(&self, flags: &[&str]) -> Result<serde_json::Value, Box<dyn Error>> {
        let frames = FRAMES.to_string();
        let stats = self.stats.to_str().ok_or("the temporary folder's name is no Unicode")?;
        let mut words = vec!["--samples", "1", "--frames", &frames, "--stats", stats];
        words.extend(flags);
        self.run(&words)?;
        Ok(serde_json::from_str(&std::fs::read_to_string(&self.stats)?)?)
    }

    /// Pictures from where the walk begins.
    fn pictures(&self, out: &Output) -> Result<(), Box<dyn Error>> {
        let picture = self.stats.with_file_name("picture.png");
        for (file, flags) in [
            ("walk.png", &[] as &[&str]),
            ("walk-occluders.png", &["--only-occluders"]),
            ("walk-level.png", &["--color", "level"]),
            // Whole copies and large pieces: more would cover the picture.
            ("walk-questions.png", &["--show-questions", "--queries", "16"]),
        ] {
            let target = picture.to_str().ok_or("the temporary folder's name is no Unicode")?;
            let mut words = vec!["--size", "640x360", "--screenshot", target];
            words.extend(flags);
            self.run(&words)?;
            out.write(file, &std::fs::read(&picture)?)?;
        }
        Ok(())
    }
}

/// The program of this workspace, beside the folder of the one that runs now, built first.
fn viewer() -> Result<PathBuf, Box<dyn Error>> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    cargo.args(["build", "--release", "--quiet", "--package", "fcview"]);
    if !cargo.status()?.success() {
        return Err("cargo could not build fcview; see above".into());
    }
    let own = std::env::current_exe()?;
    let target = own.parent().and_then(Path::parent).ok_or("this program lies in no folder of cargo's")?;
    Ok(target.join("release").join(format!("fcview{}", std::env::consts::EXE_SUFFIX)))
}

fn text(value: &serde_json::Value) -> String {
    value.as_str().unwrap_or("an unknown adapter").to_owned()
}

/// The frames of a stats document; the first, which fills buffers, is left out.
fn frames(document: &serde_json::Value) -> Result<Vec<Frame>, Box<dyn Error>> {
    let frames = document["frames"].as_array().ok_or("the stats have no frames")?;
    let read = |frame: &serde_json::Value| -> Option<Frame> {
        let times = &frame["milliseconds"];
        Some(Frame {
            milliseconds: times["total"].as_f64()?,
            triangles: frame["counts"]["triangles_drawn"].as_f64()?,
            cut: times["cut"].as_f64()?,
            overhead: times["upload"].as_f64()? + times["queries"].as_f64()?,
        })
    };
    let frames: Option<Vec<Frame>> = frames.iter().skip(1).map(read).collect();
    Ok(frames.ok_or("a frame's stats lack a member")?)
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn csv(walks: &[Vec<Frame>], fast: &[Frame]) -> String {
    let mut out = String::from("walk,frame,milliseconds,triangles,cut_ms,queries_and_upload_ms\n");
    let all = WAYS.iter().map(|way| way.name).zip(walks.iter().map(Vec::as_slice));
    for (name, walk) in all.chain(std::iter::once(("both at 100 x", fast))) {
        for (frame, number) in walk.iter().zip(1..) {
            let Frame { milliseconds, triangles, cut, overhead } = frame;
            let _ = writeln!(out, "{name},{number},{milliseconds:.3},{triangles},{cut:.3},{overhead:.3}");
        }
    }
    out
}

fn report(
    name: &str,
    turned: bool,
    adapter: &str,
    walks: &[Vec<Frame>],
    fast: &[Frame],
    again: &[Frame],
) -> String {
    let time = |walk: &[Frame]| median(walk.iter().map(|frame| frame.milliseconds));
    let per_triangle =
        |walk: &[Frame]| median(walk.iter().map(|frame| 1e6 * frame.milliseconds / frame.triangles));
    let mut text = format!(
        "# A walk through {COPIES} copies ([Tsuji07] fig. 7, 8, 13, 14 and 15, and 6.3)\n\n\
         `fcview --instances {COPIES} --camera fly` at one pixel, 1280x720, one sample a pixel, {FRAMES} frames, the first left out, drawn by {adapter} on {} with {} threads.\n\
         The times are this machine's, and other programs may have run beside; every frame is in [a table](walk.csv).\n\
         The README quotes the same walk from [the measurements](../benchmarks/README.md), in fewer frames and another run: ratios compare, milliseconds do not.\n\
         {}\
         The pictures show where the walk begins.\n\n",
        std::env::consts::ARCH,
        std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        if turned {
            format!(
                "The faces of the {name} look inwards in its file and are turned over, as by `fcbuild --flip`.\n"
            )
        } else {
            String::new()
        },
    );
    let panel = |file: &str, alt: &str, caption: &str| Panel {
        file: file.to_owned(),
        alt: alt.to_owned(),
        caption: caption.to_owned(),
    };
    text += &panels(
        &[
            panel(
                "walk-occluders.png",
                "Some copies, in part",
                "the nearest third, which hides much of the rest (fig. 7)",
            ),
            panel("walk.png", "All copies in view", "the whole frame (fig. 15)"),
            panel(
                "walk-questions.png",
                "The same with outlines in red and blue",
                "what occlusion culling asks about, with few questions: red was found hidden, blue may show (fig. 8)",
            ),
            panel(
                "walk-level.png",
                "The same, coloured by the size of clusters",
                "sizes of clusters: blue for single faces, warmer for each doubling",
            ),
        ],
        2,
    );
    text.push('\n');
    text += &panels(
        &[
            panel("walk-time.svg", "Time of each frame", "time a frame (fig. 13)"),
            panel("walk-triangles.svg", "Triangles of each frame", "triangles a frame (fig. 14)"),
            panel(
                "walk-speed.svg",
                "Time against triangles at two speeds",
                "time against triangles, at 1 x and at 100 x speed (6.3)",
            ),
        ],
        2,
    );
    let both = time(walks.first().map_or(&[], Vec::as_slice));
    let rows: Vec<Vec<String>> = WAYS
        .iter()
        .zip(walks)
        .map(|(way, walk)| {
            let triangles = median(walk.iter().map(|frame| frame.triangles));
            vec![
                way.name.to_owned(),
                three(time(walk)),
                three(time(walk) / both),
                whole(triangles as usize),
                three(median(walk.iter().map(|frame| frame.cut))),
                three(median(walk.iter().map(|frame| frame.overhead))),
            ]
        })
        .collect();
    let head = [
        "medians over the walk",
        "ms a frame",
        "over both",
        "triangles",
        "ms to choose and cut",
        "ms for queries and upload",
    ];
    let _ = write!(text, "\n{}\n", table(&head, &rows));
    let ratio = |k: usize| walks.get(k).map_or(f64::NAN, |walk| time(walk) / both);
    let jump = per_triangle(fast) / per_triangle(again);
    let _ = writeln!(
        text,
        "- Level of detail and culling together are faster than either alone, and than neither.\n  {}\n  \
         Full resolution of {name} without culling takes {} times as long as both, detail alone {} times, culling alone {} times.\n  \
         Detail alone cuts what lies behind the eye and what faces away too, anew in each frame; full resolution is cut once for all frames.\n\
         - A walk at 100 times the speed takes as long for a triangle as a slow one, because nothing is taken over from the last frame.\n  {}\n  \
         It takes {} times as long; both walks come by the same {FRAMES} places, in another order.",
        verdict((1..4).all(|k| ratio(k) > 1.0)),
        three(ratio(3)),
        three(ratio(1)),
        three(ratio(2)),
        verdict(jump <= 1.1),
        three(jump),
    );
    text
}
