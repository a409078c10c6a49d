//! `cargo xtask bench extract`: what a mesh for a view takes, and how many triangles it needs beside cluster LOD.

use std::error::Error;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use fct::Tree;

use super::builder::Builder;
use super::input::{Input, paths};
use super::ledger::{self, Entry};
use super::peers::ClusterLod;
use super::process::median;
use super::screen::{Compared, compare};
use super::speed::{Speed, cases, time};
use super::table::{Table, three};
use super::targets;
use super::walk::{JUMP, Walk, walks};
use crate::figures::plot::{Plot, Scale, Series};

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench extract                            the sample meshes
  cargo xtask bench extract --scans ~/stanford         and bunny, armadillo and dragon
  cargo xtask bench extract --no-screen dragon.ply     the times alone
  cargo xtask bench extract --plot jump.svg bunny.ply  and a plot of the walks
  cargo xtask bench extract --append my-laptop         keep the figures

Times are nanoseconds a triangle for an extraction from scratch into memory that is there already,
the least and the median of the runs; one and two threads take turns. A walk leads around a field of
100 instances at 1 pixel, culled by view and direction, in steps and in jumps of 100 steps.
Beside cluster LOD, both meshes are as far from the surface at most, in pixels of a picture of
1280 x 720, over all samples and vertices and a few views.

It fails when an answer is wrong: two threads that draw another mesh than one, or a cut that is
farther off than its pixels. A figure that is only missed is marked.";

/// Pixels that selections allow where triangles are compared.
const SCREEN: [f64; 2] = [4.0, 1.0];

/// What `cargo xtask bench extract` is told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Meshes [default: the samples in data/, and the scans of --scans]
    #[arg(value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// How fcbuild splits [default: as fcbuild does by itself]
    #[arg(long, value_name = "MODE")]
    split: Option<String>,
    /// Runs of each extraction
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=999))]
    runs: u32,
    /// Leave cluster LOD out, which takes longest
    #[arg(long)]
    no_screen: bool,
    /// Leave the walks out
    #[arg(long)]
    no_walk: bool,
    /// Plot the last mesh's walks as SVG
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// A fcbuild to build with [default: that of this workspace, built first]
    #[arg(long, value_name = "PROGRAM")]
    fcbuild: Option<PathBuf>,
    /// Append the figures to docs/benchmarks/MACHINE/DATE.csv
    #[arg(long, value_name = "MACHINE")]
    append: Option<String>,
}

/// The tables and the rows to keep.
struct Found {
    speeds: Table,
    walks: Table,
    screens: Table,
    entries: Vec<Entry>,
    wrong: Vec<String>,
}

/// Measures and prints.
///
/// # Errors
/// When something cannot be run, or an answer is wrong.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let builder = Builder::new(args.fcbuild.as_deref(), args.split.as_deref())?;
    let mut found = Found {
        speeds: Table::new(&[
            "mesh",
            "selection",
            "triangles",
            "ns 1 thread",
            "median",
            "ns 2 threads",
            "median",
            "gain",
            "",
        ]),
        walks: Table::new(&["mesh", "walk", "frames", "triangles a frame", "ns a triangle", "ratio", ""]),
        screens: Table::new(&[
            "mesh",
            "pixels",
            "pixels off",
            "triangles",
            "cluster LOD's off",
            "its triangles",
            "ratio",
            "ns of its cut",
            "",
        ]),
        entries: Vec::new(),
        wrong: Vec::new(),
    };
    for path in paths(&args.meshes, args.scans.as_deref())? {
        measure(&path, args, &builder, &mut found)?;
    }
    let mut out = std::io::stdout().lock();
    writeln!(out, "\nnanoseconds a triangle, least and median of {} runs\n", args.runs)?;
    found.speeds.print(&mut out)?;
    found.walks.print(&mut out)?;
    found.screens.print(&mut out)?;
    if let Some(machine) = &args.append {
        writeln!(out, "appended to {}", ledger::append(machine, &found.entries)?.display())?;
    }
    if found.wrong.is_empty() {
        return Ok(());
    }
    Err(format!("wrong answers:\n  {}", found.wrong.join("\n  ")).into())
}

fn measure(path: &Path, args: &Args, builder: &Builder, found: &mut Found) -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("tree.fct");
    eprintln!("{}: building", path.display());
    builder.run_outwards(path, &file)?;
    let tree = Tree::open(&file)?;
    let input = Input::read(path, tree.meta().origin)?;
    for case in cases(&tree) {
        eprintln!("{}: {}", input.name, case.name);
        let speed = time(&tree, &case, args.runs)?;
        found.speed(&input, &case.name, &speed, args.runs);
    }
    if !args.no_walk {
        eprintln!("{}: walks", input.name);
        let walks = walks(&tree, args.runs.div_ceil(5))?;
        found.walk(&input, &walks);
        if let Some(path) = &args.plot {
            std::fs::write(path, plot(&input.name, &walks).to_svg())?;
        }
    }
    if !args.no_screen {
        let lod = ClusterLod::build(&input.mesh);
        for pixels in SCREEN {
            eprintln!("{}: {pixels} pixels beside cluster LOD", input.name);
            let compared = compare(&tree, &input.mesh, &lod, pixels)?;
            found.screen(&input, &compared);
        }
    }
    Ok(())
}

