//! What can go wrong, with the exit code and the message code of each case.

use std::path::PathBuf;

/// An error of the viewer; its text says what happened, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// No graphics adapter answers on any backend.
    #[error(
        "no graphics adapter found (backends tried: {backends}); install a graphics driver, or a software \
         one: on Debian and Ubuntu `apt-get install mesa-vulkan-drivers libvulkan1`"
    )]
    NoAdapter {
        /// The backends that were asked, comma separated.
        backends: String,
    },
    /// `WGPU_ADAPTER_NAME` names no adapter of this machine.
    #[error("no graphics adapter's name contains `{wanted}` (WGPU_ADAPTER_NAME); found: {found}")]
    NoSuchAdapter {
        /// The text looked for.
        wanted: String,
        /// The names of the adapters that exist.
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
    #[error("the graphics device was lost ({reason}); it is rebuilt up to three times")]
    DeviceLost {
        /// The driver's words.
        reason: String,
    },
    /// The device refused a command: out of memory, or a bug of ours or of the driver.
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
    /// The camera's numbers make no view.
    #[error("the camera makes no view: {reason}")]
    Camera {
        /// Which number, and why.
        reason: &'static str,
    },
    /// A file could not be written or a folder could not be made.
    #[error("{}: cannot write: {source}", path.display())]
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
    #[error("{model}: {source}")]
    Extract {
        /// The model's name.
        model: String,
        /// The extractor's words.
        source: fcextract::Error,
    },
}

impl Error {
    /// The process's exit code for this error: 1 our bug, 2 usage, 4 input or output, 5 a limit, 6 no GPU or
    /// display, 7 an invalid .fct file.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::NoAdapter { .. }
            | Error::NoSuchAdapter { .. }
            | Error::Unsuitable { .. }
            | Error::NoDevice { .. }
            | Error::DeviceLost { .. }
            | Error::Device { .. }
            | Error::Timeout { .. }
            | Error::NoWindow { .. } => 6,
            Error::PictureSize { .. } | Error::BufferSize { .. } => 5,
            Error::Camera { .. } => 2,
            Error::Write { .. } | Error::Png { .. } => 4,
            Error::Fct(error) => error.exit_code(),
            Error::Extract { .. } => 7,
        }
    }

    /// The stable code that stands in front of the message, such as `FC601`.
    pub fn code(&self) -> &'static str {
        match self {
            Error::Camera { .. } => "FC221",
            Error::Write { .. } => "FC421",
            Error::Png { .. } => "FC422",
            Error::PictureSize { .. } => "FC521",
            Error::BufferSize { .. } => "FC522",
            Error::NoAdapter { .. } => "FC601",
            Error::NoSuchAdapter { .. } => "FC602",
            Error::Unsuitable { .. } => "FC603",
            Error::NoDevice { .. } => "FC604",
            Error::DeviceLost { .. } => "FC605",
            Error::Device { .. } => "FC606",
            Error::Timeout { .. } => "FC607",
            Error::NoWindow { .. } => "FC608",
            Error::Extract { .. } => "FC721",
            Error::Fct(error) => error.code(),
        }
    }
}
