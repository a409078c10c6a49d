//! A z-buffer: triangles in, the nearest one of each pixel out.

/// No triangle covers the pixel.
pub(crate) const NOTHING: u32 = u32::MAX;

/// A corner on the screen: x to the right and y down in pixels, and a depth that grows away from the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Corner {
    /// Pixels from the left edge; the first pixel's centre is at 0.5.
    pub(crate) x: f64,
    /// Pixels from the upper edge.
    pub(crate) y: f64,
    /// Distance from the eye, up to a constant.
    pub(crate) depth: f64,
    /// Red, green and blue, linear.
    pub(crate) color: [f32; 3],
}

/// What is nearest at each pixel.
#[derive(Debug)]
pub(crate) struct Raster {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    /// Which triangle is seen, or [`NOTHING`]; row by row.
    pub(crate) triangle: Vec<u32>,
    /// Its colour there.
    pub(crate) color: Vec<[f32; 3]>,
}

impl Raster {
    /// An empty one.
    pub(crate) fn new(width: usize, height: usize, background: [f32; 3]) -> Raster {
        Raster {
            width,
            height,
            depth: vec![f32::INFINITY; width * height],
            triangle: vec![NOTHING; width * height],
            color: vec![background; width * height],
        }
    }

    /// Pixels in a row.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// Draws one triangle, seen from either side. A pixel is covered if its centre is, edges included, so two
    /// triangles that share an edge leave no gap; where two are equally near, the first stays.
    pub(crate) fn draw(&mut self, triangle: u32, [a, b, c]: [Corner; 3]) {
        let area = cross(a, b, c.x, c.y);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let low_high = |p: f64, q: f64, r: f64, size: usize| {
            let low = (p.min(q).min(r) - 0.5).ceil().max(0.0) as usize;
            let high = (p.max(q).max(r) - 0.5).floor();
            (low, if high < 0.0 { 0 } else { (high as usize + 1).min(size) })
        };
        let (left, right) = low_high(a.x, b.x, c.x, self.width);
        let (top, bottom) = low_high(a.y, b.y, c.y, self.height);
        for row in top..bottom {
            for column in left..right {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let u = cross(b, c, x, y) / area;
                let v = cross(c, a, x, y) / area;
                let w = cross(a, b, x, y) / area;
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let depth = (u * a.depth + v * b.depth + w * c.depth) as f32;
                let at = row * self.width + column;
                if depth < self.depth[at] {
                    self.depth[at] = depth;
                    self.triangle[at] = triangle;
                    let mix = |k: usize| {
                        (u * f64::from(a.color[k]) + v * f64::from(b.color[k]) + w * f64::from(c.color[k]))
                            as f32
                    };
                    self.color[at] = [mix(0), mix(1), mix(2)];
                }
            }
        }
    }
}

/// Twice the signed area of the triangle of `p`, `q` and a point.
fn cross(p: Corner, q: Corner, x: f64, y: f64) -> f64 {
    (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, depth: f64) -> Corner {
        Corner { x, y, depth, color: [1.0; 3] }
    }

    fn covered(r: &Raster, triangle: u32) -> usize {
        r.triangle.iter().filter(|t| **t == triangle).count()
    }

    /// The lower left half of a square of 10 pixels has 10 + 9 + .. + 1 pixel centres on or below its diagonal,
    /// whichever way round its corners are given.
    #[test]
    fn a_right_triangle_covers_its_half_of_the_square() {
        let [a, b, c] = [corner(2.0, 2.0, 1.0), corner(2.0, 12.0, 1.0), corner(12.0, 12.0, 1.0)];
        for corners in [[a, b, c], [c, b, a]] {
            let mut r = Raster::new(20, 20, [0.0; 3]);
            r.draw(7, corners);
            assert_eq!(covered(&r, 7), 55);
            assert_eq!(r.triangle[2 * 20 + 2], 7);
            assert_eq!(r.triangle[2 * 20 + 3], NOTHING);
        }
    }

    /// Two halves cover a square without a gap.
    #[test]
    fn neighbours_leave_no_gap() {
        let [a, b, c, d] =
            [(1.3, 1.1), (1.3, 17.9), (18.2, 17.9), (18.2, 1.1)].map(|(x, y)| corner(x, y, 0.0));
        let mut r = Raster::new(20, 20, [0.0; 3]);
        r.draw(0, [a, b, c]);
        r.draw(1, [a, c, d]);
        assert_eq!(covered(&r, 0) + covered(&r, 1), 17 * 17);
    }

    /// The nearer triangle is seen whichever is drawn first, pixel by pixel where they cross.
    #[test]
    fn the_nearer_one_is_seen() {
        let flat = [corner(0.0, 0.0, 5.0), corner(40.0, 0.0, 5.0), corner(0.0, 40.0, 5.0)];
        // Nearer on the left of x = 10, farther on its right.
        let tilted = [corner(0.0, 0.0, 0.0), corner(40.0, 0.0, 20.0), corner(0.0, 40.0, 0.0)];
        let (mut one, mut other) = (Raster::new(20, 20, [0.0; 3]), Raster::new(20, 20, [0.0; 3]));
        one.draw(0, flat);
        one.draw(1, tilted);
        other.draw(1, tilted);
        other.draw(0, flat);
        assert_eq!(one.triangle, other.triangle);
        for (i, t) in one.triangle.iter().enumerate() {
            assert_eq!(*t, u32::from(i % 20 < 10), "pixel {i}");
        }
    }

    #[test]
    fn what_is_outside_or_nothing_is_left_out() {
        let mut r = Raster::new(4, 4, [0.0; 3]);
        r.draw(0, [corner(-9.0, -9.0, 0.0), corner(-5.0, -9.0, 0.0), corner(-9.0, -5.0, 0.0)]);
        r.draw(0, [corner(9.0, 9.0, 0.0), corner(15.0, 9.0, 0.0), corner(9.0, 15.0, 0.0)]);
        r.draw(0, [corner(0.0, 0.0, 0.0), corner(2.0, 2.0, 0.0), corner(4.0, 4.0, 0.0)]);
        r.draw(0, [corner(f64::NAN, 0.0, 0.0), corner(2.0, 2.0, 0.0), corner(4.0, 0.0, 0.0)]);
        assert_eq!(covered(&r, NOTHING), 16);
    }
}
