//! What carries a frame's input to the device. Each is waited for before the next.

use gpu_allocator::vulkan::Allocator;

use super::blur::{BlurFrame, FRAMES_BESIDE};
use crate::blur::{self, GroupInput, IntervalInput, PoseInput, TopologyInput, Trajectories};
use crate::data::Particles;
use crate::data::Volume;
use crate::error::Result;
use crate::flame::ParticleInput;
use crate::gpu::transfer::Upload;
use crate::host::{Host, HostBuffer};
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

/// Uploads what blurred frames bring.
#[derive(Debug, Default)]
pub(crate) struct BlurUpload {
    topology: [Upload; 7],
    poses: Upload,
    interval: [Upload; 7],
    /// The frame whose pose stands in each place on the device.
    resident: Vec<Option<u32>>,
    has_mesh: bool,
}

/// What a frame brings, on the device.
#[derive(Debug)]
pub(crate) struct UploadedBlur<'a> {
    pub(crate) mesh: Option<TopologyInput>,
    pub(crate) poses: Option<PoseInput>,
    pub(crate) interval: IntervalInput<'a>,
}

impl BlurUpload {
    /// Uploads what of a frame the effect made for `desc` does not have.
    ///
    /// # Safety
    /// As [`Upload::write`]; and every frame that was written has been recorded.
    pub(crate) unsafe fn write<'a>(
        &mut self,
        host: &Host,
        allocator: &mut Allocator,
        frame: &'a BlurFrame,
        desc: &blur::Desc,
    ) -> Result<UploadedBlur<'a>> {
        let interval = &frame.interval;
        let knots = frame.knots.as_deref().filter(|knots| spans(frame, knots) < desc.frames_resident);
        self.resident.resize(desc.frames_resident as usize, None);
        let missing = self.missing(frame, knots.unwrap_or_default());
        let mut write = |upload: &mut Upload, name, bytes: &[u8]| {
            // SAFETY: the caller's.
            unsafe { upload.write(host, allocator, name, bytes).map(at_least_a_row) }
        };
        let mesh = match self.has_mesh {
            true => None,
            false => {
                let [triangles, starts, items, corners, group_starts, group_triangles, colours] = &mut self.topology;
                let groups = frame.mesh.group_triangles();
                let corner_rows = GroupInput::corner_rows(&frame.mesh);
                let groups = GroupInput {
                    corners: write(corners, "corner upload", bytemuck::cast_slice(&corner_rows))?,
                    starts: write(group_starts, "normal upload", bytemuck::cast_slice(&groups.starts))?,
                    triangles: write(group_triangles, "normal upload", bytemuck::cast_slice(&groups.items))?,
                };
                let rows = TopologyInput::triangle_rows(&frame.mesh);
                let neighbours = frame.mesh.neighbours();
                Some(TopologyInput {
                    triangles: write(triangles, "triangle upload", bytemuck::cast_slice(&rows))?,
                    neighbour_starts: write(starts, "neighbour upload", bytemuck::cast_slice(&neighbours.starts))?,
                    neighbours: write(items, "neighbour upload", bytemuck::cast_slice(&neighbours.items))?,
                    groups: Some(groups),
                    colours: Some(write(colours, "colour upload", bytemuck::cast_slice(&frame.colours))?),
                })
            }
        };
        let poses = match missing {
            Some([first, last]) => {
                let range = (first - frame.first) as usize..=(last - frame.first) as usize;
                let rows: Vec<[f32; 3]> = frame.poses[range].iter().flat_map(|pose| pose.iter().copied()).collect();
                let positions = write(&mut self.poses, "pose upload", bytemuck::cast_slice(&rows))?;
                Some(PoseInput { first, count: last - first + 1, positions })
            }
            None => None,
        };
        let [motion, labels, clusters, hull, seams, fronts, pieces] = &mut self.interval;
        let interval = IntervalInput {
            counts: frame.counts,
            segments: &interval.segments,
            views: frame.views,
            trajectories: match knots {
                Some(knots) => Trajectories::Poses(knots),
                None => {
                    let bytes = bytemuck::cast_slice(&interval.pieces);
                    Trajectories::Pieces(write(pieces, "trajectory upload", bytes)?)
                }
            },
            motion: write(motion, "motion upload", bytemuck::cast_slice(&interval.motion))?,
            labels: write(labels, "label upload", bytemuck::cast_slice(&interval.labels))?,
            clusters: write(clusters, "cluster upload", bytemuck::cast_slice(&interval.clusters))?,
            hull: write(hull, "hull upload", bytemuck::cast_slice(&interval.hull))?,
            seams: write(seams, "seam upload", bytemuck::cast_slice(&interval.seams))?,
            fronts: write(fronts, "front upload", bytemuck::cast_slice(&interval.fronts))?,
        };
        Ok(UploadedBlur { mesh, poses, interval })
    }

    /// The first and the last pose that must be uploaded.
    fn missing(&self, frame: &BlurFrame, knots: &[blur::Knot]) -> Option<[u32; 2]> {
        let needed = needed(frame, knots);
        let missing = needed.filter(|frame| self.resident[*frame as usize % self.resident.len()] != Some(*frame));
        missing.fold(None, |range, frame| match range {
            None => Some([frame, frame]),
            Some([first, last]) => Some([frame.min(first), frame.max(last)]),
        })
    }

    /// Notes that what was written last has been recorded.
    pub(crate) fn recorded(&mut self, mesh: bool, poses: Option<PoseInput>) {
        self.has_mesh |= mesh;
        if let Some(PoseInput { first, count, .. }) = poses {
            let places = self.resident.len();
            (first..first + count).for_each(|frame| self.resident[frame as usize % places] = Some(frame));
        }
    }

    /// Destroys the buffers.
    ///
    /// # Safety
    /// As [`Upload::destroy`].
    pub(crate) unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        let uploads = self.topology.iter_mut().chain(&mut self.interval).chain([&mut self.poses]);
        // SAFETY: the caller's.
        uploads.for_each(|upload| unsafe { upload.destroy(host, allocator) });
    }
}

