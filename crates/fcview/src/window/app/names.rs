//! What files and windows are called, what is said of them, and how large a window may be.

use crate::cli::Cli;
use crate::{Scene, Warning};
use std::path::{Path, PathBuf};
use winit::dpi::PhysicalSize;

/// The first name that no file has, with a number from 0 on.
pub(super) fn free_name(stem: &str, extension: &str) -> PathBuf {
    let name = |number: u32| PathBuf::from(format!("{stem}{number}.{extension}"));
    (0..100_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(100_000))
}

/// What files are called in a title or a message.
pub(super) fn names(files: &[PathBuf]) -> String {
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    match files {
        [] => "nothing".to_owned(),
        [only] => name(only),
        [first, rest @ ..] => format!("{} and {} more", name(first), rest.len()),
    }
}

/// What is said of a scene that was opened: that, and why it may look hollow.
pub(super) fn about(cli: &Cli, scene: &Scene, opened: &str) -> String {
    match Warning::of_hollow(cli, scene) {
        Some(_) if opened.is_empty() => HOLLOW.to_owned(),
        Some(_) => format!("{opened}; {HOLLOW}"),
        None => opened.to_owned(),
    }
}

/// For the panel, which has a switch for it.
const HOLLOW: &str = "the faces look inwards, so that the model looks hollow: see \"Two-sided\"";

/// The window's title: what it shows, then the program.
pub(super) fn title(files: &[PathBuf]) -> String {
    format!("{} - facetree", names(files))
}

/// A window's size, pixels, no larger than the monitor: beyond it, its panel and its edges are out of reach.
pub(super) fn fitting(size: [u32; 2], monitor: Option<PhysicalSize<u32>>) -> PhysicalSize<u32> {
    let [width, height] = size;
    match monitor {
        // Some systems know a monitor but not its size.
        Some(monitor) if monitor.width > 0 && monitor.height > 0 => {
            PhysicalSize::new(width.min(monitor.width), height.min(monitor.height))
        }
        _ => PhysicalSize::new(width, height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_names_the_files_and_the_window_fits_the_monitor() {
        assert_eq!(title(&["a/scan.fct".into()]), "scan.fct - facetree");
        assert_eq!(title(&["a.fct".into(), "b.fct".into(), "c.fct".into()]), "a.fct and 2 more - facetree");
        let monitor = Some(PhysicalSize::new(1024, 768));
        assert_eq!(fitting([1280, 720], monitor), PhysicalSize::new(1024, 720));
        assert_eq!(fitting([1280, 720], None), PhysicalSize::new(1280, 720));
    }
}
