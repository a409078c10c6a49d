//! The graphics device: which adapter is taken, and where its errors go.
//!
//! `WGPU_BACKEND` (such as `vulkan` or `gl`) narrows the backends and `WGPU_ADAPTER_NAME` (part of a name)
//! picks an adapter; without them the strongest kind of adapter wins and a software one is the last resort.

use crate::Error;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long one piece of GPU work may take before it counts as hung.
///
/// A software rasteriser draws some ten million triangles a second, so a full-resolution frame of a large
/// scene takes many seconds; shorter would break honest work, longer only delays the message.
const PATIENCE: Duration = Duration::from_secs(120);

/// A device with its queue, and what the driver said about itself. A clone is the same device.
#[derive(Clone)]
pub struct Gpu {
    #[cfg(feature = "window")]
    pub(crate) instance: wgpu::Instance,
    pub(crate) adapter: wgpu::Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    faults: Arc<Faults>,
}

/// What the driver reported outside the call that caused it.
#[derive(Default)]
struct Faults {
    lost: AtomicBool,
    errors: Mutex<Vec<Error>>,
}

impl Faults {
    fn add(&self, error: Error) {
        self.errors.lock().unwrap_or_else(PoisonError::into_inner).push(error);
    }

    /// The first of the errors, which caused the others more often than not; all are forgotten.
    fn take(&self) -> Option<Error> {
        std::mem::take(&mut *self.errors.lock().unwrap_or_else(PoisonError::into_inner)).into_iter().next()
    }
}

/// The driver's error as ours.
fn reported(error: &wgpu::Error) -> Error {
    let message = error.to_string();
    match error {
        wgpu::Error::OutOfMemory { .. } => Error::DeviceMemory { message },
        _ => Error::Device { message },
    }
}

impl Gpu {
    /// Opens a device for drawing without a display.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] and its neighbours, all of exit code 6.
    pub fn headless() -> Result<Gpu, Error> {
        first_that_works(|backends| {
            let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
            descriptor.backends = backends;
            Gpu::from_instance(wgpu::Instance::new(descriptor), None, backends)
        })
    }

    /// Opens a device of `instance` that can present to `surface`, where one is given.
    pub(crate) fn from_instance(
        instance: wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
        backends: wgpu::Backends,
    ) -> Result<Gpu, Error> {
        let adapter = choose_adapter(&instance, surface, backends)?;
        let info = adapter.get_info();
        let downlevel = adapter.get_downlevel_capabilities();
        for (flag, what) in [
            (wgpu::DownlevelFlags::BASE_VERTEX, "base vertices"),
            (wgpu::DownlevelFlags::NON_POWER_OF_TWO_MIPMAPPED_TEXTURES, "textures of any size"),
        ] {
            if !downlevel.flags.contains(flag) {
                return Err(Error::Unsuitable { adapter: info.name, missing: what.to_owned() });
            }
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("fcview"),
            required_features: wgpu::Features::empty(),
            // Whatever the adapter has: a model of a hundred million vertices needs buffers beyond the defaults.
            required_limits: adapter.limits(),
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| Error::NoDevice { adapter: info.name, reason: error.to_string() })?;
        let faults = Arc::new(Faults::default());
        let sink = Arc::clone(&faults);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| sink.add(reported(&error))));
        let sink = Arc::clone(&faults);
        device.set_device_lost_callback(move |_, message| {
            if !message.is_empty() {
                sink.add(Error::DeviceLost { reason: message });
            }
            sink.lost.store(true, Ordering::Release);
        });
        Ok(Gpu {
            #[cfg(feature = "window")]
            instance,
            adapter,
            device,
            queue,
            faults,
        })
    }

    /// What the driver says about itself.
    pub fn info(&self) -> wgpu::AdapterInfo {
        self.adapter.get_info()
    }

    /// True if the adapter is a program on the CPU: right, but slow.
    pub fn is_software(&self) -> bool {
        self.info().device_type == wgpu::DeviceType::Cpu
    }

    /// The limits that the device was opened with.
    pub fn limits(&self) -> wgpu::Limits {
        self.device.limits()
    }

    /// Whether depth can be read back; OpenGL cannot.
    pub(crate) fn copies_depth(&self) -> bool {
        let flags = self.adapter.get_downlevel_capabilities().flags;
        flags.contains(wgpu::DownlevelFlags::DEPTH_TEXTURE_AND_BUFFER_COPIES)
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// [`Error::Timeout`] if the device seems hung, and what [`Gpu::check`] says.
    pub fn wait(&self, what: &'static str) -> Result<(), Error> {
        let waited = self.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) })?;
        self.check()?;
        if waited { Ok(()) } else { Err(Error::Timeout { what, seconds: PATIENCE.as_secs() }) }
    }

    /// Reports what the driver complained about since the last call.
    ///
    /// # Errors
    /// [`Error::DeviceLost`], [`Error::DeviceMemory`] or [`Error::Device`].
    pub fn check(&self) -> Result<(), Error> {
        // A device that is gone drops all calls without a word; only when polled does it say so.
        self.poll(wgpu::PollType::Poll)?;
        let first = self.faults.take();
        if self.faults.lost.load(Ordering::Acquire) {
            let reason = first.map_or_else(|| "no reason given".to_owned(), driver_words);
            return Err(Error::DeviceLost { reason });
        }
        first.map_or(Ok(()), Err)
    }

    /// Lets the device go, as a driver does that is updated or was hung, for tests of what follows.
    #[doc(hidden)]
    pub fn lose(&self) {
        self.device.destroy();
    }

    /// Reports that memory has run out, as a driver does, for tests of what follows.
    #[doc(hidden)]
    pub fn run_out_of_memory(&self) {
        self.faults.add(Error::DeviceMemory { message: "out of memory, said a test".to_owned() });
    }

    /// Looks after submitted work; false if it was not done in time.
    fn poll(&self, how: wgpu::PollType) -> Result<bool, Error> {
        // wgpu panics where the driver loses the device during a wait.
        let polled = catch_unwind(AssertUnwindSafe(|| self.device.poll(how).is_ok()));
        polled.map_err(|panic| {
            self.faults.lost.store(true, Ordering::Release);
            let words = panic.downcast_ref::<String>().map(String::as_str);
            Error::DeviceLost { reason: words.unwrap_or("while it was waited for").to_owned() }
        })
    }
}

