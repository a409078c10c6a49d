//! What was meant: flags with their defaults resolved.

use super::flags::{Flags, MAX_THREADS};
use super::memory;
use fcbuild::error::ErrorKind;
use fcbuild::mesh::Weld;
use fcbuild::{Error, SplitMode};
use fct::{MessageFormat, ProgressForm, Size};
use std::path::{Path, PathBuf};

/// How to do the job.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The meshes.
    pub(crate) inputs: Vec<PathBuf>,
    /// The tree.
    pub(crate) output: PathBuf,
    /// The report, if one is asked for.
    pub(crate) report: Option<PathBuf>,
    /// How clusters are cut.
    pub(crate) split: SplitMode,
    /// Which vertices become one.
    pub(crate) weld: Weld,
    /// How much colours count.
    pub(crate) color_weight: f64,
    /// Whether every face is turned over.
    pub(crate) flip: bool,
    /// Whether all groups are made one.
    pub(crate) join_groups: bool,
    /// Threads of the pool.
    pub(crate) threads: usize,
    /// Bytes that the job may take, as far as they are known.
    pub(crate) max_memory: Option<Size>,
    /// The most faces of a part that can be read alone.
    pub(crate) chunk_faces: u32,
    /// Whether outputs may be replaced.
    pub(crate) force: bool,
    /// Whether repairs are errors.
    pub(crate) strict: bool,
    /// How progress is shown.
    pub(crate) progress: ProgressForm,
}

impl Settings {
    /// Resolves the flags on this machine.
    ///
    /// # Errors
    /// Usage for standard input or output in place of a file: the readers jump in their files, and the tree is
    /// moved to its place when it is whole.
    pub(crate) fn from_flags(flags: &Flags) -> Result<Settings, Error> {
        let all = flags.inputs.iter().chain([&flags.output]).chain(&flags.report);
        for path in all {
            if path == Path::new("-") {
                return Err(Error::new(
                    ErrorKind::Usage,
                    "FC102",
                    "standard input and output cannot be used",
                )
                .remedy("name a file; one that is called `-` is `./-`"));
            }
        }
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Settings {
            inputs: flags.inputs.clone(),
            output: flags.output.clone(),
            report: flags.report.clone(),
            split: flags.split.into(),
            weld: flags.weld,
            color_weight: flags.color_weight,
            flip: flags.flip,
            join_groups: flags.join_groups,
            threads: flags.threads.map_or_else(cores, |n| n as usize).min(MAX_THREADS as usize),
            max_memory: flags.max_memory.clone().or_else(|| memory::default_limit().map(Size::of_bytes)),
            chunk_faces: flags.chunk_faces,
            force: flags.force,
            strict: flags.strict,
            progress: ProgressForm::here(flags.progress, flags.message_format == MessageFormat::Json),
        })
    }

    /// The names of the inputs without folders.
    pub(crate) fn input_names(&self) -> String {
        let names: Vec<_> =
            self.inputs.iter().filter_map(|p| p.file_name()).map(|name| name.to_string_lossy()).collect();
        names.join(", ")
    }
}
