//! What is done when a device fails at a frame: it is rebuilt, or memory is given back, a bounded number of times.

use crate::cli::Cli;
use crate::{Error, FrameOptions, FrameStats, Gpu, Renderer, Scene};

/// How often in a run a lost device is rebuilt. A driver that was updated or hung once comes back with the first; one
/// that needs more will not come back.
pub const REBUILDS: u32 = 3;

/// What may help against a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Remedy {
    /// A new device with everything on it.
    Rebuild,
    /// All memory given back that can be filled anew.
    Evict,
}

/// Counts the failures of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Recovery {
    rebuilds: u32,
    evicted: bool,
}

impl Recovery {
    /// What to try before the same frame is drawn again.
    ///
    /// # Errors
    /// The failure itself where nothing is left to try.
    pub(crate) fn remedy(&mut self, failure: Error) -> Result<Remedy, Error> {
        match failure {
            Error::DeviceLost { .. } if self.rebuilds < REBUILDS => {
                self.rebuilds += 1;
                Ok(Remedy::Rebuild)
            }
            // Once a frame: what does not fit into empty memory never will.
            Error::DeviceMemory { .. } if !self.evicted => {
                self.evicted = true;
                Ok(Remedy::Evict)
            }
            failure => {
                self.drawn();
                Err(failure)
            }
        }
    }

    /// A frame was drawn, or given up.
    pub(crate) fn drawn(&mut self) {
        self.evicted = false;
    }
}

/// Failures still to come, for tests of what follows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Misfortune {
    losses: u32,
    shortages: u32,
}

impl Misfortune {
    /// What the hidden flags of a command line ask for.
    pub(crate) fn new(cli: &Cli) -> Misfortune {
        Misfortune { losses: cli.lose_device, shortages: cli.exhaust_memory }
    }

    /// Strikes a device, at an attempt to draw.
    pub(crate) fn strike(&mut self, gpu: &Gpu) {
        if self.losses > 0 {
            self.losses -= 1;
            gpu.lose();
        } else if self.shortages > 0 {
            self.shortages -= 1;
            gpu.run_out_of_memory();
        }
    }
}

/// A renderer that survives its device.
pub struct Survivor<'a> {
    scene: &'a Scene,
    open: Box<dyn FnMut() -> Result<Gpu, Error> + 'a>,
    renderer: Option<Renderer>,
    recovery: Recovery,
}

impl<'a> Survivor<'a> {
    /// A renderer of `scene` on the device that `open` opens, now and whenever it is lost.
    ///
    /// # Errors
    /// Those of `open` and of [`Renderer::new`].
    pub fn new(
        scene: &'a Scene,
        open: impl FnMut() -> Result<Gpu, Error> + 'a,
    ) -> Result<Survivor<'a>, Error> {
        let mut survivor =
            Survivor { scene, open: Box::new(open), renderer: None, recovery: Recovery::default() };
        survivor.surely(|_, _| Ok(()))?;
        Ok(survivor)
    }

    /// Draws a frame, and has `then` do what it has to with it, on one device.
    ///
    /// # Errors
    /// Those of [`Renderer::draw`] and of `then`. A lost device is rebuilt up to three times in the life of this
    /// renderer and a frame without memory is drawn once more after all was given back; `then` may be called again.
    pub fn draw<T>(
        &mut self,
        camera: &crate::Camera,
        options: &FrameOptions,
        mut then: impl FnMut(&mut Renderer) -> Result<T, Error>,
    ) -> Result<(FrameStats, T), Error> {
        self.surely(|renderer, scene| {
            let stats = renderer.draw(scene, camera, options)?;
            Ok((stats, then(renderer)?))
        })
    }

    /// The device.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.renderer.as_ref().map(Renderer::gpu)
    }

    /// Does something with the renderer, again after each failure for which there is a remedy.
    fn surely<T>(
        &mut self,
        mut work: impl FnMut(&mut Renderer, &Scene) -> Result<T, Error>,
    ) -> Result<T, Error> {
        loop {
            let done = match &mut self.renderer {
                Some(renderer) => work(renderer, self.scene),
                None => match (self.open)().and_then(|gpu| Renderer::new(gpu, self.scene)) {
                    Ok(renderer) => {
                        self.renderer = Some(renderer);
                        continue;
                    }
                    Err(error) => Err(error),
                },
            };
            match done {
                Ok(done) => {
                    self.recovery.drawn();
                    return Ok(done);
                }
                Err(failure) => match self.recovery.remedy(failure)? {
                    // The old one goes first: two may not fit side by side.
                    Remedy::Rebuild => self.renderer = None,
                    Remedy::Evict => self.renderer.iter_mut().for_each(Renderer::evict),
                },
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_losses_are_mended_and_the_fourth_is_the_end() {
        let mut recovery = Recovery::default();
        let lost = || Error::DeviceLost { reason: "gone".to_owned() };
        for _ in 0..REBUILDS {
            assert_eq!(recovery.remedy(lost()).unwrap(), Remedy::Rebuild);
            recovery.drawn();
        }
        assert!(matches!(recovery.remedy(lost()), Err(Error::DeviceLost { .. })), "for the whole run");
    }

    #[test]
    fn memory_is_given_back_once_a_frame_and_other_failures_stay() {
        let mut recovery = Recovery::default();
        let memory = || Error::DeviceMemory { message: "none".to_owned() };
        for _ in 0..10 {
            assert_eq!(recovery.remedy(memory()).unwrap(), Remedy::Evict);
            assert!(matches!(recovery.remedy(memory()), Err(Error::DeviceMemory { .. })));
        }
        let other = Error::Device { message: "bad call".to_owned() };
        assert!(matches!(recovery.remedy(other), Err(Error::Device { .. })));
    }
}
