//! From coloured triangles to a picture: light, lines, smooth edges, PNG.

use super::raster::{Corner, NOTHING, Raster};
use super::view::{Frame, View};
use glam::DVec3;
use std::error::Error;

/// Samples on a side of a pixel.
const SUB: usize = 3;

/// The paper that models stand on.
const BACKGROUND: [f32; 3] = [1.0; 3];

/// Colour of lines, linear.
const INK: [f32; 3] = [0.012, 0.014, 0.02];

/// Unpainted models, as a PNG stores colours. Grey, so that the steps of the channels never differ and tint it.
pub(crate) const CLAY: [u8; 3] = [202; 3];

/// Triangles to be drawn.
#[derive(Debug, Default)]
pub(crate) struct Scene {
    /// Corners of each triangle.
    pub(crate) triangles: Vec<[DVec3; 3]>,
    /// A normal at each corner; without, triangles are flat.
    pub(crate) normals: Option<Vec<[DVec3; 3]>>,
    /// The cluster of each triangle.
    pub(crate) cluster: Vec<u32>,
    /// Colour of each cluster, as a PNG stores colours; [`CLAY`] for those that are not named.
    pub(crate) colors: Vec<[u8; 3]>,
}

/// Which lines are drawn over a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lines {
    /// Where one cluster meets another, or ends.
    pub(crate) clusters: bool,
    /// Where triangles meet, thinner.
    pub(crate) triangles: bool,
}

/// Eight bits a channel, row by row.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Picture {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// Red, green, blue.
    pub(crate) pixels: Vec<[u8; 3]>,
}

/// Draws `scene` as `frame` sees it.
pub(crate) fn draw(scene: &Scene, frame: &Frame, lines: Lines) -> Picture {
    let mut raster = Raster::new(frame.width * SUB, frame.height * SUB, BACKGROUND);
    for (i, corners) in scene.triangles.iter().enumerate() {
        let cluster = scene.cluster.get(i).map_or(0, |c| *c as usize);
        let paint = scene.colors.get(cluster).copied().unwrap_or(CLAY).map(linear);
        let [a, b, c] = *corners;
        let flat = [(b - a).cross(c - a).normalize_or_zero(); 3];
        let normals = scene.normals.as_ref().and_then(|n| n.get(i)).copied().unwrap_or(flat);
        let placed = [0, 1, 2].map(|k| {
            let [x, y, depth] = frame.place(corners[k], SUB);
            Corner { x, y, depth, color: lit(&frame.view, normals[k], paint) }
        });
        raster.draw(i as u32, placed);
    }
    let dark = ink(&raster, scene, lines);
    let mut pixels = Vec::with_capacity(frame.width * frame.height);
    for y in 0..frame.height {
        for x in 0..frame.width {
            let mut sum = [0.0_f32; 3];
            for s in 0..SUB * SUB {
                let at = (y * SUB + s / SUB) * raster.width() + x * SUB + s % SUB;
                for k in 0..3 {
                    sum[k] += raster.color[at][k] * (1.0 - dark[at]) + INK[k] * dark[at];
                }
            }
            pixels.push(sum.map(|x| stored(x / (SUB * SUB) as f32)));
        }
    }
    Picture { width: frame.width, height: frame.height, pixels }
}

/// A key light from the upper left, a fill light from the right, and some of the sky everywhere.
///
/// The side that is seen is lit, so that a surface with holes has no black inside.
fn lit(view: &View, normal: DVec3, paint: [f32; 3]) -> [f32; 3] {
    let n = if normal.dot(view.toward) < 0.0 { -normal } else { normal };
    let from = |right: f64, up: f64, toward: f64| {
        let way = (view.right * right + view.up * up + view.toward * toward).normalize_or_zero();
        n.dot(way).max(0.0)
    };
    let light = 0.24 + 0.08 * n.dot(view.up) + 0.82 * from(-0.55, 0.7, 0.85) + 0.2 * from(0.9, 0.05, 0.5);
    paint.map(|p| p * light as f32)
}