/// What the driver said, without our words around it.
fn driver_words(error: Error) -> String {
    match error {
        Error::DeviceLost { reason } => reason,
        Error::DeviceMemory { message } | Error::Device { message } => message,
        other => other.to_string(),
    }
}

/// Tries the backends that modern systems have, then the others with them.
///
/// Asking OpenGL starts a good part of it, which takes time and may print warnings, so it is asked only where
/// nothing else answers.
pub(crate) fn first_that_works<T>(
    mut open: impl FnMut(wgpu::Backends) -> Result<T, Error>,
) -> Result<T, Error> {
    let allowed = wgpu::Backends::all().with_env();
    let modern = allowed & wgpu::Backends::PRIMARY;
    if !modern.is_empty() && modern != allowed {
        match open(modern) {
            Err(Error::NoAdapter { .. } | Error::NoSuchAdapter { .. }) => {}
            done => return done,
        }
    }
    open(allowed)
}

/// Takes the adapter that `WGPU_ADAPTER_NAME` names, else the strongest kind that suits the surface.
fn choose_adapter(
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface<'_>>,
    backends: wgpu::Backends,
) -> Result<wgpu::Adapter, Error> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    if let Some(surface) = surface {
        adapters.retain(|adapter| adapter.is_surface_supported(surface));
    }
    if let Ok(wanted) = std::env::var("WGPU_ADAPTER_NAME") {
        let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
        let lower = wanted.to_lowercase();
        adapters.retain(|adapter| adapter.get_info().name.to_lowercase().contains(&lower));
        if adapters.is_empty() && !names.is_empty() {
            return Err(Error::NoSuchAdapter { wanted, found: names.join(", ") });
        }
    }
    // The sort is stable, so adapters of one kind stay in the order of the backends, Vulkan and Metal first.
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
        .into_iter()
        .next()
        .ok_or_else(|| Error::NoAdapter { backends: crate::error::built_backends(backends) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn buffer(gpu: &Gpu, size: u64) {
        let usage = wgpu::BufferUsages::VERTEX;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        drop(gpu.device.create_buffer(&descriptor));
    }

    #[test]
    fn a_bad_call_is_reported_once_and_the_device_goes_on() {
        let gpu = Gpu::headless().expect("this test needs a graphics adapter");
        buffer(&gpu, u64::MAX);
        assert!(matches!(gpu.check(), Err(Error::Device { .. })));
        gpu.check().expect("it was reported");
        buffer(&gpu, 64);
        gpu.wait("nothing").expect("the device goes on");
    }

    #[test]
    fn a_lost_device_says_so_at_every_check_and_keeps_quiet_at_calls() {
        let gpu = Gpu::headless().expect("this test needs a graphics adapter");
        gpu.lose();
        for _ in 0..3 {
            buffer(&gpu, 64);
            assert!(matches!(gpu.check(), Err(Error::DeviceLost { .. })));
            assert!(matches!(gpu.wait("nothing"), Err(Error::DeviceLost { .. })));
        }
    }
}
