//! The rules for outputs, checked before anything is drawn, and how a file is replaced.

use crate::Error;
use crate::cli::{CameraFlag, Cli};
use std::fs;
use std::io::{self, BufWriter, Read as _, Write};
use std::path::{Path, PathBuf};

/// What stands for a frame's number in the name of a picture.
const PLACEHOLDER: &str = "{n}";

/// How the names of temporaries begin after a dot, whatever they become: those of killed runs are found by it.
const TEMPORARY: &str = "fcview-output";

/// Bytes in which a stats document has said what it is.
const STATS_START: u64 = 256;

/// Checks the pictures and the document that a command line asks for.
///
/// # Errors
/// Usage when an output is an input, when two outputs are one, when a picture is no .png or its name has a brace
/// that is no placeholder, when stats are no .json, and for `-`; input or output when a folder is not there or cannot be
/// written, a place is no regular file, or stats would replace something else.
pub(super) fn check(cli: &Cli) -> Result<(), Error> {
    if let Some(name) = &cli.screenshot {
        check_picture_name(name)?;
    }
    // A path of the camera is an input too.
    let mut inputs = cli.files.clone();
    if let CameraFlag::Path(file) = &cli.camera {
        inputs.push(file.clone());
    }
    let pictures = (0..cli.frames).filter_map(|frame| picture_name(cli, frame));
    for picture in pictures {
        check_place(&picture, &inputs)?;
        if cli.stats.as_ref().is_some_and(|stats| same_place(&picture, stats)) {
            return Err(Error::SameFile { path: picture, other: "what --stats writes" });
        }
    }
    if let Some(stats) = &cli.stats {
        check_place(stats, &inputs)?;
        check_stats(stats)?;
    }
    // A temporary that is made and gone again tells whether the folders can be written.
    let last = picture_name(cli, cli.frames.saturating_sub(1));
    last.iter().chain(&cli.stats).try_for_each(|path| {
        fct::Pending::create(path, true).map_err(Error::Place)?;
        // One under the name that temporaries have here takes those of killed runs with it.
        let _ = fct::Pending::create(&folder_of(path).join(TEMPORARY), true);
        Ok(())
    })
}

/// The file for a frame's picture, if it gets one: each frame where the name has a placeholder, else the last.
pub(super) fn picture_name(cli: &Cli, frame: u32) -> Option<PathBuf> {
    let name = cli.screenshot.as_ref()?;
    let last = cli.frames.saturating_sub(1);
    match name.to_str() {
        Some(text) if text.contains(PLACEHOLDER) => {
            // All numbers are as wide as the last, so that the names sort as the frames do.
            let width = last.to_string().len();
            Some(PathBuf::from(text.replace(PLACEHOLDER, &format!("{frame:0width$}"))))
        }
        // Names that are not Unicode hold no placeholder.
        _ => (frame == last).then(|| name.clone()),
    }
}

/// Writes a document; one that is there is replaced.
///
/// # Errors
/// [`Error::Write`].
pub(crate) fn write_json(path: &Path, document: &impl serde::Serialize) -> Result<(), Error> {
    let failed = |source| Error::Write { path: path.to_path_buf(), source };
    let mut text = serde_json::to_string_pretty(document).map_err(|error| failed(error.into()))?;
    text.push('\n');
    replace(path, |out| out.write_all(text.as_bytes())).map_err(failed)
}

/// Writes a file beside its place and moves it there, so that whoever has the old one open, mapped even, keeps it
/// whole, and a failure leaves it as it was.
///
/// # Errors
/// What making, writing or moving the file says, or `write`.
pub(crate) fn replace<E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let mut builder = tempfile::Builder::new();
    let prefix = format!(".{TEMPORARY}.");
    builder.prefix(&prefix).suffix(fct::Pending::SUFFIX);
    #[cfg(unix)]
    {
        // The default is for the owner alone; a picture is a file like any other, as the umask says.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // The kind alone: the library's words name the temporary, which the user has never seen.
    let temporary = builder.tempfile_in(folder_of(path)).map_err(|error| io::Error::from(error.kind()))?;
    let mut writer = BufWriter::new(temporary);
    write(&mut writer)?;
    let temporary = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
    temporary.persist(path).map_err(|error| error.error)?;
    Ok(())
}

