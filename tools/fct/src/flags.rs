//! The command line: flags typed by clap, then what they mean.

use crate::error::Error;
use crate::export::{Detail, Format, Settings, View};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 our bug, 2 usage, 4 input or output, 5 a limit, 7 invalid .fct file,
130 or 143 stopped by a signal. On any but 0 nothing is written.";

const EXAMPLES: &str = "\
Examples:
  fct info dragon.fct                                    what the file says about itself
  fct verify dragon.fct                                  check every byte and every rule
  fct export dragon.fct -o full.ply                      the input's faces
  fct export dragon.fct -o small.obj --triangles 5000    at most 5,000 triangles

Exit codes: 0 done, 1 our bug, 2 usage, 4 input or output, 5 a limit, 7 invalid .fct file.";

const INFO_EXAMPLES: &str = "\
Examples:
  fct info dragon.fct
  fct info dragon.fct --json | jq .counts.faces

The file's header, table and description are checked, the rest is not: see `fct verify`.
Exit codes: 0 done, 1 our bug, 2 usage, 4 input or output, 7 invalid .fct file.";

const VERIFY_EXAMPLES: &str = "\
Examples:
  fct verify dragon.fct
  fct verify dragon.fct --json

With --json the result goes to standard output as JSON, also when the file is invalid.
Exit codes: 0 every rule holds, 1 our bug, 2 usage, 4 input or output, 5 a limit, 7 invalid .fct file.";

const EXPORT_EXAMPLES: &str = "\
Examples:
  fct export dragon.fct -o full.ply                      the input's faces
  fct export dragon.fct -o near.ply --error 0.0005       an error of at most 0.0005
  fct export dragon.fct -o small.obj --triangles 5000    at most 5,000 triangles
  fct export dragon.fct -o coarse.ply --clusters 250     at most 250 clusters
  fct export dragon.fct -o view.ply --eye 0,0.1,0.6 --pixels 1 --fov 40 --height 1080
                                                         an error of at most a pixel from there

Lengths and places are in the unit of the input. The bound that is printed is the largest among the
clusters. --error and --eye choose clusters by it; --triangles and --clusters spend their budget by
the mean error, so that their bound is loose.";

/// Looks into, verifies and exports face-cluster trees (.fct).
#[derive(Debug, Parser)]
#[command(name = "fct", version, about, after_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Flags {
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
    Verify(FileFlags),
    /// Write a mesh of a chosen detail as PLY or OBJ
    #[command(after_help = format!("{EXPORT_EXAMPLES}\n{EXIT_CODES}"))]
    Export(ExportFlags),
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

/// Flags of `export`.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("detail").args(["error", "triangles", "clusters", "eye"]))]
pub(crate) struct ExportFlags {
    /// A tree made by fcbuild
    #[arg(value_name = "FILE.fct")]
    file: PathBuf,
    /// The mesh to write: binary PLY or OBJ, by the extension
    #[arg(short, long, value_name = "OUT.(ply|obj)")]
    output: PathBuf,
    /// Replace an existing output
    #[arg(long)]
    force: bool,
    /// No point of the surface is farther than this from the mesh: the flag for a tight guarantee
    #[arg(long, value_name = "DIST", value_parser = not_negative, allow_negative_numbers = true)]
    error: Option<f64>,
    /// At most so many triangles, with a low mean error and a loose bound
    #[arg(long, value_name = "N", value_parser = triangles, allow_negative_numbers = true)]
    triangles: Option<u64>,
    /// At most so many clusters, with a low mean error and a loose bound
    #[arg(long, value_name = "N", value_parser = clusters, allow_negative_numbers = true)]
    clusters: Option<u64>,
    /// Detail for a picture from this point, all around it
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<[f64; 3]>,
    /// Error in the middle of the picture, pixels
    #[arg(long, value_name = "P", default_value_t = 1.0, value_parser = positive, requires = "eye", allow_negative_numbers = true)]
    pixels: f64,
    /// Vertical field of view of the picture, degrees
    #[arg(long, value_name = "DEG", default_value_t = 40.0, value_parser = field_of_view, requires = "eye", allow_negative_numbers = true)]
    fov: f64,
    /// Height of the picture, pixels
    #[arg(long, value_name = "PX", default_value_t = 720, value_parser = height, requires = "eye", allow_negative_numbers = true)]
    height: u32,
}

