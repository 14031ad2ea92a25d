//! Description of the effect.

use ash::vk;

use crate::blur::mesh::Mesh;
use crate::blur::settings::Settings;
use crate::error::{Error, Result};
use crate::host::DepthFormat;
use crate::settings::Rule;
use crate::shaders::blur::constants::{BASE_MASK, MOST_SEGMENTS};

/// Triangles that refinement may make, unless a host says otherwise.
pub const MOST_TRIANGLES: u32 = 1_000_000;

/// Description of a blur effect. All of it is fixed until `resize`.
#[derive(Clone, Debug)]
pub struct Desc {
    /// Pixels of the picture, each at least 1.
    pub size: [u32; 2],
    /// Format of the target and of the frames' images; one that can be a colour attachment and be sampled.
    pub target_format: vk::Format,
    /// Points of the mesh, at least 1.
    pub points: u32,
    /// Its triangles.
    pub triangles: u32,
    /// Entries of its lists of neighbours.
    pub neighbours: u32,
    /// Its objects.
    pub objects: u32,
    /// Its normal groups, and the entries of the lists of their triangles; not looked at unless `completion = "surface"`.
    pub groups: u32,
    /// As `groups`.
    pub group_triangles: u32,
    /// Whether frames may bring images of frames i - 1 and i + 2, or these are drawn, too.
    pub outer: bool,
    /// Whether there may be outputs without images, whose frames are drawn; needs normal groups and base colours.
    pub toon: bool,
    /// How the host's depth images hold depth, if they are to hide the mesh and to take its depth.
    pub depth: Option<DepthFormat>,
    /// How depth images of frames i - 1 to i + 2 hold depth, if frames bring them beside their images: what hides the mesh there
    /// is not taken for it.
    pub occluders: Option<DepthFormat>,
    /// Triangles that refinement may make, at least `triangles`; fewer are made where the device has no room for as many.
    /// Usually [`MOST_TRIANGLES`].
    pub most_triangles: u32,
    /// Pieces that a trajectory may have in a frame, 1 to 32: [`Desc::segments_of`], or more with `trajectory = "exact"`.
    pub segments: u32,
    /// Frames whose poses are kept on the device, at least 4 and as many as a window of trajectories has; a frame takes
    /// the place of the one that is so many before it.
    pub frames_resident: u32,
    /// Same seed, same teeth.
    pub seed: u32,
    /// The look.
    pub settings: Settings,
    /// Whether every buffer that is a layer is kept for reading after the frame.
    pub layers: bool,
}

impl Desc {
    /// For a mesh, pictures of `size` pixels and 32-bit floats, and every setting; four frames' poses, no layers, no depth,
    /// images of frames i and i + 1 only. What is to be otherwise is set after.
    pub fn new(mesh: &Mesh, size: [u32; 2], settings: Settings) -> Desc {
        let triangles = mesh.triangles().len() as u32;
        Desc {
            size,
            target_format: vk::Format::R32G32B32A32_SFLOAT,
            points: mesh.points() as u32,
            triangles,
            neighbours: mesh.neighbours().items.len() as u32,
            objects: mesh.objects().len() as u32,
            groups: mesh.group_triangles().starts.len() as u32 - 1,
            group_triangles: mesh.group_triangles().items.len() as u32,
            outer: false,
            toon: false,
            depth: None,
            occluders: None,
            most_triangles: MOST_TRIANGLES.max(triangles),
            segments: Desc::segments_of(&settings),
            frames_resident: 4,
            seed: 0,
            settings,
            layers: false,
        }
    }

    /// Pieces that splines need: one, and one for each frame that the effect reaches back over.
    pub fn segments_of(settings: &Settings) -> u32 {
        1 + settings.reach().ceil() as u32
    }

    /// Checks every value that does not depend on the device.
    pub(super) fn validate(&self) -> Result<()> {
        self.settings.validate()?;
        if self.size.contains(&0) {
            return Err(Error::setting("size", format!("{:?}", self.size), "at least 1 pixel a side"));
        }
        if self.points == 0 {
            return Err(Error::setting("blur's points", 0, "at least 1"));
        }
        if self.triangles > self.most_triangles || self.most_triangles > BASE_MASK {
            let allowed = format!("from the mesh's own {} to {BASE_MASK}", self.triangles);
            return Err(Error::setting("blur's triangles", self.most_triangles, allowed));
        }
        if self.toon && self.groups == 0 {
            return Err(Error::setting("blur's normal groups", 0, "at least 1 where frames are drawn"));
        }
        Rule::new("", 1..=MOST_SEGMENTS).check("blur's segments", self.segments)?;
        Rule::new("", 4..=1 << 24).check("blur's resident frames", self.frames_resident)
    }
}
