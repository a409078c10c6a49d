//! The rules for outputs, checked before the long work.

use super::settings::Settings;
use fcbuild::Error;
use fcbuild::error::ErrorKind;
use fct::{Pending, Writer};
use std::fs;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

/// How the files end that this program reads.
const MESHES: [&str; 5] = ["ply", "obj", "stl", "gltf", "glb"];

/// The outputs as temporaries beside their final places. Dropping them leaves nothing behind.
pub(crate) struct Outputs {
    /// The tree.
    pub(crate) tree: Writer,
    /// The report, if one is asked for.
    pub(crate) report: Option<PendingReport>,
}

impl Outputs {
    /// Checks the places and makes the temporaries.
    ///
    /// # Errors
    /// Usage when an output is an input, when both outputs are one, or when one has the name of a mesh; I/O when an output
    /// exists and may not be replaced, is something else than what would replace it or no regular file, or its folder
    /// cannot be written.
    pub(crate) fn prepare(settings: &Settings) -> Result<Outputs, Error> {
        let outputs = std::iter::once(&settings.output).chain(&settings.report);
        for output in outputs {
            for input in &settings.inputs {
                if same_place(input, output) {
                    return Err(Error::new(ErrorKind::Usage, "FC101", "the output is an input")
                        .in_file(output)
                        .remedy("give the output another name"));
                }
            }
            check_kind(output)?;
        }
        check_name(
            &settings.output,
            "a tree",
            "give it a name that ends in .fct; `fct export` writes meshes",
        )?;
        if let Some(report) = &settings.report {
            check_name(report, "a report", "give it a name that ends in .json")?;
        }
        if settings.report.as_ref().is_some_and(|report| same_place(report, &settings.output)) {
            return Err(Error::new(ErrorKind::Usage, "FC101", "the report and the tree are one file")
                .in_file(&settings.output)
                .remedy("give the report another name"));
        }
        let tree = Writer::create(&settings.output, settings.force).map_err(writer_error)?;
        let report =
            settings.report.as_ref().map(|path| PendingReport::create(path, settings.force)).transpose()?;
        Ok(Outputs { tree, report })
    }
}

/// A report that is not there yet.
pub(crate) struct PendingReport(Pending);

impl PendingReport {
    fn create(target: &Path, overwrite: bool) -> Result<PendingReport, Error> {
        if overwrite {
            spare_others(target)?;
        }
        Pending::create(target, overwrite).map(PendingReport).map_err(report_error)
    }

    /// Writes `text` and brings it to the disk.
    ///
    /// # Errors
    /// I/O, with the old file untouched.
    pub(crate) fn write(&self, text: &str) -> Result<(), Error> {
        let PendingReport(pending) = self;
        let mut file = pending.file();
        file.write_all(text.as_bytes())
            .map_err(|e| Error::io("FC412", pending.target(), "cannot write the report", &e))?;
        pending.sync().map_err(report_error)
    }

    /// Moves the file to its place.
    ///
    /// # Errors
    /// I/O, with the old file untouched.
    pub(crate) fn publish(self) -> Result<(), Error> {
        self.0.publish().map_err(report_error)
    }
}

/// Bytes in which a report has said what it is.
const REPORT_START: u64 = 256;

/// Refuses to replace a file that is no report: a scene or a setting of another program is JSON too.
fn spare_others(target: &Path) -> Result<(), Error> {
    if !fs::symlink_metadata(target).is_ok_and(|found| found.is_file()) {
        return Ok(());
    }
    let mut start = Vec::new();
    fs::File::open(target)
        .and_then(|file| file.take(REPORT_START).read_to_end(&mut start))
        .map_err(|e| Error::io("FC412", target, "cannot look what the file is that is to be replaced", &e))?;
    let mark = b"\"generator\": \"fcbuild ";
    if start.starts_with(b"{") && start.windows(mark.len()).any(|words| words == mark) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Io, "FC474", "the file is no report and is left alone")
        .in_file(target)
        .remedy("give the report another name"))
}

/// An error with the report as one of this program; the system's refusals have a code of their own.
fn report_error(error: fct::Error) -> Error {
    match error {
        fct::Error::Io { path, what, source } => Error::io("FC412", &path, &what, &source),
        fct::Error::Folder { path, problem, remedy } => folder_error("FC412", &path, problem, remedy),
        other => writer_error(other),
    }
}

