//! Which buffers and images the effect has, and how large they are. Pure.

use crate::blur::limits::{DRAWN_PLACES, MOST_KNOTS, MOST_LINES, MOST_LISTED, MOST_TABLES};
use ash::vk;

use crate::blur::desc::{Desc, MOST_SOURCES};
use crate::blur::motion::most_bounds;
use crate::blur::parts::PartSizes;
use crate::blur::settings::{Completion, Extent};
use crate::effect::{DeviceTraits, Inventory};
use crate::error::{Error, Result};
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::scratch::{Lifetime, Overlay};
use crate::host::{HostBuffer, TemporalFormats};
use crate::layout::{MOST_GROUPS, Sizes, buffers};
use crate::plan::{Binding, BufferId, ImageId, Resource};
use crate::shaders::blur as glsl;
use crate::shaders::blur::blocks::{
    BlurParams, Chunk, Cluster, Control, Covering, Knot, PartRow, Piece, PointMotion, Round, Site, ToonParams, Trail,
    Vertex,
};
use crate::shaders::blur::constants::{
    BIN_FIELDS, BINS, BLOCK, DIRECTIONS, DISPATCHES, FEW_TRIANGLES, FRONTS_A_WORD, MOST_FEW, MOST_FIRST, MOST_ROWS,
    MOST_SITES, ROUNDS, STARTS, SURFACES, TILE, TILE_DISPATCHES, TILE_FLAGS, TONE_ROWS,
};

buffers! {
    "blur"
    PARAMS = "BlurParams",
    CONTROL = "ControlBuffer": Kept,
    ROUND_LIST = "Rounds",
    KNOTS = "Knots",
    POSES = "Poses": Sequence,
    TRIANGLES = "Triangles": Sequence,
    NEIGHBOUR_STARTS = "NeighbourStarts": Sequence,
    NEIGHBOURS = "Neighbours": Sequence,
    SHARES = "Shares": Sequence,
    MOTIONS = "Motions": Layer,
    LABELS = "Labels": Layer,
    CLUSTERS = "Clusters": Layer,
    BOUNDS = "Bounds",
    SEAMS = "Seams": Sequence,
    FRONTS = "Fronts",
    SMOOTH = "Smooth",
    CLIP = "Clip",
    SPLINES = "Splines",
    VERTICES = "Vertices": Layer,
    ACTIVE = "Active",
    NEXT = "Next",
    FINISHED = "Finished": Layer,
    PART_SUMS = "PartSums",
    TOON_BUFFER = "ToonBuffer": Sequence,
    TRAILING = "Trailing",
    PREVIOUS_NAMES = "PreviousNames": Layer,
    NEXT_NAMES = "NextNames": Layer,
    DISTORTED_NAMES = "DistortedNames": Layer,
    PICTURE = "Picture": Layer,
    COLOUR_LAYER = "ColourLayer": Layer,
    PREVIOUS_LAYER = "PreviousLayer": Layer,
    NEXT_LAYER = "NextLayer": Layer,
    SUBFRAME_LAYER = "SubframeLayer": Layer,
    MASK_LAYER = "MaskLayer": Layer,
    OBJECT_LAYER = "ObjectLayer": Layer,
    LINES = "Lines",
    CORNER_GROUPS = "CornerGroups": Sequence,
    GROUP_STARTS = "GroupStarts": Sequence,
    GROUP_TRIANGLES = "GroupTriangles": Sequence,
    NORMALS = "Normals",
    LARGE_GROUPS = "LargeGroups",
    TILES = "Tiles",
    COMPLETING = "Completing",
    SUMS = "Sums",
    TABLES = "Tables",
    SITES = "Sites",
    LIGHTS = "Lights",
    SAMPLE_COLOURS = "SampleColours",
    SAMPLE_STATES = "SampleStates",
    SAMPLE_SIDES = "SampleSides",
    LISTS = "Lists",
    SURFACE = "Surface": Kept,
    SCENE_WORDS = "SceneWords",
    SOURCE_ROWS = "SourceRows": Sequence,
    PART_LABELS = "PartLabels": Sequence,
    PART_MEMBERS = "PartMembers": Sequence,
    PART_CHUNKS = "PartChunks": Sequence,
    PART_ROWS = "PartRows": Sequence,
    CHUNK_SUMS = "ChunkSums",
    CHUNK_FARTHEST = "ChunkFarthest",
    SUPPORT_VALUES = "SupportValues",
    SUPPORT_POINTS = "SupportPoints",
    ROW_VALUES = "RowValues",
}

