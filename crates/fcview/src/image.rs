//! A picture in memory, and as a PNG file.

use crate::Error;
use crate::headless::outputs;
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

    /// Writes the picture as PNG, replacing what is there at once and as a whole.
    ///
    /// # Errors
    /// [`Error::Write`] or [`Error::Png`], both of exit code 4.
    pub fn write_png(&self, path: &Path) -> Result<(), Error> {
        let encoded = outputs::replace(path, |out| {
            let mut encoder = png::Encoder::new(out, self.width, self.height);
            encoder.set_color(png::ColorType::Rgba);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&self.rgba)?;
            writer.finish()
        });
        encoded.map_err(|error| match error {
            // What the system says about the file comes through the encoder too.
            png::EncodingError::IoError(source) => Error::Write { path: path.to_path_buf(), source },
            source => Error::Png { path: path.to_path_buf(), source },
        })
    }
}
