//! Approximations of a model: by the ways to cut, and by the number of clusters.
//!
//! # Paper
//! `[Tsuji07]` figures 10 and 11.

use super::cut::Cut;
use super::model::Model;
use super::modes::{Mode, QUALITY};
use super::output::Output;
use super::page::{Panel, panels, whole};
use super::picture::{Lines, Scene, draw};
use super::view::Frame;
use std::error::Error;

/// Clusters of figure 10.
const COUNT: usize = 250;

/// Clusters of figure 11.
const SERIES: [usize; 5] = [50, 150, 500, 2_000, 8_000];

/// How large, and from where, a model is shown.
pub(crate) fn frame_of(model: &Model, size: [usize; 2]) -> Frame {
    let used = (0..model.faces()).flat_map(|f| model.corners(f));
    Frame::around(model.view, used, size[0], size[1])
}

/// The same for what was built from the model, which is in the model's own unit.
pub(crate) fn stored_frame_of(model: &Model, size: [usize; 2]) -> Frame {
    let used = model.mesh.faces.as_flattened().iter().map(|v| model.mesh.stored[*v as usize].as_dvec3());
    Frame::around(model.view, used, size[0], size[1])
}

/// The input, smooth and unpainted.
fn original(model: &Model) -> Scene {
    Scene {
        triangles: (0..model.faces()).map(|f| model.corners(f)).collect(),
        normals: Some((0..model.faces()).map(|f| model.normals(f)).collect()),
        ..Scene::default()
    }
}

/// Pictures of each input and of 250 clusters by each mode; returns the text for the page.
///
/// # Errors
/// Those of the builder, the extraction and the output folder.
pub(crate) fn by_mode(models: &[&Model], out: &Output) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## 250 clusters by each way to cut ([Tsuji07] figure 10)\n\n\
         The cuts have at most 250 clusters, in budget order, in which a viewer refines.\n\
         Lines run between the polygons; the mean errors stand in the table above.\n",
    );
    for model in models {
        eprintln!("250 clusters of {}", model.name);
        let mut list = vec![input_panel(model, out)?];
        for mode in model.modes() {
            list.push(mode_panel(model, *mode, out)?);
        }
        text.push('\n');
        text += &panels(&list, 2);
    }
    Ok(text)
}

fn mode_panel(model: &Model, mode: Mode, out: &Output) -> Result<Panel, Box<dyn Error>> {
    let cut = Cut::of(&model.tree(mode)?, COUNT)?;
    let file = format!("approximation-{}-{}.png", model.name, mode.name());
    let scene = Scene { colors: Vec::new(), ..cut.polygons };
    let lines = Lines { clusters: true, triangles: false };
    out.picture(&file, &draw(&scene, &stored_frame_of(model, out.size), lines))?;
    let (name, clusters, triangles) = (mode.name(), whole(cut.clusters), whole(scene.triangles.len()));
    Ok(Panel {
        file,
        alt: format!("{} in {clusters} clusters by {name}", model.name),
        caption: format!("`{name}`: {clusters} clusters, {triangles} triangles"),
    })
}

fn input_panel(model: &Model, out: &Output) -> Result<Panel, Box<dyn Error>> {
    let file = format!("input-{}.png", model.name);
    out.picture(&file, &draw(&original(model), &frame_of(model, out.size), Lines::default()))?;
    Ok(Panel {
        file,
        alt: format!("{}, the input", model.name),
        caption: format!("input: {} triangles", whole(model.faces())),
    })
}

/// Pictures of finer and finer cuts of one tree; returns the text for the page.
///
/// # Errors
/// Those of the builder, the extraction and the output folder.
pub(crate) fn by_count(model: &Model, out: &Output) -> Result<String, Box<dyn Error>> {
    let tree = model.tree(QUALITY)?;
    let mut list = Vec::new();
    for count in SERIES.into_iter().filter(|c| *c * 4 < model.faces()) {
        let cut = Cut::of(&tree, count)?;
        let file = format!("series-{}-{count}.png", model.name);
        let scene = Scene { colors: Vec::new(), ..cut.polygons };
        out.picture(&file, &draw(&scene, &stored_frame_of(model, out.size), Lines::default()))?;
        let (clusters, triangles) = (whole(cut.clusters), whole(scene.triangles.len()));
        list.push(Panel {
            file,
            alt: format!("{} in {clusters} clusters", model.name),
            caption: format!("{clusters} clusters, {triangles} triangles"),
        });
    }
    list.push(input_panel(model, out)?);
    Ok(format!(
        "## From few clusters to many ([Tsuji07] figure 11)\n\nCuts of one tree, built by `{}`, drawn flat.\n\n{}",
        QUALITY.name(),
        panels(&list, 3)
    ))
}
