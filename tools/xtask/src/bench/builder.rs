//! The program `fcbuild`, built and run as its users run it.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The command and the settings that are the same for all meshes.
#[derive(Debug)]
pub(crate) struct Builder {
    program: PathBuf,
    split: Option<String>,
    chunk_faces: Option<u32>,
}

impl Builder {
    /// `program`, or the one of this workspace, built first; `split` as its option takes it.
    ///
    /// # Errors
    /// When cargo fails, or left no program.
    pub(crate) fn new(program: Option<&Path>, split: Option<&str>) -> Result<Builder, Box<dyn Error>> {
        let program = match program {
            Some(path) => path.to_owned(),
            None => build()?,
        };
        if !program.is_file() {
            return Err(format!("{}: no such program; name one by --fcbuild", program.display()).into());
        }
        Ok(Builder { program, split: split.map(str::to_owned), chunk_faces: None })
    }

    /// With parts of at most so many faces, as its option takes them.
    #[must_use]
    pub(crate) fn in_chunks(self, chunk_faces: Option<u32>) -> Builder {
        Builder { chunk_faces, ..self }
    }

    /// A command that makes `output` of `input`, without a progress bar.
    pub(crate) fn command(&self, input: &Path, output: &Path, threads: Option<u32>) -> Command {
        let mut command = Command::new(&self.program);
        command.arg(input).arg("-o").arg(output).args(["--force", "--progress", "never"]);
        if let Some(split) = &self.split {
            command.args(["--split", split]);
        }
        if let Some(faces) = self.chunk_faces {
            command.args(["--chunk-faces", &faces.to_string()]);
        }
        if let Some(threads) = threads {
            command.args(["--threads", &threads.to_string()]);
        }
        command
    }

    /// Makes `output` of `input`.
    ///
    /// # Errors
    /// What `fcbuild` says when it fails.
    pub(crate) fn run(&self, input: &Path, output: &Path) -> Result<(), Box<dyn Error>> {
        self.said(input, output, &[]).map(drop)
    }

    /// The same, with the faces turned over if they look inwards: a viewer that leaves out back faces would show the
    /// inside.
    ///
    /// # Errors
    /// What `fcbuild` says when it fails.
    pub(crate) fn run_outwards(&self, input: &Path, output: &Path) -> Result<(), Box<dyn Error>> {
        if self.said(input, output, &[])?.contains("[FC293]") {
            self.said(input, output, &["--flip"])?;
        }
        Ok(())
    }

    /// Makes `output` of `input`; what `fcbuild` warns of.
    fn said(&self, input: &Path, output: &Path, flags: &[&str]) -> Result<String, Box<dyn Error>> {
        let done = self.command(input, output, None).args(flags).output()?;
        if done.status.success() {
            return Ok(String::from_utf8_lossy(&done.stderr).into_owned());
        }
        Err(format!("fcbuild {}: {}", input.display(), String::from_utf8_lossy(&done.stderr).trim()).into())
    }
}

/// The program of this workspace, beside the folder of the one that runs now.
fn build() -> Result<PathBuf, Box<dyn Error>> {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(super::workspace());
    cargo.args(["build", "--release", "--quiet", "--package", "fcbuild"]);
    if !cargo.status()?.success() {
        return Err("cargo could not build fcbuild; see above".into());
    }
    let own = std::env::current_exe()?;
    let target = own.parent().and_then(Path::parent).ok_or("this program lies in no folder of cargo's")?;
    Ok(target.join("release").join(format!("fcbuild{}", std::env::consts::EXE_SUFFIX)))
}
