//! The implicit shape of the sculpture: an elephant that carries a pavilion and stands on a plinth.
//!
//! X points forward, Y up, Z to its left; the elephant is about 2 long. Skin is smooth with folds and fine relief, the
//! ears and the cloth are thin, plinth and pavilion are flat with sharp creases.

use glam::{DVec2, DVec3};

use super::distance::{Rope, blend, cuboid, ellipsoid, extruded, ramp, rectangle, wave, without, zigzag};
use super::noise;

/// Lower corner of the cube that holds the sculpture.
pub(crate) const LOW: DVec3 = DVec3::new(-1.27, -0.61, -1.67);

/// Side of that cube.
pub(crate) const SIZE: f64 = 3.35;

/// Wavelength of the coarsest relief.
const RELIEF: f64 = 0.21;

/// The shape, with as much fine relief as the edge length can carry.
#[derive(Debug)]
pub(crate) struct Field {
    legs: Vec<Rope>,
    trunk: Rope,
    tusk: Rope,
    tail: Rope,
    octaves: u32,
}

fn rope(stations: &[[f64; 4]], steps: u32) -> Rope {
    let stations: Vec<(DVec3, f64)> =
        stations.iter().map(|[x, y, z, r]| (DVec3::new(*x, *y, *z), *r)).collect();
    Rope::new(&stations, steps)
}

impl Field {
    /// The shape for a mesh with edges of about `length`.
    pub(crate) fn new(length: f64) -> Field {
        // An octave is kept while three edges fit into its wavelength.
        let mut octaves = 0;
        let mut wavelength = RELIEF;
        while wavelength > 3.0 * length && octaves < 6 {
            octaves += 1;
            wavelength *= 0.5;
        }
        let legs = [
            [
                [0.30, 0.92, 0.20, 0.20],
                [0.36, 0.55, 0.21, 0.15],
                [0.33, 0.22, 0.21, 0.125],
                [0.34, -0.05, 0.21, 0.16],
            ],
            [
                [0.30, 0.90, -0.20, 0.20],
                [0.50, 0.58, -0.21, 0.15],
                [0.53, 0.34, -0.21, 0.12],
                [0.56, 0.12, -0.21, 0.15],
            ],
            [
                [-0.42, 0.88, 0.19, 0.24],
                [-0.38, 0.52, 0.21, 0.165],
                [-0.50, 0.24, 0.21, 0.125],
                [-0.46, -0.05, 0.21, 0.155],
            ],
            [
                [-0.42, 0.88, -0.19, 0.24],
                [-0.50, 0.52, -0.21, 0.165],
                [-0.66, 0.24, -0.21, 0.125],
                [-0.64, -0.05, -0.21, 0.155],
            ],
        ];
        Field {
            legs: legs.iter().map(|l| rope(l, 3)).collect(),
            trunk: rope(
                &[
                    [0.90, 1.16, 0.0, 0.19],
                    [1.06, 0.98, 0.0, 0.155],
                    [1.26, 0.88, 0.02, 0.125],
                    [1.45, 0.96, 0.05, 0.105],
                    [1.53, 1.19, 0.08, 0.092],
                    [1.47, 1.44, 0.09, 0.082],
                    [1.43, 1.67, 0.07, 0.074],
                    [1.54, 1.86, 0.04, 0.066],
                    [1.70, 1.86, 0.02, 0.060],
                ],
                4,
            ),
            tusk: rope(
                &[
                    [0.90, 1.03, 0.13, 0.062],
                    [1.06, 0.86, 0.21, 0.056],
                    [1.26, 0.78, 0.26, 0.045],
                    [1.45, 0.85, 0.25, 0.032],
                    [1.54, 0.97, 0.22, 0.020],
                ],
                3,
            ),
            tail: rope(
                &[
                    [-0.66, 1.18, 0.0, 0.06],
                    [-0.80, 1.06, 0.02, 0.045],
                    [-0.87, 0.80, 0.05, 0.036],
                    [-0.90, 0.58, 0.08, 0.034],
                    [-0.93, 0.48, 0.09, 0.055],
                    [-0.95, 0.36, 0.10, 0.03],
                ],
                3,
            ),
            octaves,
        }
    }

    /// Roughly the signed distance in the sculpture's units, negative inside.
    pub(crate) fn value(&self, p: DVec3) -> f64 {
        let stone = plinth(p);
        // Below the top of the plinth the elephant is only inside it.
        if p.y < -0.03 {
            return stone;
        }
        let built = stone.min(pavilion(p));
        // Boxes around the body, the head with ears and tusks, and the raised trunk.
        let body = cuboid(p - DVec3::new(-0.09, 0.75, 0.0), DVec3::new(0.91, 0.78, 0.47));
        let front = cuboid(p - DVec3::new(0.98, 1.15, 0.0), DVec3::new(0.62, 0.49, 0.67));
        let trunk = cuboid(p - DVec3::new(1.53, 1.53, 0.05), DVec3::new(0.26, 0.42, 0.14));
        if body.min(front).min(trunk) > built.min(0.1) {
            return built.min(body.min(front).min(trunk));
        }
        let torso = torso(p);
        let mut d = self.skin(p, torso);
        let mirrored = DVec3::new(p.x, p.y, p.z.abs());
        if self.tusk.within(mirrored, d + 0.03) {
            d = blend(d, self.tusk.distance(mirrored).0, 0.03);
        }
        d.min(cloth(p, torso)).min(built)
    }

