//! Clusters in colours, and the polygons that stand for them.
//!
//! # Paper
//! `[Tsuji07]` figure 3, `[TsujiJa]` figures 7 and 8.

use super::approximations::stored_frame_of;
use super::cut::Cut;
use super::model::Model;
use super::modes::PAPER;
use super::output::Output;
use super::page::{Panel, panels, table, three, verdict, whole};
use super::picture::{Lines, Scene, draw};
use std::error::Error;
use std::fmt::Write as _;

/// Clusters of figures 7 and 8, and the triangles that figure 8 prints for the dragon.
const PRINTED: [(usize, usize); 4] = [(100, 231), (500, 1_263), (1_000, 2_315), (5_000, 10_875)];

/// Clusters of the picture of clusters and polygons.
const FEW: usize = 300;

/// Clusters on the surface, and beside them their polygons in the same colours; returns the text for the page.
///
/// # Errors
/// Those of the builder, the extraction and the output folder.
pub(crate) fn clusters_and_polygons(models: &[&Model], out: &Output) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## Clusters and their polygons ([Tsuji07] figure 3)\n\n\
         A cluster is a connected set of faces; its polygon links the corners that stand on its boundary, in the same colour.\n",
    );
    for model in models {
        eprintln!("clusters and polygons of {}", model.name);
        let cut = Cut::of(&model.tree(PAPER)?, FEW)?;
        let frame = stored_frame_of(model, out.size);
        let lines = Lines { clusters: true, triangles: false };
        let captions = [
            format!("{} clusters of {} faces", whole(cut.clusters), whole(model.faces())),
            format!("their polygons, {} triangles", whole(cut.triangles())),
        ];
        let mut list = Vec::new();
        for ((what, scene), caption) in
            [("clusters", &cut.faces), ("polygons", &cut.polygons)].into_iter().zip(captions)
        {
            let file = format!("{what}-{}.png", model.name);
            out.picture(&file, &draw(scene, &frame, lines))?;
            list.push(Panel { file, alt: format!("{}, {what} in colours", model.name), caption });
        }
        text.push('\n');
        text += &panels(&list, 2);
    }
    Ok(text)
}

/// Clusters beside their triangles, from few to many; returns the text for the page.
///
/// # Errors
/// Those of the builder, the extraction and the output folder.
pub(crate) fn by_count(models: &[&Model], out: &Output) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## 100, 500, 1,000 and 5,000 clusters and their triangles ([TsujiJa] figures 7 and 8)\n",
    );
    let (mut rows, mut each) = (Vec::new(), Vec::new());
    let row = |what: &str, asked: usize, clusters: usize, triangles: usize| {
        let ratio = three(triangles as f64 / clusters as f64);
        vec![what.to_owned(), whole(asked), whole(clusters), whole(triangles), ratio]
    };
    for model in models {
        eprintln!("clusters and triangles of {}", model.name);
        let tree = model.tree(PAPER)?;
        let mut list = Vec::new();
        for (count, _) in PRINTED.into_iter().filter(|(c, _)| *c * 4 < model.faces()) {
            let cut = Cut::of(&tree, count)?;
            rows.push(row(&model.name, count, cut.clusters, cut.triangles()));
            each.push(cut.triangles() as f64 / cut.clusters as f64);
            list.extend(pair(model, count, cut, out)?);
        }
        text.push('\n');
        text += &panels(&list, 2);
    }
    rows.extend(PRINTED.map(|(n, triangles)| row("dragon as printed", n, n, triangles)));
    let most = each.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = each.iter().copied().fold(f64::INFINITY, f64::min);
    let head = ["model", "clusters asked for", "clusters", "triangles", "triangles a cluster"];
    let _ = write!(
        text,
        "\n{}\n\
         - [TsujiJa] prints 2.2 to 2.5 triangles a cluster.\n  {}\n  \
           Here a cluster has {} to {}.\n  \
           By Euler's formula, discs of which three meet at each corner have close to six corners each, hence four triangles; how the printed counts come to be below that, the paper does not say.\n  \
           A cluster with several rims, such as a piece of a tube, takes more: each rim keeps three corners or more, and a border of several pieces registers the ends of each; coarse cuts have many such clusters.\n",
        table(&head, &rows),
        verdict(most < 2.6),
        three(least),
        three(most)
    );
    Ok(text)
}

/// The clusters of a cut, and its triangles.
fn pair(model: &Model, count: usize, cut: Cut, out: &Output) -> Result<[Panel; 2], Box<dyn Error>> {
    let frame = stored_frame_of(model, out.size);
    let panel = |what: &str, scene: &Scene, lines: Lines, n: usize| -> Result<Panel, Box<dyn Error>> {
        let file = format!("{what}-{}-{count}.png", model.name);
        out.picture(&file, &draw(scene, &frame, lines))?;
        let alt = format!("{} in {} {what}", model.name, whole(n));
        Ok(Panel { file, alt, caption: format!("{} {what}", whole(n)) })
    };
    let triangles = cut.triangles();
    let unpainted = Scene { colors: Vec::new(), ..cut.polygons };
    Ok([
        panel("clusters", &cut.faces, Lines { clusters: true, triangles: false }, cut.clusters)?,
        panel("triangles", &unpainted, Lines { clusters: false, triangles: true }, triangles)?,
    ])
}
