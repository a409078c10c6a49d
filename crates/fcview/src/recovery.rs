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
    /// Half the memory for vertices, where that helps.
    Shrink,
}

/// Counts the failures of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Recovery {
    rebuilds: u32,
    evicted: bool,
}

impl Recovery {
    /// What to try before the same frame is drawn again; `can_shrink` where the memory for vertices can be halved.
    ///
    /// # Errors
    /// The failure itself where nothing is left to try.
    pub(crate) fn remedy(&mut self, failure: Error, can_shrink: bool) -> Result<Remedy, Error> {
        match failure {
            Error::DeviceLost { .. } if self.rebuilds < REBUILDS => {
                self.rebuilds += 1;
                Ok(Remedy::Rebuild)
            }
            // Once a frame: what does not fit into empty memory never will, but for fewer vertices.
            Error::DeviceMemory { .. } if !self.evicted => {
                self.evicted = true;
                Ok(Remedy::Evict)
            }
            // So often as the vertices can be halved.
            Error::DeviceMemory { .. } if can_shrink => Ok(Remedy::Shrink),
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
    memory: Option<u64>,
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
        Survivor::with_memory(scene, None, open)
    }

    /// The same with so many bytes of the GPU's memory for vertices, as [`Renderer::with_memory`].
    ///
    /// # Errors
    /// Those of `open` and of [`Renderer::with_memory`].
    pub fn with_memory(
        scene: &'a Scene,
        memory: Option<u64>,
        open: impl FnMut() -> Result<Gpu, Error> + 'a,
    ) -> Result<Survivor<'a>, Error> {
        let recovery = Recovery::default();
        let mut survivor = Survivor { scene, memory, open: Box::new(open), renderer: None, recovery };
        survivor.surely(|_, _| Ok(()))?;
        Ok(survivor)
    }

    /// Draws a frame, and has `then` do what it has to with it, on one device.
    ///
    /// # Errors
    /// Those of [`Renderer::draw`] and of `then`. A lost device is rebuilt up to three times in the life of this
    /// renderer and a frame without memory is drawn once more after all was given back, and again with half the memory for
    /// vertices as long as that can be halved; `then` may be called again.
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
                None => {
                    match (self.open)().and_then(|gpu| Renderer::with_memory(gpu, self.scene, self.memory)) {
                        Ok(renderer) => {
                            self.renderer = Some(renderer);
                            continue;
                        }
                        Err(error) => Err(error),
                    }
                }
            };
            match done {
                Ok(done) => {
                    self.recovery.drawn();
                    return Ok(done);
                }
                Err(failure) => {
                    let can_shrink =
                        self.renderer.as_ref().is_some_and(|renderer| renderer.can_shrink(self.scene));
                    match self.recovery.remedy(failure, can_shrink)? {
                        // The old one goes first: two may not fit side by side.
                        Remedy::Rebuild => self.renderer = None,
                        Remedy::Evict => self.renderer.iter_mut().for_each(Renderer::evict),
                        Remedy::Shrink => {
                            self.renderer.iter_mut().try_for_each(|renderer| renderer.shrink(self.scene))?;
                        }
                    }
                }
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
            assert_eq!(recovery.remedy(lost(), true).unwrap(), Remedy::Rebuild);
            recovery.drawn();
        }
        assert!(matches!(recovery.remedy(lost(), true), Err(Error::DeviceLost { .. })), "for the whole run");
    }

    #[test]
    fn memory_is_given_back_once_a_frame_then_halved_and_other_failures_stay() {
        let mut recovery = Recovery::default();
        let memory = || Error::DeviceMemory { message: "none".to_owned() };
        for _ in 0..10 {
            assert_eq!(recovery.remedy(memory(), true).unwrap(), Remedy::Evict);
            assert_eq!(recovery.remedy(memory(), true).unwrap(), Remedy::Shrink);
            assert!(matches!(recovery.remedy(memory(), false), Err(Error::DeviceMemory { .. })));
        }
        let other = Error::Device { message: "bad call".to_owned() };
        assert!(matches!(recovery.remedy(other, true), Err(Error::Device { .. })));
    }
}
