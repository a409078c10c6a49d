//! `cargo xtask campaign`: the promises over thousands of views and on real scans.

use std::error::Error;
use std::path::PathBuf;
use std::process::Command;

/// Runs the tests that are too long for every day, and those that need real scans.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder with bunny.ply, armadillo.ply and dragon.ply of the Stanford 3D Scanning Repository.
    #[arg(long, env = "FCT_DATA", value_name = "DIR")]
    scans: Option<PathBuf>,
    /// Only the tests of one promise: a file of tests, such as `cracks` or `silhouette`.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
}

/// Runs them by cargo, in release, and shows what they count.
pub(crate) fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(["test", "--release", "--package", "fctests", "--package", "fcview", "--no-fail-fast"]);
    if let Some(name) = &args.only {
        command.args(["--test", name]);
    }
    command.args(["--", "--ignored", "--nocapture"]);
    match &args.scans {
        Some(folder) => {
            // Cargo runs tests in the package's folder; a relative path means the caller's.
            command.env("FCT_DATA", std::path::absolute(folder)?);
        }
        None => {
            eprintln!("no --scans: the tests on real scans are left out");
            command.args(["--skip", "scans"]);
        }
    }
    if command.status()?.success() { Ok(()) } else { Err("the campaign found something; see above".into()) }
}
