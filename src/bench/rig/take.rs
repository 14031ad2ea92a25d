//! The blur effect's input: one output of a mesh that moves, which is made again and again.

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use super::FORMAT;
use super::effect::{Input, Made};
use crate::blur::motion::Segment;
use crate::blur::{
    Background, Blur, Counts, Desc, Frame, GroupInput, Interval, IntervalInput, Knot, Mesh, PoseInput, TopologyInput,
    Trajectories, View,
};
use crate::error::Result;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::profiler::Timing;
use crate::gpu::transfer::{COPIED_FROM, Upload, record_picture};
use crate::host::{Host, HostBuffer, HostImage};

/// What an output is made of.
pub(in crate::bench) struct Take<'a> {
    pub(in crate::bench) mesh: &'a Mesh,
    /// Number of the first pose's frame.
    pub(in crate::bench) first: u32,
    pub(in crate::bench) poses: &'a [Vec<[f32; 3]>],
    pub(in crate::bench) interval: &'a Interval,
    /// Frames i - 1 to i + 2.
    pub(in crate::bench) views: [View; 4],
    /// The frames that trajectories go through; none: they are the interval's.
    pub(in crate::bench) knots: Option<&'a [Knot]>,
    /// Of frames i and i + 1; none: they are empty.
    pub(in crate::bench) images: Option<&'a [Vec<[f32; 4]>; 2]>,
}

/// Buffers and images of a [`Take`], and what a frame says of them.
pub(in crate::bench) struct TakeUpload {
    uploads: [Upload; BUFFERS],
    buffers: Vec<HostBuffer>,
    images: Vec<Image>,
    size: [u32; 2],
    /// Number of the first, and their number.
    poses: [u32; 2],
    counts: Counts,
    segments: Vec<Segment>,
    views: [View; 4],
    knots: Option<Vec<Knot>>,
    is_first: bool,
}

const TRIANGLES: usize = 0;
const NEIGHBOUR_STARTS: usize = 1;
const NEIGHBOURS: usize = 2;
const POSES: usize = 3;
const MOTION: usize = 4;
const LABELS: usize = 5;
const CLUSTERS: usize = 6;
const HULL: usize = 7;
const SEAMS: usize = 8;
const FRONTS: usize = 9;
const PIECES: usize = 10;
const PICTURES: [usize; 2] = [11, 12];
const CORNERS: usize = 13;
const GROUP_STARTS: usize = 14;
const GROUP_TRIANGLES: usize = 15;
const BUFFERS: usize = 16;

impl Input for Take<'_> {
    type Desc = Desc;

    fn size(desc: &Desc) -> [u32; 2] {
        desc.size
    }

    unsafe fn make(&self, host: &Host, allocator: &mut Allocator, desc: Desc) -> Result<Made> {
        let mut upload = TakeUpload {
            uploads: Default::default(),
            buffers: Vec::new(),
            images: Vec::new(),
            size: desc.size,
            poses: [self.first, self.poses.len() as u32],
            counts: Counts::of(self.interval, self.mesh.neighbours()),
            segments: self.interval.segments.clone(),
            views: self.views,
            knots: self.knots.map(<[Knot]>::to_vec),
            is_first: true,
        };
        // SAFETY: the caller's.
        unsafe {
            let blur = upload.fill(host, allocator, self).and_then(|()| Blur::new(host, allocator, desc));
            match blur {
                Ok(blur) => Ok(Made::Blur(Box::new(blur), Box::new(upload))),
                Err(error) => {
                    upload.destroy(host, allocator);
                    Err(error)
                }
            }
        }
    }
}

