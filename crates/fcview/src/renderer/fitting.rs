//! How much detail fits into the memory for vertices.
//!
//! A frame whose pages are more than there are slots is drawn coarser: the tolerance is multiplied by the least of some
//! factors at which they fit, or a number of triangles divided by it. Which pages those are is found from what the
//! view shows if it is culled by frustum and cones and nothing is hidden, whatever is really culled, and from nothing
//! before the frame: one view is always drawn alike.

use super::Renderer;
use crate::Error;
use crate::camera::View;
use crate::frame::plan::Plan;
use crate::options::{Detail, FrameOptions};
use crate::residency::{Needs, Paged, Residency, needs};
use crate::scene::Scene;
use crate::stats::{COARSEST, FrameStats};
use fcextract::Fitter;

/// Halvings of the interval between a factor that is too small and twice as much: the factor ends within a tenth of the
/// least one.
const HALVINGS: u32 = 3;

/// What fits.
pub(super) struct Fit {
    pub(super) detail: Detail,
    /// The factor: 1 where all fits, [`COARSEST`] where the coarsest mesh is drawn.
    pub(super) coarser: f64,
}

impl Renderer {
    /// Finds how much detail to draw, and begins the frame's account of pages.
    pub(super) fn fit_into_memory(
        &mut self,
        scene: &Scene,
        chooser: &View,
        view: &View,
        options: &FrameOptions,
    ) -> Result<Fit, Error> {
        let Residency::Paged(paged) = &mut self.residency else {
            return Ok(Fit { detail: options.detail, coarser: 1.0 });
        };
        // Every face is every face: pages come and go within the frame.
        if options.detail == Detail::Full {
            paged.begin_frame(None);
            return Ok(Fit { detail: options.detail, coarser: 1.0 });
        }
        let mut search = Search { paged, scene, chooser, view, options, fitter: &mut self.fitter };
        let (coarser, needs) = search.least_factor()?;
        paged.begin_frame(needs.as_ref());
        Ok(Fit { detail: times(options.detail, coarser), coarser })
    }
}

struct Search<'a> {
    paged: &'a Paged,
    scene: &'a Scene,
    chooser: &'a View,
    view: &'a View,
    options: &'a FrameOptions,
    fitter: &'a mut Fitter,
}

impl Search<'_> {
    /// The factor, and what is needed there; the coarsest mesh may need more than fits.
    fn least_factor(&mut self) -> Result<(f64, Option<Needs>), Error> {
        if let Some(needs) = self.at(1.0)? {
            return Ok((1.0, Some(needs)));
        }
        let mut high = 2.0;
        let mut found = loop {
            match self.at(high)? {
                Some(needs) if high < COARSEST => break needs,
                needs if high >= COARSEST => return Ok((COARSEST, needs)),
                _ => high *= 2.0,
            }
        };
        // Too small and large enough, a factor of two apart.
        let mut low = 0.5 * high;
        for _ in 0..HALVINGS {
            let middle = (low * high).sqrt();
            match self.at(middle)? {
                Some(needs) => (high, found) = (middle, needs),
                None => low = middle,
            }
        }
        Ok((high, Some(found)))
    }

    /// What is needed at a factor, if it fits.
    fn at(&mut self, factor: f64) -> Result<Option<Needs>, Error> {
        let detail = times(self.options.detail, factor);
        let culled = FrameOptions { detail, frustum: true, backface: true, ..*self.options };
        let mut stats = FrameStats::default();
        let plan = Plan::new(self.scene, self.chooser, self.view, &culled, self.fitter, &mut stats)?;
        needs(self.paged, self.scene, &plan)
    }
}

/// So many times less detail.
fn times(detail: Detail, factor: f64) -> Detail {
    match detail {
        _ if factor == 1.0 => detail,
        Detail::Full => Detail::Full,
        Detail::Triangles(_) if factor >= COARSEST => Detail::Triangles(1),
        Detail::Triangles(triangles) => Detail::Triangles(((triangles as f64 / factor) as u64).max(1)),
        _ if factor >= COARSEST => Detail::Distance(f64::INFINITY),
        Detail::Pixels(pixels) => Detail::Pixels(pixels * factor),
        Detail::Distance(distance) => Detail::Distance(distance * factor),
        Detail::Gain(pixels) => Detail::Gain(pixels * factor),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_detail_is_a_larger_tolerance_or_fewer_triangles() {
        assert_eq!(times(Detail::Pixels(0.5), 4.0), Detail::Pixels(2.0));
        assert_eq!(times(Detail::Gain(0.5), 4.0), Detail::Gain(2.0));
        assert_eq!(times(Detail::Distance(0.1), 1.0), Detail::Distance(0.1));
        assert_eq!(times(Detail::Triangles(1000), 4.0), Detail::Triangles(250));
        assert_eq!(times(Detail::Triangles(u64::MAX), COARSEST), Detail::Triangles(1));
        assert_eq!(times(Detail::Pixels(0.5), COARSEST), Detail::Distance(f64::INFINITY));
        assert_eq!(times(Detail::Full, 4.0), Detail::Full);
    }
}
