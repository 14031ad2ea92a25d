//! Description of the effect.

use ash::vk;

use crate::blur::frame::MeshSizes;
use crate::blur::mesh::Mesh;
use crate::blur::parts::PartSizes;
use crate::blur::settings::Settings;
use crate::error::{Error, Result};
use crate::host::{DepthFormat, HostBuffer, TemporalFormats, check_buffer};
use crate::layout::LOOP_BUDGET;
use crate::settings::Rule;
use crate::shaders::blur::constants::{BASE_MASK, MOST_SEGMENTS};

/// Triangles that refinement may make, unless a host says otherwise.
pub const MOST_TRIANGLES: u32 = 1_000_000;

/// The most buffers that positions are read from.
pub const MOST_SOURCES: usize = 8;

/// The largest `minStorageBufferOffsetAlignment` that a device may have.
const SOURCE_ALIGNMENT: u64 = 256;

/// A buffer in which the host's own skinning leaves positions: three `f32` a vertex, world position in metres, finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// The buffer, until the effect is changed or destroyed. Its offset is a multiple of 256, which is enough for every device. Usage:
    /// `STORAGE_BUFFER`.
    pub buffer: HostBuffer,
    /// `f32` from the beginning of a position to that of the next one, at least 3.
    pub stride: u32,
    /// Vertices.
    pub vertices: u32,
    /// Points of the mesh that come from here: the first of them follows the last of the source before.
    pub points: u32,
}

impl Source {
    fn validate(&self) -> Result<()> {
        Rule::new("", 3..=1 << 16).check("blur's source's stride", self.stride)?;
        if !self.buffer.offset.is_multiple_of(SOURCE_ALIGNMENT) {
            let allowed = format!(
                "a multiple of {SOURCE_ALIGNMENT}, from which on {} bytes are read; SkinnedInput::offsets may be any multiple of 4",
                self.bytes()
            );
            return Err(Error::setting("blur's source's offset", self.buffer.offset, allowed));
        }
        check_buffer("a source of blur's positions", &self.buffer, self.bytes())
    }

    /// From the first position to the end of the last.
    pub(super) fn bytes(&self) -> u64 {
        4 * (u64::from(self.stride) * u64::from(self.vertices.max(1) - 1) + 3)
    }
}

/// Description of a blur effect. All of it is fixed until `Effect::change` or `resize`.
#[derive(Clone, Debug)]
pub struct Desc {
    /// Pixels of the picture, each at least 1.
    pub size: [u32; 2],
    /// Format of the target and of the frames' images; one that can be a colour attachment, blended, sampled and copied
    /// both ways.
    pub target_format: vk::Format,
    /// Points of the mesh, at least 1.
    pub points: u32,
    /// Its triangles.
    pub triangles: u32,
    /// Entries of its lists of neighbours.
    pub neighbours: u32,
    /// Its surfaces: objects, by their materials.
    pub surfaces: u32,
    /// Its normal groups, and the entries of the lists of their triangles; not looked at unless `completion = "surface"`.
    pub groups: u32,
    /// As `groups`.
    pub group_triangles: u32,
    /// Rows of textures ([`crate::blur::texture_rows`]) that the mesh brings for frames that are drawn; 0: none.
    pub texture_rows: u32,
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
    /// Pieces that a trajectory may have in a frame, 1 to 32: [`Desc::segments_of`] the settings, also when these change, or more with
    /// `trajectory = "exact"`.
    pub segments: u32,
    /// Frames whose poses are kept on the device, at least 4 and, where the device makes trajectories ([`Knot`](crate::blur::Knot)), as many
    /// as these go through: 14 with `trajectory = "past"`, up to 26 else. A frame takes the place of the one that is so many before it.
    pub frames_resident: u32,
    /// Parts that the host names ([`crate::blur::Parts::sizes`]): what moves is then found on the device, and outputs bring poses
    /// and no more. None: outputs bring [`crate::blur::frame::ClusterInput`].
    pub parts: Option<PartSizes>,
    /// Buffers in which the host's own skinning leaves positions, read in place; at most [`MOST_SOURCES`], of points that follow each
    /// other. None: outputs bring [`crate::blur::frame::PoseInput`].
    pub sources: Vec<Source>,
    /// Same seed, same teeth.
    pub seed: u32,
    /// The look.
    pub settings: Settings,
    /// Whether every buffer that is a layer is kept for reading after the frame.
    pub layers: bool,
    /// Outputs for temporal upscalers.
    pub temporal: TemporalFormats,
}

