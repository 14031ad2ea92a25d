//! A host's description of one frame.

use crate::error::{Error, Result};
use crate::host::{Background, HostBuffer, HostImage, TemporalImages};
use crate::host::{check_background, check_beside, check_buffer, check_depth, check_target};
use crate::smoke::desc::Desc;
use crate::view::{FARTHEST, FireLight, Light, View};

/// How a frame follows the one recorded before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sequence {
    /// All particles are born anew.
    #[default]
    Restart,
    /// One frame later: particles move on.
    Advance,
    /// The same moment again: a frame later, all rests. It may be seen or lit otherwise.
    Hold,
    /// The frame recorded before once more, which it is a part of: seen through another view, as the other eye's, or lit otherwise. Motion
    /// vectors are that frame's, from [`TemporalImages::previous`], which it needs with them.
    Again,
}

/// A volume on the device, x fastest, then y, then z.
#[derive(Clone, Copy, Debug)]
pub struct VolumeInput {
    /// Voxels along x, y, z; at least 1 and at most what the effect was made for.
    pub dimensions: [u32; 3],
    /// Sides of a voxel in metres, at least 1e-12; along no axis all of them together above [`FARTHEST`].
    pub voxel_size: [f32; 3],
    /// World position of the corner of voxel (0, 0, 0), in metres, none beyond [`FARTHEST`].
    pub origin: [f32; 3],
    /// `f32` a voxel. Usage: `TRANSFER_SRC`.
    pub density: HostBuffer,
    /// Three `f32` a voxel (x, y, z; m/s). Usage: `TRANSFER_SRC`. Given exactly if the effect was made for velocities.
    pub velocity: Option<HostBuffer>,
}

/// One frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// How it follows the one before.
    pub sequence: Sequence,
    /// Seconds until the next frame, above 0, at most 1e6.
    pub dt: f32,
    /// What it is seen through.
    pub view: View,
    /// The light.
    pub light: Light,
    /// A fire that lights the smoke, too: with the smoke's own form, cut into as many steps as there are tones, and with coarse
    /// shadows, 16 samples of the way to it. [`crate::flame::fire_light`] makes one of a fire's particles.
    pub fire: Option<FireLight>,
    /// This frame's volume; none if it is the last one recorded. The first frame needs one.
    pub volume: Option<VolumeInput>,
    /// Where it goes; none only moves the particles on. Usage: `COLOR_ATTACHMENT`, and `TRANSFER_DST` for a background that is an image.
    pub target: Option<HostImage>,
    /// The background.
    pub background: Background,
    /// The depth of what the host has drawn through `view`: it occludes smoke, and takes the smoke's. Given exactly if the effect was
    /// made for one and there is a target. Usage: `DEPTH_STENCIL_ATTACHMENT`.
    pub depth: Option<HostImage>,
    /// Partial coverage that is not in `depth`: the edges of a blurred mesh, as `Blur::edges`. Smoke
    /// behind is blended with it. 16 bytes a pixel: linear RGB, premultiplied by the share that is covered, and that
    /// share, as halves; view depth in metres, `f32`; 4 unused bytes. Usage: `TRANSFER_SRC`.
    pub edges: Option<HostBuffer>,
    /// Outputs for temporal upscalers; none without a target. What a pixel shows has moved with its sphere.
    pub temporal: TemporalImages,
}

/// Shape and place of a volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shape {
    /// Voxels along x, y, z.
    pub dimensions: [u32; 3],
    /// Sides of a voxel in metres.
    pub voxel_size: [f32; 3],
    /// Corner of voxel (0, 0, 0) in metres.
    pub origin: [f32; 3],
}

impl Shape {
    /// Number of voxels.
    pub fn voxels(&self) -> u64 {
        self.dimensions.iter().map(|n| u64::from(*n)).product()
    }

    /// Whether voxels are cubes.
    pub fn is_cubic(&self) -> bool {
        self.voxel_size[1] == self.voxel_size[0] && self.voxel_size[2] == self.voxel_size[0]
    }
}

impl VolumeInput {
    /// Its shape.
    pub fn shape(&self) -> Shape {
        Shape { dimensions: self.dimensions, voxel_size: self.voxel_size, origin: self.origin }
    }