    fn skin(&self, p: DVec3, torso: f64) -> f64 {
        let mut d = torso;
        for leg in &self.legs {
            if leg.within(p, d + 0.15) {
                let (to_leg, along) = leg.distance(p);
                // Folds from the knee down to the ankle.
                let share = ramp(along, 0.3, 0.5) * (1.0 - ramp(along, 0.75, 0.85));
                let folds = if to_leg.abs() < 0.1 { 0.005 * share * crooked(p, along) } else { 0.0 };
                d = blend(d, to_leg - folds, 0.15);
            }
        }
        d = blend(d, nails(p), 0.02);
        if self.tail.within(p, d + 0.06) {
            d = blend(d, self.tail.distance(p).0, 0.06);
        }
        if (p - DVec3::new(0.8, 1.2, 0.0)).length() < d + 1.1 {
            d = blend(d, head(p), 0.16);
            d = blend(d, ear(DVec3::new(p.x, p.y, p.z.abs())), 0.05);
        }
        if self.trunk.within(p, d + 0.12) {
            let (to_trunk, along) = self.trunk.distance(p);
            let share = ramp(along, 0.1, 0.35);
            let folds = if to_trunk.abs() < 0.1 { 0.008 * share * crooked(p, along) } else { 0.0 };
            d = blend(d, to_trunk - folds, 0.12);
        }
        if d.abs() < 0.06 {
            d -= 0.015 * noise::octaves(p / RELIEF, self.octaves, 3);
        }
        d
    }
}

/// Folds across a limb, 0 in the creases, uneven so that they do not look turned on a lathe.
fn crooked(p: DVec3, along: f64) -> f64 {
    wave((along + 0.025 * noise::value(p / 0.15, 17)) / 0.085)
}

/// Where the feet stand: x, y, z of the middle of the sole.
const FEET: [[f64; 3]; 4] = [[0.34, 0.0, 0.21], [0.56, 0.11, -0.21], [-0.46, 0.0, 0.21], [-0.64, 0.0, -0.21]];

/// Three nails in front of each foot.
fn nails(p: DVec3) -> f64 {
    let mut d = f64::INFINITY;
    for [x, y, z] in FEET {
        let q = p - DVec3::new(x, y, z);
        if q.length_squared() < 0.09 {
            for (front, side) in [(0.148, 0.0), (0.118, 0.088), (0.118, -0.088)] {
                d = d.min(ellipsoid(q - DVec3::new(front, 0.025, side), DVec3::new(0.03, 0.05, 0.036)));
            }
        }
    }
    d
}

/// Trunk of the body, without limbs.
fn torso(p: DVec3) -> f64 {
    let at = |x: f64, y: f64, rx: f64, ry: f64, rz: f64| {
        ellipsoid(p - DVec3::new(x, y, 0.0), DVec3::new(rx, ry, rz))
    };
    let middle = at(-0.05, 0.98, 0.62, 0.40, 0.38);
    let shoulders = at(0.34, 1.04, 0.36, 0.38, 0.33);
    let rump = at(-0.40, 1.00, 0.34, 0.38, 0.34);
    blend(blend(middle, shoulders, 0.2), rump, 0.2)
}

fn head(p: DVec3) -> f64 {
    let at = |x: f64, y: f64, z: f64, rx: f64, ry: f64, rz: f64| {
        ellipsoid(DVec3::new(p.x - x, p.y - y, p.z.abs() - z), DVec3::new(rx, ry, rz))
    };
    let mut d = at(0.80, 1.24, 0.0, 0.25, 0.29, 0.23);
    d = blend(d, at(0.62, 1.16, 0.0, 0.24, 0.26, 0.24), 0.12);
    d = blend(d, at(0.80, 1.42, 0.09, 0.14, 0.13, 0.12), 0.1);
    d = blend(d, at(0.84, 1.00, 0.0, 0.15, 0.13, 0.14), 0.1);
    d = blend(d, at(0.97, 0.92, 0.0, 0.12, 0.06, 0.06), 0.08);
    // A brow, and the eyeball set under it.
    d = blend(d, at(0.94, 1.32, 0.17, 0.08, 0.045, 0.06), 0.05);
    let eye = DVec3::new(p.x - 0.955, p.y - 1.265, p.z.abs() - 0.175).length() - 0.048;
    d.min(eye)
}

