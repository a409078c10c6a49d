//! From a file that may be larger than the memory to vertex and index buffers.
//!
//! `cargo run --release -p fcextract --example streaming -- scan.fct 64`, with the megabytes that its parts may take.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example shows what it has done")]

use fcextract::{ChunkCache, Mesh, Order, Perspective, Selection, Streamed};
use glam::DVec3;
use std::error::Error;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        // An error says what is wrong, where and what to do.
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let path = arguments.next().ok_or("give the path of a .fct file, as fcbuild makes it")?;
    let megabytes = arguments.next().and_then(|text| text.to_str()?.parse().ok()).unwrap_or(64_u64);
    // Opening reads the upper part of the tree, a few hundredths of the file, and starts the thread that reads the rest.
    let cache = ChunkCache::open(path, megabytes << 20)?;
    let meta = cache.file().meta();
    let [low, high] = [meta.bounds_min, meta.bounds_max].map(|b| DVec3::from(b.map(f64::from)));
    let (center, size) = (low.midpoint(high), low.distance(high));

    // Made once and used for every frame.
    let (mut streamed, mut mesh) = (Streamed::default(), Mesh::default());
    let mut frame = |eye: DVec3| -> Result<(), Box<dyn Error>> {
        let camera = Perspective::new(eye, center - eye, 60_f64.to_radians(), [1920.0, 1080.0], 1.0);
        // Displaced: a lower error for the same number of triangles.
        let selection = Selection { displaced: true, ..Selection::perspective(camera, Order::Bound) };
        cache.begin_frame();
        // Never waits for the disk: what is missing is drawn coarser and read in the background.
        cache.extract(&selection, &mut streamed)?;
        // The same buffers as those of a tree that is in memory: each vertex once, and no triangle turned by a step.
        mesh.fill_streamed(cache.file().crown(), &streamed, &selection)?;
        let [triangles, vertices] = [mesh.indices.len() / 3, mesh.positions.len()];
        println!("{triangles} triangles, {vertices} vertices, {} parts missing", streamed.missing.len());
        Ok(())
    };
    let eye = |turn: f64| {
        let angle = turn * std::f64::consts::TAU;
        center + DVec3::new(angle.cos(), 0.3, angle.sin()) * size * 1.5
    };
    for step in 0..8 {
        frame(eye(f64::from(step) / 8.0))?;
    }
    // An engine would draw on; here the camera rests until all is there that fits.
    for _ in 0..2 {
        cache.settle();
        frame(eye(7.0 / 8.0))?;
    }
    // What could not be read is drawn as its root, and told here.
    for (piece, error) in cache.errors() {
        eprintln!("{piece:?}: {error}");
    }
    println!("{:?}", cache.stats());
    Ok(())
}
