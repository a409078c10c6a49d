//! What was typed: the flags as `clap` reads them.

use clap::{Parser, ValueEnum};
use fcbuild::mesh::Weld;
use fcbuild::{BuildOptions, SplitMode};
use fct::{MessageFormat, ShowProgress, Size};
use std::path::PathBuf;

/// What `--help` shows below the flags.
const EXAMPLES: &str = "\
Examples:
  fcbuild dragon.ply -o dragon.fct                      the whole job
  fcbuild left.obj right.obj -o pair.fct                several files, one tree, a group each
  fcbuild dragon.ply -o dragon.fct --split cca          cut clusters by normals only
  fcbuild scan.stl -o scan.fct --weld 0.001             join vertices up to 0.001 apart
  fcbuild scan.ply -o scan.fct --force --report r.json  replace the output, keep the counts
  fcbuild scan.ply -o scan.fct --strict                 refuse what would need repair

The summary goes to standard output, progress, warnings and errors to standard error.

Exit codes: 0 done (perhaps with warnings), 1 our bug, 2 usage, 3 bad input,
4 input or output, 5 a limit, 129, 130, 131, 143 or 152 stopped by a signal.
On any but 0 nothing is written, unless all that fails is standard output or a
signal comes when the tree is complete.";

/// More threads than this only cost memory: the serial parts dominate long before.
pub(crate) const MAX_THREADS: i64 = 256;

/// Parts that can be read alone are no smaller than a page, and no mesh is larger.
const LEAST_CHUNK: i64 = 256;
const MOST_CHUNK: i64 = 1 << 30;

/// Colours that count more would have every face drawn.
const MOST_WEIGHT: f64 = 1e3;

/// Builds a face-cluster tree (.fct) from polygon meshes: PLY, OBJ, STL, glTF or GLB.
#[derive(Clone, Debug, Parser)]
#[command(name = "fcbuild", version, about, after_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Flags {
    /// Meshes; each object in them becomes a group of the tree
    #[arg(required = true, value_name = "IN")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The tree to write
    #[arg(short, long, value_name = "OUT.fct")]
    pub(crate) output: PathBuf,
    /// How the tree is made: by merging where that saves most triangles for its error (quality), or Garland's way (merge); or by cutting clusters in two across positions (pca), by normals (cca), or the better of both (paper)
    #[arg(long, value_enum, value_name = "quality|paper|pca|cca|merge", default_value_t = SplitFlag::Quality, hide_possible_values = true)]
    pub(crate) split: SplitFlag,
    /// Threads, 1 to 256; the output does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MAX_THREADS), allow_negative_numbers = true)]
    pub(crate) threads: Option<u32>,
    /// Refuse before the long work what would need more, such as 800M or 6GiB [default: 75 % of what the machine or its control group has]
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(crate) max_memory: Option<Size>,
    /// Faces, at most, of a part that can be read alone where a file is larger than the memory, from 256 on: with fewer a coarse view reads less, and the file is larger
    #[arg(long, value_name = "N", default_value_t = fct::CHUNK_FACES, value_parser = clap::value_parser!(u32).range(LEAST_CHUNK..=MOST_CHUNK), allow_negative_numbers = true)]
    pub(crate) chunk_faces: u32,
    /// Replace existing outputs, if they are trees and reports
    #[arg(long)]
    pub(crate) force: bool,
    /// Take every repair and every dropped face for an error; textures, materials and normals of corners, which no tree keeps, are only warned of
    #[arg(long)]
    pub(crate) strict: bool,
    /// Join vertices at equal positions (exact), up to a distance apart (EPS, in the unit of the input), or not at all
    #[arg(long, value_name = "exact|EPS|off", default_value = "exact", value_parser = weld, allow_negative_numbers = true)]
    pub(crate) weld: Weld,
    /// How much colours of vertices count: a patch drawn black in place of white is an error of W times its width; 0 leaves them out
    #[arg(long, value_name = "W", default_value_t = BuildOptions::default().color_weight, value_parser = weight, allow_negative_numbers = true)]
    pub(crate) color_weight: f64,
    /// Turn every face over, its normals too: for a surface that looks inwards
    #[arg(long)]
    pub(crate) flip: bool,
    /// Make one surface of all groups: it is not cut where they meet, and the tree does not tell them apart
    #[arg(long)]
    pub(crate) join_groups: bool,
    /// Write counts, times and sizes as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Form of errors and warnings: for people, or one JSON object a line
    #[arg(long, value_name = "human|json", default_value = "human")]
    pub(crate) message_format: MessageFormat,
    /// Show progress: on a terminal (auto), always, or never
    #[arg(long, value_name = "auto|always|never", default_value = "auto")]
    pub(crate) progress: ShowProgress,
}