/// Words before the flags of tiles: their number, and dispatches over them.
pub const TILE_WORDS: usize = TILE_FLAGS as usize;
/// Words before the list of large groups: dispatch over them.
pub const LARGE_WORDS: usize = 4;
/// Words of what completion works on, before those of each surface.
pub const COMPLETING_WORDS: usize = SURFACES as usize;
/// Bytes of a table of colours, and of the sums that it is made from.
const TABLE_BYTES: u64 = 16 * BINS as u64;
const SUM_BYTES: u64 = 4 * (BIN_FIELDS * BINS) as u64;
/// Layers: triangle-id buffers, ids from 1, 0 where a pixel sees none. Of the mesh in frames i and i + 1, and of the
/// refined one.
pub const NAME_LAYERS: [BufferId; 3] = [PREVIOUS_NAMES, NEXT_NAMES, DISTORTED_NAMES];
/// The host's topology: triangles, where lists of neighbours begin, neighbours.
pub const HOST_TOPOLOGY: [BufferId; 3] = [BufferId(BUFFERS), BufferId(BUFFERS + 1), BufferId(BUFFERS + 2)];
/// The host's poses.
pub const HOST_POSES: BufferId = BufferId(BUFFERS + 3);
/// The host's interval: motion, labels, clusters, hulls, seams, fronts, pieces.
pub const HOST_INTERVAL: [BufferId; 7] = [
    BufferId(BUFFERS + 4),
    BufferId(BUFFERS + 5),
    BufferId(BUFFERS + 6),
    BufferId(BUFFERS + 7),
    BufferId(BUFFERS + 8),
    BufferId(BUFFERS + 9),
    BufferId(BUFFERS + 10),
];
/// The host's normal groups: of each corner, where lists of their triangles begin, triangles.
pub const HOST_GROUPS: [BufferId; 3] = [BufferId(BUFFERS + 11), BufferId(BUFFERS + 12), BufferId(BUFFERS + 13)];
/// The host's base colours.
pub const HOST_COLOURS: BufferId = BufferId(BUFFERS + 14);
/// The host's parts: labels, members, chunks, rows, points near seams.
pub const HOST_PARTS: [BufferId; 5] = [
    BufferId(BUFFERS + 15),
    BufferId(BUFFERS + 16),
    BufferId(BUFFERS + 17),
    BufferId(BUFFERS + 18),
    BufferId(BUFFERS + 19),
];
/// The host's rows of points in its sources.
pub const HOST_SOURCE_ROWS: BufferId = BufferId(BUFFERS + 20);
/// The host's shares of strength.
pub const HOST_SHARES: BufferId = BufferId(BUFFERS + 21);
/// The host's textures.
pub const HOST_TEXTURES: BufferId = BufferId(BUFFERS + 22);
/// The first of the host's sources.
const FIRST_SOURCE: u16 = BUFFERS + 23;
/// Buffers of the host's.
pub const HOST_BUFFERS: usize = 23 + MOST_SOURCES;

/// A source of the host's.
pub fn host_source(number: usize) -> BufferId {
    BufferId(FIRST_SOURCE + number as u16)
}

/// Where in [`TOON_BUFFER`] the base colours begin.
pub const BASE_COLOURS: u64 = size_of::<ToonParams>() as u64;

