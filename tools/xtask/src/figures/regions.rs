//! A model that is fine in one half and coarse in the other.
//!
//! # Paper
//! `[Tsuji07]` figure 12.

use super::approximations::stored_frame_of;
use super::cut::scene;
use super::model::Model;
use super::modes::QUALITY;
use super::output::Output;
use super::page::{Panel, panels, whole};
use super::picture::{Lines, draw};
use fcextract::{Extraction, Order, Region, Selection, extract};
use glam::DVec3;
use std::error::Error;

/// Errors allowed, in diagonals of the model's box: in the fine half and in the coarse one.
const FINE: f64 = 1e-3;
const COARSE: f64 = 2e-2;

/// Radius of the ball that stands for a half, in diagonals: its surface is nearly flat where it cuts the model.
const HALF: f64 = 20.0;

/// The model with one half finer than the other, as lines and as a surface; returns the text for the page.
///
/// # Errors
/// Those of the builder, the extraction and the output folder.
pub(crate) fn section(model: &Model, out: &Output) -> Result<String, Box<dyn Error>> {
    let tree = model.tree(QUALITY)?;
    let corner = |b: [f32; 3]| DVec3::from(b.map(f64::from));
    let [low, high] = [tree.meta().bounds_min, tree.meta().bounds_max].map(corner);
    let (middle, diagonal) = (low.midpoint(high), low.distance(high));
    let half = Region {
        center: middle - model.view.right * HALF * diagonal,
        radius: HALF * diagonal,
        distance: FINE * diagonal,
    };
    let selection = Selection { regions: vec![half], ..Selection::uniform(COARSE * diagonal, Order::Bound) };
    let mut cut = Extraction::default();
    extract(&tree, &selection, &mut cut)?;
    let drawn = scene(&tree, &cut.indices);
    let frame = stored_frame_of(model, out.size);
    let mut list = Vec::new();
    for (what, lines) in
        [("triangles", Lines { clusters: false, triangles: true }), ("surface", Lines::default())]
    {
        let file = format!("region-{}-{what}.png", model.name);
        out.picture(&file, &draw(&drawn, &frame, lines))?;
        list.push(Panel {
            file,
            alt: format!("{}, fine on the left and coarse on the right: {what}", model.name),
            caption: format!("{what}, {} of {}", whole(drawn.triangles.len()), whole(model.faces())),
        });
    }
    Ok(format!(
        "## Half fine, half coarse ([Tsuji07] figure 12)\n\n\
         On the left the surface is at most {FINE} of the diagonal of the model's box from the mesh, on the right at most {COARSE}.\n\
         The mesh is one and has no crack where they meet; `fct export --region` writes such meshes.\n\n{}",
        panels(&list, 2)
    ))
}
