//! How a scene becomes a frame of fire.

use crate::data::Particles;
use crate::error::Result;
use crate::flame::{Desc, Flame, FlameKind, Frame, ParticleInput, SceneDepth, SceneFormat};
use crate::gpu::headless::Headless;
use crate::gpu::transfer::{Upload, at_least_a_row};
use crate::host::{Host, HostBuffer, MemorySource};
use crate::offline::{Depth, Describe, Feed, Place, Scene, Sharing};

impl Describe for Desc {
    type Feed = FlameFeed;
    const DEPTH: Depth = Depth::Hidden;

    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn share(&mut self, Sharing { image, buffer, vectors }: Sharing) {
        self.temporal.motion = vectors;
        match (image, buffer) {
            (Some(format), _) => self.scene = Some(SceneFormat::Image(format)),
            (None, true) => self.scene = Some(SceneFormat::Buffer),
            (None, false) => {}
        }
    }
}

/// Uploads particles, and the depth of a scene.
#[derive(Debug, Default)]
pub struct FlameFeed {
    rows: Upload,
    earlier: Upload,
    ids: Upload,
    velocities: Upload,
    depths: Upload,
    /// Those of the scene uploaded last.
    particles: Option<ParticleInput>,
    depth: Option<HostBuffer>,
}

impl Feed for FlameFeed {
    type Kind = FlameKind;

    fn upload(&mut self, flame: &Flame, device: &mut Headless, scene: &Scene, place: &Place) -> Result<()> {
        let (host, allocator) = device.parts();
        // With smoke it is the smoke that hides the fire.
        let depth = scene.depth.filter(|_| place.left.depth.is_none());
        // SAFETY: the device's own handles, and every submission has been waited for.
        unsafe {
            let dt = flame.desc().temporal.motion.map(|_| scene.dt);
            self.particles = scene.particles.map(|given| self.write(&host, allocator, given, dt)).transpose()?;
            let write = |depth| self.depths.write(&host, allocator, "upload", bytemuck::cast_slice(depth));
            self.depth = depth.map(write).transpose()?;
        }
        Ok(())
    }

    fn frame<'a>(&'a self, flame: &Flame, scene: &Scene<'a>, place: &Place) -> Option<Frame> {
        Some(Frame {
            view: scene.seen(flame.desc().size),
            particles: self.particles,
            spread: scene.spread,
            number: scene.drawing.unwrap_or(scene.number),
            accumulate: scene.accumulate,
            target: place.target?,
            background: place.background,
            scene: match place.depth {
                Some(depth) => Some(SceneDepth::Image(depth)),
                None => place.left.depth.or(self.depth).map(SceneDepth::Buffer),
            },
            temporal: place.temporal(scene),
        })
    }

    fn check(flame: &Flame, frame: &Frame) -> Result<()> {
        frame.validate(flame.desc(), false)
    }

    unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        // SAFETY: the caller's.
        [&mut self.rows, &mut self.earlier, &mut self.ids, &mut self.velocities, &mut self.depths]
            .into_iter()
            .for_each(|upload| unsafe { upload.destroy(host, allocator) });
    }
}

impl FlameFeed {
    /// Uploads particles: positions with temperatures, and their ids if they have any; for motion vectors, as far as they have
    /// velocities, where they were so many seconds before.
    ///
    /// # Safety
    /// As [`Upload::write`].
    unsafe fn write(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        particles: &Particles,
        dt: Option<f32>,
    ) -> Result<ParticleInput> {
        let Particles { position, temperature, id, velocity } = particles;
        let rows = position.iter().zip(temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]);
        let rows: Vec<[f32; 4]> = rows.collect();
        // SAFETY: the caller's.
        let (position_temperature, previous, ids, velocity) = unsafe {
            let bytes = bytemuck::cast_slice(&rows);
            let uploaded = self.rows.write(host, allocator, "particle upload", bytes)?;
            let earlier = dt.zip(velocity.as_ref()).map(|(dt, velocity)| {
                let back =
                    |([x, y, z, t], v): (&[f32; 4], &[f32; 3])| [x - dt * v[0], y - dt * v[1], z - dt * v[2], *t];
                let rows: Vec<[f32; 4]> = rows.iter().zip(velocity).map(back).collect();
                self.earlier.write(host, allocator, "earlier particle upload", bytemuck::cast_slice(&rows))
            });
            let write = |ids: &[u32]| self.ids.write(host, allocator, "id upload", bytemuck::cast_slice(ids));
            let ids = id.as_deref().map(write).transpose()?;
            let velocity = velocity.as_ref().map(|velocity| {
                let rows: Vec<[f32; 4]> = velocity.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
                self.velocities.write(host, allocator, "velocity upload", bytemuck::cast_slice(&rows))
            });
            (uploaded, earlier.transpose()?, ids, velocity.transpose()?)
        };
        Ok(ParticleInput {
            count: rows.len() as u32,
            hottest: rows.iter().map(|row| row[3]).fold(0.0, f32::max),
            position_temperature: at_least_a_row(position_temperature),
            ids: ids.map(at_least_a_row),
            previous: previous.map(at_least_a_row),
            velocity: velocity.map(at_least_a_row),
        })
    }
}
