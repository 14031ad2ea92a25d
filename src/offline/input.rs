//! What carries a frame's input to the device. Each is waited for before the next.

use gpu_allocator::vulkan::Allocator;

use crate::error::Result;
use crate::flame::ParticleInput;
use crate::gpu::transfer::Upload;
use crate::host::{Host, HostBuffer};
use crate::io::particles::Particles;
use crate::io::volume::Volume;
use crate::smoke::VolumeInput;

/// Uploads volumes.
#[derive(Debug, Default)]
pub(crate) struct VolumeUpload {
    density: Upload,
    velocity: Upload,
}

impl VolumeUpload {
    /// Uploads a volume, with its velocity if that is `wanted`.
    ///
    /// # Safety
    /// As [`Upload::write`].
    pub(crate) unsafe fn write(
        &mut self,
        host: &Host,
        allocator: &mut Allocator,
        volume: &Volume,
        wanted: bool,
    ) -> Result<VolumeInput> {
        let Volume { dimensions, voxel_size, origin, .. } = *volume;
        let values = volume.velocity.as_deref().filter(|_| wanted);
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

    /// Destroys the buffers.
    ///
    /// # Safety
    /// As [`Upload::destroy`].
    pub(crate) unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        [&mut self.density, &mut self.velocity]
            .into_iter()
            .for_each(|upload| unsafe { upload.destroy(host, allocator) });
    }
}

/// Uploads particles.
#[derive(Debug, Default)]
pub(crate) struct ParticleUpload {
    rows: Upload,
    ids: Upload,
}

impl ParticleUpload {
    /// Uploads particles: positions with temperatures, and their ids if they have any.
    ///
    /// # Safety
    /// As [`Upload::write`].
    pub(crate) unsafe fn write(
        &mut self,
        host: &Host,
        allocator: &mut Allocator,
        particles: &Particles,
    ) -> Result<ParticleInput> {
        let Particles { position, temperature, id } = particles;
        let rows = position.iter().zip(temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]);
        let rows: Vec<[f32; 4]> = rows.collect();
        // SAFETY: the caller's.
        let (position_temperature, ids) = unsafe {
            let bytes = bytemuck::cast_slice(&rows);
            let uploaded = self.rows.write(host, allocator, "particle upload", bytes)?;
            let write = |ids: &[u32]| self.ids.write(host, allocator, "id upload", bytemuck::cast_slice(ids));
            (uploaded, id.as_deref().map(write).transpose()?)
        };
        Ok(ParticleInput {
            count: rows.len() as u32,
            hottest: rows.iter().map(|row| row[3]).fold(0.0, f32::max),
            position_temperature: at_least_a_row(position_temperature),
            ids: ids.map(at_least_a_row),
        })
    }

    /// Destroys the buffers.
    ///
    /// # Safety
    /// As [`Upload::destroy`].
    pub(crate) unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        [&mut self.rows, &mut self.ids].into_iter().for_each(|upload| unsafe { upload.destroy(host, allocator) });
    }
}

/// A range that is never empty, which a buffer's must not be; an upload has at least 16 bytes.
fn at_least_a_row(buffer: HostBuffer) -> HostBuffer {
    HostBuffer { size: buffer.size.max(16), ..buffer }
}
