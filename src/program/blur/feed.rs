//! How a scene becomes a frame of a blur.

use std::sync::Arc;

use crate::blur::{self, Blur, BlurKind, DepthInput, Desc, Frame, Knot, Mesh, MeshSizes, Placed, PoseInput, ToonInput};
use crate::error::{Error, Result};
use crate::gpu::capabilities::{DeviceTraits, own_memory};
use crate::gpu::headless::Headless;
use crate::gpu::image::Image;
use crate::gpu::transfer::{COPIED_FROM, Upload};
use crate::host::{Host, HostImage, MemorySource, TemporalImages};
use crate::offline::motion::{BlurFrame, FRAMES_BESIDE};
use crate::offline::picture::{host_image, put};
use crate::offline::{BlurScene, Depth, Describe, Feed, Left, Place, Scene, Sharing};

impl Describe for Desc {
    type Feed = BlurFeed;
    const DEPTH: Depth = Depth::Solid;

    fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Layers say where and what of the mesh pixels show.
    fn wants_depth(&self) -> bool {
        self.layers
    }

    fn share(&mut self, Sharing { image, vectors, .. }: Sharing) {
        self.temporal.motion = vectors;
        if image.is_some() {
            self.depth = image;
        }
    }

    fn fitted(self, host: &Host) -> Desc {
        // SAFETY: the host's handles are those of its own device.
        let (limit, memory) =
            unsafe { (DeviceTraits::of(host.instance, host.physical_device).storage_range, own_memory(host)) };
        Desc { frames_resident: resident(self.frames_resident, self.points, memory, limit), ..self }
    }
}

/// Uploads a mesh's motion, and the pictures of the frames that are blurred.
#[derive(Debug, Default)]
pub struct BlurFeed {
    packed: blur::Upload,
    upload: Upload,
    pictures: Upload,
    /// Pictures of the frames that are blurred, each in the place of its number modulo theirs, and which these are.
    shown: [Option<(u32, Image)>; 4],
    /// The frame whose pose stands in each place on the device.
    resident: Vec<Option<u32>>,
    /// The mesh on the device, and that of the frame that is made.
    mesh: Option<Arc<Mesh>>,
    brought: Option<Arc<Mesh>>,
    placed: Option<Placed>,
}

impl Feed for BlurFeed {
    type Kind = BlurKind;

    fn upload(&mut self, blur: &Blur, device: &mut Headless, scene: &Scene, _: &Place) -> Result<()> {
        let Some(BlurScene { frame, images, outer }) = scene.blur else {
            return Err(Error::HostResource { name: "blur", why: "no motion: expected some".to_owned() });
        };
        if !blur.desc().toon {
            self.show_all(device, blur.desc().size, frame, images, outer)?;
        }
        let (host, allocator) = device.parts();
        // SAFETY: the device's own handles, and every submission has been waited for.
        self.placed = Some(unsafe { self.write(&host, allocator, frame, blur.desc())? });
        Ok(())
    }

    fn frame<'a>(&'a self, blur: &Blur, scene: &Scene<'a>, place: &Place) -> Option<Frame<'a>> {
        let (target, desc, BlurScene { frame, .. }) = (place.target?, blur.desc(), scene.blur?);
        let placed = self.placed?;
        let is_drawn = desc.toon;
        let image = |number: u32| self.image(number, desc.size).filter(|_| !is_drawn);
        let [before, after] = frame.images().map(image);
        let interval = placed.interval(&frame.interval, &frame.mesh, frame.views, knots(frame, desc));
        let view = frame.views[2];
        Some(Frame {
            mesh: placed.mesh,
            skinned: None,
            poses: placed.poses,
            // In front of the first frame there is no interval.
            interval: interval.filter(|_| frame.views[1].frame != view.frame),
            images: before.zip(after).map(|(before, after)| [before, after]),
            toon: is_drawn.then_some(ToonInput { view, light: scene.light }),
            outer: frame.outer_images().map(|number| image(number?)),
            occluders: [None; 4],
            target,
            depth: place.depth.map(|depth| DepthInput { host: depth, view }),
            background: place.background,
            // What the frame before was seen through stands in the interval.
            temporal: TemporalImages { previous: None, ..place.temporal(scene) },
        })
    }

    fn leave(blur: &Blur, left: &mut Left) {
        left.edges = blur.edges();
    }

    fn finished(&mut self) {
        let Some(Placed { poses, .. }) = self.placed.take() else { return };
        self.mesh = self.brought.take().or(self.mesh.take());
        if let Some(PoseInput { first, count, .. }) = poses {
            let places = self.resident.len();
            (first..first + count).for_each(|frame| self.resident[frame as usize % places] = Some(frame));
        }
    }

    unsafe fn destroy(&mut self, host: &Host, allocator: &mut dyn MemorySource) {
        let uploads = [&mut self.upload, &mut self.pictures];
        // SAFETY: the caller's.
        unsafe {
            uploads.into_iter().for_each(|upload| upload.destroy(host, allocator));
            self.shown.iter_mut().flatten().for_each(|(_, image)| image.destroy(host, allocator));
        }
    }
}

