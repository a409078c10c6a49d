//! How far a mesh lies from another one, in the unit of the tables.

use crate::data::ply_out::Mesh;

/// Distances between a mesh and the reference, in 1e-4 of the diagonal of the reference's bounding box.
pub(crate) use fcmeasure::Distance;

/// A surface that others are compared with.
#[derive(Debug)]
pub(crate) struct Reference(fcmeasure::Reference);

impl Reference {
    /// Prepares comparisons with `mesh`, by so many samples each way.
    ///
    /// Every vertex of the mesh is expected to be used by a face.
    pub(crate) fn new(mesh: &Mesh, samples: usize) -> Reference {
        Reference(fcmeasure::Reference::new(mesh.surface(), samples))
    }

    /// Measures both ways; infinite when `mesh` has no faces.
    pub(crate) fn distance(&self, mesh: &Mesh) -> Distance {
        let Distance { rms, max, color_rms } = self.0.distance(mesh.surface());
        let unit = 1e4 / self.0.diagonal();
        Distance { rms: rms * unit, max: max * unit, color_rms }
    }
}
