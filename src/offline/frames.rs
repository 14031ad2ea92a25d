//! What a scene holds, as each effect takes it: uploads what is not on the device yet.

use ash::vk;

use super::{BlurScene, Frames, Offline, Parts, Scene, input};
use crate::blur::{self as blur_effect, Blur, DepthInput, ToonInput};
use crate::error::{Error, Result};
use crate::flame::{self, SceneDepth};
use crate::gpu::transfer::COPIED_FROM;
use crate::host::{Background, HostBuffer, HostDepth, HostImage, ImageState};
use crate::smoke;
use crate::view::Camera;

impl Offline {
    /// Uploads what the frame brings, and says it as each effect takes it.
    pub(super) fn frames<'a>(&mut self, scene: &Scene<'a>) -> Result<Frames<'a>> {
        // The first effect's background covers what the frame before left, whose copy has been waited for; the others
        // keep what it has made.
        let target = |offline: &Offline, is_first: bool| {
            offline.target(if is_first { ImageState::default() } else { COPIED_FROM }).filter(|_| scene.rendered)
        };
        let blur = match (target(self, true), self.parts.blur.is_some()) {
            (Some(target), true) => self.blur_frame(scene, target)?,
            _ => None,
        };
        let is_first = blur.is_none();
        let smoke = self.smoke_frame(scene, target(self, is_first), is_first)?;
        let is_first = is_first && smoke.is_none();
        let flame = match (target(self, is_first), self.parts.flame.is_some()) {
            (Some(target), true) => Some(self.flame_frame(scene, target, is_first)?),
            _ => None,
        };
        if let (true, Some(frame), Some(flame)) = (smoke.is_some() || blur.is_some(), &flame, &self.parts.flame) {
            // Before others are recorded, which would not know that their frame is never submitted.
            frame.validate(flame.desc(), false)?;
        }
        Ok(Frames { smoke, flame, blur })
    }

    /// Uploads what of the pictures and of the motion is not on the device. Without a picture that is needed and not
    /// there, an error.
    fn blur_frame<'a>(&mut self, scene: &Scene<'a>, target: HostImage) -> Result<Option<blur_effect::Frame<'a>>> {
        let Some(BlurScene { frame, images, outer }) = scene.blur else {
            return Err(Error::HostResource { name: "blur", why: "no motion: expected some".to_owned() });
        };
        let is_drawn = self.parts.blur.as_ref().is_some_and(|blur| blur.desc().toon);
        let (images, outer) = match is_drawn {
            true => (None, [None; 2]),
            false => (Some(self.images(frame.images(), images)?), self.outer_images(frame.outer_images(), outer)?),
        };
        let background = self.background();
        let (host, allocator) = self.device.parts();
        let Parts { blur, blur_input, .. } = &mut self.parts;
        let Some(blur) = blur else { return Ok(None) };
        // SAFETY: the device is this host's own, and every submission has been waited for.
        let uploaded = unsafe { blur_input.write(&host, allocator, frame, blur.desc())? };
        let input::UploadedBlur { mesh, poses, interval } = uploaded;
        let toon = is_drawn.then(|| ToonInput { view: interval.views[2], light: scene.light });
        // In front of the first frame there is no interval.
        let interval = (interval.views[1].frame != interval.views[2].frame).then_some(interval);
        let view = frame.views[2];
        let depth = self.parts.depth.as_ref().map(|depth| depth.of_frame(view.camera.near, true));
        let depth = depth.map(|host| DepthInput { host, view });
        Ok(Some(blur_effect::Frame { mesh, poses, interval, images, toon, outer, target, depth, background }))
    }

    /// The images of two frames on the device: the pictures that are given, and those that are there.
    fn images(&mut self, numbers: [u32; 2], pictures: [Option<&[[f32; 4]]>; 2]) -> Result<[HostImage; 2]> {
        for (number, picture) in numbers.into_iter().zip(pictures) {
            self.show(number, picture)?;
        }
        match numbers.map(|number| self.shown(number)) {
            [Some(before), Some(after)] => Ok([before, after]),
            _ => {
                let why = format!("no image of frame {} or {}: expected one", numbers[0], numbers[1]);
                Err(Error::HostResource { name: "blur", why })
            }
        }
    }

    /// The images of frames i - 1 and i + 2, as far as there are any.
    fn outer_images(
        &mut self,
        numbers: [Option<u32>; 2],
        pictures: [Option<&[[f32; 4]]>; 2],
    ) -> Result<[Option<HostImage>; 2]> {
        for (number, picture) in numbers.into_iter().zip(pictures) {
            number.map_or(Ok(()), |number| self.show(number, picture))?;
        }
        Ok(numbers.map(|number| self.shown(number?)))
    }

    /// The image of a frame, if it is on the device.
    fn shown(&self, number: u32) -> Option<HostImage> {
        let place = number as usize % self.parts.shown.len();
        let (_, image) = self.parts.shown[place].as_ref().filter(|(shown, _)| *shown == number)?;
        Some(self.host_image(image, COPIED_FROM))
    }

    /// Puts the picture of a frame where it belongs, unless it is there.
    fn show(&mut self, number: u32, picture: Option<&[[f32; 4]]>) -> Result<()> {
        let place = number as usize % self.parts.shown.len();
        let is_there = self.parts.shown[place].as_ref().is_some_and(|(shown, _)| *shown == number);
        let Some(pixels) = picture.filter(|_| !is_there) else { return Ok(()) };
        let image = self.parts.shown[place].take().map(|(_, image)| image);
        let image = self.put("blurred frame", image, pixels)?;
        self.parts.shown[place] = Some((number, image));
        Ok(())
    }

    fn smoke_frame(
        &mut self,
        scene: &Scene,
        target: Option<HostImage>,
        is_first: bool,
    ) -> Result<Option<smoke::Frame>> {
        let Some(smoke) = &self.parts.smoke else { return Ok(None) };
        let wants_velocity = smoke.desc().velocity;
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own, and every submission has been waited for.
        let write = |volume| unsafe { self.parts.volume.write(&host, allocator, volume, wants_velocity) };
        let volume = scene.volume.map(write).transpose()?;
        Ok(Some(smoke::Frame {
            sequence: scene.sequence,
            dt: scene.dt,
            camera: scene.camera,
            light: scene.light,
            volume,
            target,
            depth: target.and(self.shared_depth(&scene.camera)),
            edges: self.parts.blur.as_ref().filter(|_| target.is_some()).and_then(Blur::edges),
            background: if is_first { self.background() } else { Background::Keep },
        }))
    }

    fn flame_frame(&mut self, scene: &Scene, target: HostImage, is_first: bool) -> Result<flame::Frame> {
        let (host, allocator) = self.device.parts();
        // With smoke it is the smoke that hides the fire.
        let given = scene.depth.filter(|_| self.parts.smoke.is_none());
        // SAFETY: the device is this host's own, and every submission has been waited for.
        let (particles, depth) = unsafe {
            let Parts { particles, upload, .. } = &mut self.parts;
            let given_particles = scene.particles.map(|given| particles.write(&host, allocator, given));
            let depth = given.map(|depth| upload.write(&host, allocator, "upload", bytemuck::cast_slice(depth)));
            (given_particles.transpose()?, depth.transpose()?)
        };
        Ok(flame::Frame {
            camera: scene.camera,
            particles,
            number: scene.number,
            accumulate: scene.accumulate,
            target,
            background: if is_first { self.background() } else { Background::Keep },
            scene: match self.shared_depth(&scene.camera) {
                Some(depth) => Some(SceneDepth::Image(depth)),
                None => self.smoke_depth().or(depth).map(SceneDepth::Buffer),
            },
        })
    }

    /// The depth that the mesh and what is drawn after it leave, if there is a mesh.
    fn shared_depth(&self, camera: &Camera) -> Option<HostDepth> {
        self.parts.depth.as_ref().map(|depth| depth.of_frame(camera.near, false))
    }

    /// The depth that the smoke leaves: written by its shaders, or cleared where there is none.
    fn smoke_depth(&self) -> Option<HostBuffer> {
        let (buffer, offset, size) = self.parts.smoke.as_ref()?.buffer(smoke::layout::DEPTH);
        let stage = vk::PipelineStageFlags2::COMPUTE_SHADER | vk::PipelineStageFlags2::ALL_TRANSFER;
        let access = vk::AccessFlags2::SHADER_STORAGE_WRITE | vk::AccessFlags2::TRANSFER_WRITE;
        Some(HostBuffer { buffer, offset, size, stage, access })
    }
}