    pub(crate) fn validate(&self, desc: &Desc) -> Result<()> {
        let refuse = |why: String| Err(Error::HostResource { name: "volume", why });
        let Shape { dimensions, voxel_size, origin } = self.shape();
        if (0..3).any(|a| dimensions[a] == 0 || dimensions[a] > desc.dimensions[a]) {
            return refuse(format!("{dimensions:?} voxels; the effect was made for 1 to {:?}", desc.dimensions));
        }
        // Each by itself: the larger of a number and none is the number.
        let is_near = |a: usize| origin[a].abs() <= FARTHEST && voxel_size[a] * dimensions[a] as f32 <= FARTHEST;
        if !voxel_size.iter().all(|h| *h >= 1e-12) || !(0..3).all(is_near) {
            return refuse(format!(
                "voxel size {voxel_size:?} m, origin {origin:?} m; sizes must be at least 1e-12, nothing beyond 1e12"
            ));
        }
        if self.velocity.is_some() != desc.velocity {
            let is = if desc.velocity { "missing" } else { "given" };
            return refuse(format!("velocities are {is}; the effect was made with velocity = {}", desc.velocity));
        }
        let bytes = 4 * self.shape().voxels();
        if self.density.size < bytes || self.velocity.is_some_and(|v| v.size < 3 * bytes) {
            return refuse(format!("its buffers are smaller than {} voxels need", self.shape().voxels()));
        }
        Ok(())
    }
}

impl Frame {
    /// A first frame, at 24 a second and under the default light, over what the target holds. What is to be otherwise is set after.
    pub fn new(view: View, volume: VolumeInput, target: HostImage) -> Frame {
        Frame {
            sequence: Sequence::Restart,
            dt: 1.0 / 24.0,
            view,
            light: Light::default(),
            fire: None,
            volume: Some(volume),
            target: Some(target),
            background: Background::Keep,
            depth: None,
            edges: None,
            temporal: TemporalImages::default(),
        }
    }

    pub(crate) fn validate(&self, desc: &Desc, first: bool) -> Result<()> {
        self.view.validate()?;
        self.light.validate()?;
        let point = matches!(self.light.source, crate::view::LightSource::Position(_));
        if point != desc.point_light {
            let is = if point { "a point light" } else { "a direction" };
            let why = format!("{is}; the effect was made with point_light = {}", desc.point_light);
            return Err(Error::HostResource { name: "light", why });
        }
        for (is_there, may_be, name) in
            [(self.light.rim > 0.0, desc.rim, "rim"), (self.light.second.is_some(), desc.second_light, "second_light")]
        {
            if is_there && !may_be {
                let why = format!("has one more; the effect was made with {name} = false");
                return Err(Error::HostResource { name: "light", why });
            }
        }
        if let Some(fire) = &self.fire {
            fire.validate()?;
            if !desc.fire_light {
                let why = "given; the effect was made with fire_light = false".to_owned();
                return Err(Error::HostResource { name: "fire", why });
            }
        }
        if !(self.dt > 0.0 && self.dt <= 1e6) {
            return Err(Error::setting("frame.dt", self.dt, "seconds, above 0, at most 1e6"));
        }
        match &self.volume {
            Some(volume) => volume.validate(desc)?,
            None if first => {
                let why = "the first frame needs one".to_owned();
                return Err(Error::HostResource { name: "volume", why });
            }
            None => {}
        }
        if first && self.sequence != Sequence::Restart {
            return Err(Error::setting("frame.sequence", format!("{:?}", self.sequence), "Restart in the first frame"));
        }
        if self.target.is_some() {
            if self.edges.is_some() && !desc.edges {
                let why = "given; the effect was made with edges = false".to_owned();
                return Err(Error::HostResource { name: "edges", why });
            }
            check_depth("depth", self.depth.as_ref().map(|depth| (depth, &self.view)), desc.size, desc.depth)?;
        }
        let pixels = u64::from(desc.size[0]) * u64::from(desc.size[1]);
        if let Some(edges) = &self.edges {
            check_buffer("edges", edges, 16 * pixels)?;
        }
        match &self.target {
            Some(target) => {
                check_beside(self.depth.as_ref(), target)?;
                check_target(target, &self.background, desc.size, desc.target_format)?;
                let background = self.background.image();
                let others = [self.depth.as_ref(), background.as_ref()];
                self.temporal.check(&desc.temporal, desc.size, target, &others)
            }
            None => {
                self.temporal.check_none()?;
                check_background(&self.background, desc.size, desc.target_format)
            }
        }
    }
}
