//! A host of celfx's own: renders the smoke effect's frames into memory, for the program and for tests.
//!
//! One frame at a time: upload, record, submit, wait. After a wait that did not end nothing is reused or destroyed.

use ash::vk;

use crate::error::{Error, Result};
use crate::gpu::headless::Headless;
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::profiler::{Profiler, Timing};
use crate::gpu::transfer::{COPIED_FROM, Copy, Download, Upload, record_picture, record_readback};
use crate::host::{HostImage, ImageState};
use crate::io::volume::Volume;
use crate::plan::BufferId;
use crate::profile::FrameTimes;
use crate::smoke::{Background, Desc, Frame, Sequence, Smoke, VolumeInput};
use crate::view::{Camera, Light};

/// Format of the target.
pub const TARGET_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// One frame, as a shot says it.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// How it follows the frame before.
    pub sequence: Sequence,
    /// Seconds until the next frame.
    pub dt: f32,
    /// What sees it.
    pub camera: Camera,
    /// What lights it.
    pub light: Light,
    /// Its volume; none if it is the last one.
    pub volume: Option<&'a Volume>,
    /// Whether it is rendered, or only moves the particles on.
    pub rendered: bool,
    /// Number of the frame in profiles.
    pub number: u32,
}

/// A device, the effect on it, and what carries volumes to it and pictures back.
pub struct Offline {
    device: Headless,
    parts: Parts,
    size: [u32; 2],
    /// The colour under the smoke; none: the backdrop.
    background: Option<[f32; 4]>,
    /// Buffers that are read back with each rendered frame.
    layers: Vec<BufferId>,
    timed: bool,
    times: Option<FrameTimes>,
    /// Whether what was read back is a whole frame.
    is_read: bool,
}

/// What must be destroyed by hand.
#[derive(Default)]
struct Parts {
    smoke: Option<Smoke>,
    target: Option<Image>,
    backdrop: Option<Image>,
    /// Densities and backdrops: each is waited for before the next.
    upload: Upload,
    velocity: Upload,
    /// The picture, then the layers.
    frame: Download,
    /// Single buffers.
    buffer: Download,
    profiler: Option<Profiler>,
}

impl Offline {
    /// Makes the effect on `device`. `desc.target_format` is [`TARGET_FORMAT`].
    ///
    /// # Errors
    /// As [`Smoke::new`]; the device is lost with it.
    pub fn new(device: Headless, desc: Desc) -> Result<Offline> {
        let mut offline = Offline {
            device,
            parts: Parts::default(),
            size: desc.size,
            background: Some([0.0; 4]),
            layers: Vec::new(),
            timed: true,
            times: None,
            is_read: false,
        };
        offline.create(desc)?;
        Ok(offline)
    }

    fn create(&mut self, desc: Desc) -> Result<()> {
        let queue_family = self.device.queue_family();
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own and outlives what is made here.
        unsafe {
            let smoke = self.parts.smoke.insert(Smoke::new(&host, allocator, desc)?);
            let (steps, _) = smoke.plan_capacity();
            self.parts.profiler = Some(Profiler::new(&host, queue_family, 1, steps as u32)?);
            self.parts.target = Some(Image::new(&host, allocator, &image_desc("target", self.size))?);
        }
        self.make_download()
    }

    /// Room for a frame's picture and layers; now, so that too little memory shows before frames are rendered.
    fn make_download(&mut self) -> Result<()> {
        self.is_read = false;
        let layers: u64 = self.layer_copies().iter().map(|copy| copy.from.2).sum();
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own, and every frame has been waited for.
        unsafe { self.parts.frame.fit(&host, allocator, "frame read back", pixel_bytes(self.size) + layers) }
    }

    /// The colour under the smoke: linear RGBA, premultiplied. Black and transparent at first.
    pub fn set_background(&mut self, colour: [f32; 4]) {
        self.background = Some(colour);
    }

    /// A picture of the target's size under the smoke: linear RGBA, premultiplied, rows from the top.
    ///
    /// # Errors
    /// Another size; no memory; a failed Vulkan call; a device that does not answer.
    pub fn set_backdrop(&mut self, pixels: &[[f32; 4]]) -> Result<()> {
        self.check_free()?;
        let bytes: &[u8] = bytemuck::cast_slice(pixels);
        if bytes.len() as u64 != pixel_bytes(self.size) {
            let why = format!("{} pixels, {:?} expected", pixels.len(), self.size);
            return Err(Error::HostResource { name: "background", why });
        }
        let size = self.size;
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own, and every submission has been waited for.
        let (from, image) = unsafe {
            let image = match self.parts.backdrop.take() {
                Some(image) => image,
                None => Image::new(&host, allocator, &image_desc("backdrop", size))?,
            };
            let image = self.parts.backdrop.insert(image).handle;
            (self.parts.upload.write(&host, allocator, "upload", bytes)?, image)
        };
        self.device.one_time("backdrop", |host, commands| {
            // SAFETY: buffer and image are alive until the wait is over, and nothing else uses them.
            unsafe { record_picture(host, commands, &from, image, size) };
            Ok(())
        })?;
        self.background = None;
        Ok(())
    }

