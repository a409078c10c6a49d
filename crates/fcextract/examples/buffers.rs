//! From a file to vertex and index buffers, as an engine would fill them each frame.
//!
//! `cargo run --release -p fcextract --example buffers -- scan.fct`

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example shows what it has done")]

use fcextract::{
    Budget, Extraction, Fitter, Frustum, Mesh, Order, ParallelExtractor, Perspective, Selection, Shown,
    extract,
};
use fct::Tree;
use glam::dcamera::rh::{proj::directx, view};
use glam::{DMat4, DVec3};
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
    let path = std::env::args_os().nth(1).ok_or("give the path of a .fct file, as fcbuild makes it")?;
    // Opening maps the file: what no view shows is never read.
    let tree = Tree::open(&path)?;
    let [low, high] = [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from(b.map(f64::from)));
    let (center, size) = (low.midpoint(high), low.distance(high));

    // Made once and used for every frame: from some frame on, none of them asks the system for memory.
    let (mut cut, mut mesh) = (Extraction::default(), Mesh::default());

    // A walk around the model, one pixel of error in a picture 1080 pixels high with a field of view of 60 degrees.
    let (pixels, picture, field_of_view) = (1.0, [1920.0, 1080.0], 60_f64.to_radians());
    let projection = directx::perspective_infinite_reverse(field_of_view, 1920.0 / 1080.0, 0.01 * size);
    for frame in 0..8 {
        let angle = f64::from(frame) * std::f64::consts::TAU / 8.0;
        let eye = center + DVec3::new(angle.cos(), 0.3, angle.sin()) * size * 1.5;
        let camera = Perspective::new(eye, center - eye, field_of_view, picture, pixels);
        let world_to_eye = view::look_at_mat4(eye, center, DVec3::Y);
        let selection = Selection {
            // Leaves out clusters that lie outside the picture.
            frustum: Some(Frustum::from_view_projection(&(projection * world_to_eye))),
            // Leaves out clusters that turn their back as a whole.
            backface_eye: Some(eye),
            ..Selection::perspective(camera, Order::Bound)
        };
        extract(&tree, &selection, &mut cut)?;
        mesh.fill(&tree, &cut, &selection)?;
        upload(&format!("frame {frame}"), &mesh);
    }

    // The same picture on all threads; the mesh is the same to the last index.
    let selection = Selection::uniform(1e-3 * size, Order::Bound);
    ParallelExtractor::default().extract(&tree, &selection, &mut cut)?;
    mesh.fill(&tree, &cut, &selection)?;
    upload("a thousandth of the size", &mesh);

    // Two copies in a world, one of them farther away, that share ten thousand triangles as they look.
    let eye = center + DVec3::Z * size * 2.0;
    let camera = Perspective::new(eye, -DVec3::Z, field_of_view, picture, pixels);
    let world = Selection::perspective(camera, Order::Budget);
    let shown = |place: DMat4| {
        Ok::<_, fcextract::Error>(Shown { tree: &tree, selection: world.in_local_space(&place)? })
    };
    let away = DMat4::from_translation(DVec3::new(1.0, 0.0, -2.0) * size);
    let mut copies = [shown(DMat4::IDENTITY)?, shown(away)?];
    let fitted = Fitter::default().fit(&mut copies, Budget::Triangles(10_000))?;
    println!("{} triangles for two copies", fitted.count);
    for Shown { tree, selection } in &copies {
        extract(tree, selection, &mut cut)?;
        mesh.fill(tree, &cut, selection)?;
        upload("a copy", &mesh);
    }
    Ok(())
}

/// Stands for what an engine does with the buffers: they are plain arrays, ready to be copied.
fn upload(name: &str, mesh: &Mesh) {
    let positions: &[[f32; 3]] = &mesh.positions;
    let normals: &[[f32; 3]] = &mesh.normals;
    let colors: &[[u8; 4]] = &mesh.colors;
    let indices: &[u32] = &mesh.indices;
    let bytes = size_of_val(positions) + size_of_val(normals) + size_of_val(colors) + size_of_val(indices);
    println!("{name}: {} triangles, {} vertices, {bytes} bytes", indices.len() / 3, positions.len());
}
