//! How long an extraction takes, from scratch.

use std::error::Error;
use std::time::Instant;

use fcextract::{Extraction, Order, ParallelExtractor, Selection};
use fct::Tree;
use glam::DVec3;

use super::process::median;
use super::view::View;

/// Uniform tolerances, in diagonals of the mesh's box.
const TOLERANCES: [f64; 4] = [2e-3, 5e-4, 2e-4, 5e-5];

/// Errors in perspective, in pixels.
const PIXELS: [f64; 2] = [1.0, 0.25];

/// A selection and its name.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) selection: Selection,
}

/// What a case takes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Speed {
    pub(crate) triangles: u64,
    /// Nanoseconds a triangle on one thread: the least and the median of the runs.
    pub(crate) one: [f64; 2],
    /// The same on two.
    pub(crate) two: [f64; 2],
}

impl Speed {
    /// How many times as fast two threads are, by the least times.
    pub(crate) fn gain(&self) -> f64 {
        self.one[0] / self.two[0]
    }
}

/// The box of a tree's mesh.
pub(crate) fn bounds(tree: &Tree) -> [DVec3; 2] {
    [tree.meta().bounds_min, tree.meta().bounds_max].map(|p| DVec3::from_array(p.map(f64::from)))
}

/// What is measured of every mesh.
pub(crate) fn cases(tree: &Tree) -> Vec<Case> {
    let [low, high] = bounds(tree);
    let size = (high - low).length();
    let mut cases: Vec<Case> = TOLERANCES
        .iter()
        .map(|t| Case { name: format!("uniform {t}"), selection: Selection::uniform(t * size, Order::Bound) })
        .collect();
    cases.push(Case { name: "every face".to_owned(), selection: Selection::full() });
    if let Some(view) = View::around(low, high, 1).first() {
        for pixels in PIXELS {
            let selection = Selection::perspective(view.tolerance(pixels), Order::Bound);
            let culled = Selection {
                frustum: Some(view.frustum(size)),
                backface_eye: Some(view.eye),
                ..selection.clone()
            };
            cases.push(Case { name: format!("{pixels} pixel"), selection });
            cases.push(Case { name: format!("{pixels} pixel, culled"), selection: culled });
        }
    }
    cases
}

/// Times a case in turns of one and two threads. Memory is kept from run to run, as a program would.
///
/// # Errors
/// When the tree is damaged or a pool of threads cannot be made, or if two threads draw another mesh.
pub(crate) fn time(tree: &Tree, case: &Case, runs: u32) -> Result<Speed, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build()?;
    let (mut mesh, mut other, mut parallel) =
        (Extraction::default(), Extraction::default(), ParallelExtractor::default());
    let (mut one, mut two) = (Vec::new(), Vec::new());
    // The first round finds the memory and is not counted.
    for round in 0..=runs {
        let start = Instant::now();
        fcextract::extract(tree, &case.selection, &mut mesh)?;
        let single = start.elapsed();
        let start = Instant::now();
        pool.install(|| parallel.extract(tree, &case.selection, &mut other))?;
        let double = start.elapsed();
        if round > 0 {
            one.push(single.as_nanos() as f64);
            two.push(double.as_nanos() as f64);
        }
    }
    if mesh.indices != other.indices || mesh.stats != other.stats {
        return Err(format!("{}: two threads draw another mesh than one", case.name).into());
    }
    let triangles = mesh.stats.triangles;
    let per_triangle = |times: &[f64]| {
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        [least, median(times.iter().copied()).unwrap_or(f64::NAN)].map(|t| t / triangles.max(1) as f64)
    };
    Ok(Speed { triangles, one: per_triangle(&one), two: per_triangle(&two) })
}
