//! An effect that is measured, and the input that all of its frames have.

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use super::Shot;
use super::take::TakeUpload;
use crate::blur::Blur;
use crate::data::Particles;
use crate::data::Volume;
use crate::error::Result;
use crate::flame::{self, Flame, ParticleInput};
use crate::gpu::profiler::Timing;
use crate::host::{Background, Host, HostImage};
use crate::offline::{AnyEffect, ParticleUpload, VolumeUpload};
use crate::smoke::{self, Smoke, VolumeInput};

/// An effect, what holds its input, and the input.
pub(in crate::bench) enum Made {
    Smoke(Box<Smoke>, VolumeUpload, VolumeInput),
    Flame(Box<Flame>, ParticleUpload, ParticleInput),
    Blur(Box<Blur>, Box<TakeUpload>),
}

/// What an effect is made for and given once.
pub(in crate::bench) trait Input {
    /// What the effect is made of.
    type Desc;

    /// Size of its picture.
    fn size(desc: &Self::Desc) -> [u32; 2];

    /// Makes the effect and uploads the input; leaves nothing behind on error.
    ///
    /// # Safety
    /// `host` holds valid handles, and `allocator` belongs to its device.
    unsafe fn make(&self, host: &Host, allocator: &mut Allocator, desc: Self::Desc) -> Result<Made>;
}

impl Input for Volume {
    type Desc = smoke::Desc;

    fn size(desc: &smoke::Desc) -> [u32; 2] {
        desc.size
    }

    unsafe fn make(&self, host: &Host, allocator: &mut Allocator, desc: smoke::Desc) -> Result<Made> {
        let mut upload = VolumeUpload::default();
        // SAFETY: the caller's.
        unsafe {
            let input = upload.write(host, allocator, self, desc.velocity);
            let input = input.inspect_err(|_| upload.destroy(host, allocator))?;
            let smoke = Smoke::new(host, allocator, desc).inspect_err(|_| upload.destroy(host, allocator))?;
            Ok(Made::Smoke(Box::new(smoke), upload, input))
        }
    }
}

impl Input for Particles {
    type Desc = flame::Desc;

    fn size(desc: &flame::Desc) -> [u32; 2] {
        desc.size
    }

    unsafe fn make(&self, host: &Host, allocator: &mut Allocator, desc: flame::Desc) -> Result<Made> {
        let mut upload = ParticleUpload::default();
        // SAFETY: the caller's.
        unsafe {
            let input = upload.write(host, allocator, self);
            let input = input.inspect_err(|_| upload.destroy(host, allocator))?;
            let flame = Flame::new(host, allocator, desc).inspect_err(|_| upload.destroy(host, allocator))?;
            Ok(Made::Flame(Box::new(flame), upload, input))
        }
    }
}

impl Made {
    pub(super) fn effect(&self) -> &dyn AnyEffect {
        match self {
            Made::Smoke(smoke, ..) => smoke.as_ref(),
            Made::Flame(flame, ..) => flame.as_ref(),
            Made::Blur(blur, ..) => blur.as_ref(),
        }
    }

    pub(super) fn effect_mut(&mut self) -> &mut dyn AnyEffect {
        match self {
            Made::Smoke(smoke, ..) => smoke.as_mut(),
            Made::Flame(flame, ..) => flame.as_mut(),
            Made::Blur(blur, ..) => blur.as_mut(),
        }
    }

    /// Records a frame over nothing.
    ///
    /// # Safety
    /// As [`Smoke::record`].
    pub(super) unsafe fn record(
        &mut self,
        host: &Host,
        commands: vk::CommandBuffer,
        shot: &Shot,
        target: HostImage,
    ) -> Result<()> {
        let background = Background::Clear([0.0; 4]);
        match self {
            Made::Smoke(smoke, _, volume) => {
                let frame = smoke::Frame {
                    sequence: shot.sequence,
                    dt: 1.0 / crate::bench::smoke::scene::FPS as f32,
                    camera: shot.camera,
                    light: shot.light,
                    volume: Some(*volume),
                    target: shot.rendered.then_some(target),
                    background,
                    depth: None,
                    edges: None,
                };
                // SAFETY: the caller's.
                unsafe { smoke.record(host, commands, &frame, &mut Timing::None) }
            }
            Made::Flame(flame, _, particles) => {
                let frame = flame::Frame {
                    camera: shot.camera,
                    particles: Some(*particles),
                    number: 0,
                    accumulate: false,
                    target,
                    background,
                    scene: None,
                };
                // SAFETY: the caller's.
                unsafe { flame.record(host, commands, &frame, &mut Timing::None) }
            }
            // SAFETY: the caller's.
            Made::Blur(blur, upload) => unsafe { upload.record(host, commands, blur, target, background) },
        }
    }

    /// Destroys all of it.
    ///
    /// # Safety
    /// The device is done with every frame; `host` and `allocator` are those that it was made with.
    pub(super) unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        unsafe {
            self.effect_mut().destroy(host, allocator);
            match self {
                Made::Smoke(_, upload, _) => upload.destroy(host, allocator),
                Made::Flame(_, upload, _) => upload.destroy(host, allocator),
                Made::Blur(_, upload) => upload.destroy(host, allocator),
            }
        }
    }
}
