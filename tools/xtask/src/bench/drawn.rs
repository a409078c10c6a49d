//! Meshes that are drawn from a tree, for a number of triangles.
//!
//! What a cut's triangles are made of is asked for in this file alone.

use std::error::Error;

use fcextract::{Budget, Extraction, Order, Selection, extract, fit};
use fct::Tree;

use super::input::weld;
use crate::data::ply_out::Mesh;

/// The search for a tolerance ends when so large a share of the triangles is used.
const NEAR_ENOUGH: f64 = 0.998;

/// No finite key is over this tolerance.
const COARSEST: f64 = f32::MAX as f64;

/// A mesh and the number of triangles that it was drawn with.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// Equal positions joined; triangles that collapse are left out.
    pub(crate) mesh: Mesh,
    /// Those that collapse counted too.
    pub(crate) triangles: u64,
    /// Whether the tree has a cut of no more triangles than were asked for.
    pub(crate) exists: bool,
}

/// Every face of the tree.
///
/// # Errors
/// When the tree is damaged.
pub(crate) fn full(tree: &Tree) -> Result<Drawn, Box<dyn Error>> {
    let mut cut = Extraction::default();
    let selection = Selection::full();
    extract(tree, &selection, &mut cut)?;
    drawn(tree, &cut, &selection, true)
}

/// The finest cut of at most `triangles` triangles in an order, or what the search has left if it found none.
///
/// # Errors
/// When the tree is damaged.
pub(crate) fn within(tree: &Tree, triangles: u64, order: Order) -> Result<Drawn, Box<dyn Error>> {
    let mut cut = Extraction::default();
    extract(tree, &Selection::uniform(COARSEST, order), &mut cut)?;
    let exists = cut.stats.triangles <= triangles;
    let selection = match order {
        Order::Budget => fit(tree, Selection::by_budget(), Budget::Triangles(triangles), &mut cut)?.0,
        Order::Bound => {
            let distance = tolerance(tree, triangles, &mut cut)?;
            let displaced = tree.promises_displaced();
            let selection = Selection { displaced, ..Selection::uniform(distance, Order::Bound) };
            extract(tree, &selection, &mut cut)?;
            selection
        }
    };
    drawn(tree, &cut, &selection, exists)
}

/// The least distance bound found whose cut keeps to the number, by halving the numbers that there are.
fn tolerance(tree: &Tree, triangles: u64, cut: &mut Extraction) -> Result<f64, Box<dyn Error>> {
    // Numbers of one sign are in the order of their bits.
    let (mut over, mut fits) = (0_u32, f32::MAX.to_bits());
    while fits - over > 1 {
        let middle = over + (fits - over) / 2;
        extract(tree, &Selection::uniform(f64::from(f32::from_bits(middle)), Order::Bound), cut)?;
        if cut.stats.triangles > triangles {
            over = middle;
        } else {
            fits = middle;
            if cut.stats.triangles as f64 >= NEAR_ENOUGH * triangles as f64 {
                break;
            }
        }
    }
    Ok(f64::from(f32::from_bits(fits)))
}

fn drawn(
    tree: &Tree,
    cut: &Extraction,
    selection: &Selection,
    exists: bool,
) -> Result<Drawn, Box<dyn Error>> {
    let mut mesh = fcextract::Mesh::default();
    mesh.fill(tree, cut, selection)?;
    let mesh = weld(&mesh.positions, mesh.indices.as_chunks::<3>().0);
    Ok(Drawn { mesh, triangles: cut.stats.triangles, exists })
}
