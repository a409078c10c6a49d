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
    /// Budget keys of up to this many pixels on screen: the cut that a budget chooses, whose mean error is lower than that
    /// of [`Detail::Pixels`] with as many triangles, and which promises nothing.
    Gain(f64),
    /// So many triangles in all instances together, spent where they lower errors on screen the most. Those that face
    /// away or lie outside the view count for nothing, those that others hide count.
    Triangles(u64),
}

/// How hidden parts are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occlusion {
    /// By asking whether bounding polygons would show before what this frame has drawn; the picture is the same as
    /// without, pixel for pixel. Who answers is whoever is sooner done: occlusion queries of a graphics card, or, where a
    /// program draws one sample a pixel, a look at its depth.
    Exact,
    /// The same, by occlusion queries everywhere.
    Queries,
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
    /// By the distance from the eye, from the nearest that is in sight, yellow, over pink to the farthest, dark blue; equal
    /// ratios of distances are equal steps.
    Depth,
    /// By the number of faces in a cluster, from blue for one over green and yellow to red for a million, a step for each
    /// doubling, with outlines: how coarse the cut is where.
    Level,
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
    /// About the number of pieces that a frame is divided into under occlusion culling, each of which is asked about
    /// unless its instance is hidden as a whole. More hide more and cost more. None: [`FrameOptions::LOOKS`] where
    /// the depth is looked at, and [`FrameOptions::QUERIES`] elsewhere.
    pub queries: Option<usize>,
    /// What colours the surface.
    pub color: ColorMode,
    /// Draw the edges of all triangles too.
    pub wireframe: bool,
    /// Draw only the first half of the rounds: shows what hides the rest.
    pub only_occluders: bool,
    /// Draw the polygons that occlusion queries ask about over the picture: red where what they enclose was hidden, blue
    /// where it may show.
    pub show_questions: bool,
    /// Choose detail and cull for this camera while another one draws: shows from outside what a view gets.
    pub frozen: Option<Camera>,
    /// Wait for the GPU after each stage, so that the stages' times are true. Costs a little of the total.
    pub measure: bool,
    /// Keep the depth for [`crate::Image::depth`].
    pub depth: bool,
}

impl FrameOptions {
    /// Pieces of a frame where a question takes a look at the depth: at one pixel seven tenths and more are left out of
    /// what a test of every triangle would find hidden.
    pub const LOOKS: usize = 8192;

    /// Pieces of a frame where a question takes an occlusion query.
    pub const QUERIES: usize = 1024;

    /// Rounds in which a frame of about so many pieces is drawn under occlusion culling, nearest pieces first: each asks
    /// which of its instances and pieces the earlier ones hide, before they are cut. More hide more; each waits for its
    /// answers twice, or once where the depth is looked at.
    pub(crate) fn rounds(pieces: usize) -> u32 {
        (pieces / 512).clamp(4, 32) as u32
    }
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
            queries: None,
            color: ColorMode::Shaded,
            wireframe: false,
            only_occluders: false,
            show_questions: false,
            frozen: None,
            measure: false,
            depth: false,
        }
    }
}
