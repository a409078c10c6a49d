//! `cargo xtask bench`: what the trees are worth and what they cost, beside other programs in the same run.
//!
//! Every bench checks its own answers and fails when one is wrong; a figure that is merely missed is marked.

use std::error::Error;
use std::path::Path;

use clap::Subcommand;

mod build;
mod builder;
mod colors;
mod costs;
mod culling;
mod cut;
mod distance;
mod drawn;
mod extract;
mod input;
mod ledger;
mod orbit;
mod peers;
mod process;
mod quality;
mod scores;
mod screen;
mod speed;
mod stream;
mod subdivision;
mod table;
mod targets;
mod view;
mod walk;

/// Something to measure.
#[derive(Debug, Subcommand)]
pub(crate) enum Bench {
    /// Surface distances at equal numbers of triangles.
    Quality(quality::Args),
    /// Surface distances and differences of colour of painted models.
    Colors(colors::Args),
    /// Time, memory and size of building a tree.
    Build(build::Args),
    /// Time of an extraction, by triangles; triangles beside cluster LOD at the same error on the screen.
    Extract(extract::Args),
    /// What bounds let a viewer leave out, against the paper's tree.
    Culling(culling::Args),
    /// What a view reads of a file that is larger than the memory it may have.
    Stream(stream::Args),
}

/// The folder of the workspace.
fn workspace() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).unwrap_or(own)
}

/// Runs one of them.
///
/// # Errors
/// When something cannot be run, or an answer is wrong.
pub(crate) fn run(bench: &Bench) -> Result<(), Box<dyn Error>> {
    match bench {
        Bench::Quality(args) => quality::run(args),
        Bench::Colors(args) => colors::run(args),
        Bench::Build(args) => build::run(args),
        Bench::Extract(args) => extract::run(args),
        Bench::Culling(args) => culling::run(args),
        Bench::Stream(args) => stream::run(args),
    }
}