impl BlurFeed {
    /// Puts the pictures where they belong; without one that is needed and not there, an error.
    fn show_all(
        &mut self,
        device: &mut Headless,
        size: [u32; 2],
        frame: &BlurFrame,
        images: [Option<&[[f32; 4]]>; 2],
        outer: [Option<&[[f32; 4]]>; 2],
    ) -> Result<()> {
        for (number, picture) in frame.images().into_iter().zip(images) {
            self.show(device, size, number, picture)?;
        }
        let [before, after] = frame.images();
        if self.image(before, size).is_none() || self.image(after, size).is_none() {
            let why = format!("no image of frame {before} or {after}: expected one");
            return Err(Error::HostResource { name: "blur", why });
        }
        for (number, picture) in frame.outer_images().into_iter().zip(outer) {
            number.map_or(Ok(()), |number| self.show(device, size, number, picture))?;
        }
        Ok(())
    }

    /// Puts the picture of a frame where it belongs, unless it is there.
    fn show(&mut self, device: &mut Headless, size: [u32; 2], number: u32, picture: Option<&[[f32; 4]]>) -> Result<()> {
        let place = number as usize % self.shown.len();
        let is_there = self.shown[place].as_ref().is_some_and(|(shown, _)| *shown == number);
        let Some(pixels) = picture.filter(|_| !is_there) else { return Ok(()) };
        let image = self.shown[place].take().map(|(_, image)| image);
        let image = put(device, &mut self.pictures, "blurred frame", image, size, pixels)?;
        self.shown[place] = Some((number, image));
        Ok(())
    }

    /// The image of a frame, if it is on the device.
    fn image(&self, number: u32, size: [u32; 2]) -> Option<HostImage> {
        let place = number as usize % self.shown.len();
        let (_, image) = self.shown[place].as_ref().filter(|(shown, _)| *shown == number)?;
        Some(host_image(image, size, COPIED_FROM))
    }

    /// Uploads what of a frame the effect made for `desc` does not have.
    ///
    /// # Safety
    /// As [`Upload::write`]; and every frame that was written has been recorded.
    unsafe fn write(
        &mut self,
        host: &Host,
        allocator: &mut dyn MemorySource,
        frame: &BlurFrame,
        desc: &Desc,
    ) -> Result<Placed> {
        let knots = knots(frame, desc);
        self.resident.resize(desc.frames_resident as usize, None);
        self.packed.clear();
        if self.mesh.as_ref().is_none_or(|mesh| !Arc::ptr_eq(mesh, &frame.mesh)) {
            self.packed.mesh_of_rows(&frame.mesh, &frame.colours);
            if desc.texture_rows > 0 {
                self.packed.textures(&frame.textures);
            }
            if !frame.shares.is_empty() {
                self.packed.shares(&frame.shares);
            }
            self.brought = Some(frame.mesh.clone());
            // They are of another.
            self.resident.fill(None);
        }
        if let Some([first, last]) = self.missing(frame, knots.unwrap_or_default()) {
            let range = (first - frame.first) as usize..=(last - frame.first) as usize;
            let poses: Vec<&[[f32; 3]]> = frame.poses[range].iter().map(|pose| &pose[..]).collect();
            self.packed.poses(first, &poses);
        }
        self.packed.interval(&frame.interval, knots.is_none());
        // SAFETY: the caller's.
        let buffer = unsafe { self.upload.write(host, allocator, "blur upload", self.packed.bytes())? };
        let mut placed = self.packed.placed(buffer);
        if let Some(mesh) = &mut placed.mesh {
            mesh.sizes = (!desc.is_for(&frame.mesh)).then(|| MeshSizes::of(&frame.mesh));
        }
        Ok(placed)
    }

    /// The first and the last pose that must be uploaded.
    fn missing(&self, frame: &BlurFrame, knots: &[Knot]) -> Option<[u32; 2]> {
        let needed = needed(frame, knots);
        let missing = needed.filter(|frame| self.resident[*frame as usize % self.resident.len()] != Some(*frame));
        missing.fold(None, |range, frame| match range {
            None => Some([frame, frame]),
            Some([first, last]) => Some([frame.min(first), frame.max(last)]),
        })
    }
}

/// The frames that trajectories go through, where the device has all their poses.
fn knots<'a>(frame: &'a BlurFrame, desc: &Desc) -> Option<&'a [Knot]> {
    frame.knots.as_deref().filter(|knots| spans(frame, knots) < desc.frames_resident)
}

/// Frames whose poses must be on the device.
fn needed<'a>(frame: &'a BlurFrame, knots: &'a [Knot]) -> impl Iterator<Item = u32> + 'a {
    frame.views.iter().chain(knots.iter().map(|knot| &knot.view)).map(|view| view.frame)
}

/// Frames from the first to the last whose pose must be on the device, less one.
fn spans(frame: &BlurFrame, knots: &[Knot]) -> u32 {
    let (first, last) = needed(frame, knots).fold((u32::MAX, 0), |(a, b), frame| (a.min(frame), b.max(frame)));
    last.saturating_sub(first)
}

/// How many frames' poses of a mesh with so many points are kept on a device: as many of the `wanted` as any window of
/// trajectories has, for no frame looks at more, if these fit into a quarter of its memory and into the largest buffer of
/// `limit` bytes; else as many as do, and at least the few that a frame is drawn from.
fn resident(wanted: u32, points: u32, memory: u64, limit: u64) -> u32 {
    let fits = (memory / 4).min(limit) / (12 * u64::from(points.max(1)));
    let fits = u32::try_from(fits).unwrap_or(u32::MAX);
    let window = 2 * FRAMES_BESIDE + 2;
    window.min(fits).min(wanted).max(4)
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
