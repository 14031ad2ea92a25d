//! The Vulkan side of `celfx render`: one device, one target, one frame at a time.

use ash::vk;
use bytemuck::cast_slice;

use super::layers;
use super::outputs::Frame as Finished;
use crate::cli::{Common, Failure};
use crate::error::{Error, Result};
use crate::gpu::buffer::Buffer;
use crate::gpu::headless::{Headless, Messages, Options};
use crate::gpu::image::{Image, ImageDesc};
use crate::gpu::profiler::{Profiler, Timing};
use crate::gpu::transfer::{COPIED_FROM, Copy, Upload, readback, record_picture, record_readback};
use crate::host::{HostImage, ImageState};
use crate::io::image::Picture;
use crate::io::shot::{Background as ShotBackground, Shot};
use crate::io::volume::{Extent, Volume};
use crate::profile::FrameTimes;
use crate::smoke::{Background, Desc, Frame, Sequence, Smoke, VolumeInput};
use crate::view::LightSource;

const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
const PIXEL_BYTES: u64 = 16;

/// Renders the frames of one shot, in order.
pub(super) struct Renderer {
    headless: Headless,
    smoke: Option<Smoke>,
    target: Option<Image>,
    background_image: Option<Image>,
    background: Background,
    density: Upload,
    velocity: Upload,
    download: Option<Buffer>,
    profiler: Option<Profiler>,
    size: [u32; 2],
    first: u32,
    /// Something may still be running on the device: nothing can be destroyed.
    stuck: bool,
}

impl Renderer {
    /// Opens the device and makes everything that frames need. `timed`: passes are timed.
    pub(super) fn new(
        common: &Common,
        shot: &Shot,
        extent: Extent,
        layers: bool,
        timed: bool,
        background: Option<&Picture<[f32; 4]>>,
    ) -> std::result::Result<Renderer, Failure> {
        let options = Options { validate: common.validate, device: common.device.clone(), ..Options::default() };
        let mut renderer = Renderer {
            headless: Headless::new(&options)?,
            smoke: None,
            target: None,
            background_image: None,
            background: match shot.background {
                ShotBackground::Colour([r, g, b]) => Background::Clear([r, g, b, 1.0]),
                _ => Background::Clear([0.0; 4]),
            },
            density: Upload::default(),
            velocity: Upload::default(),
            download: None,
            profiler: None,
            size: shot.size,
            first: shot.frames[0],
            stuck: false,
        };
        let light = shot.light(shot.frames[0]).source;
        let desc = Desc {
            size: shot.size,
            target_format: FORMAT,
            dimensions: extent.dimensions,
            velocity: extent.velocity,
            point_light: matches!(light, LightSource::Position(_)),
            seed: shot.seed,
            settings: shot.smoke.settings.clone(),
            layers,
            skipping: true,
        };
        renderer.create(desc, timed)?;
        if let Some(picture) = background {
            renderer.upload_background(picture)?;
        }
        renderer.check_messages()?;
        Ok(renderer)
    }

    fn create(&mut self, desc: Desc, timed: bool) -> Result<()> {
        let family = self.headless.queue_family();
        let (host, allocator) = self.headless.parts();
        let target = ImageDesc {
            name: "frame",
            extent: desc.size,
            layers: 1,
            array_view: false,
            format: FORMAT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::TRANSFER_DST
                | vk::ImageUsageFlags::TRANSFER_SRC,
        };
        let with_layers = desc.layers && desc.settings.particles > 0;
        // SAFETY: the headless device's own handles and allocator; what is made is destroyed in `drop`.
        unsafe {
            let smoke = self.smoke.insert(Smoke::new(&host, allocator, desc)?);
            self.target = Some(Image::new(&host, allocator, &target)?);
            let layer_bytes: u64 =
                if with_layers { layers::BUFFERS.iter().map(|id| smoke.buffer(*id).2).sum() } else { 0 };
            let bytes = pixel_bytes(self.size) + layer_bytes;
            self.download = Some(Buffer::new(&host, allocator, &readback("frame read back", bytes))?);
            if timed {
                let steps = smoke.plan().steps.capacity() as u32;
                self.profiler = Some(Profiler::new(&host, family, 1, steps)?);
            }
        }
        Ok(())
    }

