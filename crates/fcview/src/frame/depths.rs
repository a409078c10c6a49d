//! The depth drawn so far in this machine's memory, and whether a polygon would show before it.
//!
//! A driver that is a program has its depth there already, so that a copy costs little more than the wait for it, while
//! each of its occlusion queries costs as much as some hundred triangles.
//!
//! # Paper
//! [Tsuji07, 5.3]: "a visibility test is performed for the polygons enclosing clusters".
//!
//! # Deviations
//! The test is made on a copy of the depth, and tile by tile where that tells; the answer is that of a query.

use glam::{DVec2, DVec3, DVec4, Vec4};
use rayon::prelude::*;

/// Width and height of a tile, pixels: large enough that most of a hidden polygon is found hidden tile by tile, small enough
/// that a silhouette spoils few pixels around it.
const TILE: usize = 8;

/// A picture's depth: 1 at the near plane, 0 where nothing is drawn; a sample at the middle of each pixel.
#[derive(Default)]
pub(crate) struct Depths {
    size: [usize; 2],
    /// Row by row from the top.
    pixels: Vec<f32>,
    /// The farthest of each tile, row by row.
    tiles: Vec<f32>,
}

impl Depths {
    /// Takes a picture's depth over from its rows, of which each is at least as long as the picture is wide.
    pub(crate) fn fill(&mut self, [width, height]: [u32; 2], rows: &[f32], row: usize) {
        let [width, height] = [width as usize, height as usize];
        self.size = [width, height];
        self.pixels.resize(width * height, 0.0);
        let across = width.div_ceil(TILE);
        self.tiles.resize(across * height.div_ceil(TILE), 0.0);
        self.pixels
            .par_chunks_mut(TILE * width)
            .zip(self.tiles.par_chunks_mut(across))
            .zip(rows.par_chunks(TILE * row))
            .for_each(|((pixels, tiles), rows)| {
                for (pixels, from) in pixels.chunks_mut(width).zip(rows.chunks(row)) {
                    let Some(from) = from.get(..width) else { continue };
                    pixels.copy_from_slice(from);
                }
                for (tile, x) in tiles.iter_mut().zip((0..width).step_by(TILE)) {
                    let rows = pixels.chunks(width).filter_map(|row| row.get(x..width.min(x + TILE)));
                    *tile = farthest(rows);
                }
            });
    }

    /// Whether a point in clip space, before the eye, lies in a pixel of the picture that nothing before it covers.
    pub(crate) fn is_open_at(&self, clip: DVec4) -> bool {
        let [width, height] = self.size;
        let x = 0.5 * (1.0 + clip.x / clip.w) * width as f64;
        let y = 0.5 * (1.0 - clip.y / clip.w) * height as f64;
        let is_in = x >= 0.0 && x < width as f64 && y >= 0.0 && y < height as f64;
        let depth = self.pixels.get(y as usize * width + x as usize);
        is_in && depth.is_some_and(|depth| f64::from(*depth) <= clip.z / clip.w)
    }