    /// The buffers that each rendered frame reads back with its picture, in its own submission; none at first.
    /// [`Offline::layers`] has what was read.
    ///
    /// # Errors
    /// No memory; a device that does not answer.
    pub fn set_layers(&mut self, ids: &[BufferId]) -> Result<()> {
        self.check_free()?;
        self.layers = ids.to_vec();
        self.make_download()
    }

    /// Whether frames are timed, which costs some time itself; they are at first.
    pub fn set_timed(&mut self, timed: bool) {
        self.timed = timed;
    }

    /// Renders a frame and waits for it.
    ///
    /// # Errors
    /// As [`Smoke::record`]; a lost device; a device that does not answer.
    pub fn frame(&mut self, scene: &Scene) -> Result<()> {
        self.check_free()?;
        self.times = None;
        self.is_read &= !scene.rendered;
        let volume = scene.volume.map(|volume| self.upload(volume)).transpose()?;
        let layers = self.layer_copies();
        let frame = Frame {
            sequence: scene.sequence,
            dt: scene.dt,
            camera: scene.camera,
            light: scene.light,
            volume,
            // The background covers what the frame before left, whose copy has been waited for.
            target: self.image(&self.parts.target, ImageState::default()).filter(|_| scene.rendered),
            depth: None,
            background: match self.image(&self.parts.backdrop, COPIED_FROM).filter(|_| self.background.is_none()) {
                Some(backdrop) => Background::Copy(backdrop),
                None => Background::Clear(self.background.unwrap_or_default()),
            },
        };
        let Parts { smoke: Some(smoke), profiler, frame: download, .. } = &mut self.parts else { return Ok(()) };
        let mut profiler = profiler.as_mut().filter(|_| self.timed);
        self.device.one_time(&format!("frame {}", scene.number), |host, commands| {
            let mut timing = Timing::None;
            // SAFETY: everything is this host's own, in the declared states, and the frame is waited for.
            unsafe {
                if let Some(profiler) = profiler.as_deref_mut() {
                    profiler.begin_frame(host, commands, 0, scene.number)?;
                    timing = Timing::Profiler(profiler);
                }
                smoke.record(host, commands, &frame, &mut timing)?;
                if let (Some(target), Some(download)) = (&frame.target, download.buffer()) {
                    let images = [Copy { from: (target.image, target.extent), to: 0 }];
                    record_readback(host, commands, &images, &layers, download);
                }
            }
            Ok(())
        })?;
        self.is_read |= scene.rendered;
        // SAFETY: the frame has been waited for.
        self.times = profiler.and_then(|profiler| unsafe { profiler.collect(&self.device.host(), 0) });
        Ok(())
    }

    fn upload(&mut self, volume: &Volume) -> Result<VolumeInput> {
        let Parts { smoke, upload, velocity: velocities, .. } = &mut self.parts;
        let wants_velocity = smoke.as_ref().is_some_and(|smoke| smoke.desc().velocity);
        let (host, allocator) = self.device.parts();
        let Volume { dimensions, voxel_size, origin, .. } = *volume;
        let values = volume.velocity.as_deref().filter(|_| wants_velocity);
        // SAFETY: the device is this host's own, and every submission has been waited for.
        let (density, velocity) = unsafe {
            let density = upload.write(&host, allocator, "upload", bytemuck::cast_slice(&volume.density))?;
            let write = |values: &[[f32; 3]]| {
                velocities.write(&host, allocator, "velocity upload", bytemuck::cast_slice(values))
            };
            (density, values.map(write).transpose()?)
        };
        Ok(VolumeInput { dimensions, voxel_size, origin, density, velocity })
    }

    /// The picture of the frame rendered last: linear RGBA, premultiplied, rows from the top. Empty if there is none.
    pub fn picture(&self) -> &[[f32; 4]] {
        let bytes = self.read_range(0, pixel_bytes(self.size));
        bytemuck::try_cast_slice(bytes).unwrap_or_default()
    }

    /// What [`Offline::set_layers`] asked for, in that order, as the frame rendered last left it. Each is empty if there
    /// is none.
    pub fn layers(&self) -> Vec<&[u8]> {
        self.layer_copies().iter().map(|copy| self.read_range(copy.to, copy.from.2)).collect()
    }

