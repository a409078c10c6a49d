//! What developers run: `cargo xtask data` writes the sample meshes, `cargo xtask figures` the figures of the papers,
//! `cargo xtask campaign` runs the long tests, `cargo xtask bench` measures quality and speed beside those of other
//! programs.
//!
//! This file only parses the command line and hands over; each subcommand has a module of its own.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod bench;
mod campaign;
mod data;
mod figures;

/// Tasks of the workspace that are no part of the product.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Write the sample meshes, the same bytes on every run.
    Data(data::Args),
    /// Draw the figures of the papers, and the page that explains them.
    Figures(figures::Args),
    /// Run the tests that take minutes or need real scans.
    Campaign(campaign::Args),
    /// Measure beside other programs, and check every answer.
    #[command(subcommand)]
    Bench(bench::Bench),
}

fn main() -> ExitCode {
    let result = match Cli::parse().task {
        Task::Data(args) => data::run(&args).map_err(Into::into),
        Task::Figures(args) => figures::run(&args),
        Task::Campaign(args) => campaign::run(&args),
        Task::Bench(bench) => bench::run(&bench),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
