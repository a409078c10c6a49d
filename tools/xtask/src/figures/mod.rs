//! `cargo xtask figures`: the figures of the papers, made by this project, and a page that explains them.
//!
//! The same input gives the same bytes, but for the table of times and the walk, which alone needs a graphics driver.
//!
//! # Paper
//! `[Tsuji07]` figures 3 and 7 to 15; `[TsujiJa]` table 1 and figures 4, 5, 7 and 8.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

mod approximations;
mod boundaries;
mod cluster_pictures;
mod cut;
mod error_curves;
mod front;
mod model;
mod modes;
mod output;
mod page;
mod palette;
mod picture;
pub(crate) mod plot;
mod raster;
mod regions;
mod sampling;
mod times;
mod view;
mod walk;

use crate::data::sculpture;
use model::Model;
use output::Output;
use page::listed;

/// What `cargo xtask figures` is told.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder to write to [default: docs/figures with scans; without, target/figures].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository.
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// Small pictures of the samples alone, in seconds, into target/figures.
    #[arg(long)]
    quick: bool,
    /// Only the walk, which needs a graphics driver and differs from run to run.
    #[arg(long, conflicts_with = "quick")]
    only_walk: bool,
}

/// Writes every figure and the page.
///
/// # Errors
/// When an input is missing or broken, or the folder cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize()?;
    let scans = args.scans.as_deref().filter(|_| !args.quick);
    let usual = home.join(if scans.is_some() { "docs/figures" } else { "target/figures" });
    let out = Output::create(args.out.as_deref().unwrap_or(&usual), args.quick)?;
    if scans.is_none() {
        eprintln!("no --scans: the figures show the samples of this project alone");
    }
    let chief = scans.map_or_else(|| home.join("data/sculpture.ply"), |folder| folder.join("bunny.ply"));
    if args.only_walk {
        return out.write("walk.md", walk::page(&chief, &out)?.as_bytes());
    }
    let inputs = Inputs::read(&home.join("data"), scans)?;
    let page = inputs.page(&out)?;
    out.write("README.md", page.as_bytes())?;
    if !args.quick {
        out.write("partition-times.md", inputs.times()?.as_bytes())?;
        out.write("walk.md", walk::page(&chief, &out)?.as_bytes())?;
    }
    Ok(())
}

/// The meshes shown.
struct Inputs {
    sculpture: Model,
    terrain: Model,
    /// Bunny, armadillo and dragon, or none of them.
    scans: Option<[Model; 3]>,
}

impl Inputs {
    fn read(data: &Path, scans: Option<&Path>) -> Result<Inputs, Box<dyn Error>> {
        let scan = |folder: &Path, name: &str| {
            let path = folder.join(name);
            if !path.is_file() {
                let path = path.display();
                return Err(
                    format!("{path} is missing; get it from the Stanford 3D Scanning Repository").into()
                );
            }
            eprintln!("reading {}", path.display());
            Model::read(&path)
        };
        let scans = match scans {
            Some(folder) => Some([
                scan(folder, "bunny.ply")?,
                scan(folder, "armadillo.ply")?,
                scan(folder, "dragon.ply")?,
            ]),
            None => None,
        };
        let sample = |name: &str| Model::read(&data.join(name));
        Ok(Inputs { sculpture: sample("sculpture.ply")?, terrain: sample("terrain.ply")?, scans })
    }

    /// The paper's own model where it is given.
    fn chief(&self) -> &Model {
        self.scans.as_ref().map_or(&self.sculpture, |[bunny, ..]| bunny)
    }

    /// The chief model and the sculpture, each once.
    fn two(&self) -> Vec<&Model> {
        match &self.scans {
            Some([bunny, ..]) => vec![bunny, &self.sculpture],
            None => vec![&self.sculpture],
        }
    }

    fn all(&self) -> Vec<&Model> {
        let mut all = vec![&self.sculpture, &self.terrain];
        all.extend(self.scans.iter().flatten());
        all
    }

    fn page(&self, out: &Output) -> Result<String, Box<dyn Error>> {
        let mut counted = vec![self.chief()];
        counted.extend(self.scans.iter().map(|[_, _, dragon]| dragon));
        let sections = [
            self.introduction(),
            cluster_pictures::clusters_and_polygons(&self.two(), out)?,
            error_curves::section(&self.all(), out)?,
            approximations::by_mode(&self.two(), out)?,
            approximations::by_count(self.chief(), out)?,
            regions::section(self.chief(), out)?,
            boundaries::section(&self.two(), out)?,
            cluster_pictures::by_count(&counted, out)?,
            sampling::section(out)?,
        ];
        Ok(sections.join("\n"))
    }

    fn introduction(&self) -> String {
        let mut text = String::from(
            "# Figures\n\n\
             The figures of [Tsuji07] and [TsujiJa], made anew by this project; [the references](../references.md) name both papers in full.\n\
             `cargo xtask figures --scans DIR` writes this page and every picture in it, the same bytes on the same input, and [a table of times](partition-times.md) and [a walk through a hundred copies](walk.md), which differ from run to run.\n\
             Without `--scans` it shows the samples of this project alone.\n\
             Where a claim of a paper does not reproduce, the page says so.\n\n",
        );
        let modes: Vec<String> = modes::ALL.iter().map(|m| format!("`{}` ({})", m.name(), m.words)).collect();
        let _ = writeln!(text, "The modes compared are {}.", listed(&modes));
        for model in self.all() {
            for mode in modes::ALL.iter().filter(|m| !model.has(**m)) {
                let _ = writeln!(
                    text,
                    "`{}` would make too deep a tree of the {}, which the builder then splits as `paper` does; it is left out there.",
                    mode.name(),
                    model.name
                );
            }
        }
        if self.scans.is_some() {
            text += "Bunny, armadillo and dragon are scans of the [Stanford 3D Scanning Repository](https://graphics.stanford.edu/data/3Dscanrep/), Stanford University Computer Graphics Laboratory; the sculpture and the terrain are this project's own.\n";
        }
        text
    }

    /// The table of times, on meshes from small to large.
    fn times(&self) -> Result<String, Box<dyn Error>> {
        let (positions, faces) = sampling::ellipsoid(64, 65, [1.0; 3], 1.0);
        let sphere = Model::of_triangles("sphere", positions, faces)?;
        let made = |name: &str, faces| {
            eprintln!("making {name}");
            let mesh = sculpture(faces).map_err(|e| e.to_string())?;
            Model::of_triangles(name, mesh.positions, mesh.faces)
        };
        let half = made("sculpture, half as fine", 35_000)?;
        let fine = made("sculpture, twelve times as fine", 870_000)?;
        let mut all: Vec<&Model> = vec![&sphere, &half, &self.sculpture, &fine];
        all.extend(self.scans.iter().flatten());
        all.sort_by_key(|m| m.faces());
        times::measure(&all)
    }
}
