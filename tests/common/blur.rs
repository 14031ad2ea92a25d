//! The blur effect under validation, and everything that it makes read back.

use ash::vk;
use celfx::blur::settings::Completion;
use celfx::blur::{
    Background, Blur, ClusterInput, Counts, DepthFormat, DepthInput, Desc, Frame, FrameView, GroupInput, Interval,
    IntervalInput, Knot, Mesh, PartInput, Parts, PoseInput, Settings, SkinnedInput, Source, ToonInput, TopologyInput,
    Trajectories,
};
use celfx::effect::Effort;
use celfx::error::Result;
use celfx::host::{HostBuffer, HostImage, ImageState, TemporalImages};
use celfx::low_level::blur::layout;
use celfx::low_level::blur::params::{Control, Piece, Vertex};
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::headless::Submission;
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM, Upload, record_depth, record_picture};
use celfx::low_level::plan::BufferId;
use celfx::offline::TARGET_FORMAT;
use celfx::view::{Light, View};

use super::host::{self, Place};
use super::temporal::{Found, Outputs};
use super::{TestDevice, device};

/// An effect of this picture size for this mesh, with every layer kept.
pub fn desc(size: [u32; 2], mesh: &Mesh, settings: Settings) -> Desc {
    Desc {
        target_format: TARGET_FORMAT,
        outer: true,
        most_triangles: 100_000,
        frames_resident: 30,
        seed: 1,
        layers: true,
        ..Desc::new(mesh, size, settings)
    }
}

/// Settings for tests that do not look at what completion makes, which takes longest by far.
pub fn incomplete() -> Settings {
    Settings { completion: Completion::None, ..Settings::default() }
}

/// What an output is made of.
pub struct Shot<'a> {
    /// Poses of frames that are new, from this number.
    pub poses: Option<(u32, &'a [Vec<[f32; 3]>])>,
    pub interval: Option<&'a Interval>,
    /// Frames i - 1 to i + 2.
    pub views: [FrameView; 4],
    /// The frames that trajectories go through; none: the interval's pieces.
    pub knots: Option<&'a [Knot]>,
}

/// The effect on a device of its own.
pub struct BlurRig {
    device: TestDevice,
    blur: Option<Blur>,
    pub mesh: Mesh,
    /// Of each slot: target, frames i and i + 1, frames i - 1 and i + 2, background.
    images: Vec<Image>,
    uploads: [[Upload; 24]; SLOTS],
    /// What the effect was made for: with them, the device measures what moves.
    pub parts: Option<Parts>,
    /// What the host's skinning has made, and the row of each point in it.
    sources: Vec<Buffer>,
    pub source_rows: Vec<u32>,
    /// A pose in them, for the next output.
    pub skinned: Option<SkinnedInput>,
    /// What the host writes to the start of the first of them, in the command buffer of the next output.
    pub skinning: Vec<f32>,
    /// Which frame in flight is worked on.
    pub slot: usize,
    /// Whether closed objects are said to be.
    pub are_closed: bool,
    is_first: bool,
    /// What frames are drawn with and over, if they are.
    pub toon: Option<(Light, Background)>,
    /// Base colours, one of each vertex; none is white.
    pub colours: Vec<[f32; 3]>,
    /// Rows of textures, if the effect was made for such.
    pub textures: Vec<[u32; 4]>,
    /// Shares of strength, one of each point; none is all of it.
    pub shares: Vec<f32>,
    /// Whether frames i - 1 and i + 2 have images.
    outer: [bool; 2],
    /// The host's depth, if the effect was made for one.
    depth: Option<Image>,
    /// What it holds before a frame.
    pub wall: f32,
    has_backdrop: bool,
    /// How far from the upper left of their images pictures begin.
    corner: [u32; 2],
    /// Depth images of frames i - 1 to i + 2.
    occluders: [Option<Image>; 4],
    /// What scratch memory is filled with before each frame that is waited for, if it is.
    pub poison: Option<u32>,
    /// What outputs say of the view before.
    pub previous: Option<View>,
    /// Images for temporal upscalers, if the effect was made for both, and what the host has in the mask.
    outputs: Option<Outputs>,
    pub share: f32,
}

