//! Which pages a frame needs.

use super::Paged;
use crate::Error;
use crate::frame::pieces;
use crate::frame::plan::Plan;
use crate::scene::Scene;
use fcextract::Extraction;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// A set of pages.
pub(crate) struct Needs {
    bits: Vec<AtomicU64>,
    count: AtomicU32,
}

impl Needs {
    fn new(pages: u32) -> Needs {
        let words = pages.div_ceil(64);
        Needs { bits: (0..words).map(|_| AtomicU64::new(0)).collect(), count: AtomicU32::new(0) }
    }

    /// Whether a page is among them.
    pub(crate) fn holds(&self, page: u32) -> bool {
        let word = self.bits.get(page as usize / 64);
        word.is_some_and(|word| word.load(Ordering::Relaxed) >> (page % 64) & 1 == 1)
    }

    fn add(&self, page: u32) {
        let bit = 1 << (page % 64);
        let Some(word) = self.bits.get(page as usize / 64) else { return };
        // Most are there already, and reading is cheaper.
        if word.load(Ordering::Relaxed) & bit == 0 && word.fetch_or(bit, Ordering::Relaxed) & bit == 0 {
            self.count.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn count(&self) -> u32 {
        self.count.load(Ordering::Relaxed)
    }
}

/// The pages that a plan needs if nothing is hidden; none if they are more than there are slots, which is found sooner.
///
/// # Errors
/// [`Error::Extract`] if a tree is damaged.
pub(crate) fn needs(paged: &Paged, scene: &Scene, plan: &Plan) -> Result<Option<Needs>, Error> {
    let needs = Needs::new(paged.pages());
    let whole = plan.whole(scene);
    let pieces = pieces::divide(scene, plan, &whole, &mut fcextract::Stats::default())?;
    pieces.par_iter().try_for_each_init(Extraction::default, |cut, piece| {
        let placed = plan.placed.get(piece.placed as usize);
        let Some((placed, model)) = placed.and_then(|p| Some((p, scene.models.get(p.model)?))) else {
            return Ok::<(), Error>(());
        };
        // Whoever passes the number of slots ends it for all.
        if needs.count() > paged.slots() {
            return Ok(());
        }
        cut.clear();
        cut.append(&model.tree, &placed.selection, &piece.part)
            .map_err(|source| Error::Extract { model: model.name.clone(), source })?;
        for vertex in &cut.indices {
            needs.add(paged.page(placed.model, *vertex));
        }
        Ok(())
    })?;
    Ok((needs.count() <= paged.slots()).then_some(needs))
}