/// How much ink lies on each sample, from 0 to 1.
///
/// Lines are found in the picture: where neighbouring samples show different clusters or triangles. So hidden ones
/// are hidden, and all have the same width however near.
fn ink(raster: &Raster, scene: &Scene, lines: Lines) -> Vec<f32> {
    let (width, height) = (raster.width(), raster.height());
    let cluster = |at: usize| match raster.triangle[at] {
        NOTHING => NOTHING,
        t => scene.cluster.get(t as usize).copied().unwrap_or(0),
    };
    let mut dark = vec![0.0; width * height];
    if !lines.clusters && !lines.triangles {
        return dark;
    }
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            let right = if x + 1 < width { at + 1 } else { at };
            let below = if y + 1 < height { at + width } else { at };
            if lines.clusters && (cluster(at) != cluster(right) || cluster(at) != cluster(below)) {
                // The sample and its neighbours: a line as wide as a pixel.
                for (dx, dy) in [(1, 1), (0, 1), (2, 1), (1, 0), (1, 2)] {
                    if let (Some(px), Some(py)) = ((x + dx).checked_sub(1), (y + dy).checked_sub(1))
                        && px < width
                        && py < height
                    {
                        dark[py * width + px] = 1.0;
                    }
                }
            }
            let triangle = raster.triangle[at];
            if lines.triangles && (triangle != raster.triangle[right] || triangle != raster.triangle[below]) {
                dark[at] = 1.0_f32.min(dark[at] + if lines.clusters { 0.55 } else { 0.9 });
            }
        }
    }
    dark
}

/// A stored channel as an amount of light. A square is close enough to the sRGB curve, and the same everywhere.
fn linear(stored: u8) -> f32 {
    let x = f32::from(stored) / 255.0;
    x * x
}

/// Steps of a channel: enough for the eye, and files are a quarter smaller than with 255.
const STEPS: f32 = 63.0;

/// The other way round.
fn stored(linear: f32) -> u8 {
    let step = (linear.clamp(0.0, 1.0).sqrt() * STEPS + 0.5).floor();
    (step / STEPS * 255.0 + 0.5) as u8
}

impl Picture {
    /// The bytes of a PNG file, the same for the same picture.
    ///
    /// # Errors
    /// Those of the encoder, for a picture without pixels.
    pub(crate) fn to_png(&self) -> Result<Vec<u8>, Box<dyn Error>> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        encoder.write_header()?.write_image_data(self.pixels.as_flattened())?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64, cluster: u32) -> Scene {
        let [a, b, c, d] = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]].map(DVec3::from);
        Scene {
            triangles: vec![[a, b, c], [a, c, d]],
            normals: None,
            cluster: vec![cluster; 2],
            colors: vec![[250, 20, 20], [20, 20, 250]],
        }
    }

    fn frame(scene: &Scene) -> Frame {
        Frame::around(View::from([0.0, 0.0, 1.0]), scene.triangles.iter().flatten().copied(), 40, 40)
    }

    /// What lies in front hides what lies behind, in its own colour; the border stays paper.
    #[test]
    fn the_front_one_shows() {
        let mut scene = square(0.0, 0);
        let front = square(1.0, 1);
        scene.triangles.extend(front.triangles);
        scene.cluster.extend(front.cluster);
        let picture = draw(&scene, &frame(&scene), Lines::default());
        let [red, _, blue] = picture.pixels[20 * 40 + 20];
        assert!(blue > 4 * red, "{red} {blue}");
        assert_eq!(picture.pixels[0], [255; 3]);
    }

    /// Lines of clusters run round them, not through them; lines of triangles cross the square.
    #[test]
    fn lines_stand_where_clusters_meet() {
        let scene = square(0.0, 0);
        let plain = draw(&scene, &frame(&scene), Lines::default());
        let ringed = draw(&scene, &frame(&scene), Lines { clusters: true, triangles: false });
        let wired = draw(&scene, &frame(&scene), Lines { clusters: false, triangles: true });
        let middle = 20 * 40 + 20;
        assert_eq!(ringed.pixels[middle], plain.pixels[middle]);
        assert!(ringed.pixels[20 * 40 + 1][0] < 160, "{:?}", ringed.pixels[20 * 40 + 1]);
        let diagonal = |p: &Picture| (5..35).map(|i| u32::from(p.pixels[(39 - i) * 40 + i][0])).sum::<u32>();
        assert!(diagonal(&wired) + 30 * 20 < diagonal(&plain));
    }

    #[test]
    fn the_same_scene_gives_the_same_bytes() {
        let scene = square(0.0, 1);
        let png =
            || draw(&scene, &frame(&scene), Lines { clusters: true, triangles: true }).to_png().unwrap();
        let bytes = png();
        assert!(bytes == png());
        assert_eq!(bytes[..8], [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a]);
    }
}
