//! Draws face-cluster trees (.fct files) with wgpu: level of detail, frustum, cone and occlusion culling, without a
//! display or in a window.
//!
//! ```text
//! Scene + Camera + FrameOptions -> Renderer: cut every instance (fcextract, in parallel) -> triangles to the GPU
//!     -> nearest pieces drawn -> round by round: occlusion queries of the next ones' bounding polygons, those that
//!     show drawn -> Image + FrameStats
//! ```
//!
//! The cut depends on the view and the tolerance alone; each culling method only leaves out what does not show, so
//! that at one tolerance the picture is the same with a method on or off, pixel for pixel; the cone test
//! alone also leaves out the few triangles that face the eye though no face of their cluster does.
//!
//! The library prints nothing and needs no display; the window is behind the feature `window`.
//!
//! # Paper
//! [Tsuji07, 5 and 6]: level of detail by projected error, culling of invisible surfaces, occlusion queries.

pub mod bounding_polygon;
pub mod camera;
pub mod camera_path;
pub mod cli;
mod error;
pub mod flight;
mod frame;
mod gpu;
pub mod headless;
mod image;
pub mod inwards;
pub mod options;
pub mod orbit;
pub mod pick;
pub mod random;
mod recovery;
mod renderer;
mod residency;
pub mod scene;
pub mod stats;
pub mod steering;
mod warning;
#[cfg(feature = "window")]
pub mod window;

pub use camera::Camera;
pub use error::Error;
pub use gpu::Gpu;
pub use image::Image;
pub use options::{ColorMode, Detail, FrameOptions, Occlusion};
pub use recovery::{REBUILDS, Survivor};
#[doc(hidden)]
pub use renderer::Census;
pub use renderer::Renderer;
pub use scene::{Instance, Model, Scene};
pub use stats::{FrameStats, RunStats};
pub use warning::Warning;

/// Draws one picture on a device of its own.
///
/// For several pictures keep a [`Renderer`]: opening a device and uploading the models takes longer than drawing.
///
/// # Errors
/// See [`Gpu::headless`], [`Renderer::new`] and [`Renderer::draw`].
pub fn render(scene: &Scene, camera: &Camera, options: &FrameOptions) -> Result<(Image, FrameStats), Error> {
    Renderer::new(Gpu::headless()?, scene)?.render(scene, camera, options)
}
