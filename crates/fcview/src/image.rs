//! A picture in memory, and as a PNG file.

use crate::Error;
use std::path::Path;

/// A picture: rows from the top, 8-bit RGBA in sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `4 * width * height` bytes.
    pub rgba: Vec<u8>,
    /// Depth of each pixel, where the picture has one sample a pixel, the options ask for it and the adapter can
    /// copy it (OpenGL cannot): the near distance over the distance along the view axis, so 1 at the near plane and 0 where nothing was drawn.
    pub depth: Option<Vec<f32>>,
}

impl Image {
    /// The number of pixels that differ from another picture's, or `None` if the sizes differ.
    pub fn differing_pixels(&self, other: &Image) -> Option<usize> {
        if (self.width, self.height) != (other.width, other.height) {
            return None;
        }
        let (mine, theirs) = (self.rgba.as_chunks::<4>().0, other.rgba.as_chunks::<4>().0);
        Some(mine.iter().zip(theirs).filter(|(a, b)| a != b).count())
    }

    /// Writes the picture as PNG, replacing what is there.
    ///
    /// # Errors
    /// [`Error::Write`] or [`Error::Png`], both of exit code 4.
    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let file = std::fs::File::create(path)
            .map_err(|source| Error::Write { path: path.to_path_buf(), source })?;
        let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let encode = |source| Error::Png { path: path.to_path_buf(), source };
        let mut writer = encoder.write_header().map_err(encode)?;
        writer.write_image_data(&self.rgba).map_err(encode)?;
        writer.finish().map_err(encode)
    }
}
