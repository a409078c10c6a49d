//! The command line: flags typed by clap, then what they mean.

mod values;

use crate::error::Error;
use crate::export::{Ball, Detail, Format, Output, Scale, Settings};
use clap::{Args, Parser, Subcommand};
use fcextract::Budget;
use fct::{MessageFormat, Progress, ProgressForm, ShowProgress};
use std::path::PathBuf;
use std::sync::Arc;
use values::{ball, clusters, field_of_view, height, length, point, positive, square, triangles};

const EXAMPLES: &str = "\
Examples:
  fct info dragon.fct                                    what the file says about itself
  fct verify dragon.fct                                  check every byte and every rule
  fct export dragon.fct -o full.ply                      the input's faces
  fct export dragon.fct -o small.glb --triangles 5000    at most 5,000 triangles

Exit codes: 0 done, 1 our bug, 2 usage, 4 input or output, 5 a limit, 7 invalid
.fct file, 129, 130, 131, 143 or 152 stopped by a signal.";

const INFO_EXAMPLES: &str = "\
Examples:
  fct info dragon.fct
  fct info dragon.fct --json | jq .counts.faces

The file's header, table and description are checked, the rest is not: see
`fct verify`.

Exit codes: 0 done, 1 our bug, 2 usage, 4 input or output, 7 invalid .fct file.";

const VERIFY_EXAMPLES: &str = "\
Examples:
  fct verify dragon.fct
  fct verify dragon.fct --json

With --json the result goes to standard output as JSON, also when the file is
invalid.

Exit codes: 0 every rule holds, 1 our bug, 2 usage, 4 input or output, 5 a
limit, 7 invalid .fct file, 129, 130, 131, 143 or 152 stopped by a signal.";

// The sign {#} is printed as {n}, which the library would take for the end of a line.
const EXPORT_EXAMPLES: &str = "\
Examples:
  The input's faces:
    fct export dragon.fct -o full.ply
  A guaranteed error of at most 0.0005, or 0.2 % of the diagonal of the box:
    fct export dragon.fct -o near.ply --error 0.0005
    fct export dragon.fct -o nearer.ply --error 0.2%
  At most 5,000 triangles:
    fct export dragon.fct -o small.obj --triangles 5000
  A chain of levels of detail, lod_50000.glb and so on:
    fct export dragon.fct -o 'lod_{#}.glb' --triangles 50000,10000,2000
  At most 250 clusters:
    fct export dragon.fct -o coarse.ply --clusters 250
  An error of at most a pixel in a picture from there:
    fct export dragon.fct -o view.ply --eye 0,0.1,0.6 --pixels 1 --fov 40 --height 1080
  The 5,000 triangles that show most from there:
    fct export dragon.fct -o seen.ply --eye 0,0.1,0.6 --triangles 5000
  An error of a pixel in a picture 0.25 high, without perspective:
    fct export dragon.fct -o plan.ply --ortho 0.25 --pixels 1 --height 1080
  0.0002 in a ball of radius 0.05, elsewhere 0.01:
    fct export dragon.fct -o head.ply --error 0.01 --region -0.08,0.15,0,0.05=0.0002
  Only vertices of the input, as a part of their own:
    fct export dragon.fct -o subset.ply --error 0.001 --in-place
  A mean square distance of at most 1e-9:
    fct export dragon.fct -o flat.ply --epsilon 1e-9

Lengths and places are in the unit of the input; `fct info` shows the model's
box. A number of triangles is met exactly or missed by up to four. The bound
that is printed is the largest among the clusters. --error, --eye and --ortho
choose clusters by it; --triangles and --clusters spend their budget by the mean
error, and --epsilon holds the mean error, so that their bound is loose. All but
--epsilon draw vertices a little beside their places, nearer to the surface,
and --error, --eye and --ortho only as far as the bound allows.

The hashes of the whole file are checked first, and nothing is made of damaged
bytes; `fct verify` checks every rule besides.

--force replaces meshes that fct has written; any other file stays.

Exit codes: 0 done, 1 our bug, 2 usage, 4 input or output, 5 a limit, 7 invalid
.fct file, 129, 130, 131, 143 or 152 stopped by a signal. On any but 0
nothing is written, unless all that fails is standard output or a signal comes
when the meshes are complete.";

/// The text of a usage error, or of help and version.
pub(crate) fn said(error: &clap::Error) -> String {
    error.render().to_string().replace("{#}", NUMBER)
}

/// Looks into, verifies and exports face-cluster trees (.fct).
#[derive(Debug, Parser)]
#[command(name = "fct", version, about, after_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Flags {
    /// Form of errors and warnings: for people, or one JSON object a line
    #[arg(long, global = true, value_name = "human|json", default_value = "human")]
    pub(crate) message_format: MessageFormat,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Print what a file says about itself
    #[command(after_help = INFO_EXAMPLES)]
    Info(FileFlags),
    /// Check every byte and every rule of a file
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify(VerifyFlags),
    /// Write a mesh of a chosen detail as PLY, OBJ or GLB
    #[command(after_help = EXPORT_EXAMPLES)]
    Export(Box<ExportFlags>),
}

