//! The figures that the trees are held against: ratios to a peer at the same number of triangles, and what a build
//! may take.

/// A number of triangles to simplify to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Size {
    /// So many.
    Count(u64),
    /// So many of a hundred faces of the input.
    Percent(f64),
}

/// Where the coarse end begins: below, equal to the peer is good enough.
const FINE: u64 = 5_000;

impl Size {
    /// Those of the bench when none are named.
    pub(crate) const DEFAULT: &str = "250,1000,5000,10%,50%";

    /// Reads `5000` or `10%`.
    ///
    /// # Errors
    /// A sentence for the command line.
    pub(crate) fn parse(text: &str) -> Result<Size, String> {
        let wrong =
            || "expected a number of triangles such as 5000, or a share of the faces such as 10%".to_owned();
        if let Some(share) = text.strip_suffix('%') {
            let share: f64 = share.trim().parse().map_err(|_not_a_number| wrong())?;
            return if share > 0.0 && share <= 100.0 { Ok(Size::Percent(share)) } else { Err(wrong()) };
        }
        match text.parse() {
            Ok(count) if count >= 4 => Ok(Size::Count(count)),
            _ => Err(wrong()),
        }
    }

    /// Triangles, for a mesh of so many faces; a share is rounded down, so that half is at most half.
    pub(crate) fn of(self, faces: usize) -> u64 {
        match self {
            Size::Count(count) => count,
            Size::Percent(share) => (faces as f64 * share / 100.0) as u64,
        }
    }

    fn is_fine(self) -> bool {
        match self {
            Size::Count(count) => count >= FINE,
            Size::Percent(_) => true,
        }
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Size::Count(count) => write!(f, "{count}"),
            Size::Percent(share) => write!(f, "{share} %"),
        }
    }
}

/// Largest ratio of the mean errors in the budget order to simplification with the input's vertices.
pub(crate) fn rms(mesh: &str, size: Size) -> f64 {
    match size {
        // Its scales are finer than such triangles: there the order of merging matters less.
        Size::Count(FINE) if mesh == "dragon" => 0.95,
        _ if size.is_fine() => 0.85,
        _ => 1.0,
    }
}

/// The same in the guaranteed order, where there is a figure.
pub(crate) fn guaranteed_rms(triangles: u64) -> Option<f64> {
    (triangles >= FINE).then_some(1.0)
}

/// Largest ratio of the mean errors to cluster LOD at its own cuts.
pub(crate) const CLUSTER_LOD: f64 = 0.85;

/// Largest ratio of the largest distances to simplification with the input's vertices.
pub(crate) const MAX: f64 = 1.2;

/// What is aimed at beyond: the mean error of quadrics with optimal placement.
pub(crate) const STRETCH: f64 = 1.0;

/// Building is judged from so many faces on.
pub(crate) const LARGE: usize = 500_000;

/// Least speed of a build with two threads.
pub(crate) const FACES_PER_SECOND: f64 = 600_000.0;

/// Most memory of a build at its peak, in bytes a face.
pub(crate) const PEAK: f64 = 200.0;

/// Largest file, in bytes a face.
pub(crate) const FILE: f64 = 45.0;

/// Largest ratio of time over n log n between a mesh and one that is smaller: one, and what noise adds.
pub(crate) const GROWTH: f64 = 1.1;

/// Most nanoseconds of an extraction for each triangle on one thread, on meshes from [`LARGE`] faces on, and in a frame
/// of many culled instances.
pub(crate) const EXTRACTION: f64 = 60.0;
pub(crate) const FRAME: f64 = 100.0;

/// Least gain of two threads, on meshes from [`LARGE`] faces on.
pub(crate) const GAIN: f64 = 1.7;

/// Bytes that a view reads of a file in parts over the bytes of the pages that hold what it draws.
pub(crate) const PAGES: f64 = 1.5;

/// Largest ratio of nanoseconds a triangle between a walk in jumps and one in steps.
pub(crate) const JUMP: f64 = 1.1;

/// Largest ratio of our triangles to cluster LOD's at the same error on the screen.
pub(crate) const SCREEN: f64 = 0.9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_numbers_or_shares() {
        assert_eq!(Size::parse("5000"), Ok(Size::Count(5_000)));
        assert_eq!(Size::parse("12.5%").map(|s| s.of(800)), Ok(100));
        for wrong in ["", "0", "3", "-5", "0%", "101%", "nan%", "many"] {
            assert!(Size::parse(wrong).is_err(), "{wrong}");
        }
        assert!(Size::DEFAULT.split(',').all(|s| Size::parse(s).is_ok()));
    }

    #[test]
    fn the_fine_end_asks_for_more_than_the_coarse() {
        let of = |size| rms("bunny", size);
        assert_eq!([250, 1_000, 5_000].map(|n| of(Size::Count(n))), [1.0, 1.0, 0.85]);
        assert_eq!((of(Size::Percent(10.0)), rms("dragon", Size::Count(5_000))), (0.85, 0.95));
    }
}