/// Triangle-id buffers of frames i and i + 1.
pub const SEEN: [ImageId; 2] = [ImageId(0), ImageId(1)];
/// Their depth.
pub const SEEN_DEPTH: [ImageId; 2] = [ImageId(2), ImageId(3)];
/// Which refined triangle each pixel sees.
pub const DISTORTED: ImageId = ImageId(4);
/// Its depth.
pub const DISTORTED_DEPTH: ImageId = ImageId(5);
/// Which refined triangle each of a pixel's four samples sees.
pub const SAMPLED: ImageId = ImageId(6);
/// Their depth.
pub const SAMPLED_DEPTH: ImageId = ImageId(7);
/// The host's images of frames i and i + 1, as shaders see them.
pub const FRAMES: [ImageId; 2] = [ImageId(8), ImageId(9)];
/// Triangle-id buffers of frames i - 1 and i + 2.
pub const OUTER_SEEN: [ImageId; 2] = [ImageId(10), ImageId(11)];
/// Their depth.
pub const OUTER_DEPTH: [ImageId; 2] = [ImageId(12), ImageId(13)];
/// The host's images of these, as shaders see them.
pub const OUTER_FRAMES: [ImageId; 2] = [ImageId(14), ImageId(15)];
/// Frames that are drawn because the host has no images of them: frame f stands in place f modulo their number.
/// Only two are used where frames i - 1 and i + 2 are not.
pub const TOON: [ImageId; DRAWN_PLACES] = [ImageId(16), ImageId(17), ImageId(18), ImageId(19)];
/// An after-image, at four samples a pixel.
pub const GHOST: ImageId = ImageId(20);
/// Its format.
pub const GHOST_FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
/// Its depth.
pub const GHOST_DEPTH: ImageId = ImageId(21);
/// The host's background, as shaders see it.
pub const BACKGROUND: ImageId = ImageId(22);
/// Own images.
pub const IMAGES: u16 = 23;
/// The host's target.
pub const TARGET: ImageId = ImageId(IMAGES);
/// The host's images of frames i and i + 1.
pub const HOST_FRAMES: [ImageId; 2] = [ImageId(IMAGES + 1), ImageId(IMAGES + 2)];
/// The host's images of frames i - 1 and i + 2.
pub const HOST_OUTER: [ImageId; 2] = [ImageId(IMAGES + 3), ImageId(IMAGES + 4)];
/// The host's depth.
pub const HOST_DEPTH: ImageId = ImageId(IMAGES + 5);
/// The host's background.
pub const HOST_BACKGROUND: ImageId = ImageId(IMAGES + 6);
/// The host's depth images of frames i - 1 to i + 2.
pub const HOST_SCENES: [ImageId; 4] =
    [ImageId(IMAGES + 7), ImageId(IMAGES + 8), ImageId(IMAGES + 9), ImageId(IMAGES + 10)];
/// The host's motion vectors.
pub const MOTION: ImageId = ImageId(IMAGES + 11);
/// The host's reactive mask.
pub const REACTIVE: ImageId = ImageId(IMAGES + 12);
/// Images of the host's.
pub const HOST_IMAGES: usize = 13;