impl TakeUpload {
    /// # Safety
    /// As [`Upload::write`].
    unsafe fn fill(&mut self, host: &Host, allocator: &mut Allocator, take: &Take) -> Result<()> {
        let (rows, poses) = (TopologyInput::triangle_rows(take.mesh), take.poses.concat());
        let (corners, groups) = (GroupInput::corner_rows(take.mesh), take.mesh.group_triangles());
        let (neighbours, interval) = (take.mesh.neighbours(), take.interval);
        let empty = vec![[0.0_f32; 4]; self.size[0] as usize * self.size[1] as usize];
        let picture = |frame: usize| take.images.map_or(&empty, |images| &images[frame]);
        let pieces = if take.knots.is_none() { interval.pieces.as_slice() } else { &[] };
        let contents: [&[u8]; BUFFERS] = [
            bytemuck::cast_slice(&rows),
            bytemuck::cast_slice(&neighbours.starts),
            bytemuck::cast_slice(&neighbours.items),
            bytemuck::cast_slice(&poses),
            bytemuck::cast_slice(&interval.motion),
            bytemuck::cast_slice(&interval.labels),
            bytemuck::cast_slice(&interval.clusters),
            bytemuck::cast_slice(&interval.hull),
            bytemuck::cast_slice(&interval.seams),
            bytemuck::cast_slice(&interval.fronts),
            bytemuck::cast_slice(pieces),
            bytemuck::cast_slice(picture(0)),
            bytemuck::cast_slice(picture(1)),
            bytemuck::cast_slice(&corners),
            bytemuck::cast_slice(&groups.starts),
            bytemuck::cast_slice(&groups.items),
        ];
        for (upload, bytes) in self.uploads.iter_mut().zip(contents) {
            let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
            // SAFETY: the caller's.
            self.buffers.push(unsafe { upload.write(host, allocator, "take", bytes)? });
        }
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        let image = ImageDesc { name: "frame", extent: self.size, layers: 1, array_view: false, format: FORMAT, usage };
        for _ in 0..2 {
            // SAFETY: the caller's.
            self.images.push(unsafe { Image::new(host, allocator, &image)? });
        }
        Ok(())
    }

    /// Records the output; the first time with all that is uploaded.
    ///
    /// # Safety
    /// As [`Blur::record`].
    pub(super) unsafe fn record(
        &mut self,
        host: &Host,
        commands: vk::CommandBuffer,
        blur: &mut Blur,
        target: HostImage,
        background: Background,
    ) -> Result<()> {
        let buffer = |place: usize| self.buffers[place];
        if self.is_first {
            for (image, from) in self.images.iter().zip(PICTURES) {
                // SAFETY: the caller's.
                unsafe { record_picture(host, commands, &buffer(from), image.handle, self.size) };
            }
        }
        let image = |image: &Image| HostImage {
            image: image.handle,
            view: image.view,
            format: FORMAT,
            extent: self.size,
            state_in: COPIED_FROM,
            state_out: COPIED_FROM,
        };
        let trajectories = match &self.knots {
            Some(knots) => Trajectories::Poses(knots),
            None => Trajectories::Pieces(buffer(PIECES)),
        };
        let frame = Frame {
            mesh: self.is_first.then(|| TopologyInput {
                triangles: buffer(TRIANGLES),
                neighbour_starts: buffer(NEIGHBOUR_STARTS),
                neighbours: buffer(NEIGHBOURS),
                groups: Some(GroupInput {
                    corners: buffer(CORNERS),
                    starts: buffer(GROUP_STARTS),
                    triangles: buffer(GROUP_TRIANGLES),
                }),
                colours: None,
            }),
            poses: self.is_first.then(|| PoseInput {
                first: self.poses[0],
                count: self.poses[1],
                positions: buffer(POSES),
            }),
            interval: Some(IntervalInput {
                counts: self.counts,
                segments: &self.segments,
                views: self.views,
                trajectories,
                motion: buffer(MOTION),
                labels: buffer(LABELS),
                clusters: buffer(CLUSTERS),
                hull: buffer(HULL),
                seams: buffer(SEAMS),
                fronts: buffer(FRONTS),
            }),
            images: Some([image(&self.images[0]), image(&self.images[1])]),
            toon: None,
            outer: [None; 2],
            depth: None,
            target,
            background,
        };
        // SAFETY: the caller's.
        unsafe { blur.record(host, commands, &frame, &mut Timing::None)? };
        self.is_first = false;
        Ok(())
    }

    /// Destroys all of it.
    ///
    /// # Safety
    /// As [`Upload::destroy`].
    pub(super) unsafe fn destroy(&mut self, host: &Host, allocator: &mut Allocator) {
        // SAFETY: the caller's.
        unsafe {
            self.uploads.iter_mut().for_each(|upload| upload.destroy(host, allocator));
            self.images.iter_mut().for_each(|image| image.destroy(host, allocator));
        }
    }
}