impl Desc {
    /// For a mesh, pictures of `size` pixels and 32-bit floats, and every setting; four frames' poses, no layers, no depth,
    /// images of frames i and i + 1 only, no outputs for temporal upscalers. What is to be otherwise is set after.
    pub fn new(mesh: &Mesh, size: [u32; 2], settings: Settings) -> Desc {
        let triangles = mesh.triangles().len() as u32;
        Desc {
            size,
            target_format: vk::Format::R32G32B32A32_SFLOAT,
            points: mesh.points() as u32,
            triangles,
            neighbours: mesh.neighbours().items.len() as u32,
            surfaces: mesh.surfaces(),
            groups: mesh.group_triangles().starts.len() as u32 - 1,
            group_triangles: mesh.group_triangles().items.len() as u32,
            texture_rows: 0,
            outer: false,
            toon: false,
            depth: None,
            occluders: None,
            most_triangles: MOST_TRIANGLES.max(triangles),
            segments: Desc::segments_of(&settings),
            frames_resident: 4,
            parts: None,
            sources: Vec::new(),
            seed: 0,
            settings,
            layers: false,
            temporal: TemporalFormats::default(),
        }
    }

    /// What it has room for of a mesh.
    pub(super) fn sizes(&self) -> MeshSizes {
        let Desc { points, triangles, neighbours, surfaces, groups, group_triangles, .. } = *self;
        MeshSizes { points, triangles, neighbours, surfaces, groups, group_triangles }
    }

    /// Whether it was made for a mesh, or one with as many of everything.
    #[cfg(feature = "cli")]
    pub(crate) fn is_for(&self, mesh: &Mesh) -> bool {
        let own = Desc::new(mesh, self.size, Settings::default());
        own.sizes() == self.sizes()
    }

    /// The same for a mesh of these sizes.
    pub(super) fn sized(&self, sizes: &MeshSizes) -> Desc {
        let MeshSizes { points, triangles, neighbours, surfaces, groups, group_triangles } = *sizes;
        Desc { points, triangles, neighbours, surfaces, groups, group_triangles, ..self.clone() }
    }

    /// Pieces that splines need: one, and one for each frame that the effect reaches back over.
    pub fn segments_of(settings: &Settings) -> u32 {
        1 + settings.reach().ceil() as u32
    }

    /// Whether frames i - 1 and i + 2 are drawn: smears that are drawn themselves need nothing that these show.
    pub(super) fn draws_outer(&self) -> bool {
        self.toon && self.outer && !self.settings.toon.draws_smears()
    }

    /// Checks every value that does not depend on the device.
    pub(super) fn validate(&self) -> Result<()> {
        self.settings.validate()?;
        self.temporal.validate()?;
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
        if let Some(PartSizes { most_neighbours, .. }) = self.parts {
            check_seams(most_neighbours)?;
        }
        self.validate_sources()?;
        Rule::new("", 1..=MOST_SEGMENTS).check("blur's segments", self.segments)?;
        Rule::new("", 4..=1 << 24).check("blur's resident frames", self.frames_resident)
    }

    fn validate_sources(&self) -> Result<()> {
        self.sources.iter().try_for_each(Source::validate)?;
        let points: u64 = self.sources.iter().map(|source| u64::from(source.points)).sum();
        let fits = self.sources.is_empty() || points == u64::from(self.points);
        match fits && self.sources.len() <= MOST_SOURCES {
            true => Ok(()),
            false => {
                let given = format!("{} of {points} points", self.sources.len());
                let allowed = format!("at most {MOST_SOURCES}, of the mesh's {} points together", self.points);
                Err(Error::setting("blur's sources", given, allowed))
            }
        }
    }
}

/// Refuses seams with a point of so many neighbours.
pub(super) fn check_seams(most_neighbours: u32) -> Result<()> {
    if most_neighbours <= LOOP_BUDGET {
        return Ok(());
    }
    let (needed, limit) = (most_neighbours.into(), LOOP_BUDGET.into());
    let (what, advice) = ("neighbours of a point at a seam", "use a mesh with fewer points");
    Err(Error::Limit { what, needed, limit, advice })
}