/// The resource of a shader's binding: each buffer and image goes by one name everywhere.
pub fn resource(binding: &Binding) -> Option<Resource> {
    let image = match binding.name {
        "seen_previous" => Some(SEEN[0]),
        "seen_next" => Some(SEEN[1]),
        "distorted" => Some(DISTORTED),
        "sampled" => Some(SAMPLED),
        "ghost" => Some(GHOST),
        "ghost_depth" => Some(GHOST_DEPTH),
        "depth_previous" => Some(SEEN_DEPTH[0]),
        "depth_next" => Some(SEEN_DEPTH[1]),
        "frame_previous" => Some(FRAMES[0]),
        "frame_next" => Some(FRAMES[1]),
        "distorted_depth" => Some(DISTORTED_DEPTH),
        "sampled_depth" => Some(SAMPLED_DEPTH),
        "seen_before" => Some(OUTER_SEEN[0]),
        "seen_after" => Some(OUTER_SEEN[1]),
        "depth_before" => Some(OUTER_DEPTH[0]),
        "depth_after" => Some(OUTER_DEPTH[1]),
        "frame_before" => Some(OUTER_FRAMES[0]),
        "frame_after" => Some(OUTER_FRAMES[1]),
        "background_image" => Some(BACKGROUND),
        _ => None,
    };
    let buffer = BLOCKS.iter().position(|name| *name == binding.name).map(|index| BufferId(index as u16));
    image.map(Resource::Image).or(buffer.map(Resource::Buffer))
}

/// Where in [`TILES`] a dispatch of one, two (1) or four (2) workgroups a tile stands, in words.
pub fn tile_dispatch(kind: usize) -> usize {
    debug_assert!(kind < DISPATCHES as usize);
    TILE_DISPATCHES as usize + 4 * kind
}

/// The most points that one dispatch can have.
fn points_dispatched() -> u64 {
    MOST_GROUPS * u64::from(glsl::project::SHADER.local_size[0])
}

/// Surfaces whose colours are learnt.
fn tables(desc: &Desc, limit: u64) -> u32 {
    let room = (limit / (2 * SUM_BYTES)).min(MOST_TABLES.into()) as u32;
    if desc.settings.completion == Completion::Surface { desc.surfaces.min(room) } else { 0 }
}

/// Samples that may have to be filled from their neighbours: with the paper's way all, else the few that nothing shows.
fn listed(desc: &Desc) -> u64 {
    let pixels = u64::from(desc.size[0]) * u64::from(desc.size[1]);
    let samples = if desc.settings.completion == Completion::Gradient { 4 * pixels } else { pixels };
    samples.min(MOST_LISTED)
}

/// Sizes of everything, from what the effect is made for.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Triangles that there may be.
    pub triangles: u32,
    /// Vertices that there is room for: the mesh's points, and one for each triangle that refinement adds.
    pub vertices: u32,
    /// Surfaces whose colours completion learns.
    pub tables: u32,
    /// Samples that there is room for in each list of completion.
    pub listed: u32,
    sizes: Sizes<{ BUFFERS as usize }>,
}

impl Layout {
    /// Computes it; fails where a buffer is larger than `limit` bytes, the largest range that a shader can bind.
    pub fn new(desc: &Desc, traits: &DeviceTraits) -> Result<Layout> {
        let limit = traits.storage_range;
        let vertex = u64::from(desc.segments) * size_of::<Piece>() as u64;
        let room = (limit / vertex.max(size_of::<Vertex>() as u64)).min(points_dispatched());
        let added = u64::from(desc.most_triangles - desc.triangles).min(room.saturating_sub(desc.points.into()));
        // Lists of triangles are bound, too, and dispatched over.
        let added = added.min((limit / 16).min(MOST_GROUPS * u64::from(BLOCK)).saturating_sub(desc.triangles.into()));
        let mut layout = Layout {
            triangles: desc.triangles + added as u32,
            vertices: desc.points + added as u32,
            tables: tables(desc, limit),
            listed: (listed(desc).min(limit / 16)) as u32,
            sizes: Sizes::LEAST,
        };
        layout.size_buffers(desc);
        layout.check(desc, limit)?;
        Ok(layout)
    }

    /// Whether anything needs the mesh's normals.
    pub fn has_normals(&self, desc: &Desc) -> bool {
        desc.toon || self.tables > 0
    }

    fn set(&mut self, id: BufferId, bytes: u64) {
        self.sizes.set(id, bytes);
    }

    /// Bytes of a buffer.
    pub fn size(&self, id: BufferId) -> u64 {
        self.sizes.get(id)
    }