    /// Whether a convex polygon in clip space, all of it before the eye, has a pixel's middle where nothing is before it.
    pub(crate) fn show(&self, polygon: &[[f32; 4]]) -> bool {
        let [width, height] = self.size;
        let size = DVec2::new(width as f64, height as f64);
        let Some(flat) = Flat::new(polygon, size) else { return !polygon.is_empty() };
        // Pixels whose middles may lie inside: from the first to before the last.
        let [x, y] = [0, 1].map(|k| {
            let first = (flat.low[k] - 0.5).ceil().clamp(0.0, size[k]) as usize;
            let last = (flat.high[k] + 0.5).floor().clamp(0.0, size[k]) as usize;
            first..last
        });
        let across = width.div_ceil(TILE);
        if x.is_empty() || y.is_empty() {
            return false;
        }
        for tile_y in y.start / TILE..y.end.div_ceil(TILE) {
            for tile_x in x.start / TILE..x.end.div_ceil(TILE) {
                let farthest = self.tiles.get(tile_y * across + tile_x).copied().unwrap_or(0.0);
                let corner = DVec2::new(tile_x as f64, tile_y as f64) * TILE as f64;
                if flat.is_behind(corner, f64::from(farthest)) {
                    continue;
                }
                for y in y.start.max(tile_y * TILE)..y.end.min((tile_y + 1) * TILE) {
                    for x in x.start.max(tile_x * TILE)..x.end.min((tile_x + 1) * TILE) {
                        let depth = self.pixels.get(y * width + x).copied().unwrap_or(0.0);
                        if flat.is_before(DVec2::new(x as f64, y as f64) + 0.5, f64::from(depth)) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }
}

/// The farthest depth of a tile; few numbers are as few instructions four at a time as one by one.
#[inline]
fn farthest<'a>(rows: impl Iterator<Item = &'a [f32]>) -> f32 {
    let mut farthest = Vec4::ONE;
    for row in rows {
        let (fours, rest) = row.as_chunks::<4>();
        for four in fours {
            farthest = farthest.min(Vec4::from(*four));
        }
        for depth in rest {
            farthest = farthest.min(Vec4::splat(*depth));
        }
    }
    farthest.min_element()
}

/// A polygon in the picture: pixels from the left and the top, and depths on a plane that is nowhere behind its corners.
struct Flat {
    /// For each side what grows from it inwards: the gradient, and the value at the origin.
    sides: [(DVec2, f64); MOST_CORNERS],
    count: usize,
    gradient: DVec2,
    /// The plane's depth at the origin.
    depth: f64,
    nearest: f64,
    low: DVec2,
    high: DVec2,
}

/// The most corners of a polygon that is asked about.
const MOST_CORNERS: usize = 8;

impl Flat {
    /// None if it is none, or has no area, which then may show.
    fn new(polygon: &[[f32; 4]], size: DVec2) -> Option<Flat> {
        let mut corners = [DVec3::ZERO; MOST_CORNERS];
        let corners = corners.get_mut(..polygon.len())?;
        for (corner, clip) in corners.iter_mut().zip(polygon) {
            let [x, y, z, w] = clip.map(f64::from);
            *corner = DVec3::new(0.5 * (1.0 + x / w) * size.x, 0.5 * (1.0 - y / w) * size.y, z / w);
        }
        let first = *corners.first()?;
        let next = |k: usize| corners.get((k + 1) % corners.len()).copied().unwrap_or(first);
        // Newell's normal; its third component is twice the area.
        let mut normal = DVec3::ZERO;
        for (k, corner) in corners.iter().enumerate() {
            normal += (*corner - first).cross(next(k) - first);
        }
        let mut flat = Flat {
            sides: [(DVec2::ZERO, 0.0); MOST_CORNERS],
            count: corners.len(),
            gradient: -normal.truncate() / normal.z,
            depth: f64::NEG_INFINITY,
            nearest: f64::NEG_INFINITY,
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        };
        if !(flat.gradient.is_finite() && normal.z != 0.0) {
            return None;
        }
        for ((k, corner), side) in corners.iter().enumerate().zip(&mut flat.sides) {
            let place = corner.truncate();
            let inwards = normal.z.signum() * (next(k).truncate() - place).perp();
            *side = (inwards, -inwards.dot(place));
            flat.depth = flat.depth.max(corner.z - flat.gradient.dot(place));
            flat.nearest = flat.nearest.max(corner.z);
            flat.low = flat.low.min(place);
            flat.high = flat.high.max(place);
        }
        Some(flat)
    }

    /// Whether what lies in the tile at this corner is outside the polygon, or the polygon behind this depth there.
    fn is_behind(&self, corner: DVec2, depth: f64) -> bool {
        let half = DVec2::splat(0.5 * TILE as f64);
        let most = |gradient: DVec2, at: f64| at + gradient.dot(corner + half) + gradient.abs().dot(half);
        most(self.gradient, self.depth).min(self.nearest) < depth
            || self.sides.iter().take(self.count).any(|(inwards, at)| most(*inwards, *at) < 0.0)
    }

    /// Whether a point lies in the polygon, and that not behind a depth.
    fn is_before(&self, point: DVec2, depth: f64) -> bool {
        let before = (self.depth + self.gradient.dot(point)).min(self.nearest) >= depth;
        before && self.sides.iter().take(self.count).all(|(inwards, at)| inwards.dot(point) + at >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const SIZE: [u32; 2] = [61, 37];

    /// A corner at a place of the picture in pixels, at a depth, seen by an eye that it is `w` before.
    fn clip([x, y]: [f64; 2], depth: f64, w: f64) -> [f32; 4] {
        let [width, height] = SIZE.map(f64::from);
        [w * (2.0 * x / width - 1.0), w * (1.0 - 2.0 * y / height), w * depth, w].map(|c| c as f32)
    }

    /// Depths of some boxes over each other, in rows that are longer than the picture is wide.
    fn picture(random: &mut Random) -> (Vec<f32>, usize) {
        let [width, height] = SIZE.map(|size| size as usize);
        let row = width + 3;
        let mut rows = vec![0.0_f32; row * height];
        for _ in 0..random.below(9) {
            let [x, y] = [width, height].map(|size| random.below(size as u64) as usize);
            let [wide, high] = [width - x, height - y].map(|size| random.below(size as u64) as usize + 1);
            let depth = random.unit() as f32;
            for row in rows.chunks_mut(row).skip(y).take(high) {
                row[x..x + wide].iter_mut().for_each(|pixel| *pixel = pixel.max(depth));
            }
        }
        (rows, row)
    }

    /// By the definition: whether the polygon, moved toward the eye and grown by a hair, has a pixel's middle before which
    /// there is nothing. The hair may be negative.
    fn shows(rows: &[f32], row: usize, corners: &[DVec3], hair: f64) -> bool {
        let [width, height] = SIZE.map(|size| size as usize);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let sides = || corners.iter().zip(corners.iter().cycle().skip(1));
        (0..width * height).any(|k| {
            let [x, y] = [k % width, k / width];
            let point = DVec2::new(x as f64, y as f64) + 0.5;
            let inside = sides().all(|(a, b)| {
                let side = (b - a).truncate();
                side.perp_dot(point - a.truncate()) * normal.z.signum() >= -hair * side.length()
            });
            let offset = point - corners[0].truncate();
            let depth = corners[0].z - normal.truncate().dot(offset) / normal.z;
            inside && depth + hair >= f64::from(rows[y * row + x])
        })
    }

    #[test]
    fn a_polygon_shows_where_a_pixel_of_it_does() {
        let mut random = Random::new(4);
        let mut depths = Depths::default();
        let mut hidden = 0;
        for _ in 0..300 {
            let (rows, row) = picture(&mut random);
            depths.fill(SIZE, &rows, row);
            for _ in 0..30 {
                // A regular polygon about some place in and around the picture, in either winding, on a slanting plane.
                let count = [3, 4, 8][random.below(3) as usize];
                let middle = SIZE.map(|size| f64::from(size) * (1.4 * random.unit() - 0.2));
                let radius = 30.0 * random.unit() * random.unit();
                let turn = 7.0 * random.unit() * if random.below(2) == 0 { 1.0 } else { -1.0 };
                let slope = [0, 1].map(|_| 0.01 * (random.unit() - 0.5));
                let depth = 0.3 + 0.4 * random.unit();
                let corners: Vec<DVec3> = (0..count)
                    .map(|k| {
                        let (sin, cos) = (turn
                            + turn.signum() * std::f64::consts::TAU * f64::from(k) / f64::from(count))
                        .sin_cos();
                        let [x, y] = [radius * cos, radius * sin];
                        DVec3::new(middle[0] + x, middle[1] + y, depth + slope[0] * x + slope[1] * y)
                    })
                    .collect();
                let polygon: Vec<[f32; 4]> = corners
                    .iter()
                    .map(|corner| clip([corner.x, corner.y], corner.z, 0.5 + 4.0 * random.unit()))
                    .collect();
                let found = depths.show(&polygon);
                assert!(found || !shows(&rows, row, &corners, -1e-4), "{corners:?} is not hidden");
                assert!(!found || shows(&rows, row, &corners, 1e-4), "{corners:?} is hidden");
                hidden += u32::from(!found);
            }
        }
        assert!((2000..7000).contains(&hidden), "{hidden} of 9000");
    }

    #[test]
    fn a_point_is_open_where_nothing_is_before_it() {
        let mut depths = Depths::default();
        let mut rows = [0.0; 61 * 37];
        rows[10 * 61 + 20] = 0.5;
        depths.fill(SIZE, &rows, 61);
        let is_open = |x: f64, y: f64, depth: f64| {
            let point = clip([x, y], depth, 3.0).map(f64::from);
            depths.is_open_at(DVec4::from_array(point))
        };
        assert!(is_open(20.5, 10.5, 0.6) && !is_open(20.5, 10.5, 0.4));
        assert!(is_open(19.5, 10.5, 0.4) && is_open(20.5, 11.5, 0.4));
        // Outside of the picture there is no pixel.
        assert!(!is_open(-0.5, 10.5, 0.6) && !is_open(20.5, 37.5, 0.6) && !is_open(f64::NAN, 10.5, 0.6));
    }

    #[test]
    fn what_is_no_polygon_may_show_and_nothing_does_not() {
        let mut depths = Depths::default();
        depths.fill(SIZE, &[1.0; 61 * 37], 61);
        let corner = clip([30.0, 20.0], 0.5, 1.0);
        assert!(depths.show(&[corner; 8]));
        assert!(depths.show(&[corner; 9]));
        assert!(depths.show(&[corner, clip([40.0, 20.0], f64::NAN, 1.0), clip([40.0, 30.0], 0.5, 1.0)]));
        assert!(!depths.show(&[]));
        assert!(!depths.show(&[corner, clip([40.0, 20.0], 0.5, 1.0), clip([40.0, 30.0], 0.5, 1.0)]));
    }
}
