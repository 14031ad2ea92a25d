//! A host of celfx's own: renders frames of effects into memory, for the program and for tests.
//!
//! One frame at a time: upload, record, submit, wait. After a wait that did not end nothing is reused or destroyed.

mod depth;
mod effects;
pub mod motion;
pub mod passes;
mod past;
pub(crate) mod picture;
mod player;
mod slices;
mod vectors;

use std::mem::ManuallyDrop;
use std::time::Duration;

use ash::vk;

use crate::data::{Particles, Volume};
use crate::effect::{Effect, Effort, Kind};
use crate::error::{Error, Result};
use crate::gpu::headless::Headless;
use crate::gpu::image::Image;
use crate::gpu::profiler::{Profiler, Timing};
use crate::gpu::recorder::Stream;
use crate::gpu::transfer::{COPIED_FROM, Copy, Download, Upload, record_readback};
use crate::host::{Background, HostImage, ImageState};
use crate::profile::FrameTimes;
use crate::smoke::Sequence;
use crate::view::{Camera, FireLight, Light, View};
use depth::SharedDepth;
pub use effects::Effects;
pub use motion::{BlurError, BlurFrame, BlurInput};
pub use passes::PassesInput;
use picture::{host_image, image_desc, pixel_bytes, put};
pub use player::{Depth, Describe, EffectBuffer, Feed, Left, Place, Sharing};
pub(crate) use player::{Player, make};
use slices::{Pace, Slicer};
use vectors::SharedVectors;

/// Format of the target.
pub const TARGET_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// One frame, as a shot says it. What effects are not there for is not looked at.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scene<'a> {
    /// How it follows the frame before.
    pub sequence: Sequence,
    /// Seconds until the next frame.
    pub dt: f32,
    /// The camera.
    pub camera: Camera,
    /// What it is seen through instead, if it is not a camera's.
    pub view: Option<View>,
    /// What the frame before was seen through; none: there is none, or no motion vectors are asked for.
    pub previous: Option<View>,
    /// The light.
    pub light: Light,
    /// The light of its fire on smoke that was made for one.
    pub fire: Option<FireLight>,
    /// Its volume; none if it is the last one.
    pub volume: Option<&'a Volume>,
    /// Its particles; none if they are those of the last rendered frame. Those of other frames are not looked at.
    pub particles: Option<&'a Particles>,
    /// How far the flame's sprites are from their particle at most, where its settings do not say it
    /// ([`crate::flame::Frame::spread`]).
    pub spread: Option<f32>,
    /// View depth of what hides the fire, in metres a pixel, rows from the top, infinity where nothing is. Given exactly
    /// if the flame was made for a buffer of depths ([`crate::flame::SceneFormat`]) and there is no smoke.
    pub depth: Option<&'a [f32]>,
    /// The input of its blur.
    pub blur: Option<BlurScene<'a>>,
    /// Whether the flame adds its repetitions to those of the frame before ([`crate::flame::Frame::accumulate`]).
    pub accumulate: bool,
    /// Whether it is rendered, or only moves the smoke's particles on.
    pub rendered: bool,
    /// Number of the frame, in profiles and for the flame's flicker.
    pub number: u32,
    /// Number of the fire's drawing, for its flicker, if that is not the frame's.
    pub drawing: Option<u32>,
}

impl Scene<'_> {
    /// What it is seen through in pictures of `size` pixels.
    pub(crate) fn seen(&self, size: [u32; 2]) -> View {
        self.view.unwrap_or_else(|| self.camera.view(size))
    }
}