    fn size_buffers(&mut self, desc: &Desc) {
        let (points, triangles) = (u64::from(desc.points), u64::from(self.triangles));
        let vertices = u64::from(self.vertices);
        self.set(PARAMS, size_of::<BlurParams>() as u64);
        self.set(CONTROL, size_of::<Control>() as u64);
        self.set(ROUND_LIST, u64::from(ROUNDS + 1) * size_of::<Round>() as u64);
        self.set(KNOTS, (MOST_KNOTS * size_of::<Knot>()) as u64);
        self.set(POSES, 12 * points * u64::from(desc.frames_resident));
        self.set(TRIANGLES, 16 * u64::from(desc.triangles));
        self.set(NEIGHBOUR_STARTS, 4 * (points + 1));
        self.set(NEIGHBOURS, 4 * u64::from(desc.neighbours));
        self.set(SHARES, 4 * points);
        self.set(MOTIONS, size_of::<PointMotion>() as u64 * points);
        self.set(LABELS, 4 * points);
        self.set(CLUSTERS, size_of::<Cluster>() as u64 * points);
        self.set(BOUNDS, 8 * most_bounds(desc.points));
        self.set(SEAMS, 4 * points);
        self.set(FRONTS, 4 * u64::from(desc.triangles.div_ceil(FRONTS_A_WORD)));
        self.set(SMOOTH, 8 * points);
        self.set(CLIP, 4 * 16 * points);
        self.set(SPLINES, vertices * u64::from(desc.segments) * size_of::<Piece>() as u64);
        self.set(VERTICES, vertices * size_of::<Vertex>() as u64);
        self.set(ACTIVE, triangles * 16);
        self.set(NEXT, triangles * 16);
        self.set(FINISHED, triangles * 16);
        let pixels = u64::from(desc.size[0]) * u64::from(desc.size[1]);
        let kept = |bytes: u64| if desc.layers { bytes * pixels } else { 0 };
        for id in NAME_LAYERS.into_iter().chain([SUBFRAME_LAYER, MASK_LAYER]) {
            self.set(id, kept(4));
        }
        for id in [COLOUR_LAYER, PREVIOUS_LAYER, NEXT_LAYER, OBJECT_LAYER] {
            self.set(id, kept(16));
        }
        self.set(PICTURE, 16 * pixels);
        self.set(SURFACE, if desc.depth.is_some() { size_of::<Covering>() as u64 * pixels } else { 0 });
        self.set(SCENE_WORDS, if desc.occluders.is_some() { 4 * pixels } else { 0 });
        let rows = 3 * u64::from(desc.triangles) + u64::from(desc.texture_rows);
        self.set(TOON_BUFFER, if desc.toon { BASE_COLOURS + 16 * rows } else { 0 });
        self.set(
            TRAILING,
            if desc.settings.lines.are_on() { size_of::<Trail>() as u64 * u64::from(MOST_LINES) } else { 0 },
        );
        // Four samples a pixel.
        self.set(LINES, if desc.toon { 16 * pixels } else { 0 });
        self.set(PART_SUMS, triangles.div_ceil(BLOCK.into()) * 8);
        self.size_completion(desc, pixels);
        self.size_parts(desc);
    }

    fn size_parts(&mut self, desc: &Desc) {
        let points = u64::from(desc.points);
        self.set(SOURCE_ROWS, if desc.sources.is_empty() { 0 } else { 4 * points });
        let Some(PartSizes { parts, chunks, .. }) = desc.parts else { return };
        let (parts, chunks, directions) = (u64::from(parts), u64::from(chunks), u64::from(DIRECTIONS));
        self.set(PART_LABELS, 4 * points);
        self.set(PART_MEMBERS, 4 * points);
        self.set(PART_CHUNKS, size_of::<Chunk>() as u64 * chunks);
        self.set(PART_ROWS, size_of::<PartRow>() as u64 * parts);
        self.set(CHUNK_SUMS, 16 * chunks);
        self.set(CHUNK_FARTHEST, 8 * directions * chunks);
        self.set(SUPPORT_VALUES, 4 * directions * parts);
        self.set(SUPPORT_POINTS, 4 * directions * parts);
        self.set(ROW_VALUES, if desc.settings.extent == Extent::Row { 8 * u64::from(MOST_ROWS) * parts } else { 0 });
        self.set(BOUNDS, 8 * directions * parts);
    }

