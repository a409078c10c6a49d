//! `cargo xtask data`: the sample meshes, reproducible to the byte.
//!
//! Everything here computes with + - * / and sqrt alone and takes its randomness from an integer hash, so the files
//! are the same on every machine.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

mod boulder;
mod circle;
mod distance;
mod field;
mod halfedge;
pub(crate) mod noise;
mod odd;
mod parts;
pub(crate) mod ply_out;
mod polygonise;
mod relax;
pub(crate) mod sculpture;
mod terrain;
#[cfg(test)]
pub(crate) mod topology;
mod vase;

pub(crate) use circle::circle;
use ply_out::Mesh;
pub(crate) use sculpture::sculpture;

/// What `cargo xtask data` is told.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder to write to [default: the workspace's data folder].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Faces of sculpture.ply, met within about five percent.
    #[arg(long, value_name = "N", default_value_t = sculpture::FACES, value_parser = clap::value_parser!(u64).range(2_000..=20_000_000))]
    faces: u64,
    /// Write only a sculpture of this many faces, named for the number (sculpture-4m.ply); about 0.55 GB of memory per million faces.
    #[arg(long, value_name = "N", conflicts_with = "faces", requires = "out", value_parser = clap::value_parser!(u64).range(2_000..=20_000_000))]
    large: Option<u64>,
    /// Write only a rough ball of at least this many faces (boulder-100m.ply), 19 bytes of file and next to no memory a face.
    #[arg(long, value_name = "N", conflicts_with_all = ["faces", "large"], requires = "out", value_parser = clap::value_parser!(u64).range(12..=1_000_000_000))]
    boulder: Option<u64>,
    /// Write only a painted vase of about this many faces (vase-400k.ply).
    #[arg(long, value_name = "N", conflicts_with_all = ["faces", "large", "boulder"], requires = "out", value_parser = clap::value_parser!(u64).range(2_000..=20_000_000))]
    vase: Option<u64>,
}

/// Why no sample could be written.
#[derive(Debug)]
pub(crate) enum DataError {
    /// A file or folder refused.
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The surface came out open: the sampling grid missed a part of it.
    Open {
        /// Directed edges without an opposite.
        edges: usize,
    },
}

impl DataError {
    fn io(path: &Path, source: std::io::Error) -> DataError {
        DataError::Io { path: path.to_owned(), source }
    }
}

impl std::error::Error for DataError {}

impl std::fmt::Display for DataError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            DataError::Io { path, source } => {
                write!(f, "{}: {source}; choose a writable folder with --out", path.display())
            }
            DataError::Open { edges } => {
                write!(f, "the sculpture has {edges} open edges at this size; choose another --faces")
            }
        }
    }
}

/// Writes the samples and names each file on stdout.
///
/// # Errors
/// [`DataError`] when a file cannot be written or the surface is not closed.
pub(crate) fn run(args: &Args) -> Result<(), DataError> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data");
    let out = args.out.as_deref().unwrap_or(&home);
    let odd = out.join("odd");
    let folder = if args.large.or(args.boulder).or(args.vase).is_some() { out } else { &odd };
    fs::create_dir_all(folder).map_err(|source| DataError::io(folder, source))?;
    if let Some(faces) = args.large {
        let path = out.join(format!("sculpture-{}.ply", short(faces)));
        return write(&path, &sculpture(faces)?, &[], sculpture::COMMENT);
    }
    if let Some(faces) = args.boulder {
        let path = out.join(format!("boulder-{}.ply", short(faces)));
        let counts = boulder::write_file(&path, faces).map_err(|source| DataError::io(&path, source))?;
        say(&path, &format!("{} faces, {} vertices", counts.0, counts.1));
        return Ok(());
    }
    if let Some(faces) = args.vase {
        let (mesh, colors) = vase::vase(faces);
        return write(&out.join(format!("vase-{}.ply", short(faces))), &mesh, &colors, vase::COMMENT);
    }
    for (name, bytes) in odd::files() {
        let path = odd.join(name);
        fs::write(&path, &bytes).map_err(|source| DataError::io(&path, source))?;
        say(&path, &format!("{} bytes", bytes.len()));
    }
    write(&out.join("terrain.ply"), &terrain::terrain(), &[], "height field with holes")?;
    write(&out.join("parts.ply"), &parts::parts(), &[], "forty separate pieces")?;
    write(&out.join("sculpture.ply"), &sculpture(args.faces)?, &[], sculpture::COMMENT)
}

fn write(path: &Path, mesh: &Mesh, colors: &[[u8; 3]], comment: &str) -> Result<(), DataError> {
    ply_out::write_file(path, mesh, colors, comment)?;
    say(path, &format!("{} faces, {} vertices", mesh.faces.len(), mesh.positions.len()));
    Ok(())
}

/// Names a written file; a closed pipe is no reason to stop writing files.
fn say(path: &Path, what: &str) {
    let _ = writeln!(std::io::stdout(), "{}: {what}", path.display());
}

/// 4000000 as `4m`, 250000 as `250k`, anything else in full.
pub(crate) fn short(n: u64) -> String {
    match n {
        n if n % 1_000_000 == 0 => format!("{}m", n / 1_000_000),
        n if n % 1_000 == 0 => format!("{}k", n / 1_000),
        n => n.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The committed files are what the code writes: a change of either without the other is found here.
    #[test]
    fn committed_files_are_reproduced() {
        let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data");
        let bytes = |mesh: &Mesh, comment: &str| {
            let mut out = Vec::new();
            ply_out::write_to(&mut out, mesh, &[], comment).unwrap();
            out
        };
        let mut expected: Vec<(PathBuf, Vec<u8>)> =
            odd::files().into_iter().map(|(n, b)| (home.join("odd").join(n), b)).collect();
        expected.push((home.join("terrain.ply"), bytes(&terrain::terrain(), "height field with holes")));
        expected.push((home.join("parts.ply"), bytes(&parts::parts(), "forty separate pieces")));
        for (path, bytes) in expected {
            let found = fs::read(&path).unwrap();
            // assert_eq would print megabytes.
            assert!(found == bytes, "{}: run `cargo xtask data` and commit the result", path.display());
        }
    }

    #[test]
    fn sizes_are_named_shortly() {
        assert_eq!([4_000_000, 250_000, 1_234].map(short), ["4m", "250k", "1234"]);
    }
}
