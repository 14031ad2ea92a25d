//! A host's images of the outputs for temporal upscalers, and what is to be in them.

use ash::vk;
use celfx::host::{Host, TemporalFormats, TemporalImages};
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM};
use celfx::low_level::shaders::common::constants::LEAST_SHARE;
use celfx::view::{Projection, View};
use glam::{DVec2, DVec3};

use super::TestDevice;
use super::host::{self, DISCARDED, Place};

/// Whole floats: what is found is what the shaders wrote.
pub const FORMATS: TemporalFormats =
    TemporalFormats { motion: Some(vk::Format::R32G32_SFLOAT), reactive: Some(vk::Format::R32_SFLOAT) };

/// What the host has in the motion vectors' image where no effect writes.
pub const HOSTS: [f32; 2] = [7.0, -9.0];

/// Both images, in which a picture lies.
pub struct Outputs {
    pub place: Place,
    motion: Image,
    reactive: Image,
}

/// What is found in the picture, by pixel.
pub struct Found {
    pub motion: Vec<[f32; 2]>,
    pub reactive: Vec<f32>,
}

impl Outputs {
    pub fn new(device: &mut TestDevice, place: Place) -> Outputs {
        let mut image = |format: Option<vk::Format>| host::image(device, place.extent(), format.expect("a format"));
        Outputs { place, motion: image(FORMATS.motion), reactive: image(FORMATS.reactive) }
    }

    /// As an effect is given them, after [`Self::clear`].
    pub fn given(&self) -> TemporalImages {
        let given = |image, format: Option<vk::Format>| {
            Some(self.place.given(image, format.expect("a format"), CLEARED, COPIED_FROM))
        };
        TemporalImages {
            motion: given(&self.motion, FORMATS.motion),
            reactive: given(&self.reactive, FORMATS.reactive),
            previous: None,
        }
    }

    /// What the host draws before the effect: [`HOSTS`], and this share.
    ///
    /// # Safety
    /// As for [`host::barrier`].
    pub unsafe fn clear(&self, host: &Host, commands: vk::CommandBuffer, share: f32) {
        let values = [(&self.motion, [HOSTS[0], HOSTS[1], 0.0, 0.0]), (&self.reactive, [share; 4])];
        for (image, float32) in values {
            // SAFETY: the caller's.
            unsafe {
                host::change(host, commands, (image.handle, image.aspect), DISCARDED, CLEARED);
                let (value, range) = (vk::ClearColorValue { float32 }, host::whole(image.aspect));
                host.device.cmd_clear_color_image(commands, image.handle, CLEARED.layout, &value, &[range]);
            }
        }
    }

    /// What an effect has left; beside the picture stands what the host had there, which is asserted.
    pub fn found(&self, device: &mut TestDevice, share: f32) -> Found {
        let extent = self.place.extent();
        let (motion, beside) = self.place.parts(&host::read_image::<[f32; 2]>(device, &self.motion, extent));
        assert!(beside.iter().all(|vector| *vector == HOSTS), "motion vectors beside the picture");
        let (reactive, beside) = self.place.parts(&host::read_image::<f32>(device, &self.reactive, extent));
        assert!(beside.iter().all(|held| *held == share), "a mask beside the picture");
        Found { motion, reactive }
    }

    pub fn destroy(mut self, device: &mut TestDevice) {
        host::destroy(device, [], [&mut self.motion, &mut self.reactive]);
    }
}

impl Found {
    /// All of it.
    pub fn bits(&self) -> (Vec<[u32; 2]>, Vec<u32>) {
        let motion = self.motion.iter().map(|vector| vector.map(f32::to_bits));
        (motion.collect(), self.reactive.iter().map(|share| share.to_bits()).collect())
    }

    /// Asserts that what shows the effect to at least half, and nothing else, has a vector, and that the mask is the larger of its share and
    /// the host's.
    pub fn assert_where(&self, shares: &[f32], hosts: f32) {
        for (i, share) in shares.iter().enumerate() {
            assert_eq!(self.motion[i] != HOSTS, *share >= LEAST_SHARE, "a vector in pixel {i}, which shows {share}");
            assert_eq!(self.reactive[i], share.max(hosts), "the mask in pixel {i}");
        }
    }
}

/// The vector of a place that is `now` in this frame and was `before` in the one before, in pixels: a finite difference.
pub fn vector(views: [&View; 2], size: [u32; 2], before: DVec3, now: DVec3) -> DVec2 {
    let seen = |view: &View, place: DVec3| {
        let projection = Projection::of_valid(&View { jitter: [0.0; 2], ..*view }, size);
        projection.pixel_of(projection.to_view(place))
    };
    seen(views[0], before) - seen(views[1], now)
}

/// The place that a pixel of the picture shows at a view depth.
pub fn place_at(view: &View, size: [u32; 2], pixel: usize, depth: f64) -> DVec3 {
    let projection = Projection::of_valid(view, size);
    let [x, y] = [pixel as u32 % size[0], pixel as u32 / size[0]].map(f64::from);
    let [from, way] = projection.ray_at(DVec2::new(x, y) + 0.5);
    projection.eye + projection.axes.transpose() * (from + depth * way)
}

/// Largest distance of two vectors along an axis; infinite where one is NaN.
pub fn distance(found: [f32; 2], expected: DVec2) -> f64 {
    super::apart(found[0], expected.x).max(super::apart(found[1], expected.y))
}