fn check_picture_name(name: &Path) -> Result<(), Error> {
    let refused = |reason| Err(Error::Output { path: name.to_path_buf(), reason });
    check_not_stdout(name)?;
    if !name.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return refused("pictures are PNG files; give --screenshot a name that ends in .png");
    }
    let rest = name.file_name().map(|file| file.to_string_lossy().replace(PLACEHOLDER, ""));
    if rest.is_some_and(|rest| rest.contains(['{', '}'])) {
        return refused("the name has a brace that is not part of {n}, the number of the frame");
    }
    Ok(())
}

/// Stats replace nothing but stats: a model or a path of the camera in their place is a slip.
fn check_stats(path: &Path) -> Result<(), Error> {
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        let reason = "stats are JSON; give --stats a name that ends in .json";
        return Err(Error::Output { path: path.to_path_buf(), reason });
    }
    let start = || -> io::Result<Vec<u8>> {
        let mut start = Vec::new();
        fs::File::open(path)?.take(STATS_START).read_to_end(&mut start)?;
        Ok(start)
    };
    let mark = b"\"generator\": \"fcview ";
    let is_stats = |start: &[u8]| start.starts_with(b"{") && start.windows(mark.len()).any(|w| w == mark);
    if path.exists() && !start().is_ok_and(|start| is_stats(&start)) {
        return Err(Error::NotStats { path: path.to_path_buf() });
    }
    Ok(())
}

/// Whether an output may be written at its place.
fn check_place(path: &Path, inputs: &[PathBuf]) -> Result<(), Error> {
    check_not_stdout(path)?;
    let folder = folder_of(path);
    let failed = |source| Error::Folder { path: path.to_path_buf(), folder: folder.to_path_buf(), source };
    let found = fs::metadata(folder).map_err(failed)?;
    if !found.is_dir() {
        return Err(failed(io::ErrorKind::NotADirectory.into()));
    }
    if inputs.iter().any(|input| same_place(path, input)) {
        return Err(Error::SameFile { path: path.to_path_buf(), other: "an input" });
    }
    // A pipe or a device would be replaced by a file, which nobody means.
    if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return Err(Error::NotAFile { path: path.to_path_buf() });
    }
    Ok(())
}

fn check_not_stdout(path: &Path) -> Result<(), Error> {
    if path.as_os_str() == "-" {
        let reason = "this program does not write to standard output; give the name of a file";
        return Err(Error::Output { path: path.to_path_buf(), reason });
    }
    Ok(())
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
    Some(fs::canonicalize(folder_of(path)).ok()?.join(path.file_name()?))
}

/// The folder that a file lies in.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn cli(words: &str) -> Cli {
        Cli::try_parse_from(["fcview", "a.fct", "--headless"].into_iter().chain(words.split_whitespace()))
            .unwrap()
    }

    #[test]
    fn names_of_pictures_sort_as_their_frames_do() {
        for (frames, first, last) in
            [(1, "f0.png", "f0.png"), (10, "f0.png", "f9.png"), (11, "f00.png", "f10.png")]
        {
            let cli = cli(&format!("--frames {frames} --screenshot f{{n}}.png"));
            assert_eq!(picture_name(&cli, 0), Some(PathBuf::from(first)));
            assert_eq!(picture_name(&cli, frames - 1), Some(PathBuf::from(last)));
        }
        let cli = cli("--frames 3 --screenshot f.png");
        let names: Vec<_> = (0..3).map(|frame| picture_name(&cli, frame)).collect();
        assert_eq!(names, [None, None, Some(PathBuf::from("f.png"))]);
    }

    #[test]
    fn a_replaced_file_leaves_its_readers_the_old_one_and_no_trace_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        fs::write(&path, "old").unwrap();
        let mut open = fs::File::open(&path).unwrap();
        replace(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        if cfg!(unix) {
            assert_eq!(io::read_to_string(&mut open).unwrap(), "old");
        }
        let failed = replace(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("stop"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn one_file_is_known_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let [file, other] = ["a.fct", "b.png"].map(|name| folder.path().join(name));
        fs::write(&file, "x").unwrap();
        assert!(same_place(&file, &folder.path().join(".").join("a.fct")));
        assert!(!same_place(&file, &other));
        assert!(same_place(&other, &folder.path().join(".").join("b.png")), "also when it is not there");
        fs::hard_link(&file, &other).unwrap();
        assert!(cfg!(not(unix)) || same_place(&file, &other));
    }
}