    fn read_range(&self, from: u64, size: u64) -> &[u8] {
        let bytes = if self.is_read { self.parts.frame.bytes() } else { &[] };
        bytes.get(from as usize..(from + size) as usize).unwrap_or_default()
    }

    /// Where each layer comes from and goes to: one after the other behind the picture.
    fn layer_copies(&self) -> Vec<Copy<(vk::Buffer, u64, u64)>> {
        let Some(smoke) = &self.parts.smoke else { return Vec::new() };
        let mut end = pixel_bytes(self.size);
        let place = |id: &BufferId| {
            let (from, to) = (smoke.buffer(*id), end);
            end += from.2;
            Copy { from, to }
        };
        self.layers.iter().map(place).collect()
    }

    /// The first `bytes` of a buffer of the effect after the last frame; all of it if it is smaller.
    ///
    /// # Errors
    /// No memory; a failed Vulkan call; a device that does not answer.
    pub fn read(&mut self, id: BufferId, bytes: u64) -> Result<Vec<u8>> {
        self.check_free()?;
        let (source, offset, size) = self.parts.smoke.as_ref().map_or_else(Default::default, |smoke| smoke.buffer(id));
        let size = size.min(bytes);
        if size == 0 {
            return Ok(Vec::new());
        }
        let (host, allocator) = self.device.parts();
        let staging = &mut self.parts.buffer;
        // SAFETY: the device is this host's own, and every submission has been waited for.
        unsafe { staging.fit(&host, allocator, "buffer read back", size)? };
        self.device.one_time("read back", |host, commands| {
            let ranges = [Copy { from: (source, offset, size), to: 0 }];
            if let Some(to) = staging.buffer() {
                // SAFETY: both buffers are alive, and the frame that wrote the source has been waited for.
                unsafe { record_readback(host, commands, &[], &ranges, to) };
            }
            Ok(())
        })?;
        Ok(staging.bytes().get(..size as usize).unwrap_or_default().to_vec())
    }

    /// [`Offline::read`] as values of a plain type.
    ///
    /// # Errors
    /// As [`Offline::read`].
    pub fn read_as<T: bytemuck::AnyBitPattern>(&mut self, id: BufferId, count: usize) -> Result<Vec<T>> {
        let bytes = self.read(id, (count * size_of::<T>()) as u64)?;
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Times of the last frame, once; none where it was not timed or the device has no timestamps.
    pub fn times(&mut self) -> Option<FrameTimes> {
        self.times.take()
    }

    /// The effect; none only if it could not be made.
    pub fn smoke(&mut self) -> Option<&mut Smoke> {
        self.parts.smoke.as_mut()
    }

    /// The device.
    pub fn device(&self) -> &Headless {
        &self.device
    }

    /// Nothing may be reused while it may still be running.
    fn check_free(&self) -> Result<()> {
        let running = || Error::vulkan("vkWaitForFences", "an earlier submission")(vk::Result::TIMEOUT);
        (!self.device.is_stuck()).then_some(()).ok_or_else(running)
    }

    fn image(&self, image: &Option<Image>, state_in: ImageState) -> Option<HostImage> {
        let (extent, state_out) = (self.size, COPIED_FROM);
        let Image { handle, view, .. } = image.as_ref()?;
        Some(HostImage { image: *handle, view: *view, format: TARGET_FORMAT, extent, state_in, state_out })
    }
}

impl Drop for Offline {
    fn drop(&mut self) {
        if self.device.is_stuck() {
            return;
        }
        let Parts { smoke, target, backdrop, upload, velocity, frame, buffer, profiler } = &mut self.parts;
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for, or its device is lost; nothing is used afterwards.
        unsafe {
            smoke.iter_mut().for_each(|smoke| smoke.destroy(&host, allocator));
            target.iter_mut().chain(backdrop).for_each(|image| image.destroy(&host, allocator));
            [upload, velocity].into_iter().for_each(|buffer| buffer.destroy(&host, allocator));
            [frame, buffer].into_iter().for_each(|buffer| buffer.destroy(&host, allocator));
            profiler.iter_mut().for_each(|profiler| profiler.destroy(&host));
        }
    }
}

fn image_desc(name: &'static str, extent: [u32; 2]) -> ImageDesc {
    // A backdrop is only copied, but every image has a view, and a view needs a usage of its own.
    let usage =
        vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
    ImageDesc { name, extent, layers: 1, array_view: false, format: TARGET_FORMAT, usage }
}

fn pixel_bytes(size: [u32; 2]) -> u64 {
    u64::from(size[0]) * u64::from(size[1]) * size_of::<[f32; 4]>() as u64
}