impl ExportFlags {
    /// What is meant.
    ///
    /// # Errors
    /// Usage when the extension of the output names no format.
    pub(crate) fn settings(&self) -> Result<Settings, Error> {
        let extension = self.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match extension.as_deref() {
            Some("ply") => Format::Ply,
            Some("obj") => Format::Obj,
            _ => {
                return Err(Error::Usage(format!(
                    "{}: the extension tells the format; give it .ply or .obj",
                    self.output.display()
                )));
            }
        };
        let detail = if let Some(distance) = self.error {
            Detail::Distance(distance)
        } else if let Some(n) = self.triangles {
            Detail::Triangles(n)
        } else if let Some(n) = self.clusters {
            Detail::Clusters(n)
        } else if let Some(eye) = self.eye {
            // An error of p pixels in a picture h pixels high is p 2 tan(fov / 2) / h at distance 1.
            let slope = self.pixels * 2.0 * (0.5 * self.fov.to_radians()).tan() / f64::from(self.height);
            Detail::View(View { eye, slope })
        } else {
            Detail::Full
        };
        Ok(Settings {
            input: self.file.clone(),
            output: self.output.clone(),
            force: self.force,
            format,
            detail,
        })
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|x| x.is_finite())
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text).filter(|x| *x >= 0.0).ok_or_else(|| "expected a distance, 0 or more".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    number(text).filter(|x| *x > 0.0).ok_or_else(|| "expected a number above 0".to_owned())
}

fn triangles(text: &str) -> Result<u64, String> {
    count(text).ok_or_else(|| "expected a number of triangles, 1 or more".to_owned())
}

fn clusters(text: &str) -> Result<u64, String> {
    count(text).ok_or_else(|| "expected a number of clusters, 1 or more".to_owned())
}

fn height(text: &str) -> Result<u32, String> {
    count(text)
        .and_then(|n| u32::try_from(n).ok())
        .ok_or_else(|| "expected a number of pixels, 1 or more".to_owned())
}

fn count(text: &str) -> Option<u64> {
    text.trim().parse().ok().filter(|n| *n > 0)
}

fn field_of_view(text: &str) -> Result<f64, String> {
    number(text)
        .filter(|x| (1.0..=170.0).contains(x))
        .ok_or_else(|| "expected degrees from 1 to 170".to_owned())
}

fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers
        .and_then(|n| <[f64; 3]>::try_from(n).ok())
        .ok_or_else(|| "expected three numbers such as 0,1.5,-2".to_owned())
}

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
        assert_eq!(export("export a.fct -o b.PLY").detail, Detail::Full);
        assert_eq!(export("export a.fct -o b.obj --error 0.5").detail, Detail::Distance(0.5));
        assert_eq!(export("export a.fct -o b.obj --triangles 7").detail, Detail::Triangles(7));
        assert_eq!(export("export a.fct -o b.obj --clusters 8").detail, Detail::Clusters(8));
        let view = export("export a.fct -o b.obj --eye -1,2.5,3 --pixels 2 --fov 90 --height 100").detail;
        let Detail::View(View { eye, slope }) = view else { panic!("{view:?}") };
        assert_eq!(eye, [-1.0, 2.5, 3.0]);
        assert!((slope - 0.04).abs() < 1e-12);
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
            "export a.fct -o b.ply --error 1 --triangles 5",
            "export a.fct -o b.ply --triangles 0",
            "export a.fct -o b.ply --pixels 2",
            "export a.fct -o b.ply --eye 1,2",
            "export a.fct -o b.ply --eye 1,2,nan",
            "export a.fct -o b.ply --eye 1,2,3 --fov 180",
        ] {
            assert_eq!(parse(words).expect_err(words).exit_code(), 2, "{words}");
        }
        // A negative number is taken for a value, so that the answer is about numbers and not about flags.
        for flag in ["error", "triangles", "clusters", "eye", "eye 0,0,1 --pixels", "eye 0,0,1 --height"] {
            let error = parse(&format!("export a.fct -o b.ply --{flag} -1")).expect_err(flag).to_string();
            assert!(error.contains("invalid value '-1'") && error.contains("expected"), "{error}");
        }
        let Command::Export(flags) = parse("export a.fct -o b.stl").unwrap().command else { panic!() };
        assert_eq!(flags.settings().unwrap_err().exit_code(), 2);
    }
}