    fn upload_background(&mut self, picture: &Picture<[f32; 4]>) -> Result<()> {
        let extent = picture.size;
        // Only copied, but every image has a view, and a view needs a usage of its own.
        let usage = vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let desc = ImageDesc { name: "background", extent, layers: 1, array_view: false, format: FORMAT, usage };
        // SAFETY: the headless device's own handles and allocator; the upload is waited for before the buffer is used
        // again.
        unsafe {
            let (host, allocator) = self.headless.parts();
            let image = self.background_image.insert(Image::new(&host, allocator, &desc)?);
            let (image, view) = (image.handle, image.view);
            let from = self.density.write(&host, allocator, "upload", cast_slice(&picture.pixels))?;
            let uploaded = self.headless.one_time("background", |host, commands| {
                record_picture(host, commands, &from, image, extent);
                Ok(())
            });
            self.note(uploaded)?;
            let (state_in, state_out) = (COPIED_FROM, COPIED_FROM);
            self.background = Background::Copy(HostImage { image, view, format: FORMAT, extent, state_in, state_out });
        }
        Ok(())
    }

    /// The device and the memory that the effect takes, for people.
    pub(super) fn describe(&self) -> String {
        let memory = self.smoke.as_ref().and_then(|smoke| Smoke::memory(smoke.desc(), u64::MAX).ok());
        let mebibytes = memory.unwrap_or_default().total().div_ceil(1 << 20);
        format!("device {}; {mebibytes} MiB of its memory", self.headless.info().to_string().trim())
    }

    /// Steps to frame `number`, with a volume if it is another than the frame before had, and renders it if asked for.
    /// Frames come in order, without gaps, from the shot's first.
    pub(super) fn step(
        &mut self,
        shot: &Shot,
        number: u32,
        volume: Option<&Volume>,
        is_rendered: bool,
    ) -> std::result::Result<(Option<Finished>, Option<FrameTimes>), Failure> {
        let volume = volume.map(|volume| self.upload(volume)).transpose()?;
        let frame = Frame {
            sequence: if number == self.first { Sequence::Restart } else { Sequence::Advance },
            dt: (1.0 / shot.fps) as f32,
            camera: shot.camera(number),
            light: shot.light(number),
            volume,
            target: self.target.as_ref().filter(|_| is_rendered).map(|target| self.host_image(target)),
            background: self.background,
        };
        let times = self.submit(&frame, number)?;
        self.check_messages()?;
        let finished = is_rendered.then(|| self.finished(number));
        Ok((finished, times))
    }

    fn host_image(&self, target: &Image) -> HostImage {
        HostImage {
            image: target.handle,
            view: target.view,
            format: FORMAT,
            extent: self.size,
            // The frame before has been waited for, and what it left is not needed.
            state_in: ImageState::default(),
            state_out: COPIED_FROM,
        }
    }

    fn upload(&mut self, volume: &Volume) -> Result<VolumeInput> {
        let (host, allocator) = self.headless.parts();
        // SAFETY: the headless device's own handles; the frame before has been waited for.
        let (density, velocity) = unsafe {
            let density = self.density.write(&host, allocator, "upload", cast_slice(&volume.density))?;
            let velocity = volume.velocity.as_ref();
            let velocity = velocity.map(|v| self.velocity.write(&host, allocator, "velocity upload", cast_slice(v)));
            (density, velocity.transpose()?)
        };
        let Volume { dimensions, voxel_size, origin, .. } = *volume;
        Ok(VolumeInput { dimensions, voxel_size, origin, density, velocity })
    }

