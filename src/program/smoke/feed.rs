//! How a scene becomes a frame of smoke.

use crate::data::Volume;
use crate::error::Result;
use crate::gpu::headless::Headless;
use crate::gpu::transfer::Upload;
use crate::host::{Host, MemorySource};
use crate::offline::{Depth, Describe, Feed, Left, Place, Scene, Sharing};
use crate::smoke::{Desc, Frame, Smoke, SmokeKind, VolumeInput};

impl Describe for Desc {
    type Feed = SmokeFeed;
    const DEPTH: Depth = Depth::Leaves;

    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn share(&mut self, Sharing { image, vectors, .. }: Sharing) {
        self.temporal.motion = vectors;
        if image.is_some() {
            (self.depth, self.edges) = (image, true);
        }
    }
}

/// Uploads volumes.
#[derive(Debug, Default)]
pub struct SmokeFeed {
    density: Upload,
    velocity: Upload,
    /// That of the scene uploaded last.
    volume: Option<VolumeInput>,
}

impl Feed for SmokeFeed {
    type Kind = SmokeKind;
    const MOVES: bool = true;

    fn upload(&mut self, smoke: &Smoke, device: &mut Headless, scene: &Scene, _: &Place) -> Result<()> {
        let (host, allocator) = device.parts();
        let wants_velocity = smoke.desc().velocity;
        // SAFETY: the device's own handles, and every submission has been waited for.
        let write = |volume| unsafe { self.write(&host, allocator, volume, wants_velocity) };
        self.volume = scene.volume.map(write).transpose()?;
        Ok(())
    }

    fn frame<'a>(&'a self, smoke: &Smoke, scene: &Scene<'a>, place: &Place) -> Option<Frame> {
        Some(Frame {
            sequence: scene.sequence,
            dt: scene.dt,
            view: scene.seen(smoke.desc().size),
            light: scene.light,
            fire: scene.fire.filter(|_| smoke.desc().fire_light),
            volume: self.volume,
            target: place.target,
            depth: place.target.and(place.depth),
            edges: place.target.and(place.left.edges),
            background: place.background,
            temporal: place.temporal(scene),
        })
    }

    fn leave(smoke: &Smoke, left: &mut Left) {
        left.depth = Some(smoke.depth());
    }

    unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        [&mut self.density, &mut self.velocity]
            .into_iter()
            .for_each(|upload| unsafe { upload.destroy(host, allocator) });
    }
}

impl SmokeFeed {
    /// Uploads a volume, with its velocity if that is `wanted`.
    ///
    /// # Safety
    /// As [`Upload::write`].
    unsafe fn write(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        volume: &Volume,
        wanted: bool,
    ) -> Result<VolumeInput> {
        let Volume { dimensions, voxel_size, origin, .. } = *volume;
        // A frame without velocities, among others that have some, is still.
        let still = (wanted && volume.velocity.is_none()).then(|| vec![[0.0; 3]; volume.density.len()]);
        let values = volume.velocity.as_deref().or(still.as_deref()).filter(|_| wanted);
        // SAFETY: the caller's.
        let (density, velocity) = unsafe {
            let density = bytemuck::cast_slice(&volume.density);
            let density = self.density.write(host, allocator, "density upload", density)?;
            let write = |values: &[[f32; 3]]| {
                self.velocity.write(host, allocator, "velocity upload", bytemuck::cast_slice(values))
            };
            (density, values.map(write).transpose()?)
        };
        Ok(VolumeInput { dimensions, voxel_size, origin, density, velocity })
    }
}