    fn size_completion(&mut self, desc: &Desc, pixels: u64) {
        let tables = u64::from(self.tables);
        if self.has_normals(desc) {
            self.set(CORNER_GROUPS, 16 * u64::from(desc.triangles));
            self.set(GROUP_STARTS, 4 * (u64::from(desc.groups) + 1));
            self.set(GROUP_TRIANGLES, 4 * u64::from(desc.group_triangles));
            let frames = if desc.draws_outer() { 4 } else { 2 };
            self.set(NORMALS, frames * 16 * u64::from(desc.groups));
            let most_large = u64::from(desc.group_triangles / (FEW_TRIANGLES + 1));
            self.set(LARGE_GROUPS, 4 * (LARGE_WORDS as u64 + most_large));
        }
        let tiles = desc.size.map(|side| u64::from(side.div_ceil(TILE)));
        self.set(TILES, 4 * (TILE_WORDS as u64 + 2 * tiles[0] * tiles[1] + pixels));
        self.set(COMPLETING, 4 * COMPLETING_WORDS as u64 + 8 * tables);
        self.set(SUMS, 2 * SUM_BYTES * tables);
        // Behind the tables, the light's directions and tones: of all and of each surface.
        let tones = if tables > 0 { 16 * u64::from(TONE_ROWS) * (1 + tables) } else { 0 };
        self.set(TABLES, 2 * TABLE_BYTES * tables + tones);
        let sites = u64::from(MOST_SITES + MOST_FEW + MOST_FIRST) * size_of::<Site>() as u64;
        self.set(SITES, if tables > 0 { sites } else { 0 });
        self.set(LIGHTS, if tables > 0 { 2 * 2 * 16 * u64::from(STARTS) } else { 0 });
        self.set(SAMPLE_COLOURS, 4 * 16 * pixels);
        self.set(SAMPLE_STATES, 4 * 4 * pixels);
        let is_gradient = desc.settings.completion == Completion::Gradient;
        self.set(SAMPLE_SIDES, if is_gradient { 4 * 16 * pixels } else { 0 });
        self.set(LISTS, 4 * 4 * u64::from(self.listed));
    }

    fn check(&self, desc: &Desc, limit: u64) -> Result<()> {
        let advice = |id: BufferId| match id {
            POSES => "keep fewer frames on the device",
            CORNER_GROUPS | GROUP_STARTS | GROUP_TRIANGLES | NORMALS => "use a smaller mesh",
            id if id >= PREVIOUS_NAMES => "render a smaller picture",
            _ => "use a smaller mesh",
        };
        self.sizes.check(limit, &NAMES, advice)?;
        for (what, needed, limit) in [
            ("blur's points", desc.points, points_dispatched()),
            ("blur's triangles", desc.triangles, MOST_GROUPS * u64::from(glsl::begin::SHADER.local_size[0])),
            ("blur's parts", desc.parts.map_or(0, |parts| parts.parts.max(parts.chunks)), MOST_GROUPS),
            ("blur's normals", desc.groups, MOST_GROUPS * u64::from(glsl::normals::SHADER.local_size[0])),
        ] {
            if u64::from(needed) > limit {
                return Err(Error::Limit { what, needed: needed.into(), limit, advice: "use a smaller mesh" });
            }
        }
        Ok(())
    }
}

impl Inventory for Layout {
    type Desc = Desc;
    const HOST_BUFFERS: usize = HOST_BUFFERS;
    const HOST_IMAGES: usize = HOST_IMAGES;

