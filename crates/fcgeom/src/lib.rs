//! Pure geometry for face clusters, on glam types: moments of surfaces, symmetric eigenproblems, the axes of
//! principal component and canonical correlation analysis, enclosing spheres and normal cones, segments, planes and frusta.
//!
//! Everything is computed in `f64` and stored in `f32` where it goes to a file, rounded towards safety: radii up,
//! cosines down. Only `+ - * /` and `sqrt` are used, whose results IEEE 754 fixes to the last bit, so the same input
//! gives the same bytes on every platform. Nothing here reads, writes, prints, starts a thread or panics.
//!
//! Units: lengths are those of the input; an area is a length squared; a covariance of positions, and therefore
//! [`Moments::epsilon`], is a length squared too.
//!
//! # Paper
//! `[Tsuji07]`: Tsuji, Zha, Hasegawa, Kurazume, "Hierarchical Face Cluster Partitioning of Polygonal Surfaces and
//! High-Speed Rendering", Systems and Computers in Japan 38(8), 2007.

mod ball;
pub mod cca;
pub mod cone;
pub mod frustum;
pub mod moments;
pub mod pca;
pub mod plane;
pub mod point_pca;
pub mod quads;
pub mod rounding;
pub mod segment;
pub mod smallest;
pub mod sphere;
pub mod symmetric;
#[cfg(test)]
mod tests;

pub use cca::cca_axis;
pub use cone::{Cone, Glance, Side};
pub use frustum::{Containment, Frustum};
pub use moments::{FaceMoments, Moments};
pub use pca::{PlaneFit, pca_axis};
pub use plane::{Plane, tangent_frame};
pub use point_pca::point_covariance;
pub use quads::Quads;
pub use rounding::{round_down, round_up};
pub use segment::{distance_to_segment, offset_from_segment};
pub use smallest::{smallest_eigenpair, smallest_eigenpair_near, smallest_eigenvalue};
pub use sphere::Sphere;
pub use symmetric::{Eigen, SymMat3, eigen};
