//! The stages of a build.

use fcbuild::Phase;

/// A part of the job, as the user sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Reading, in bytes.
    Import,
    /// Building, in faces.
    Build(Phase),
    /// Writing.
    Write,
}

impl From<Stage> for fct::Stage {
    fn from(stage: Stage) -> fct::Stage {
        let (number, name) = match stage {
            Stage::Import => (1, "import"),
            Stage::Build(phase) => (2 + phase as usize, phase.as_str()),
            Stage::Write => (usize::MAX, "write"),
        };
        let counts = matches!(stage, Stage::Import | Stage::Build(Phase::Partition | Phase::Bounds));
        fct::Stage { number, name, counts }
    }
}