/// Flags of `info` and `verify`.
#[derive(Debug, Args)]
pub(crate) struct FileFlags {
    /// A tree made by fcbuild
    #[arg(value_name = "FILE.fct")]
    pub(crate) file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags of `verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyFlags {
    #[command(flatten)]
    pub(crate) of_file: FileFlags,
    #[command(flatten)]
    pub(crate) of_progress: ProgressFlags,
}

/// Flags of what takes long.
#[derive(Debug, Args)]
pub(crate) struct ProgressFlags {
    /// Show progress: on a terminal (auto), always, or never
    #[arg(long, value_name = "auto|always|never", default_value = "auto")]
    progress: ShowProgress,
}

impl ProgressFlags {
    /// What shows how far the job is.
    pub(crate) fn shown(&self, format: MessageFormat) -> Arc<Progress> {
        Arc::new(Progress::new(ProgressForm::here(self.progress, format == MessageFormat::Json)))
    }
}

/// Flags of `export`.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("detail").args(["error", "epsilon", "triangles", "clusters", "ortho"]))]
#[command(group = clap::ArgGroup::new("view").args(["eye", "ortho"]))]
#[command(group = clap::ArgGroup::new("budget").args(["triangles", "clusters"]))]
#[command(group = clap::ArgGroup::new("tolerance").args(["error", "epsilon", "eye", "ortho"]).multiple(true))]
pub(crate) struct ExportFlags {
    /// A tree made by fcbuild
    #[arg(value_name = "FILE.fct")]
    file: PathBuf,
    /// The mesh to write: binary PLY, OBJ or binary glTF, by the extension; {#} in the name is the number of triangles or
    /// clusters asked for
    #[arg(short, long, value_name = "OUT.(ply|obj|glb)")]
    output: PathBuf,
    /// Print what was written as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Replace existing outputs, if they are meshes that fct has written
    #[arg(long)]
    force: bool,
    /// No point of the surface is farther than this from the mesh: the flag for a tight guarantee; with % it is a part of the diagonal of the model's box
    #[arg(long, value_name = "DIST|P%", value_parser = length, allow_negative_numbers = true, conflicts_with = "eye")]
    error: Option<Scale>,
    /// A mean square distance of at most K from each cluster's plane; with --eye, K times the squared distance from there
    #[arg(long, value_name = "K", value_parser = square, allow_negative_numbers = true)]
    epsilon: Option<f64>,
    /// At most so many triangles, with a low mean error and a loose bound; several numbers for several meshes
    #[arg(long, value_name = "N[,N...]", value_parser = triangles, value_delimiter = ',', allow_negative_numbers = true)]
    triangles: Vec<u64>,
    /// At most so many clusters, with a low mean error and a loose bound; several numbers for several meshes
    #[arg(long, value_name = "N[,N...]", value_parser = clusters, value_delimiter = ',', allow_negative_numbers = true)]
    clusters: Vec<u64>,
    /// Detail for a picture from this point, all around it
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<[f64; 3]>,
    /// Detail for a picture without perspective that is so high, in the unit of the input
    #[arg(long, value_name = "SIZE", value_parser = positive, allow_negative_numbers = true)]
    ortho: Option<f64>,
    /// Error in the middle of the picture, pixels
    #[arg(long, value_name = "P", default_value_t = 1.0, value_parser = positive, requires = "view", conflicts_with_all = ["budget", "epsilon"], allow_negative_numbers = true)]
    pixels: f64,
    /// Vertical field of view of the picture, degrees
    #[arg(long, value_name = "DEG", default_value_t = 40.0, value_parser = field_of_view, requires = "eye", conflicts_with_all = ["budget", "epsilon", "ortho"], allow_negative_numbers = true)]
    fov: f64,
    /// Height of the picture, pixels
    #[arg(long, value_name = "PX", default_value_t = 720, value_parser = height, requires = "view", conflicts_with_all = ["budget", "epsilon"], allow_negative_numbers = true)]
    height: u32,
    /// An error of its own in a ball, finer or coarser than elsewhere; where several overlap, the smallest holds
    #[arg(long, value_name = "X,Y,Z,R=DIST", value_parser = ball, requires = "tolerance", conflicts_with = "budget", allow_hyphen_values = true)]
    region: Vec<Ball>,
    /// Draw vertices at their places in the input, not beside them where that is nearer to the surface; --epsilon always does
    #[arg(long, conflicts_with = "epsilon")]
    in_place: bool,
    /// Also measure how far surface and mesh are apart, in the mean and at the most, by samples of both
    #[arg(long)]
    measure: bool,
    #[command(flatten)]
    pub(crate) of_progress: ProgressFlags,
}

impl ExportFlags {
    /// What is meant.
    ///
    /// # Errors
    /// Usage when the extension of the output names no format, or when the outputs' names do not fit their number.
    pub(crate) fn settings(&self) -> Result<Settings, Error> {
        let extension = self.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match extension.as_deref() {
            Some("ply") => Format::Ply,
            Some("obj") => Format::Obj,
            Some("glb") => Format::Glb,
            _ => {
                return Err(Error::Usage(format!(
                    "{}: the extension tells the format; give it .ply, .obj or .glb",
                    self.output.display()
                )));
            }
        };
        let triangles = self.triangles.iter().map(|n| Budget::Triangles(*n));
        let budgets: Vec<Budget> =
            triangles.chain(self.clusters.iter().map(|n| Budget::Clusters(*n))).collect();
        let scale = |distance: f64, slope: f64| match self.eye {
            Some(eye) => Scale::Eye { eye, slope },
            None => Scale::Length(distance),
        };
        // An error of p pixels in a picture h pixels high is p 2 tan(fov / 2) / h at distance 1.
        let slope = self.pixels * 2.0 * (0.5 * self.fov.to_radians()).tan() / f64::from(self.height);
        let detail = if !budgets.is_empty() {
            Detail::Budgets(budgets.clone(), self.eye)
        } else if let Some(length) = self.error {
            Detail::Within(length)
        } else if let Some(k) = self.epsilon {
            Detail::Epsilon(scale(k.sqrt(), k.sqrt()))
        } else if let Some(size) = self.ortho {
            Detail::Within(Scale::Length(self.pixels * size / f64::from(self.height)))
        } else if self.eye.is_some() {
            Detail::Within(scale(0.0, slope))
        } else {
            Detail::Full
        };
        Ok(Settings {
            input: self.file.clone(),
            outputs: self.outputs(&budgets)?,
            force: self.force,
            format,
            detail,
            regions: self.region.clone(),
            in_place: self.in_place,
            measure: self.measure,
        })
    }

    /// A file for each budget.
    fn outputs(&self, budgets: &[Budget]) -> Result<Vec<Output>, Error> {
        let name = self.output.file_name().unwrap_or_default();
        let has_number = name.to_string_lossy().contains(NUMBER);
        let usage = |what: &str| Err(Error::Usage(format!("{}: {what}", self.output.display())));
        let Some((first, others)) = budgets.split_first() else {
            if has_number {
                return usage("{n} is the number of --triangles or --clusters; give one, or another name");
            }
            return Ok(vec![Output { path: self.output.clone(), budget: None }]);
        };
        if !has_number {
            if !others.is_empty() {
                return usage("several meshes need several names; put {n}, their number, into it");
            }
            return Ok(vec![Output { path: self.output.clone(), budget: Some(*first) }]);
        }
        let mut outputs: Vec<Output> = Vec::new();
        for budget in budgets {
            let (Budget::Triangles(n) | Budget::Clusters(n)) = budget;
            let Some(name) = name.to_str() else { return usage("with {n} a name has to be UTF-8") };
            let path = self.output.with_file_name(name.replace(NUMBER, &n.to_string()));
            if outputs.iter().any(|output| output.path == path) {
                return usage(&format!("the number {n} is asked for twice; give each once"));
            }
            outputs.push(Output { path, budget: Some(*budget) });
        }
        Ok(outputs)
    }
}

/// What stands for the number in an output's name.
const NUMBER: &str = "{n}";

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parse(words: &str) -> Result<Flags, clap::Error> {
        Flags::try_parse_from(std::iter::once("fct").chain(words.split_whitespace()))
    }

    fn export(words: &str) -> Settings {
        match parse(words).unwrap().command {
            Command::Export(flags) => flags.settings().unwrap(),
            _ => panic!("{words} is no export"),
        }
    }

    #[test]
    fn the_flags_are_consistent() {
        Flags::command().debug_assert();
    }

    #[test]
    fn every_detail_means_what_it_says() {
        let detail = |flags: &str| export(&format!("export a.fct -o b.obj {flags}")).detail;
        assert_eq!(detail(""), Detail::Full);
        assert_eq!(detail("--error 0.5"), Detail::Within(Scale::Length(0.5)));
        assert_eq!(detail("--error 25%"), Detail::Within(Scale::Diagonal(0.25)));
        assert_eq!(detail("--epsilon 0.25"), Detail::Epsilon(Scale::Length(0.5)));
        let eye = [-1.0, 2.5, 3.0];
        let at = "--eye -1,2.5,3";
        assert_eq!(detail(&format!("--epsilon 0.25 {at}")), Detail::Epsilon(Scale::Eye { eye, slope: 0.5 }));
        assert_eq!(detail("--triangles 7"), Detail::Budgets(vec![Budget::Triangles(7)], None));
        assert_eq!(
            detail(&format!("--clusters 8 {at}")),
            Detail::Budgets(vec![Budget::Clusters(8)], Some(eye))
        );
        assert_eq!(detail("--ortho 5 --pixels 2 --height 100"), Detail::Within(Scale::Length(0.1)));
        let view = detail(&format!("{at} --pixels 2 --fov 90 --height 100"));
        let Detail::Within(Scale::Eye { eye: from, slope }) = view else { panic!("{view:?}") };
        assert_eq!(from, eye);
        assert!((slope - 0.04).abs() < 1e-12);
        let regions =
            export("export a.fct -o b.ply --error 1 --region 1,-2,3,4=0.5 --region -1,0,0,1=2").regions;
        let ball = |center, radius, distance| Ball { center, radius, distance };
        assert_eq!(regions, [ball([1.0, -2.0, 3.0], 4.0, 0.5), ball([-1.0, 0.0, 0.0], 1.0, 2.0)]);
    }

    #[test]
    fn a_chain_of_meshes_has_a_file_each() {
        let settings = export("export a.fct -o some/lod_{n}.GLB --triangles 500,100");
        assert_eq!(settings.format, Format::Glb);
        let output = |path: &str, n| Output { path: path.into(), budget: Some(Budget::Triangles(n)) };
        assert_eq!(settings.outputs, [output("some/lod_500.GLB", 500), output("some/lod_100.GLB", 100)]);
        assert_eq!(
            export("export a.fct -o a.ply --clusters 9").outputs,
            [Output { path: "a.ply".into(), budget: Some(Budget::Clusters(9)) }]
        );
        for words in ["-o a.ply --triangles 5,6", "-o a{n}.ply --error 1", "-o a{n}.ply --triangles 5,5"] {
            let words = format!("export a.fct {words}");
            let Command::Export(flags) = parse(&words).unwrap().command else { panic!() };
            assert_eq!(flags.settings().expect_err(&words).exit_code(), 2);
        }
    }

    #[test]
    fn nonsense_is_a_usage_error() {
        for words in [
            "",
            "info",
            "info a.fct b.fct",
            "look a.fct",
            "export a.fct",
            "export a.fct -o b.ply --error -1",
            "export a.fct -o b.ply --error -1%",
            "export a.fct -o b.ply --error %",
            "export a.fct -o b.ply --error 1 --triangles 5",
            "export a.fct -o b.ply --triangles 0",
            "export a.fct -o b.ply --pixels 2",
            "export a.fct -o b.ply --eye 1,2",
            "export a.fct -o b.ply --eye 1,2,nan",
            "export a.fct -o b.ply --eye 1,2,3 --fov 180",
            "export a.fct -o b.ply --eye 1,2,3 --error 1",
            "export a.fct -o b.ply --eye 1,2,3 --ortho 1",
            "export a.fct -o b.ply --eye 1,2,3 --triangles 9 --pixels 2",
            "export a.fct -o b.ply --ortho 0",
            "export a.fct -o b.ply --ortho 1 --fov 40",
            "export a.fct -o b.ply --ortho 1 --triangles 9",
            "export a.fct -o b.ply --triangles 5,",
            "export a.fct -o b.ply --triangles 5 --clusters 5",
            "export a.fct -o b.ply --epsilon -1",
            "export a.fct -o b.ply --epsilon 1 --in-place",
            "export a.fct -o b.ply --region 1,2,3,4=1",
            "export a.fct -o b.ply --triangles 9 --region 1,2,3,4=1",
            "export a.fct -o b.ply --error 1 --region 1,2,3=1",
            "export a.fct -o b.ply --error 1 --region 1,2,3,4",
            "export a.fct -o b.ply --error 1 --region 1,2,3,0=1",
            "export a.fct -o b.ply --error 1 --region 1,2,3,4=-1",
        ] {
            assert_eq!(parse(words).expect_err(words).exit_code(), 2, "{words}");
        }
        // A negative number is taken for a value, so that the answer is about numbers and not about flags.
        for flag in [
            "error",
            "epsilon",
            "triangles",
            "clusters",
            "eye",
            "ortho",
            "eye 0,0,1 --pixels",
            "ortho 1 --height",
        ] {
            let error = parse(&format!("export a.fct -o b.ply --{flag} -1")).expect_err(flag).to_string();
            assert!(error.contains("invalid value '-1'") && error.contains("expected"), "{error}");
        }
        let Command::Export(flags) = parse("export a.fct -o b.stl").unwrap().command else { panic!() };
        assert_eq!(flags.settings().unwrap_err().exit_code(), 2);
    }
}
