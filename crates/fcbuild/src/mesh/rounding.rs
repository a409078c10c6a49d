//! What it costs to store in single precision what came in double precision.

use super::Weld;
use fct::counted;
use glam::DVec3;
use rayon::prelude::*;

/// How far the corners of faces are moved by rounding, beside the size of the faces.
///
/// Coordinates of a map that are stored relative to an origin lose nothing that matters: of a town 10 km wide they are
/// within half a millimetre. With one stray triangle at the coordinates 0 0 0 they would be within a metre.
/// Every number here scales with the mesh, so that the unit of length does not matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rounding {
    /// The farthest that a corner is moved (length).
    pub(crate) largest: f64,
    /// Faces that were looked at.
    pub(crate) faces: u64,
    /// Faces that are not at least [`FINE`] times as long as their corners are moved.
    pub(crate) coarse: u64,
    /// Faces of which two corners fall together that were apart; they are coarse too.
    pub(crate) collapsed: u64,
    /// The length that half of the coarse faces do not pass (length); see [`Rounding::of`].
    typical: f64,
}

/// A face this many times as long as its corners are moved keeps its form to the eye, and its normal to about a degree.
const FINE: f64 = 100.0;

/// One face of so many may be coarse: slivers and tiny details are in every model of a town.
const FEW: u64 = 100;

impl Rounding {
    /// Looks at all triangles; `exact` and `stored` give the places of a vertex before and after rounding.
    pub(crate) fn of(
        triangles: &[[u32; 3]],
        weld: Weld,
        exact: impl Fn(u32) -> DVec3 + Sync,
        stored: impl Fn(u32) -> DVec3 + Sync,
    ) -> Rounding {
        let places = |t: &[u32; 3]| (t.map(&exact), t.map(&stored));
        let all = triangles.par_iter().fold(Rounding::default, |mut sum, t| {
            let (exact, stored) = places(t);
            sum.add(exact, stored, weld);
            sum
        });
        let mut all = all.reduce(Rounding::default, |a, b| Rounding {
            largest: a.largest.max(b.largest),
            faces: a.faces + b.faces,
            coarse: a.coarse + b.coarse,
            collapsed: a.collapsed + b.collapsed,
            typical: 0.0,
        });
        if all.matters() {
            let is_coarse = |t: &&[u32; 3]| {
                let (exact, stored) = places(t);
                let mut own = Rounding::default();
                own.add(exact, stored, weld);
                own.coarse > 0
            };
            let mut lengths: Vec<f64> =
                triangles.iter().filter(is_coarse).map(|t| length(t.map(&exact))).collect();
            let middle = lengths.len().saturating_sub(1) / 2;
            all.typical = *lengths.select_nth_unstable_by(middle, f64::total_cmp).1;
        }
        all
    }

    /// Looks at one face, whose vertices within the distance of `weld` are meant to fall together.
    pub(crate) fn add(&mut self, exact: [DVec3; 3], stored: [DVec3; 3], weld: Weld) {
        self.faces += 1;
        let moved = [0, 1, 2].map(|i| exact[i].distance(stored[i])).into_iter().fold(0.0, f64::max);
        self.largest = self.largest.max(moved);
        let apart = if let Weld::Within(distance) = weld { distance } else { 0.0 };
        let falls = |a: usize, b: usize| stored[a] == stored[b] && exact[a].distance(exact[b]) > apart;
        let collapses = falls(0, 1) || falls(1, 2) || falls(2, 0);
        // What has no length has none to lose.
        let length = length(exact);
        self.coarse += u64::from(collapses || length > 0.0 && length < FINE * moved);
        self.collapsed += u64::from(collapses);
    }

    /// Whether the form of the surface suffers.
    pub(crate) fn matters(&self) -> bool {
        self.collapsed > 0 || self.coarse > self.faces / FEW
    }

    /// What to tell of it: how many faces, and a sentence; nothing if it does not matter.
    pub(crate) fn told(&self) -> Option<(u64, String)> {
        let are = if self.coarse == 1 { "is" } else { "are" };
        let collapsed = match self.collapsed {
            0 => String::new(),
            n => format!("; of {} two corners fall together", counted(n, "face")),
        };
        self.matters().then(|| {
            let message = format!(
                "{} {are} small beside the rounding from double to single precision, which moves corners by up to {}: \
                 the longest edges of such faces are about {}{collapsed}; errors and bounds count from the rounded \
                 surface; {REMEDY}",
                counted(self.coarse, "face"),
                short(self.largest),
                short(self.typical),
            );
            (self.coarse, message)
        })
    }
}

/// What a user can do.
pub(crate) const REMEDY: &str = "build parts that lie far apart as files of their own, leave out what is there by mistake, or move parts together";

/// The longest edge.
fn length([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// Three digits are enough for people.
fn short(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces of this length in a row at `x`, rounded as single precision would do there.
    fn rounded(length: f64, x: f64, faces: u32, weld: Weld) -> Rounding {
        let exact = |v: u32| DVec3::new(x + length * f64::from(v / 2), f64::from(v % 2) * length, 0.0);
        let triangles: Vec<[u32; 3]> = (0..faces).map(|f| [f, f + 1, f + 2]).collect();
        Rounding::of(&triangles, weld, exact, |v| exact(v).as_vec3().as_dvec3())
    }

    #[test]
    fn faces_are_held_against_their_own_corners() {
        // At four million single precision steps by half a unit, or a quarter.
        let fine = rounded(40.1, 4e6, 1000, Weld::Exact);
        assert!(!fine.matters() && fine.largest > 0.05 && fine.told().is_none(), "{fine:?}");
        let coarse = rounded(3.1, 4e6, 1000, Weld::Exact);
        let (count, said) = coarse.told().unwrap();
        assert!(count > 900 && coarse.collapsed == 0 && said.contains("are about 4.38"), "{count} {said}");
        let gone = rounded(0.03, 4e6, 1000, Weld::Exact);
        assert!(gone.collapsed > 500 && gone.told().unwrap().1.contains("two corners"), "{gone:?}");
        // What is welded on purpose is not lost by rounding.
        assert_eq!(rounded(0.03, 4e6, 1000, Weld::Within(0.1)).collapsed, 0);
    }

    #[test]
    fn the_unit_does_not_matter() {
        let told = |scale: f64, length: f64| {
            let rounding = rounded(length * scale, 4e6 * scale, 500, Weld::Exact);
            (rounding.coarse, rounding.collapsed, rounding.largest / scale, rounding.typical / scale)
        };
        for length in [0.03, 3.1, 40.1] {
            for scale in [2.0_f64.powi(-60), 0.125, 2.0_f64.powi(70)] {
                assert_eq!(told(scale, length), told(1.0, length), "{length} {scale}");
            }
        }
    }
}
