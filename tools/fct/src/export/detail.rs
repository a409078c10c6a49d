//! How fine a mesh is asked for, and the cut that this is.

use crate::error::Error;
use fcextract::{
    Budget, Extraction, Order, Perspective, Region, Selection, Tolerance, by_epsilon, extract, fit,
};
use fct::Tree;
use glam::DVec3;
use std::path::Path;

/// How fine a mesh is asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Detail {
    /// The input's faces.
    Full,
    /// Within an error.
    Within(Scale),
    /// By the paper's modelling error, whose root is the error here.
    Epsilon(Scale),
    /// At most so many, each in a file of its own; errors weigh as they look from an eye, if there is one.
    Budgets(Vec<Budget>, Option<[f64; 3]>),
}

/// What an error is measured by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// A length, the same everywhere.
    Length(f64),
    /// A part of the diagonal of the model's box.
    Diagonal(f64),
    /// A length for each unit of distance from an eye.
    Eye {
        /// The eye, in the input's coordinates.
        eye: [f64; 3],
        /// The length at a distance of 1.
        slope: f64,
    },
}

/// A part of the mesh with an error of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    /// Its centre, in the input's coordinates.
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
    /// The error in it, a length.
    pub(crate) distance: f64,
}

impl Scale {
    fn tolerance(self, tree: &Tree) -> Tolerance {
        match self {
            Scale::Length(distance) => Tolerance::Uniform { distance },
            Scale::Diagonal(part) => Tolerance::Uniform { distance: part * diagonal(tree) },
            Scale::Eye { eye, slope } => {
                let eye = from_input(tree, eye);
                Tolerance::Perspective(Perspective { eye, axis: DVec3::ZERO, slope, corner_cos: 1.0 })
            }
        }
    }
}

/// The diagonal of the model's box.
pub(crate) fn diagonal(tree: &Tree) -> f64 {
    let corner = |c: [f32; 3]| DVec3::from(c.map(f64::from));
    corner(tree.meta().bounds_min).distance(corner(tree.meta().bounds_max))
}

/// An error above this part of the diagonal leaves a few triangles, and is likely meant in another unit.
const LARGE: f64 = 0.1;

/// What to tell a user whose error is large beside the model.
pub(crate) fn large_error(tree: &Tree, detail: &Detail) -> Option<String> {
    let (Detail::Within(Scale::Length(length)) | Detail::Epsilon(Scale::Length(length))) = detail else {
        return None;
    };
    let diagonal = diagonal(tree);
    (*length > LARGE * diagonal).then(|| {
        format!(
            "an error of {} is large for a model whose box is {} across; lengths are in the unit of the input, and \
             --error 0.1% is a thousandth of the box",
            *length as f32, diagonal as f32
        )
    })
}

/// What to tell a user one of whose regions has nothing of the model in it.
///
/// # Errors
/// An invalid file.
pub(crate) fn empty_region(tree: &Tree, balls: &[Ball]) -> Result<Option<String>, Error> {
    for ball in balls {
        if !region(tree, ball).meets(tree)? {
            let [x, y, z] = ball.center;
            return Ok(Some(format!(
                "nothing of the model lies in the region {x},{y},{z},{}; places are in the coordinates of the input, \
                 and fct info shows the box",
                ball.radius
            )));
        }
    }
    Ok(None)
}

fn region(tree: &Tree, ball: &Ball) -> Region {
    Region { center: from_input(tree, ball.center), radius: ball.radius, distance: ball.distance }
}

/// A place in the tree's coordinates.
fn from_input(tree: &Tree, place: [f64; 3]) -> DVec3 {
    DVec3::from(place) - DVec3::from(tree.meta().origin)
}

/// Leaves the cut that is asked for in `cut`, and says how it is to be drawn.
///
/// # Errors
/// An invalid file, a selection that cannot be used.
pub(crate) fn select(
    tree: &Tree,
    detail: &Detail,
    balls: &[Ball],
    cut: &mut Extraction,
) -> Result<Selection, Error> {
    let regions = balls.iter().map(|ball| region(tree, ball)).collect();
    let by = |scale: Scale| Selection { tolerance: scale.tolerance(tree), regions, ..Selection::full() };
    let selection = match *detail {
        Detail::Full | Detail::Budgets(..) => Selection::full(),
        Detail::Within(scale) => Selection { displaced: tree.promises_displaced(), ..by(scale) },
        Detail::Epsilon(scale) => by_epsilon(tree, by(scale))?,
    };
    extract(tree, &selection, cut)?;
    Ok(selection)
}

/// A budget is met when no more than this is left of it.
const NEARLY: u64 = 4;

/// The same for a budget, with the number that the next split would take where the budget is missed by far.
///
/// # Errors
/// As [`select`], and a limit when not even the coarsest mesh is within the budget; `path` is the tree's.
pub(crate) fn select_within(
    tree: &Tree,
    budget: Budget,
    eye: Option<[f64; 3]>,
    path: &Path,
    cut: &mut Extraction,
) -> Result<(Selection, Option<u64>), Error> {
    let mut shape = Selection::by_budget();
    if let Some(eye) = eye {
        shape.tolerance = Scale::Eye { eye, slope: 1.0 }.tolerance(tree);
    }
    let (things, asked) = match budget {
        Budget::Triangles(n) => ("triangle", n),
        Budget::Clusters(n) => ("cluster", n),
    };
    let (selection, fitted) = fit(tree, shape, budget, cut)?;
    if fitted.within {
        let missed = fitted.next.filter(|_| asked - fitted.count > NEARLY);
        return Ok((selection, missed));
    }
    // The other order keeps other vertices, and its coarsest mesh may be smaller.
    let coarsest = Selection::uniform(f64::INFINITY, Order::Bound);
    extract(tree, &coarsest, cut)?;
    let count = match budget {
        Budget::Triangles(_) => cut.stats.triangles,
        Budget::Clusters(_) => cut.stats.clusters,
    };
    if count <= asked {
        return Ok((coarsest, None));
    }
    Err(Error::Budget { path: path.to_owned(), things, asked, found: fitted.count.min(count) })
}
