//! What can go wrong, with the exit code and the message code of each case.

use std::path::PathBuf;

/// An error of the viewer; its text says what happened, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The program has failed by a bug of its own.
    #[error("fcview failed by a bug of its own; please report it with the command and the input")]
    Bug,
    /// No graphics adapter answers on any backend.
    #[error(
        "no graphics adapter found (backends tried: {backends}); install a graphics driver, or a software \
         one: on Debian and Ubuntu `apt-get install mesa-vulkan-drivers libvulkan1`"
    )]
    NoAdapter {
        /// The backends that were asked, comma separated.
        backends: String,
    },
    /// `WGPU_BACKEND` allows only backends on which no adapter answers.
    #[error(
        "no graphics adapter found: WGPU_BACKEND is `{wanted}`, {}; unset it to try all that this program was built \
         with ({built}), or install a driver: on Debian and Ubuntu `apt-get install mesa-vulkan-drivers libvulkan1`",
        allowed(backends, built)
    )]
    NoAdapterOnBackend {
        /// What the variable says.
        wanted: String,
        /// The backends that were asked, comma separated, or `none`.
        backends: String,
        /// The backends of this program, comma separated.
        built: String,
    },
    /// `WGPU_ADAPTER_NAME` names no adapter of this machine.
    #[error(
        "no graphics adapter's name contains `{wanted}` (WGPU_ADAPTER_NAME); found: {}; give a part of one of these \
         names, or unset the variable",
        distinct(found)
    )]
    NoSuchAdapter {
        /// The text looked for.
        wanted: String,
        /// The names of the adapters that exist, comma separated; one may stand there for each of its backends.
        found: String,
    },
    /// The adapter lacks something that drawing needs.
    #[error(
        "the graphics adapter {adapter} lacks {missing}; choose another one with WGPU_ADAPTER_NAME or WGPU_BACKEND"
    )]
    Unsuitable {
        /// The adapter's name.
        adapter: String,
        /// The feature or limit that is missing.
        missing: String,
    },
    /// The adapter exists but gives no device.
    #[error("the graphics adapter {adapter} gives no device: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// The device was lost while drawing.
    #[error("the graphics device was lost again ({reason}), after it had been rebuilt three times")]
    DeviceLost {
        /// The driver's words.
        reason: String,
    },
    /// The device has no memory left, with all given back that can be made anew.
    #[error(
        "the graphics device has no memory left: {message}; draw less with a larger --pixels, a smaller --size, or \
         --samples 1"
    )]
    DeviceMemory {
        /// The device's words.
        message: String,
    },
    /// The device refused a command: a bug of ours or of the driver.
    #[error("the graphics device reports: {message}")]
    Device {
        /// The device's words.
        message: String,
    },
    /// The GPU did not finish in time.
    #[error(
        "the graphics device did not finish {what} within {seconds} s; try fewer instances or a larger --pixels"
    )]
    Timeout {
        /// The work waited for.
        what: &'static str,
        /// The time allowed, seconds.
        seconds: u64,
    },
    /// There is no display, or the windowing system refused.
    #[error("no window: {reason}; use --headless to draw without a display")]
    NoWindow {
        /// The windowing system's words.
        reason: String,
    },
    /// The picture is larger than the adapter can draw.
    #[error("a picture of {width} x {height} pixels is outside what the adapter draws: 1 to {limit} a side")]
    PictureSize {
        /// Width asked for, pixels.
        width: u32,
        /// Height asked for, pixels.
        height: u32,
        /// The adapter's limit, pixels.
        limit: u32,
    },
    /// A model or a cut of it needs a larger buffer than the adapter offers.
    #[error("{what} needs a buffer of {bytes} bytes, the adapter offers {limit}; {remedy}")]
    BufferSize {
        /// What needs the buffer.
        what: String,
        /// Bytes needed.
        bytes: u64,
        /// The adapter's limit.
        limit: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// The memory allowed for vertices does not hold those of a triangle.
    #[error(
        "{bytes} bytes of graphics memory do not hold a triangle's vertices; allow --gpu-memory {least} or more"
    )]
    GpuMemory {
        /// Bytes allowed.
        bytes: u64,
        /// Bytes that would be enough to draw something.
        least: u64,
    },
    /// The system gives no thread to draw on.
    #[error(
        "no thread can be started: {source}; end other programs, or raise the limit on processes (ulimit -u)"
    )]
    NoThread {
        /// The system's words.
        source: std::io::Error,
    },
    /// The camera's numbers make no view.
    #[error("the camera makes no view: {reason}")]
    Camera {
        /// Which number, and why.
        reason: &'static str,
    },
    /// A recorded path of the camera is none.
    #[error("{}: no path of a camera: {reason}; record one in the window with the key R, or see `Paths of the \
         camera` in docs/viewer.md", path.display())]
    CameraPath {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file could not be read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// An output is another file of the command line.
    #[error("{}: the output is {other}; give the output another name", path.display())]
    SameFile {
        /// The output.
        path: PathBuf,
        /// What it is besides.
        other: &'static str,
    },
    /// An output's name says something else than what is written.
    #[error("{}: {reason}", path.display())]
    Output {
        /// The output.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        reason: &'static str,
    },
    /// The folder of an output is not there.
    #[error("{}: cannot use the folder {}: {source}; make it first, or name another one", path.display(), folder.display())]
    Folder {
        /// The output.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// Standard output cannot be written.
    #[error("cannot write to standard output: {0}")]
    Stdout(std::io::Error),
    /// No file can be made in the folder of an output.
    #[error(transparent)]
    Place(fct::Error),
    /// A signal asked the program to stop.
    #[error("stopped by a signal after {frames} of {of} frames; pictures that were written stay")]
    Interrupted {
        /// 128 + the signal's number, as shells have it.
        exit: u8,
        /// Frames that were drawn.
        frames: u32,
        /// Frames asked for.
        of: u32,
    },
    /// The output is a directory, a pipe or a device.
    #[error("{}: the output is no regular file; give the path of a file", path.display())]
    NotAFile {
        /// The output.
        path: PathBuf,
    },
    /// The stats would replace another document.
    #[error("{}: the file is no stats document of fcview and is left alone; give --stats another name", path.display())]
    NotStats {
        /// The output.
        path: PathBuf,
    },
    /// A file could not be written.
    #[error("{}: cannot write: {source}; choose a folder with room that you can write to", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// The picture could not be encoded.
    #[error("{}: cannot encode the picture: {source}", path.display())]
    Png {
        /// The file.
        path: PathBuf,
        /// The encoder's words.
        source: png::EncodingError,
    },
    /// A .fct file could not be opened or is invalid.
    #[error(transparent)]
    Fct(#[from] fct::Error),
    /// A tree could not be cut.
    #[error("{}", cut_refused(model, source))]
    Extract {
        /// The model's name.
        model: String,
        /// The extractor's words.
        source: fcextract::Error,
    },
}

/// A damaged tree's error names the file itself.
fn cut_refused(model: &str, source: &fcextract::Error) -> String {
    match source {
        fcextract::Error::Tree(error) => error.to_string(),
        other => format!("{model}: {other}"),
    }
}

/// What `WGPU_BACKEND` allows, where it names a backend of this program.
fn allowed(backends: &str, built: &str) -> String {
    match backends {
        "none" => format!("which is none of this program's backends; give one of: {built}"),
        some => format!("which allows only: {some}"),
    }
}

/// A comma-separated list without what stands there twice; a comma in parentheses belongs to a name.
fn distinct(list: &str) -> String {
    let mut depth = 0_u32;
    let names = list.split(|c: char| {
        match c {
            '(' => depth = depth.saturating_add(1),
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        c == ',' && depth == 0
    });
    let mut kept: Vec<&str> = Vec::new();
    for name in names.map(str::trim) {
        if !kept.contains(&name) {
            kept.push(name);
        }
    }
    kept.join(", ")
}

/// The names of the backends of a set that this program was built with, comma separated, or `none`.
pub(crate) fn built_backends(set: wgpu::Backends) -> String {
    let built = wgpu::Instance::enabled_backend_features() & set;
    let names: Vec<&str> = wgpu::Backend::ALL
        .into_iter()
        .filter(|backend| built.contains(wgpu::Backends::from(*backend)))
        .map(wgpu::Backend::to_str)
        .collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

impl Error {
    /// Where no adapter was found and `WGPU_BACKEND` is set: says so.
    pub(crate) fn with_backends_asked_for(self) -> Error {
        match (self, std::env::var_os("WGPU_BACKEND")) {
            (Error::NoAdapter { backends }, Some(wanted)) => {
                let wanted = wanted.to_string_lossy().into_owned();
                let built = built_backends(wgpu::Backends::all());
                Error::NoAdapterOnBackend { wanted, backends, built }
            }
            (error, _) => error,
        }
    }

    /// The process's exit code for this error: 1 our bug, 2 usage, 3 bad input data, 4 input or output, 5 a limit,
    /// 6 no GPU or display, 7 an invalid .fct file, and that of a signal.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::NoAdapter { .. }
            | Error::NoAdapterOnBackend { .. }
            | Error::NoSuchAdapter { .. }
            | Error::Unsuitable { .. }
            | Error::NoDevice { .. }
            | Error::DeviceLost { .. }
            | Error::Device { .. }
            | Error::Timeout { .. }
            | Error::NoWindow { .. } => 6,
            Error::PictureSize { .. }
            | Error::BufferSize { .. }
            | Error::GpuMemory { .. }
            | Error::DeviceMemory { .. }
            | Error::NoThread { .. } => 5,
            Error::Camera { .. } | Error::SameFile { .. } | Error::Output { .. } => 2,
            Error::Bug => 1,
            Error::Interrupted { exit, .. } => *exit,
            Error::CameraPath { .. } => 3,
            Error::Read { .. }
            | Error::Write { .. }
            | Error::Png { .. }
            | Error::Folder { .. }
            | Error::Place(_)
            | Error::Stdout(_)
            | Error::NotAFile { .. }
            | Error::NotStats { .. } => 4,
            Error::Fct(error) | Error::Extract { source: fcextract::Error::Tree(error), .. } => {
                error.exit_code()
            }
            Error::Extract { source: fcextract::Error::Selection(_), .. } => 2,
            // Too many triangles, or too little memory.
            Error::Extract { .. } => 5,
        }
    }

    /// The stable code that stands in front of the message, such as `FC601`.
    pub fn code(&self) -> &'static str {
        match self {
            Error::SameFile { .. } => "FC101",
            Error::Camera { .. } => "FC221",
            Error::Output { .. } => "FC222",
            Error::Extract { source: fcextract::Error::Selection(_), .. } => "FC223",
            Error::CameraPath { .. } => "FC224",
            Error::Stdout(_) => "FC413",
            Error::Read { .. } => "FC424",
            Error::Write { .. } => "FC421",
            Error::Png { .. } => "FC422",
            Error::Folder { .. } | Error::Place(_) => "FC423",
            Error::NotAFile { .. } => "FC473",
            Error::NotStats { .. } => "FC474",
            Error::NoThread { .. } => "FC507",
            Error::PictureSize { .. } => "FC521",
            Error::BufferSize { .. } => "FC522",
            Error::GpuMemory { .. } => "FC524",
            Error::DeviceMemory { .. } => "FC525",
            Error::NoAdapter { .. } => "FC601",
            Error::NoSuchAdapter { .. } => "FC602",
            Error::Unsuitable { .. } => "FC603",
            Error::NoDevice { .. } => "FC604",
            Error::DeviceLost { .. } => "FC605",
            Error::Device { .. } => "FC606",
            Error::Timeout { .. } => "FC607",
            Error::NoWindow { .. } => "FC608",
            Error::NoAdapterOnBackend { .. } => "FC609",
            Error::Bug => "FC901",
            Error::Interrupted { .. } => "FC902",
            Error::Fct(error) | Error::Extract { source: fcextract::Error::Tree(error), .. } => error.code(),
            Error::Extract { .. } => "FC523",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_adapters_stand_there_once() {
        let found = "llvmpipe (LLVM 19, 256 bits), Card X, llvmpipe (LLVM 19, 256 bits)";
        assert_eq!(distinct(found), "llvmpipe (LLVM 19, 256 bits), Card X");
        assert_eq!(distinct(""), "");
    }

    #[test]
    fn a_damaged_tree_keeps_its_code_and_names_its_file_once() {
        let tree = || fct::Error::NotAFile { path: PathBuf::from("a.fct") };
        let error = Error::Extract { model: "a.fct".to_owned(), source: fcextract::Error::Tree(tree()) };
        assert_eq!((error.code(), error.exit_code()), (tree().code(), tree().exit_code()));
        assert_eq!(error.to_string(), tree().to_string());
    }
}