    fn buffers(&self, desc: &Desc) -> Vec<BufferDesc> {
        self.sizes.descriptions(&NAMES, [PARAMS], desc.layers).collect()
    }

    /// Layers, and lines and after-images behind the mesh, look at all of it once more.
    fn overlays(&self, desc: &Desc) -> Vec<Overlay> {
        // Motion vectors, after-images and lines come last, and go back to the trajectories.
        if desc.layers || desc.settings.draws_behind() || desc.temporal != TemporalFormats::default() {
            return Vec::new();
        }
        let of_frames = Some(LINES).filter(|_| !(desc.toon && desc.settings.toon.inks_smears()));
        let refinement = [SPLINES, ACTIVE, NEXT].into_iter().chain(of_frames).map(Resource::Buffer).collect();
        let samples = vec![vec![SAMPLED.into()], vec![LISTS.into()], vec![PICTURE.into()]];
        vec![vec![refinement, vec![SAMPLE_COLOURS.into()]], samples]
    }

    fn images(&self, desc: &Desc) -> Vec<ImageDesc> {
        let seen = ImageDesc {
            name: "blur seen",
            extent: desc.size,
            layers: 1,
            array_view: false,
            format: vk::Format::R32_UINT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
            lifetime: Lifetime::Scratch,
        };
        let (format, usage) =
            (vk::Format::D32_SFLOAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED);
        let depth = ImageDesc { name: "blur seen depth", format, usage, ..seen };
        let extent = desc.size.map(|side| 2 * side);
        let frame = ImageDesc {
            name: "blur earlier frame",
            format: desc.target_format,
            usage: vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::SAMPLED,
            ..seen
        };
        let drawn = ImageDesc {
            name: "blur drawn frame",
            extent: if desc.toon { desc.size } else { [1; 2] },
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT
                | vk::ImageUsageFlags::TRANSFER_SRC
                | vk::ImageUsageFlags::SAMPLED,
            lifetime: Lifetime::Kept,
            ..frame
        };
        let outer_drawn = ImageDesc { extent: if desc.draws_outer() { drawn.extent } else { [1; 2] }, ..drawn };
        let ghost = ImageDesc {
            name: "blur ghost",
            extent: if desc.settings.ghosts.are_on() { extent } else { [1; 2] },
            format: GHOST_FORMAT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
            ..seen
        };
        // What no frame brings is never drawn.
        let outside = if desc.outer { desc.size } else { [1, 1] };
        let all: [ImageDesc; IMAGES as usize] = [
            seen,
            seen,
            depth,
            depth,
            ImageDesc { name: "blur distorted", ..seen },
            ImageDesc { name: "blur distorted depth", ..depth },
            ImageDesc { name: "blur samples", extent, ..seen },
            ImageDesc { name: "blur sample depth", extent, ..depth },
            frame,
            ImageDesc { name: "blur later frame", ..frame },
            ImageDesc { name: "blur seen before", extent: outside, ..seen },
            ImageDesc { name: "blur seen after", extent: outside, ..seen },
            ImageDesc { name: "blur depth before", extent: outside, ..depth },
            ImageDesc { name: "blur depth after", extent: outside, ..depth },
            ImageDesc { name: "blur frame before", extent: outside, ..frame },
            ImageDesc { name: "blur frame after", extent: outside, ..frame },
            drawn,
            drawn,
            outer_drawn,
            outer_drawn,
            ghost,
            ImageDesc { name: "blur ghost depth", extent: ghost.extent, ..depth },
            ImageDesc { name: "blur background", ..frame },
        ];
        all.into()
    }

    fn bound(&self, desc: &Desc) -> Vec<(BufferId, HostBuffer)> {
        desc.sources.iter().enumerate().map(|(number, source)| (host_source(number), source.buffer)).collect()
    }
}