/// What lies beside pictures in larger images.
pub const BESIDE: [f32; 4] = [0.75, 0.25, 0.5, 0.875];
/// Frames that may be on their way at once.
pub const SLOTS: usize = 2;
/// Images of a slot.
const IMAGES: usize = 6;

/// A channel as 8-bit formats hold it: as it is, or along the curve of sRGB.
fn encode(format: vk::Format, channel: usize, value: f32) -> u8 {
    let curved = if value <= 0.0031308 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
    let value = if format == vk::Format::R8G8B8A8_SRGB && channel < 3 { curved } else { value };
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// What [`encode`] makes a byte from.
fn decode(format: vk::Format, channel: usize, byte: u8) -> f32 {
    let value = f32::from(byte) / 255.0;
    let straight = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    if format == vk::Format::R8G8B8A8_SRGB && channel < 3 { straight } else { value }
}

fn make_images(device: &mut TestDevice, desc: &Desc, corner: [u32; 2]) -> Vec<Image> {
    let extent = Place { size: desc.size, corner }.extent();
    (0..SLOTS * IMAGES).map(|_| host::image(device, extent, desc.target_format)).collect()
}

impl BlurRig {
    /// None where there is no device and tests may do without.
    pub fn new(desc: Desc, mesh: Mesh) -> Option<BlurRig> {
        BlurRig::with_effort(desc, mesh, Effort::Needed)
    }

    pub fn with_effort(desc: Desc, mesh: Mesh, effort: Effort) -> Option<BlurRig> {
        BlurRig::make(desc, mesh, effort, [0; 2])
    }

    /// One whose pictures lie in larger images.
    pub fn in_larger_images(desc: Desc, mesh: Mesh, corner: [u32; 2]) -> Option<BlurRig> {
        BlurRig::make(desc, mesh, Effort::Needed, corner)
    }

    fn make(desc: Desc, mesh: Mesh, effort: Effort, corner: [u32; 2]) -> Option<BlurRig> {
        BlurRig::on(device()?, Vec::new(), desc, mesh, effort, corner)
    }

    /// One that reads positions from buffers that hold these values, each with so many from vertex to vertex.
    pub fn of_sources(desc: Desc, mesh: Mesh, sources: &[(&[f32], u32, u32)]) -> Option<BlurRig> {
        let mut device = device()?;
        let vertices: Vec<u32> = sources.iter().map(|(.., vertices)| *vertices).collect();
        let (source_rows, points) = mesh.source_rows(&vertices).expect("rows");
        let mut buffers: Vec<Buffer> =
            sources.iter().map(|(values, ..)| host::source(&mut device, 4 * values.len() as u64)).collect();
        let described = sources.iter().zip(&mut buffers).zip(points);
        let described = described.map(|((&(values, stride, vertices), buffer), points)| Source {
            buffer: HostBuffer {
                stage: vk::PipelineStageFlags2::ALL_TRANSFER,
                access: vk::AccessFlags2::TRANSFER_WRITE,
                ..host::fill(buffer, values)
            },
            stride,
            vertices,
            points,
        });
        let desc = Desc { sources: described.collect(), ..desc };
        let mut rig = BlurRig::on(device, buffers, desc, mesh, Effort::Needed, [0; 2])?;
        rig.source_rows = source_rows;
        Some(rig)
    }

    fn on(
        mut device: TestDevice,
        sources: Vec<Buffer>,
        desc: Desc,
        mesh: Mesh,
        effort: Effort,
        corner: [u32; 2],
    ) -> Option<BlurRig> {
        let images = make_images(&mut device, &desc, corner);
        let extent = Place { size: desc.size, corner }.extent();
        let depth = desc.depth.map(|DepthFormat { format, .. }| host::image(&mut device, extent, format));
        let place = Place { size: desc.size, corner };
        let outputs = desc.temporal.motion.map(|_| Outputs::new(&mut device, place));
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        let blur =
            unsafe { Blur::with_effort(&host, kernels, allocator, desc, effort).expect("the effect can be made") };
        let mut rig = BlurRig {
            device,
            blur: Some(blur),
            mesh,
            uploads: Default::default(),
            parts: None,
            sources,
            source_rows: Vec::new(),
            skinned: None,
            skinning: Vec::new(),
            images,
            is_first: true,
            toon: None,
            colours: Vec::new(),
            textures: Vec::new(),
            shares: Vec::new(),
            outer: [false; 2],
            depth,
            wall: 0.0,
            previous: None,
            has_backdrop: false,
            slot: 0,
            are_closed: true,
            corner,
            occluders: [const { None }; 4],
            poison: None,
            outputs,
            share: 0.0,
        };
        rig.clear_images();
        Some(rig)
    }

    /// Nothing at all in the images of frames i and i + 1.
    fn clear_images(&mut self) {
        let pixels = (self.desc().size[0] * self.desc().size[1]) as usize;
        for slot in (0..SLOTS).rev() {
            self.slot = slot;
            (0..if self.corner == [0; 2] { 2 } else { 3 })
                .for_each(|i| self.write_image((i + 1) % 3, &vec![[0.0; 4]; pixels]));
        }
    }

    /// Another size of the picture; images are empty again, the mesh and poses are there.
    pub fn resize(&mut self, size: [u32; 2]) {
        let (host, kernels, allocator) = self.device.making();
        // SAFETY: the handles are the device's own, and every submission has been waited for.
        unsafe {
            let blur = self.blur.as_mut().expect("an effect");
            blur.resize(&host, kernels, allocator, size).expect("a size").destroy(&host, allocator);
            self.images.drain(..).for_each(|mut image| image.destroy(&host, allocator));
        }
        let desc = self.desc().clone();
        self.images = make_images(&mut self.device, &desc, self.corner);
        (self.outer, self.has_backdrop) = ([false; 2], false);
        self.clear_images();
    }

    fn place(&self) -> Place {
        Place { size: self.desc().size, corner: self.corner }
    }

    /// An image under everything.
    pub fn set_backdrop(&mut self, pixels: &[[f32; 4]]) {
        self.set_image(4, pixels);
        self.has_backdrop = true;
    }

    pub fn blur(&self) -> &Blur {
        self.blur.as_ref().expect("an effect")
    }

    pub fn desc(&self) -> &Desc {
        self.blur().desc()
    }

    /// The image of frame i - 1 (0) or i + 2 (1).
    pub fn set_outer(&mut self, side: usize, pixels: &[[f32; 4]]) {
        self.set_image(2 + side, pixels);
        self.outer[side] = true;
    }

    /// The image of frame i (0) or i + 1 (1).
    pub fn set_image(&mut self, frame: usize, pixels: &[[f32; 4]]) {
        self.write_image(1 + frame, pixels);
    }

    fn write_image(&mut self, image: usize, pixels: &[[f32; 4]]) {
        let (place, format) = (self.place(), self.desc().target_format);
        let (size, pixels) = (place.extent(), &place.around(pixels, BESIDE)[..]);
        let bytes: Vec<u8> = match format == TARGET_FORMAT {
            true => bytemuck::cast_slice(pixels).to_vec(),
            false => pixels.iter().flat_map(|pixel| [0, 1, 2, 3].map(|c| encode(format, c, pixel[c]))).collect(),
        };
        let (host, allocator) = self.device.parts();
        // SAFETY: the handles are the device's own, and every submission has been waited for.
        let from = unsafe { self.uploads[0][0].write(&host, allocator, "test", &bytes) };
        let (from, image) = (from.expect("an upload"), self.images[IMAGES * self.slot + image].handle);
        host::run(&mut self.device, |host, commands| {
            // SAFETY: as above.
            unsafe { record_picture(host, commands, &from, image, size) };
        });
    }

    fn upload<T: bytemuck::NoUninit>(&mut self, place: usize, values: &[T]) -> HostBuffer {
        let (host, allocator) = self.device.parts();
        // SAFETY: the handles are the device's own, and every submission has been waited for.
        let upload = &mut self.uploads[self.slot][place];
        let buffer = unsafe { upload.write(&host, allocator, "test", bytemuck::cast_slice(values)) };
        let buffer = buffer.expect("an upload");
        HostBuffer { size: buffer.size.max(16), ..buffer }
    }

    fn host_image(&self, place: usize, state_in: ImageState) -> HostImage {
        let image = &self.images[IMAGES * self.slot + place];
        self.place().given(image, self.desc().target_format, state_in, COPIED_FROM)
    }

    fn host_occluders(&self) -> [Option<HostImage>; 4] {
        let format = self.desc().occluders.map(|occluders| occluders.format);
        let given = |image: &Image| self.place().given(image, format.unwrap_or_default(), COPIED_FROM, COPIED_FROM);
        self.occluders.each_ref().map(|image| image.as_ref().map(given))
    }

    fn host_depth(&self, view: FrameView) -> Option<DepthInput> {
        let format = self.desc().depth?.format;
        let image = self.place().given(self.depth.as_ref()?, format, CLEARED, COPIED_FROM);
        Some(DepthInput { host: image, view })
    }

    /// The depth image of frame i - 1 (0) to i + 2 (3), as its format holds it.
    pub fn set_occluders(&mut self, frame: usize, depths: &[f32]) {
        let (place, format) = (self.place(), self.desc().occluders.expect("occluders").format);
        let depths = place.around(depths, 1.0);
        let image = match self.occluders[frame].take() {
            Some(image) => image,
            None => host::image(&mut self.device, place.extent(), format),
        };
        let (host, allocator) = self.device.parts();
        // SAFETY: the handles are the device's own, and every submission has been waited for.
        let from = unsafe { self.uploads[0][0].write(&host, allocator, "test", bytemuck::cast_slice(&depths)) };
        let from = from.expect("an upload");
        host::run(&mut self.device, |host, commands| {
            // SAFETY: as above.
            unsafe {
                let whole = (image.handle, image.aspect);
                host::change(host, commands, whole, host::DISCARDED, CLEARED);
                let regions = [host::image_copy(image.aspect, place.extent()).buffer_offset(from.offset)];
                let to = image.handle;
                host.device.cmd_copy_buffer_to_image(commands, from.buffer, to, CLEARED.layout, &regions);
                host::change(host, commands, whole, CLEARED, COPIED_FROM);
            }
        });
        self.occluders[frame] = Some(image);
    }

    /// What lies beside the picture in the target, and beside the host's depth.
    pub fn beside(&mut self) -> (Vec<[f32; 4]>, Vec<f32>) {
        let (place, target) = (self.place(), &self.images[IMAGES * self.slot]);
        let colours = host::read_image(&mut self.device, target, place.extent());
        let depth = self.depth.as_ref().expect("a depth");
        (place.parts(&colours).1, place.parts(&host::read_image(&mut self.device, depth, place.extent())).1)
    }

    /// What the last frame left in the host's depth.
    pub fn host_depths(&mut self) -> Vec<f32> {
        let place = self.place();
        place.parts(&host::read_image(&mut self.device, self.depth.as_ref().expect("a depth"), place.extent())).0
    }

    /// Makes an output.
    pub fn frame(&mut self, shot: &Shot) -> Result<()> {
        if let Some(word) = self.poison {
            let scratch = self.blur().scratch();
            host::poison(&mut self.device, scratch, word);
        }
        let frame = self.describe(shot);
        let (depth, wall) = (self.depth.as_ref().map(|image| image.handle), self.wall);
        let skinning = std::mem::take(&mut self.skinning);
        let source = self.sources.first().map(|source| source.handle).filter(|_| !skinning.is_empty());
        let (outputs, share) = (&self.outputs, self.share);
        let blur = self.blur.as_mut().expect("an effect");
        let done = self.device.one_time("frame", |host, commands| {
            // SAFETY: as below; earlier frames have been waited for.
            source.iter().for_each(|source| unsafe {
                host.device.cmd_update_buffer(commands, *source, 0, bytemuck::cast_slice(&skinning));
            });
            // SAFETY: everything is the test's own, in the declared states, and the frame is waited for.
            depth.iter().for_each(|image| unsafe { record_depth(host, commands, *image, wall) });
            // SAFETY: as above.
            outputs.iter().for_each(|outputs| unsafe { outputs.clear(host, commands, share) });
            // SAFETY: as above.
            unsafe { blur.record(host, commands, &frame, &mut Timing::None) }
        });
        self.is_first &= done.is_err();
        done
    }

    /// Begins an output with what belongs to the slot, which nothing else on its way uses.
    pub fn start(&mut self, shot: &Shot) -> Submission {
        let frame = self.describe(shot);
        let commands = self.device.begin().expect("commands");
        let blur = self.blur.as_mut().expect("an effect");
        // SAFETY: as in `frame`; frames are submitted in order to one queue.
        unsafe { blur.record(&self.device.host(), commands.raw(), &frame, &mut Timing::None).expect("a frame") };
        self.is_first = false;
        self.device.start(commands, "frame").expect("it starts")
    }

    pub fn wait(&mut self, submission: Submission) {
        self.device.wait(submission).expect("it ends");
    }

    fn describe<'a>(&mut self, shot: &'a Shot) -> Frame<'a> {
        let rows = TopologyInput::triangle_rows(&self.mesh);
        let (starts, items) = (self.mesh.neighbours().starts.clone(), self.mesh.neighbours().items.clone());
        let colours = TopologyInput::colour_rows(&self.mesh, &self.colours);
        let corners = GroupInput::corner_rows(&self.mesh);
        let groups = self.mesh.group_triangles();
        let (group_starts, group_items) = (groups.starts.clone(), groups.items.clone());
        let mesh = self.is_first.then(|| TopologyInput {
            triangles: self.upload(1, &rows),
            neighbour_starts: self.upload(2, &starts),
            neighbours: self.upload(3, &items),
            groups: Some(GroupInput {
                corners: self.upload(11, &corners),
                starts: self.upload(12, &group_starts),
                triangles: self.upload(13, &group_items),
            }),
            colours: Some(self.upload(14, &colours)),
            textures: {
                let rows = self.textures.clone();
                (!rows.is_empty()).then(|| self.upload(23, &rows))
            },
            shares: {
                let shares = self.shares.clone();
                (!shares.is_empty()).then(|| self.upload(22, &shares))
            },
            parts: self.parts.clone().map(|parts| PartInput {
                labels: self.upload(16, parts.labels()),
                members: self.upload(17, parts.members()),
                chunks: self.upload(18, parts.chunks()),
                rows: self.upload(19, parts.rows()),
                seams: self.upload(20, parts.seams()),
            }),
            source_rows: {
                let rows = self.source_rows.clone();
                (!rows.is_empty()).then(|| self.upload(21, &rows))
            },
            sizes: None,
        });
        let poses = shot.poses.map(|(first, poses)| {
            let positions = self.upload(4, &poses.concat());
            PoseInput { first, count: poses.len() as u32, positions }
        });
        let interval = shot.interval.map(|interval| {
            let pieces = self.upload(10, &interval.pieces);
            let fronts = if self.are_closed { interval.fronts.clone() } else { vec![0; interval.fronts.len()] };
            IntervalInput {
                counts: match &self.parts {
                    Some(parts) => Counts::of_parts(&parts.sizes(), interval.generation),
                    None => Counts::of(interval, self.mesh.neighbours()),
                },
                segments: &interval.segments,
                views: shot.views,
                trajectories: shot.knots.map_or(Trajectories::Pieces(pieces), Trajectories::Poses),
                clusters: self.parts.is_none().then(|| ClusterInput {
                    motion: self.upload(5, &interval.motion),
                    labels: self.upload(6, &interval.labels),
                    clusters: self.upload(7, &interval.clusters),
                    bounds: self.upload(8, &interval.bounds),
                    seams: self.upload(9, &interval.seams),
                    fronts: self.upload(15, &fronts),
                }),
            }
        });
        Frame {
            mesh,
            poses,
            skinned: self.skinned.take(),
            interval,
            images: self.toon.is_none().then(|| [1, 2].map(|place| self.host_image(place, COPIED_FROM))),
            toon: self.toon.map(|(light, _)| ToonInput { view: shot.views[2], light }),
            outer: [0, 1].map(|i| self.outer[i].then(|| self.host_image(3 + i, COPIED_FROM))),
            occluders: self.host_occluders(),
            depth: self.host_depth(shot.views[2]),
            // What lies beside the picture stays.
            target: self.host_image(0, if self.corner == [0; 2] { ImageState::default() } else { COPIED_FROM }),
            background: match self.has_backdrop {
                true => Background::Copy(self.host_image(5, COPIED_FROM)),
                false => self.toon.map_or(Background::Keep, |(_, background)| background),
            },
            temporal: TemporalImages {
                previous: self.previous,
                ..self.outputs.as_ref().map(Outputs::given).unwrap_or_default()
            },
        }
    }

    /// Motion vectors and mask of the last frame.
    pub fn found(&mut self) -> Found {
        self.outputs.as_ref().expect("outputs").found(&mut self.device, self.share)
    }

    /// Values of one of the effect's buffers.
    pub fn read<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Vec<T> {
        let range = self.blur().buffer(id);
        host::read(&mut self.device, range, count)
    }

    /// The picture.
    pub fn picture(&mut self) -> Vec<[f32; 4]> {
        let (place, format) = (self.place(), self.desc().target_format);
        let target = &self.images[IMAGES * self.slot];
        if format == TARGET_FORMAT {
            return place.parts(&host::read_image(&mut self.device, target, place.extent())).0;
        }
        let rows: Vec<[u8; 4]> = host::read_image(&mut self.device, target, place.extent());
        let (rows, _) = place.parts(&rows);
        rows.iter().map(|row| [0, 1, 2, 3].map(|c| decode(format, c, row[c]))).collect()
    }

    pub fn control(&mut self) -> Control {
        self.read::<Control>(layout::CONTROL, 1)[0]
    }

    /// The refined triangles: vertices, and the base triangle's word.
    pub fn finished(&mut self) -> Vec<[u32; 4]> {
        let count = self.control().triangles;
        self.read(layout::FINISHED, count as usize)
    }

    /// The mesh's points, and the vertices of the refinement after them.
    pub fn vertices(&mut self) -> Vec<Vertex> {
        let count = self.control().vertices;
        self.read(layout::VERTICES, count as usize)
    }

    /// Pieces of a segment of the mesh's points.
    pub fn pieces(&mut self, segment: usize) -> Vec<Piece> {
        let (points, segments) = (self.desc().points as usize, self.desc().segments as usize);
        let room = self.blur().buffer(layout::SPLINES).2 as usize / (segments * size_of::<Piece>());
        self.read(layout::SPLINES, segment * room + points).split_off(segment * room)
    }

    /// A layer of one value a pixel.
    pub fn layer<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId) -> Vec<T> {
        let [width, height] = self.desc().size;
        self.read(id, (width * height) as usize)
    }

    /// Names of the steps that ran, each once where it stands several times in a row.
    pub fn steps(&self) -> Vec<&'static str> {
        let blur = self.blur();
        let name = |step: &celfx::low_level::plan::Step| blur.passes()[usize::from(step.pass.0)].name;
        let mut names: Vec<_> = blur.plan().steps.iter().map(name).collect();
        names.dedup();
        names
    }
}

impl Drop for BlurRig {
    fn drop(&mut self) {
        if self.device.is_stuck() {
            return;
        }
        self.outputs.take().into_iter().for_each(|outputs| outputs.destroy(&mut self.device));
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for; nothing is used afterwards.
        unsafe {
            self.blur.iter_mut().for_each(|blur| blur.destroy(&host, allocator));
            self.uploads.iter_mut().flatten().for_each(|upload| upload.destroy(&host, allocator));
            self.sources.iter_mut().for_each(|source| source.destroy(&host, allocator));
            let occluders = self.occluders.iter_mut().flatten();
            self.images
                .iter_mut()
                .chain(&mut self.depth)
                .chain(occluders)
                .for_each(|image| image.destroy(&host, allocator));
        }
    }
}
