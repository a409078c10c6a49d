//! How a frame is drawn.

use crate::camera::Camera;

/// How much detail is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// Every face of the input.
    Full,
    /// Errors of up to this many pixels on screen.
    Pixels(f64),
    /// Errors of up to this distance, in the models' unit, wherever the camera is.
    Distance(f64),
}

/// How hidden parts are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occlusion {
    /// By occlusion queries of this frame; the picture is the same as without, pixel for pixel.
    Exact,
    /// Not at all.
    Off,
}

/// What colours the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMode {
    /// The model's colours, lit.
    Shaded,
    /// A colour for each cluster of the front, with outlines.
    Clusters,
}

/// How a frame is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameOptions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples a pixel: 1 or 4.
    pub samples: u32,
    /// How much detail is drawn. Does not depend on the culling switches below.
    pub detail: Detail,
    /// Leave out what lies outside the view.
    pub frustum: bool,
    /// Leave out clusters whose normals all face away. Off in effect when `two_sided` is on.
    pub backface: bool,
    /// Draw back faces too.
    pub two_sided: bool,
    /// How hidden parts are left out.
    pub occlusion: Occlusion,
    /// About the number of pieces that a frame is divided into under occlusion culling, each of which takes a query.
    /// More hide more and cost more; they pay where a frame is slow to draw.
    ///
    /// A software driver takes some ten microseconds for a query, in which it draws some twenty to fifty triangles: a
    /// few hundred queries about save what they cost, and thousands cost more than they save. The default is for such
    /// a driver, where it neither costs nor saves much. With 32768 queries in 32 rounds about eight to nine tenths of
    /// the triangles that are hidden go, at three to ten times the time of a frame without culling.
    pub queries: usize,
    /// Rounds in which a frame is drawn under occlusion culling, nearest pieces first: each asks which of its pieces
    /// the earlier ones hide. More hide more; each waits for its answers.
    pub rounds: u32,
    /// What colours the surface.
    pub color: ColorMode,
    /// Choose detail and cull for this camera while another one draws: shows from outside what a view gets.
    pub frozen: Option<Camera>,
    /// Wait for the GPU after each stage, so that the stages' times are true. Costs a little of the total.
    pub measure: bool,
    /// Keep the depth for [`crate::Image::depth`].
    pub depth: bool,
}

impl Default for FrameOptions {
    fn default() -> FrameOptions {
        FrameOptions {
            size: [1280, 720],
            samples: 1,
            detail: Detail::Pixels(1.0),
            frustum: true,
            backface: true,
            two_sided: false,
            occlusion: Occlusion::Exact,
            queries: 512,
            rounds: 4,
            color: ColorMode::Shaded,
            frozen: None,
            measure: false,
            depth: false,
        }
    }
}