/// The left ear: a thin bent slab with a sharp rim.
fn ear(p: DVec3) -> f64 {
    let q = p - DVec3::new(0.68, 1.27, 0.19);
    // Along the ear outward and back, across it forward; 3-4-5 keeps the turn exact.
    let out = 0.8 * q.z - 0.6 * q.x;
    let across = 0.6 * q.z + 0.8 * q.x;
    let disc = |u: f64, v: f64, r: f64| DVec2::new(out - u, q.y - v).length() - r;
    let mut outline = blend(disc(0.26, 0.08, 0.25), disc(0.20, -0.22, 0.18), 0.15);
    outline = blend(outline, disc(0.10, 0.0, 0.16), 0.1);
    outline = blend(outline, disc(0.17, -0.42, 0.05), 0.2);
    let flutter = ramp(q.y, -0.45, -0.15) - ramp(q.y, -0.15, 0.2);
    let bend = 0.35 * (out - 0.12) * (out - 0.12) - 0.07 * flutter * ramp(out, 0.05, 0.4);
    extruded(outline, (across - bend).abs() - 0.030) * 0.85
}

/// A saddle cloth with a hem and a diamond pattern, a shell over the torso.
fn cloth(p: DVec3, torso: f64) -> f64 {
    let middle = DVec3::new(p.x + 0.06, p.y - 1.2, p.z);
    let rim = cuboid(middle, DVec3::new(0.33, 0.42, 0.9));
    if torso.max(rim) > 0.1 {
        return torso.max(rim);
    }
    let hem = 0.016 * (1.0 - ramp(-rim, 0.045, 0.052));
    // Lozenges with sharp ridges in the field between the hems.
    let lozenge = zigzag(p.x / 0.24 + p.y / 0.24) + zigzag(p.x / 0.24 - p.y / 0.24);
    let raised = 0.028 * (lozenge - 1.15).clamp(0.0, 0.6) * ramp(-rim, 0.06, 0.07);
    (torso - 0.035 - hem - raised).max(rim)
}

/// Four square columns, a floor and a pyramid roof with a ball on top.
fn pavilion(p: DVec3) -> f64 {
    let q = p - DVec3::new(-0.06, 1.36, 0.0);
    let bound = cuboid(q - DVec3::Y * 0.45, DVec3::new(0.36, 0.5, 0.3));
    if bound > 0.1 {
        return bound;
    }
    let floor = cuboid(q - DVec3::Y * 0.04, DVec3::new(0.29, 0.06, 0.24));
    let step = cuboid(q - DVec3::Y * 0.12, DVec3::new(0.25, 0.03, 0.20));
    let column =
        cuboid(DVec3::new(q.x.abs() - 0.19, q.y - 0.34, q.z.abs() - 0.14), DVec3::new(0.042, 0.22, 0.042));
    let beam = cuboid(q - DVec3::Y * 0.56, DVec3::new(0.25, 0.035, 0.20));
    let eaves = cuboid(q - DVec3::Y * 0.61, DVec3::new(0.31, 0.025, 0.26));
    let up = q.y - 0.62;
    let side = ((q.x.abs() - 0.27) * 0.6 + up * 0.8).max((q.z.abs() - 0.22) * 0.6 + up * 0.8);
    let roof = side.max(-up);
    let ball = (q - DVec3::Y * 0.80).length() - 0.055;
    floor.min(step).min(column).min(beam).min(eaves).min(roof).min(ball)
}

/// Two steps, the upper with sunk panels, and the small block under the raised foot.
fn plinth(p: DVec3) -> f64 {
    if p.y > 0.4 {
        return p.y - 0.2;
    }
    let q = p;
    let upper = cuboid(q + DVec3::Y * 0.14, DVec3::new(0.98, 0.14, 0.42));
    let lower = cuboid(q + DVec3::Y * 0.34, DVec3::new(1.08, 0.08, 0.52));
    let block = cuboid(q - DVec3::new(0.58, 0.05, -0.22), DVec3::new(0.21, 0.06, 0.19));
    // A row of sunk panels round the upper step, each with a low pyramid in it.
    // Seven panels along and three across fill the sides evenly.
    let along = if q.x.abs() - 0.98 > q.z.abs() - 0.42 { q.z } else { q.x };
    let share = along / 0.28 + 0.5;
    let u = ((share - share.floor()) - 0.5).abs() * 0.28;
    let v = (q.y + 0.14).abs();
    let inner = (u - 0.105).max(v - 0.085);
    let depth = 0.032 - 0.45 * (-inner - 0.02).max(0.0);
    let skin = -rectangle(DVec2::new(q.x, q.z), DVec2::new(0.98, 0.42));
    let groove = inner.max((skin - depth) * 0.9);
    without(upper, groove).min(lower).min(block)
}