/// The input of a blurred frame.
#[derive(Clone, Copy, Debug)]
pub struct BlurScene<'a> {
    /// The mesh's motion.
    pub frame: &'a BlurFrame,
    /// Pictures of frames i and i + 1 ([`BlurFrame::images`]): linear RGBA, premultiplied, rows from the top. One that the
    /// frame before had need not be given. Not looked at if the effect was made to draw frames.
    pub images: [Option<&'a [[f32; 4]]>; 2],
    /// The same of frames i - 1 and i + 2 ([`BlurFrame::outer_images`]), which need not be there at all.
    pub outer: [Option<&'a [[f32; 4]]>; 2],
}

/// A device, the effects on it, and what carries their input to it and pictures back.
pub struct Offline {
    /// Dropped by hand, or handed back, after everything on it.
    device: ManuallyDrop<Headless>,
    parts: Parts,
    size: [u32; 2],
    /// The colour under the effects; none: the backdrop.
    background: Option<[f32; 4]>,
    /// Buffers that are read back with each rendered frame.
    layers: Vec<EffectBuffer>,
    timed: bool,
    times: Option<FrameTimes>,
    pace: Pace,
    /// Whether what was read back is a whole frame.
    is_read: bool,
}

/// Parts that must be destroyed by hand.
#[derive(Default)]
struct Parts {
    /// By the effect's name, in the order in which they are drawn.
    players: Vec<(&'static str, Box<dyn Player>)>,
    target: Option<Image>,
    backdrop: Option<Image>,
    /// That of what is solid, and of all that it hides.
    depth: Option<SharedDepth>,
    /// Motion vectors, if there are to be any.
    vectors: Option<SharedVectors>,
    /// Of backdrops: each is waited for before the next.
    upload: Upload,
    /// The picture, then motion vectors, then the layers.
    frame: Download,
    /// Single buffers.
    buffer: Download,
    profiler: Option<Profiler>,
}

impl Parts {
    /// Handle, offset and size of an effect's buffer; null if there is no such effect.
    fn buffer(&self, buffer: EffectBuffer) -> (vk::Buffer, u64, u64) {
        let player = self.players.iter().find(|(name, _)| *name == buffer.effect);
        player.map(|(_, player)| player.executor().buffer(buffer.id)).unwrap_or_default()
    }
}

impl Offline {
    /// Makes the effects on `device`. Each `target_format` is [`TARGET_FORMAT`].
    ///
    /// # Errors
    /// No effect, or effects of different sizes; as [`Effect::new`]. The device is lost with it.
    pub fn new(device: Headless, effects: impl Into<Effects>) -> Result<Offline> {
        Offline::with_effort(device, effects, Effort::Needed)
    }

    /// [`Offline::new`], to prove that leaving work out changes nothing.
    ///
    /// # Errors
    /// As there.
    #[doc(hidden)]
    pub fn with_effort(device: Headless, effects: impl Into<Effects>, effort: Effort) -> Result<Offline> {
        let effects = effects.into();
        let mut offline = Offline {
            device: ManuallyDrop::new(device),
            parts: Parts::default(),
            size: effects.size()?,
            background: Some([0.0; 4]),
            layers: Vec::new(),
            timed: true,
            times: None,
            pace: Pace::default(),
            is_read: false,
        };
        offline.create(effects, effort)?;
        Ok(offline)
    }

    fn create(&mut self, mut effects: Effects, effort: Effort) -> Result<()> {
        let (is_shared, has_vectors) = (effects.share_depth(), effects.has_vectors());
        let queue_family = self.device.queue_family();
        let Parts { players, target, depth, vectors, profiler, .. } = &mut self.parts;
        effects.make(&mut self.device, effort, |name, player| players.push((name, player)))?;
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own and outlives what is made here.
        unsafe {
            let steps: usize = players.iter().map(|(_, player)| player.executor().plan().steps.capacity()).sum();
            *profiler = Some(Profiler::new(&host, queue_family, 1, steps as u32)?);
            if is_shared {
                *depth = Some(SharedDepth::new(&host, allocator, self.size)?);
            }
            if has_vectors {
                *vectors = Some(SharedVectors::new(&host, allocator, self.size)?);
            }
            *target = Some(Image::new(&host, allocator, &image_desc("target", self.size))?);
        }
        self.make_download()
    }

    /// Room for a frame's picture and layers; now, so that too little memory shows before frames are rendered.
    fn make_download(&mut self) -> Result<()> {
        self.is_read = false;
        let end = self.layer_copies().last().map_or(self.images_end(), |copy| copy.to + copy.from.2);
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own, and every frame has been waited for.
        unsafe { self.parts.frame.fit(&host, allocator, "frame read back", end) }
    }

    /// The colour under the effects: linear RGBA, premultiplied. Black and transparent at first.
    pub fn set_background(&mut self, colour: [f32; 4]) {
        self.background = Some(colour);
    }

    /// A picture of the target's size under the effects: linear RGBA, premultiplied, rows from the top.
    ///
    /// # Errors
    /// Another size; no memory; a failed Vulkan call; a device that does not answer.
    pub fn set_backdrop(&mut self, pixels: &[[f32; 4]]) -> Result<()> {
        self.check_free()?;
        let image = self.parts.backdrop.take();
        let upload = &mut self.parts.upload;
        self.parts.backdrop = Some(put(&mut self.device, upload, "background", image, self.size, pixels)?);
        self.background = None;
        Ok(())
    }

    /// The buffers that each rendered frame reads back with its picture, in its own submission; none at first.
    /// [`Offline::layers`] has what was read.
    ///
    /// # Errors
    /// No memory; a device that does not answer.
    pub fn set_layers(&mut self, buffers: &[EffectBuffer]) -> Result<()> {
        self.check_free()?;
        self.layers = buffers.to_vec();
        self.make_download()
    }

    /// Whether frames are timed, which costs some time itself; they are at first.
    pub fn set_timed(&mut self, timed: bool) {
        self.timed = timed;
    }

    /// The longest that one submission should take: a frame is cut into several between its steps, by what they took in the
    /// frames before, and steps that have not run yet are submitted alone. Half a second at first; none: a frame is never
    /// cut. What frames show does not depend on it.
    pub fn set_longest_submission(&mut self, longest: Option<Duration>) {
        self.pace.set_longest(longest);
    }

    /// Renders a frame and waits for it.
    ///
    /// # Errors
    /// As [`Effect::record`]; a lost device; a device that does not answer; an
    /// interruption.
    pub fn frame(&mut self, scene: &Scene) -> Result<()> {
        self.check_free()?;
        self.times = None;
        self.is_read &= !scene.rendered;
        let places = self.upload(scene)?;
        let name = format!("frame {}", scene.number);
        let done = self.run(scene, &places, &name);
        let profiler = self.parts.profiler.as_mut().filter(|_| self.timed);
        let host = self.device.host();
        if let Err(error) = done {
            // SAFETY: the device is lost, after the first commands of the frame have run.
            let running = || unsafe { profiler?.running(&host, 0) };
            let step = if error.is_lost() { running() } else { None };
            return Err(slices::at_step(error, &name, step));
        }
        // SAFETY: the frame has been waited for.
        self.times = profiler.and_then(|profiler| unsafe { profiler.collect(&host, 0) });
        self.is_read |= scene.rendered;
        self.parts.players.iter_mut().for_each(|(_, player)| player.finished());
        Ok(())
    }

    /// Uploads what the frame brings, and says where each effect is drawn, if it is.
    fn upload(&mut self, scene: &Scene) -> Result<Vec<Option<Place>>> {
        let mut places = Vec::new();
        let (mut left, mut is_first) = (player::Left::default(), true);
        for index in 0..self.parts.players.len() {
            if !scene.rendered && !self.parts.players[index].1.moves() {
                places.push(None);
                continue;
            }
            // The first effect's background covers what the frame before left, whose copy has been waited for; the
            // others keep what it has made.
            let target = self.target(if is_first { ImageState::default() } else { COPIED_FROM });
            let place = Place {
                target: target.filter(|_| scene.rendered),
                background: if is_first { self.background() } else { Background::Keep },
                depth: self.parts.depth.as_ref().map(|depth| depth.placed(is_first)),
                vectors: self.parts.vectors.as_ref().map(|vectors| vectors.placed(is_first)),
                left,
            };
            let (_, player) = &mut self.parts.players[index];
            player.upload(&mut self.device, scene, &place)?;
            player.leave(&mut left);
            is_first = false;
            places.push(Some(place));
        }
        let drawn = self.parts.players.iter().zip(&places);
        let mut drawn = drawn.filter_map(|((_, player), place)| Some((player, place.as_ref()?)));
        drawn.try_for_each(|(player, place)| player.check(scene, place))?;
        Ok(places)
    }

    /// Records and submits a frame, and what is read back after it.
    fn run(&mut self, scene: &Scene, places: &[Option<Place>], name: &str) -> Result<()> {
        let mut layers = self.layer_copies();
        layers.retain(|copy| copy.from.2 > 0);
        let target = self.target(ImageState::default()).filter(|_| scene.rendered);
        let Parts { players, depth, vectors, profiler, frame: download, .. } = &mut self.parts;
        let (host, submitter) = self.device.recording();
        let mut slicer = Slicer::new(submitter, &mut self.pace, name)?;
        let stream = &mut slicer;
        let mut timing = Timing::None;
        // SAFETY: everything is this host's own, in the declared states, and the frame is waited for.
        unsafe {
            if let Some(profiler) = profiler.as_mut().filter(|_| self.timed) {
                profiler.begin_frame(&host, stream.current(), 0, scene.number)?;
                timing = Timing::Profiler(profiler);
            }
            depth.iter().filter(|_| scene.rendered).for_each(|depth| depth.clear(&host, stream.current()));
            vectors.iter().filter(|_| scene.rendered).for_each(|vectors| vectors.clear(&host, stream.current()));
            for ((_, player), place) in players.iter_mut().zip(places) {
                if let Some(place) = place {
                    player.record(&host, stream, scene, place, &mut timing)?;
                }
            }
            if let (Some(target), Some(download)) = (target, download.buffer()) {
                let mut images = vec![Copy { from: (target.image, target.extent), to: 0 }];
                images.extend(vectors.iter().map(|own| Copy { from: own.source(), to: pixel_bytes(self.size) }));
                record_readback(&host, stream.current(), &images, &layers, download);
            }
        }
        slicer.finish()
    }

    fn background(&self) -> Background {
        match self.image(&self.parts.backdrop, COPIED_FROM).filter(|_| self.background.is_none()) {
            Some(backdrop) => Background::Copy(backdrop),
            None => Background::Clear(self.background.unwrap_or_default()),
        }
    }

    fn target(&self, state_in: ImageState) -> Option<HostImage> {
        self.image(&self.parts.target, state_in)
    }

    /// The picture of the frame rendered last: linear RGBA, premultiplied, rows from the top. Empty if there is none.
    pub fn picture(&self) -> &[[f32; 4]] {
        let bytes = self.read_range(0, pixel_bytes(self.size));
        bytemuck::try_cast_slice(bytes).unwrap_or_default()
    }

    /// Motion vectors of the frame rendered last: pixels to the right and down from where what a pixel shows is to where it was a
    /// frame earlier, 0 where no effect is. Empty if there are none ([`Effects::with_vectors`]).
    pub fn vectors(&self) -> &[[f32; 2]] {
        let size = self.parts.vectors.as_ref().map_or(0, SharedVectors::bytes);
        let bytes = self.read_range(pixel_bytes(self.size), size);
        bytemuck::try_cast_slice(bytes).unwrap_or_default()
    }

    /// Where what is read back of images ends.
    fn images_end(&self) -> u64 {
        let vectors = self.parts.vectors.as_ref().map_or(0, SharedVectors::bytes);
        pixel_bytes(self.size) + vectors.next_multiple_of(16)
    }

    /// The layers that [`Offline::set_layers`] asked for, in that order, as the frame rendered last left them. Each is
    /// empty if there is none.
    pub fn layers(&self) -> Vec<&[u8]> {
        self.layer_copies().iter().map(|copy| self.read_range(copy.to, copy.from.2)).collect()
    }

    fn read_range(&self, from: u64, size: u64) -> &[u8] {
        let bytes = if self.is_read { self.parts.frame.bytes() } else { &[] };
        bytes.get(from as usize..(from + size) as usize).unwrap_or_default()
    }

    /// Where each layer comes from and goes to: one after the other behind the picture.
    fn layer_copies(&self) -> Vec<Copy<(vk::Buffer, u64, u64)>> {
        let mut end = self.images_end();
        let place = |buffer: &EffectBuffer| {
            let (from, to) = (self.parts.buffer(*buffer), end);
            end += from.2.next_multiple_of(16);
            Copy { from, to }
        };
        self.layers.iter().map(place).collect()
    }

    /// The first `bytes` of a buffer of an effect after the last frame; all of it if it is smaller, nothing if there is
    /// no such effect.
    ///
    /// # Errors
    /// No memory; a failed Vulkan call; a device that does not answer.
    pub fn read(&mut self, buffer: EffectBuffer, bytes: u64) -> Result<Vec<u8>> {
        self.check_free()?;
        let (source, offset, size) = self.parts.buffer(buffer);
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
    pub fn read_as<T: bytemuck::AnyBitPattern>(&mut self, buffer: EffectBuffer, count: usize) -> Result<Vec<T>> {
        let bytes = self.read(buffer, (count * size_of::<T>()) as u64)?;
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Times of the last frame, once; none where it was not timed or the device has no timestamps.
    pub fn times(&mut self) -> Option<FrameTimes> {
        self.times.take()
    }

    /// Whether the device can time passes: its queue has timestamps.
    pub fn has_clock(&self) -> bool {
        self.parts.profiler.as_ref().is_some_and(Profiler::is_supported)
    }

    /// Device memory that the effects take, in bytes before alignment.
    pub fn memory(&self) -> u64 {
        self.parts.players.iter().map(|(_, player)| player.executor().memory().total()).sum()
    }

    /// An effect of a kind, if there is one.
    pub fn effect<K: Kind + 'static>(&mut self) -> Option<&mut Effect<K>> {
        self.parts.players.iter_mut().find_map(|(_, player)| player.effect_mut().downcast_mut())
    }

    /// The passes that an effect left out of the frame recorded last: each one's name, and why.
    pub fn skipped(&self, effect: &str) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        let player = self.parts.players.iter().find(|(name, _)| *name == effect);
        player.into_iter().flat_map(|(_, player)| player.executor().skipped())
    }

    /// The device.
    pub fn device(&self) -> &Headless {
        &self.device
    }

    /// The device, for commands of others between frames.
    pub fn device_mut(&mut self) -> &mut Headless {
        &mut self.device
    }

    /// Nothing may be reused while it may still be running.
    fn check_free(&self) -> Result<()> {
        let running = || Error::vulkan("vkWaitForFences", "an earlier submission")(vk::Result::TIMEOUT);
        (!self.device.is_stuck()).then_some(()).ok_or_else(running)
    }

    fn image(&self, image: &Option<Image>, state_in: ImageState) -> Option<HostImage> {
        image.as_ref().map(|image| host_image(image, self.size, state_in))
    }
}

impl Offline {
    /// Destroys the effects; the device is handed back, with their pipelines.
    pub fn into_device(mut self) -> Headless {
        self.destroy();
        let mut offline = ManuallyDrop::new(self);
        drop(std::mem::take(&mut offline.parts));
        (offline.layers, offline.times) = (Vec::new(), None);
        // SAFETY: it is not touched again, as nothing is dropped.
        unsafe { ManuallyDrop::take(&mut offline.device) }
    }

    fn destroy(&mut self) {
        if self.device.is_stuck() {
            return;
        }
        let (host, allocator) = self.device.parts();
        // SAFETY: every submission has been waited for, or its device is lost; nothing is used afterwards.
        unsafe {
            let Parts { players, target, backdrop, depth, vectors, upload, frame, buffer, profiler } = &mut self.parts;
            players.iter_mut().for_each(|(_, player)| player.destroy(&host, allocator));
            target.iter_mut().chain(backdrop).for_each(|image| image.destroy(&host, allocator));
            depth.iter_mut().for_each(|depth| depth.destroy(&host, allocator));
            vectors.iter_mut().for_each(|vectors| vectors.destroy(&host, allocator));
            upload.destroy(&host, allocator);
            [frame, buffer].into_iter().for_each(|buffer| buffer.destroy(&host, allocator));
            profiler.iter_mut().for_each(|profiler| profiler.destroy(&host));
        }
    }
}

impl Drop for Offline {
    fn drop(&mut self) {
        self.destroy();
        // SAFETY: nothing else is done with it.
        unsafe { ManuallyDrop::drop(&mut self.device) };
    }
}
