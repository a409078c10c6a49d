//! The stages of the commands that take long.

/// A part of a job, as the user sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Checking hashes.
    Bytes,
    /// Checking rules, in faces.
    Rules,
    /// Choosing clusters and triangulating them.
    Cut,
    /// Collecting vertices and triangles.
    Mesh,
    /// Measuring what the mesh is bounded by.
    Bound,
    /// Measuring how far it is from the input.
    Measure,
    /// Writing, in vertices and triangles.
    Write,
}

impl From<Stage> for fct::Stage {
    fn from(stage: Stage) -> fct::Stage {
        let name = match stage {
            Stage::Bytes => "bytes",
            Stage::Rules => "rules",
            Stage::Cut => "cut",
            Stage::Mesh => "mesh",
            Stage::Bound => "bound",
            Stage::Measure => "measure",
            Stage::Write => "write",
        };
        fct::Stage { number: 1 + stage as usize, name, counts: matches!(stage, Stage::Rules | Stage::Write) }
    }
}