impl Found {
    fn keep(
        &mut self,
        what: &str,
        input: &Input,
        setting: &str,
        value: String,
        unit: &'static str,
        how: &str,
    ) {
        self.entries.push(Entry {
            what: what.to_owned(),
            input: format!("{} ({} faces)", input.name, input.mesh.faces.len()),
            setting: setting.to_owned(),
            value,
            unit,
            how: format!("cargo xtask bench extract; {how}"),
        });
    }

    fn speed(&mut self, input: &Input, case: &str, speed: &Speed, runs: u32) {
        // Small cuts are over before a thread is awake, and their first memory is a large part.
        let judged = input.mesh.faces.len() >= targets::LARGE && speed.triangles >= 200_000;
        let mut missed = Vec::new();
        if judged && speed.one[0] > targets::EXTRACTION {
            missed.push(format!("> {} ns", targets::EXTRACTION));
        }
        if judged && speed.gain() < targets::GAIN {
            missed.push(format!("gain < {}", targets::GAIN));
        }
        let [one, two] = [speed.one, speed.two].map(|t| t.map(three));
        let [[a, b], [c, d]] = [&one, &two];
        let cells = [
            &input.name,
            case,
            &speed.triangles.to_string(),
            a,
            b,
            c,
            d,
            &three(speed.gain()),
            &missed.join(", "),
        ];
        self.speeds.row(cells.map(|c| (*c).to_owned()).to_vec());
        let value = format!("{a} : {b} : {c} : {d}");
        let how = format!("{} triangles; least and median of {runs} runs in turns", speed.triangles);
        self.keep(
            "extraction, least : median on 1 thread : least : median on 2",
            input,
            case,
            value,
            "ns/triangle",
            &how,
        );
    }

    fn walk(&mut self, input: &Input, walks: &[Walk; 2]) {
        let ratio = walks[1].per_triangle() / walks[0].per_triangle();
        for walk in walks {
            let jumps = walk.speed > 1;
            let mut missed = Vec::new();
            if jumps && ratio > targets::JUMP {
                missed.push(format!("ratio > {}", targets::JUMP));
            }
            if walk.per_triangle() > targets::FRAME {
                missed.push(format!("> {} ns", targets::FRAME));
            }
            self.walks.row(vec![
                input.name.clone(),
                format!("{} x", walk.speed),
                walk.frames.len().to_string(),
                format!("{:.0}", walk.triangles()),
                three(walk.per_triangle()),
                if jumps { three(ratio) } else { String::new() },
                missed.join(", "),
            ]);
        }
        let [slow, fast] = walks.each_ref().map(|w| three(w.per_triangle()));
        let how = format!(
            "100 instances at 1 pixel, 1280 x 720, culled; {:.0} triangles a frame",
            walks[0].triangles()
        );
        self.keep(
            "walk, in steps : in jumps",
            input,
            &format!("1 x : {JUMP} x"),
            format!("{slow} : {fast}"),
            "ns/triangle",
            &how,
        );
    }

    fn screen(&mut self, input: &Input, compared: &Compared) {
        let [ours, theirs] = compared.error;
        if ours > compared.pixels {
            self.wrong
                .push(format!("{}: {ours} pixels off where {} are allowed", input.name, compared.pixels));
        }
        let missed = if compared.ratio() > targets::SCREEN {
            format!("ratio > {}", targets::SCREEN)
        } else {
            String::new()
        };
        let [a, b] = compared.triangles.map(|n| n.to_string());
        self.screens.row(vec![
            input.name.clone(),
            three(compared.pixels),
            three(ours),
            a.clone(),
            three(theirs),
            b.clone(),
            three(compared.ratio()),
            three(compared.peer_cut),
            missed,
        ]);
        let how = format!(
            "{} and {} pixels off, over 3 views; finding the peer's cut takes {} ns a triangle",
            three(ours),
            three(theirs),
            three(compared.peer_cut)
        );
        self.keep(
            "triangles for the same error on the screen : cluster LOD's",
            input,
            &format!("{} pixels", compared.pixels),
            format!("{a} : {b}"),
            "triangles",
            &how,
        );
    }
}

/// Times of frames over their triangles, tenfold medians: what else the machine did in a single frame is not shown.
fn plot(name: &str, walks: &[Walk; 2]) -> Plot {
    let series = |walk: &Walk, color, dashes| {
        let mut points: Vec<(f64, f64)> = walk.frames.iter().map(|(n, ns)| (*n as f64, ns * 1e-6)).collect();
        points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let middle = |run: &[(f64, f64)]| {
            let time = median(run.iter().map(|p| p.1)).unwrap_or(f64::NAN);
            (run.iter().map(|p| p.0).sum::<f64>() / run.len().max(1) as f64, time)
        };
        let points = points.chunks(10).map(middle).collect();
        Series { name: format!("{} x", walk.speed), color, dashes, dots: false, points }
    };
    Plot {
        title: format!("A walk through 100 instances of {name}"),
        x_label: "triangles of a frame".to_owned(),
        y_label: "milliseconds of a frame".to_owned(),
        x_scale: Scale::Logarithmic,
        series: vec![series(&walks[0], "#1f6fb4", ""), series(&walks[1], "#c8502a", "5 3")],
    }
}
