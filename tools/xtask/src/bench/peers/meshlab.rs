//! MeshLab's simplification by quadrics with optimal placement, and the Nexus builder, through the Python package
//! `pymeshlab`.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::over;
use crate::data::ply_out::{Mesh, write_file};

/// What the interpreter is given.
const SCRIPT: &str = include_str!("meshlab.py");

/// Names the interpreter when it is not `python3`.
const PYTHON: &str = "FACETREE_PYTHON";

/// An interpreter that has pymeshlab.
#[derive(Debug)]
pub(crate) struct MeshLab {
    python: PathBuf,
}

/// What the Nexus builder took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nexus {
    /// Time of one run, from a mesh file to its own.
    pub(crate) seconds: f64,
    /// Bytes of its file, not compressed.
    pub(crate) file: u64,
}

impl MeshLab {
    /// The interpreter, or a line that says what is missing.
    pub(crate) fn find() -> Result<MeshLab, String> {
        let python: PathBuf = std::env::var_os(PYTHON).map_or_else(|| "python3".into(), PathBuf::from);
        let lab = MeshLab { python };
        match lab.command(&["probe"]).output() {
            Ok(done) if done.status.success() => Ok(lab),
            _ => Err(format!(
                "MeshLab is left out: {} has no pymeshlab; not installed (pip install pymeshlab; {PYTHON} names another interpreter)",
                lab.python.display()
            )),
        }
    }

    /// Simplifies to about each number of triangles, each time from the whole mesh.
    ///
    /// # Errors
    /// When the script fails, or leaves no mesh.
    pub(crate) fn quadrics(&self, mesh: &Mesh, triangles: &[u64]) -> Result<Vec<Mesh>, Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let input = folder.path().join("input.ply");
        write_file(&input, mesh, &[], "for MeshLab")?;
        let mut command = self.command(&["quadrics"]);
        command.arg(&input).arg(folder.path()).args(triangles.iter().map(u64::to_string));
        run(command)?;
        triangles
            .iter()
            .map(|n| {
                let positions = words(&folder.path().join(format!("{n}.positions")))?;
                let faces = words(&folder.path().join(format!("{n}.faces")))?;
                let positions: Vec<[f32; 3]> =
                    positions.as_chunks::<3>().0.iter().map(|p| p.map(f32::from_bits)).collect();
                if faces.iter().any(|v| *v as usize >= positions.len()) {
                    return Err("MeshLab's mesh names a vertex that is not there".into());
                }
                Ok(over(&positions, &faces))
            })
            .collect()
    }

    /// What the Nexus builder takes to make `output` of a mesh file.
    ///
    /// # Errors
    /// When the script fails.
    pub(crate) fn nexus(&self, input: &Path, output: &Path) -> Result<Nexus, Box<dyn Error>> {
        let mut command = self.command(&["nexus"]);
        command.arg(input).arg(output);
        let said = run(command)?;
        let last = said.lines().last().unwrap_or_default();
        let seconds = last
            .trim()
            .parse()
            .map_err(|_not_a_number| format!("pymeshlab: expected seconds, found {last}"))?;
        Ok(Nexus { seconds, file: fs::metadata(output)?.len() })
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.python);
        command.args(["-c", SCRIPT]).args(arguments);
        command
    }
}

/// Runs a command and returns what it prints.
fn run(mut command: Command) -> Result<String, Box<dyn Error>> {
    let done = command.output()?;
    if done.status.success() {
        return Ok(String::from_utf8_lossy(&done.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    Err(format!("pymeshlab: {}: {}", done.status, said.lines().last().unwrap_or("no message")).into())
}

/// Little-endian words of a file.
fn words(path: &Path) -> Result<Vec<u32>, Box<dyn Error>> {
    let bytes = fs::read(path)?;
    Ok(bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
}