/// `--split`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SplitFlag {
    /// Bottom-up, by error for each triangle saved.
    Quality,
    /// Top-down, the better of the two below.
    Paper,
    /// Principal component analysis.
    Pca,
    /// Canonical correlation analysis.
    Cca,
    /// Bottom-up, after Garland.
    Merge,
}

impl From<SplitFlag> for SplitMode {
    fn from(flag: SplitFlag) -> SplitMode {
        match flag {
            SplitFlag::Quality => SplitMode::Quality,
            SplitFlag::Merge => SplitMode::Merge,
            SplitFlag::Paper => SplitMode::Paper,
            SplitFlag::Pca => SplitMode::Pca,
            SplitFlag::Cca => SplitMode::Cca,
        }
    }
}

fn weld(text: &str) -> Result<Weld, String> {
    match text {
        "exact" => Ok(Weld::Exact),
        "off" => Ok(Weld::Off),
        _ => match text.parse::<f64>() {
            Ok(distance) if distance > 0.0 && distance.is_finite() => Ok(Weld::Within(distance)),
            _ => Err("expected `exact`, `off` or a distance above 0".to_owned()),
        },
    }
}

fn weight(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(weight) if (0.0..=MOST_WEIGHT).contains(&weight) => Ok(weight),
        _ => Err(format!("expected a number from 0 to {MOST_WEIGHT}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parse(words: &str) -> Result<Flags, clap::Error> {
        Flags::try_parse_from(std::iter::once("fcbuild").chain(words.split_whitespace()))
    }

    #[test]
    fn the_flags_are_consistent() {
        Flags::command().debug_assert();
    }

    #[test]
    fn every_flag_means_what_it_says() {
        let flags = parse(
            "a.ply b.obj -o c.fct --split cca --threads 3 --max-memory 2GiB --force --strict --flip --join-groups --weld 0.5 --color-weight 0.25 \
             --chunk-faces 1024 --report r.json --message-format json --progress never",
        )
        .unwrap();
        assert_eq!(flags.inputs.len(), 2);
        assert_eq!((flags.split, flags.threads), (SplitFlag::Cca, Some(3)));
        assert_eq!(flags.max_memory.map(|size| size.bytes()), Some(2 << 30));
        assert!(flags.force && flags.strict && flags.flip && flags.join_groups && flags.report.is_some());
        assert_eq!((flags.weld, flags.chunk_faces), (Weld::Within(0.5), 1024));
        assert_eq!(flags.color_weight, 0.25);
        assert_eq!((flags.message_format, flags.progress), (MessageFormat::Json, ShowProgress::Never));
        let plain = parse("a.ply -o c.fct").unwrap();
        assert_eq!((plain.split, plain.weld, plain.color_weight), (SplitFlag::Quality, Weld::Exact, 0.5));
        assert!(!plain.force && !plain.flip && !plain.join_groups && plain.chunk_faces == fct::CHUNK_FACES);
    }

    #[test]
    fn nonsense_is_a_usage_error() {
        for words in [
            "",
            "a.ply",
            "-o c.fct",
            "a.ply -o c.fct --split best",
            "a.ply -o c.fct --threads 0",
            "a.ply -o c.fct --threads 257",
            "a.ply -o c.fct --threads -1",
            "a.ply -o c.fct --threads many",
            "a.ply -o c.fct --weld -1",
            "a.ply -o c.fct --weld nan",
            "a.ply -o c.fct --color-weight -1",
            "a.ply -o c.fct --color-weight nan",
            "a.ply -o c.fct --color-weight 1001",
            "a.ply -o c.fct --chunk-faces 255",
            "a.ply -o c.fct --chunk-faces -1",
            "a.ply -o c.fct --max-memory 0",
            "a.ply -o c.fct --max-memory -1",
            "a.ply -o c.fct --max-memory lots",
            "a.ply -o c.fct --faster",
        ] {
            assert_eq!(parse(words).expect_err(words).exit_code(), 2, "{words}");
        }
        // A negative number is taken for a value, so that the answer is about numbers and not about flags.
        let error = parse("a.ply -o c.fct --weld -1").expect_err("negative").to_string();
        assert!(error.contains("a distance above 0"), "{error}");
    }
}