/// Frames whose poses must be on the device.
fn needed<'a>(frame: &'a BlurFrame, knots: &'a [blur::Knot]) -> impl Iterator<Item = u32> + 'a {
    frame.views.iter().chain(knots.iter().map(|knot| &knot.view)).map(|view| view.frame)
}

/// Frames from the first to the last whose pose must be on the device, less one.
fn spans(frame: &BlurFrame, knots: &[blur::Knot]) -> u32 {
    let (first, last) = needed(frame, knots).fold((u32::MAX, 0), |(a, b), frame| (a.min(frame), b.max(frame)));
    last.saturating_sub(first)
}

/// How many frames' poses of a mesh with so many points are kept on a device: as many of the `wanted` as any window of
/// trajectories has, for no frame looks at more, if these fit into a quarter of its memory and into the largest buffer of
/// `limit` bytes; else as many as do, and at least the few that a frame is drawn from.
pub(crate) fn resident(wanted: u32, points: u32, memory: u64, limit: u64) -> u32 {
    let fits = (memory / 4).min(limit) / (12 * u64::from(points.max(1)));
    let fits = u32::try_from(fits).unwrap_or(u32::MAX);
    let window = 2 * FRAMES_BESIDE + 2;
    window.min(fits).min(wanted).max(4)
}

/// A range that is never empty, which a buffer's must not be; an upload has at least 16 bytes.
fn at_least_a_row(buffer: HostBuffer) -> HostBuffer {
    HostBuffer { size: buffer.size.max(16), ..buffer }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_poses_stay_as_have_room() {
        // A thousand points are 12,000 bytes a frame.
        let kept = |wanted, frames: u64| resident(wanted, 1000, 4 * 12_000 * frames, u64::MAX);
        assert_eq!((kept(48, 48), kept(48, 47), kept(2, 100)), (48, 47, 4));
        assert_eq!((kept(98, 98), kept(1000, 1000), kept(1000, 50), kept(1000, 1)), (98, 98, 50, 4));
        assert_eq!(resident(1000, 1000, u64::MAX, 12_000 * 30), 30);
    }
}