    /// Records the frame and its way back, submits and waits.
    fn submit(&mut self, frame: &Frame, number: u32) -> Result<Option<FrameTimes>> {
        let Renderer { smoke: Some(smoke), download: Some(download), .. } = self else { return Ok(None) };
        let profiler = self.profiler.as_mut().filter(|_| frame.target.is_some());
        let done = self.headless.one_time(&format!("frame {number}"), |host, commands| {
            // SAFETY: the headless device's own handles; commands are in recording state, and every frame is submitted
            // to its one queue and waited for, in order.
            unsafe {
                let mut timing = Timing::None;
                if let Some(profiler) = profiler {
                    profiler.begin_frame(host, commands, 0, number)?;
                    timing = Timing::Profiler(profiler);
                }
                smoke.record(host, commands, frame, &mut timing)?;
                if let Some(target) = &frame.target {
                    let images = [Copy { from: (target.image, target.extent), to: 0 }];
                    let ranges = layer_ranges(smoke, pixel_bytes(target.extent));
                    record_readback(host, commands, &images, &ranges, download);
                }
            }
            Ok(())
        });
        self.note(done)?;
        let host = self.headless.host();
        // SAFETY: the frame has been waited for.
        Ok(self.profiler.as_mut().and_then(|profiler| unsafe { profiler.collect(&host, 0) }))
    }

    /// What was read back.
    fn finished(&self, number: u32) -> Finished {
        let bytes = self.download.as_ref().and_then(Buffer::mapped).unwrap_or_default();
        let count = pixels(self.size) as usize;
        let (picture, rest) = bytes.split_at_checked(count * PIXEL_BYTES as usize).unwrap_or_default();
        let pixels = picture.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
        let layers = match &self.smoke {
            Some(smoke) if smoke.desc().layers && smoke.desc().settings.particles == 0 => layers::empty(count),
            Some(smoke) if smoke.desc().layers => {
                let start = pixel_bytes(self.size);
                let ranges = layer_ranges(smoke, start);
                let mut bytes = [&[][..]; layers::BUFFERS.len()];
                for (slice, Copy { from: (_, _, size), to }) in bytes.iter_mut().zip(ranges) {
                    let from = (to - start) as usize;
                    *slice = rest.get(from..from + size as usize).unwrap_or_default();
                }
                layers::decode(bytes, count, smoke.desc().settings.sigma > 0.0)
            }
            _ => Vec::new(),
        };
        Finished { number, pixels, layers }
    }

    /// Remembers a wait that did not end.
    fn note<T>(&mut self, result: Result<T>) -> Result<T> {
        self.stuck |= matches!(&result, Err(Error::Vulkan { result: vk::Result::TIMEOUT, .. }));
        result
    }

    fn check_messages(&self) -> std::result::Result<(), Failure> {
        check(&self.headless.messages())
    }

    /// Destroys everything; what validation says about that is an error too.
    pub(super) fn finish(self) -> std::result::Result<(), Failure> {
        let messages = self.headless.messages();
        drop(self);
        check(&messages)
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        if self.stuck {
            return;
        }
        let (host, allocator) = self.headless.parts();
        // SAFETY: every submission has been waited for; nothing is used afterwards.
        unsafe {
            if let Some(smoke) = &mut self.smoke {
                smoke.destroy(&host, allocator);
            }
            for image in [&mut self.target, &mut self.background_image].into_iter().flatten() {
                image.destroy(&host, allocator);
            }
            self.density.destroy(&host, allocator);
            self.velocity.destroy(&host, allocator);
            if let Some(buffer) = &mut self.download {
                buffer.destroy(&host, allocator);
            }
            if let Some(profiler) = &mut self.profiler {
                profiler.destroy(&host);
            }
        }
    }
}

fn pixels(size: [u32; 2]) -> u64 {
    u64::from(size[0]) * u64::from(size[1])
}

fn pixel_bytes(size: [u32; 2]) -> u64 {
    pixels(size) * PIXEL_BYTES
}

/// The buffers of the layers, one after the other from `start` on; none if there are none to read.
fn layer_ranges(smoke: &Smoke, start: u64) -> Vec<Copy<(vk::Buffer, u64, u64)>> {
    if !smoke.desc().layers || smoke.desc().settings.particles == 0 {
        return Vec::new();
    }
    let mut to = start;
    let range = |id: &crate::plan::BufferId| {
        let from = smoke.buffer(*id);
        let copy = Copy { from, to };
        to += from.2;
        copy
    };
    layers::BUFFERS.iter().map(range).collect()
}

/// A message of validation is an error.
fn check(messages: &Messages) -> std::result::Result<(), Failure> {
    let messages = messages.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    match messages.first() {
        Some(first) => Err(Failure::new(Failure::DEVICE, format!("validation: {first}"))),
        None => Ok(()),
    }
}