fn folder_error(code: &'static str, path: &Path, problem: String, remedy: &str) -> Error {
    Error::new(ErrorKind::Io, code, problem).in_file(path).remedy(remedy)
}

/// An error of the tree's writer as one of this program.
pub(crate) fn writer_error(error: fct::Error) -> Error {
    let code = error.code();
    match &error {
        fct::Error::Io { path, what, source } => Error::io(code, path, what, source),
        fct::Error::Exists { path } => exists(path),
        fct::Error::Folder { path, problem, remedy } => folder_error(code, path, problem.clone(), remedy),
        fct::Error::NotATree { path } => {
            Error::new(ErrorKind::Io, code, "the file is no .fct file and is left alone")
                .in_file(path)
                .remedy("give the output another name")
        }
        fct::Error::NotAFile { path } => {
            Error::new(ErrorKind::Io, code, "not a regular file").in_file(path).remedy("name a .fct file")
        }
        fct::Error::Limit { path, found, limit } => {
            Error::new(ErrorKind::Limit, code, format!("{found}; the limit is {limit}")).in_file(path)
        }
        // The tree was ours, so a broken rule is too, or the disk's.
        _ => Error::new(ErrorKind::Internal, "FC901", format!("the finished tree is refused: {error}"))
            .remedy("please report it with the input"),
    }
}

fn exists(path: &Path) -> Error {
    Error::new(ErrorKind::Io, "FC472", "the file exists").in_file(path).remedy("give --force to replace it")
}

/// A pipe or a device would be replaced by a file, which nobody means.
fn check_kind(output: &Path) -> Result<(), Error> {
    match fs::metadata(output) {
        Ok(found) if !found.is_file() => {
            let what = if found.is_dir() { "a directory" } else { "no regular file" };
            Err(Error::new(ErrorKind::Io, "FC473", format!("the output is {what}"))
                .in_file(output)
                .remedy("give the path of a file"))
        }
        _ => Ok(()),
    }
}

/// A tree or a report under the name of a mesh would pass for one: it is a slip for a second input, or for an export.
fn check_name(output: &Path, what: &str, remedy: &str) -> Result<(), Error> {
    let suffix = output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if !MESHES.contains(&suffix.as_str()) {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Usage,
        "FC103",
        format!("what is written is {what}, and .{suffix} is the name of a mesh"),
    )
    .in_file(output)
    .remedy(remedy))
}

/// Whether two paths lead to one file, however they are spelled.
fn same_place(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt as _;
        return (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    match (resolved(a), resolved(b)) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

/// The path without links and dots; the last name may be of a file that is not there yet.
fn resolved(path: &Path) -> Option<PathBuf> {
    if let Ok(found) = fs::canonicalize(path) {
        return Some(found);
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some(fs::canonicalize(folder).ok()?.join(path.file_name()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_is_known_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let [file, other] = ["a.ply", "b.ply"].map(|name| folder.path().join(name));
        fs::write(&file, "x").unwrap();
        assert!(same_place(&file, &folder.path().join(".").join("a.ply")));
        assert!(!same_place(&file, &other));
        assert!(same_place(&other, &folder.path().join(".").join("b.ply")), "also when it is not there");
        fs::hard_link(&file, &other).unwrap();
        assert!(cfg!(not(unix)) || same_place(&file, &other));
    }

    #[test]
    fn a_report_that_is_not_finished_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.json");
        drop(PendingReport::create(&path, false).unwrap());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let made = |overwrite: bool, text: &str| {
            let pending = PendingReport::create(&path, overwrite)?;
            pending.write(text)?;
            pending.publish()
        };
        made(false, "{\n  \"generator\": \"fcbuild 1\"}").unwrap();
        assert_eq!(made(false, "").err().map(|e| e.exit_code()), Some(4));
        made(true, "{}").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "{}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        for other in
            ["ply", "{}", "{\"asset\": {\"generator\": \"Blender\"}}", "\"generator\": \"fcbuild 1\""]
        {
            fs::write(&path, other).unwrap();
            assert_eq!(made(true, "").err().map(|e| e.code()), Some("FC474"), "{other}");
        }
        let lost = folder.path().join("no").join("r.json");
        let error = PendingReport::create(&lost, true).err().unwrap().to_string();
        assert!(error.ends_with("no does not exist; make it first"), "{error}");
    }
}
