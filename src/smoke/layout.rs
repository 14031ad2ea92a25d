//! Which buffers and images the effect has, and how large they are. Pure.

use ash::vk;

use crate::effect::{DeviceTraits, Inventory};
use crate::error::{Error, Result};
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::scratch::Lifetime;
use crate::layout::{MOST_GROUPS, Sizes, buffers};
use crate::plan::{Binding, BufferId, ImageId, Resource, Shader};
use crate::scan;
use crate::shaders::smoke as glsl;
use crate::shaders::smoke::blocks::{Control, Edge, History, Particle, Reach, Search, SmokeParams, Tone};
use crate::shaders::smoke::constants::{
    BIRTH_BLOCK, BLOCK, BUCKETS, FIELD_VOXELS, GROUP_WORDS, INK_WORDS, LIST_RUN, MAX_LEVELS, SLOT_PIXELS, TILE,
    TILE_BLOCKS,
};
use crate::smoke::channels::Channels;
use crate::smoke::desc::Desc;
use crate::smoke::frame::Shape;
use crate::smoke::limits::{MOST_INK_REACH, ROW_SUM_BYTES, luminance_entries};
use crate::smoke::search::{Pyramid, growth_rows};
use crate::smoke::settings::{Grow, Outline, Pixels};

buffers! {
    "smoke"
    PARAMS = "SmokeParams",
    DENSITY = "Density": Sequence,
    VELOCITY = "Velocity": Sequence,
    DETAIL_SLICES = "DetailSlices",
    DETAILED = "Detailed": Kept,
    OCCUPANCY = "Occupancy": Sequence,
    CROSSINGS = "Crossings": Kept,
    BIRTH_COUNTS = "BirthCounts": Sequence,
    CONTROL = "ControlBuffer": Layer,
    HISTORY = "HistoryBuffer": Sequence,
    PARTICLES = "Particles": Sequence,
    DYING = "Dying": Sequence,
    DYING_STEPS = "DyingSteps": Sequence,
    SPHERES = "Spheres": Sequence,
    RADII = "Radii": Sequence,
    VIEW_SPHERES = "ViewSpheres",
    GROUPS = "Groups": Sequence,
    OCCLUSION = "Occlusion",
    QUADS = "Quads",
    FIELD = "Field": Kept,
    FIELD_COLUMNS = "FieldColumns",
    SEARCHES = "Searches",
    CONTINUATIONS = "Continuations",
    LIST_SUMS = "ListSums",
    BIRTH_SUMS = "BirthSums",
    CELL_SUMS = "CellSums",
    TILE_SUMS = "TileSums",
    ITEM_SUMS = "ItemSums",
    LIVE = "Live",
    VISIBLE = "Visible": Layer,
    CELLS = "Cells": Kept,
    CASTERS = "Casters": Kept,
    BLOCK_MASKS = "BlockMasks",
    TILE_GROUPS = "TileGroups",
    OCCUPIED_TILES = "OccupiedTiles",
    LUMINANCE_PARTS = "LuminanceParts",
    PIXELS = "Pixels": Layer,
    CHANNELS = "Channels",
    DEPTH = "Depth": Kept,
    SHADOW = "Shadow": Layer,
    REACHED = "Reached",
    ROW_ITEMS = "RowItems",
    COLUMN_ITEMS = "ColumnItems",
    ITEM_ARGUMENTS = "ItemArguments",
    WEIGHTS = "Weights": Kept,
    ROW_SUMS = "RowSums",
    SMOOTH = "Smooth": Layer,
    SMOOTH_CHANNELS = "SmoothChannels",
    LINES = "Lines",
    INK_BITS = "InkBits",
    TONES = "Tones": Kept,
    PICTURE = "Picture": Layer,
    TONE_LAYER = "ToneLayer": Layer,
    OVERLAY_LAYER = "OverlayLayer": Layer,
    MATTE_LAYER = "MatteLayer": Layer,
    EDGES = "Edges",
    MOVED = "Moved": Kept,
}

/// The resource of a shader's binding: each buffer and image goes by one name everywhere.
pub fn resource(binding: &Binding) -> Option<Resource> {
    let image = match binding.name {
        "seen" => Some(SEEN),
        "shadow_map" => Some(SHADOW_MAP),
        _ => None,
    };
    let buffer = BLOCKS.iter().position(|name| *name == binding.name).map(|index| BufferId(index as u16));
    image.map(Resource::Image).or(buffer.map(Resource::Buffer))
}

/// The host's density.
pub const HOST_DENSITY: BufferId = BufferId(BUFFERS);
/// The host's velocity.
pub const HOST_VELOCITY: BufferId = BufferId(BUFFERS + 1);
/// The host's partial coverage of pixels.
pub const HOST_EDGES: BufferId = BufferId(BUFFERS + 2);
/// Layers that the kernel of tones writes beside the picture.
pub(super) const COLOUR_LAYERS: [BufferId; 3] = [TONE_LAYER, OVERLAY_LAYER, MATTE_LAYER];
/// Buffers of the host's.
pub const HOST_BUFFERS: usize = 3;
/// Sphere and group seen at each pixel.
pub const SEEN: ImageId = ImageId(0);
/// Its depth buffer.
pub const SEEN_DEPTH: ImageId = ImageId(1);
/// Shadow map.
pub const SHADOW_MAP: ImageId = ImageId(2);
/// The host's target.
pub const TARGET: ImageId = ImageId(3);
/// The host's background.
pub const BACKGROUND: ImageId = ImageId(4);
/// The host's depth.
pub const HOST_DEPTH: ImageId = ImageId(5);
/// The host's motion vectors.
pub const MOTION: ImageId = ImageId(6);
/// The host's reactive mask.
pub const REACTIVE: ImageId = ImageId(7);
/// Images of the host's.
pub const HOST_IMAGES: usize = 5;

/// Sizes of everything, from what the effect is made for.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Sphere slots: particles and the ring of dying ones.
    pub spheres: u32,
    /// Screen tiles across and down.
    pub tiles: [u32; 2],
    /// Side of a block of the occlusion test in pixels.
    pub occlusion_side: u32,
    /// Blocks of the occlusion test across and down, at most 128.
    pub occlusion_blocks: [u32; 2],
    /// Groups, or planes of the soft mask, whose row sums are in memory at a time.
    pub row_groups: u32,
    /// Those that a batch adds: all, or, of planes, one less, as the last one of the batch before stays.
    pub batch_groups: u32,
    /// Batches of them; one without a Gaussian.
    pub batches: u32,
    /// Row items of a batch.
    pub batch_capacity: u32,
    /// Sizes of the look in pixels of the picture.
    pub pixels: Pixels,
    /// Window of the Gaussian in blocks.
    pub window_blocks: u32,
    /// Levels of light-space tiles.
    pub light_levels: u32,
    /// Light-space tiles of a face.
    pub light_cells: u32,
    /// Faces of the light: 1, or 6 for a point light.
    pub light_faces: u32,
    /// Cells across a sphere at its level.
    pub cells_across: u32,
    /// Dispatches over the lists of light-space tiles.
    pub luminance_parts: u32,
    /// Dispatches of the longest radius search.
    pub search_parts: u32,
    /// What is smoothed beside luminance.
    pub channels: Channels,
    sizes: Sizes<{ BUFFERS as usize }>,
}

impl Layout {
    /// Computes it; fails where a buffer is larger than a shader can bind.
    pub fn new(desc: &Desc, traits: &DeviceTraits) -> Result<Layout> {
        let (settings, limit, pixels) = (&desc.settings, traits.storage_range, desc.pixels());
        check_ink(&pixels.outline)?;
        let tiles = desc.size.map(|side| side.div_ceil(TILE));
        let tile_count = u64::from(tiles[0]) * u64::from(tiles[1]);
        let spheres = u64::from(settings.particles) * (1 + u64::from(settings.fade));
        let per_group = tile_count * u64::from(SLOT_PIXELS) * 8;
        let (_, summed) = settings.summed();
        let kept = u32::from(settings.is_soft());
        let row_groups = (ROW_SUM_BYTES / per_group).clamp(1 + u64::from(kept), u64::from(summed)) as u32;
        let batch_groups = if row_groups < summed { row_groups - kept } else { summed };
        let faces = if desc.point_light { 6 } else { 1 };
        let exact = settings.is_exact();
        // As many finest cells as particles, within what one workgroup can sum up in its loop budget.
        let most = if desc.point_light { 6 } else { 7 };
        let finest = (f64::from(settings.particles.max(1)).sqrt().log2().ceil() as u32).min(most);
        let light_levels = if exact { finest + 1 } else { 1 };
        let casters = |across: u64| spheres * (across + 1) * (across + 1) * u64::from(faces) * 4;
        let cells_across = [8, 4].into_iter().find(|across| casters(*across) <= limit.min(16 << 20)).unwrap_or(1);
        let occlusion_side = BLOCK * desc.size[0].max(desc.size[1]).div_ceil(128 * BLOCK);
        let mut layout = Layout {
            spheres: spheres as u32,
            tiles,
            occlusion_side,
            occlusion_blocks: desc.size.map(|side| side.div_ceil(occlusion_side)),
            row_groups,
            batch_groups,
            batches: if settings.is_filtered() { summed.div_ceil(batch_groups) } else { 1 },
            batch_capacity: (tile_count * u64::from(batch_groups)) as u32,
            pixels,
            window_blocks: pixels.window().div_ceil(BLOCK),
            light_levels,
            light_cells: ((1_u64 << (2 * light_levels)) / 3) as u32,
            light_faces: faces,
            cells_across: cells_across as u32,
            luminance_parts: if exact { (spheres as u32).div_ceil(luminance_entries(traits)).max(1) } else { 1 },
            search_parts: 0,
            channels: Channels::new(desc),
            sizes: Sizes::LEAST,
        };
        layout.size_particles(desc);
        layout.size_volume(desc, traits)?;
        layout.size_pictures(desc);
        if exact {
            layout.set(CELLS, u64::from(layout.light_cells) * u64::from(faces) * u64::from(BUCKETS) * 4);
            layout.set(CELL_SUMS, scan::sums_bytes(layout.size(CELLS)));
            layout.set(CASTERS, casters(cells_across));
        }
        layout.check(limit)?;
        Ok(layout)
    }

    fn set(&mut self, id: BufferId, bytes: u64) {
        self.sizes.set(id, bytes);
    }

    /// Bytes of a buffer.
    pub fn size(&self, id: BufferId) -> u64 {
        self.sizes.get(id)
    }

    fn size_particles(&mut self, desc: &Desc) {
        let particles = u64::from(desc.settings.particles);
        let spheres = u64::from(self.spheres);
        let dying = spheres - particles;
        self.set(PARAMS, size_of::<SmokeParams>() as u64);
        self.set(CONTROL, size_of::<Control>() as u64);
        self.set(HISTORY, size_of::<History>() as u64);
        self.set(PARTICLES, particles * size_of::<Particle>() as u64);
        self.set(DYING, dying * 16);
        self.set(DYING_STEPS, dying * 16);
        self.set(SPHERES, spheres * 16);
        self.set(VIEW_SPHERES, spheres * 16);
        self.set(GROUPS, spheres * 4);
        self.set(QUADS, spheres * 16);
        let has_surface = desc.settings.has_surface();
        self.set(RADII, particles * 4);
        self.set(SEARCHES, if has_surface { 0 } else { particles * size_of::<Search>() as u64 });
        self.set(LIST_SUMS, spheres.div_ceil(u64::from(LIST_RUN) * lanes(&glsl::count::SHADER)) * 8);
        self.set(LIVE, spheres * 4);
        self.set(VISIBLE, spheres * 4);
        self.set(MOVED, if desc.temporal.motion.is_some() { spheres * 16 } else { 0 });
        self.set(LUMINANCE_PARTS, u64::from(self.luminance_parts) * 16);
    }

    fn size_volume(&mut self, desc: &Desc, traits: &DeviceTraits) -> Result<()> {
        let shape = Shape { dimensions: desc.dimensions, ..Shape::default() };
        let [nx, ny, nz] = desc.dimensions.map(u64::from);
        let pyramid = Pyramid::new(desc.dimensions);
        if pyramid.count > MAX_LEVELS {
            let (needed, limit) = (ny.max(nz), 1 << (MAX_LEVELS - 1));
            return Err(Error::Limit {
                what: "the volume's height or depth in voxels",
                needed,
                limit,
                advice: "crop it",
            });
        }
        let words = u64::from(pyramid.row_words) * ny * nz;
        let above = u64::from(pyramid.row_words) * ny.div_ceil(2) * nz.div_ceil(2);
        let [occupancy, pyramids] = [&glsl::occupancy::SHADER, &glsl::pyramid::SHADER].map(lanes);
        let needed = words.div_ceil(occupancy).max(above.div_ceil(pyramids));
        if needed > MOST_GROUPS {
            let what = "the volume (workgroups of its occupancy)";
            return Err(Error::Limit { what, needed, limit: MOST_GROUPS, advice: "use a smaller volume" });
        }
        let (has_surface, is_detailed) = (desc.settings.has_surface(), desc.settings.is_detailed());
        let cells = Pyramid::of_cells(desc.dimensions);
        let kept = |needed: bool, bytes: u64| if needed { bytes } else { 0 };
        self.set(DENSITY, shape.voxels() * 4);
        self.set(DETAIL_SLICES, kept(is_detailed, shape.voxels() * 4));
        self.set(DETAILED, kept(is_detailed, shape.voxels() * 4));
        self.set(CROSSINGS, kept(has_surface, cells.words * 4));
        self.set(VELOCITY, if desc.velocity { shape.voxels() * 12 } else { 0 });
        self.set(OCCUPANCY, pyramid.words * 4);
        self.set(BIRTH_COUNTS, (words.div_ceil(u64::from(BIRTH_BLOCK)) + 1) * 4);
        self.set(BIRTH_SUMS, scan::sums_bytes(self.size(BIRTH_COUNTS)));
        self.set(FIELD, kept(!has_surface, nx.div_ceil(FIELD_VOXELS.into()) * ny * nz * 4));
        self.set(FIELD_COLUMNS, kept(!has_surface, nx.div_ceil(FIELD_VOXELS.into()) * ny * nz * 4));
        // A walk of the pyramid also visits the inner nodes.
        let (visits, iterations) = match desc.settings.grow {
            _ if has_surface => (1, 1),
            Grow::Growth => (growth_rows(&Shape { voxel_size: [1.0; 3], ..shape }), pyramid.iterations(traits)),
            _ => (pyramid.leaves().saturating_mul(4).div_ceil(3), pyramid.iterations(traits)),
        };
        self.search_parts = visits.div_ceil(iterations).max(1);
        self.set(CONTINUATIONS, kept(!has_surface, u64::from(self.search_parts) * 16));
        Ok(())
    }

    fn size_pictures(&mut self, desc: &Desc) {
        let pixels = u64::from(desc.size[0]) * u64::from(desc.size[1]);
        let tiles = u64::from(self.tiles[0]) * u64::from(self.tiles[1]);
        let blocks = tiles * u64::from(TILE_BLOCKS * TILE_BLOCKS);
        let settings = &desc.settings;
        let filtered = settings.is_filtered();
        let inked = settings.outline.is_on();
        let kept = |needed: bool, bytes: u64| if needed { bytes } else { 0 };
        let items = u64::from(self.batches) * u64::from(self.batch_capacity);
        self.set(BLOCK_MASKS, blocks * 4);
        self.set(TILE_GROUPS, tiles * u64::from(GROUP_WORDS) * 4);
        self.set(OCCUPIED_TILES, tiles * 4);
        self.set(OCCLUSION, u64::from(self.occlusion_blocks[0]) * u64::from(self.occlusion_blocks[1]) * 4);
        self.set(PIXELS, pixels * 4);
        self.set(DEPTH, pixels * 4);
        self.set(EDGES, kept(desc.edges, pixels * size_of::<Edge>() as u64));
        self.set(SHADOW, kept(self.keeps_shadow(desc), pixels * 4));
        let channels = pixels * 4 * u64::from(self.channels.count());
        self.set(CHANNELS, channels);
        self.set(SMOOTH_CHANNELS, kept(filtered, channels));
        self.set(REACHED, kept(filtered, blocks * size_of::<Reach>() as u64));
        self.set(ROW_ITEMS, kept(filtered, items * 4));
        self.set(COLUMN_ITEMS, kept(filtered, items * 4));
        self.set(TILE_SUMS, tiles.div_ceil(lanes(&glsl::occupied::SHADER)) * 4);
        self.set(ITEM_SUMS, u64::from(self.batch_capacity).div_ceil(lanes(&glsl::items::SHADER)) * 8);
        self.set(ITEM_ARGUMENTS, u64::from(self.batches) * 32);
        self.set(WEIGHTS, u64::from(self.window_blocks * BLOCK + BLOCK) * 4);
        let row_sums = tiles * u64::from(self.row_groups) * u64::from(SLOT_PIXELS) * 8;
        self.set(ROW_SUMS, kept(filtered, row_sums));
        self.set(SMOOTH, kept(filtered, pixels * 4));
        self.set(LINES, kept(inked, pixels * 4));
        self.set(INK_BITS, kept(inked && settings.outline.is_hard(), tiles * u64::from(INK_WORDS) * 4));
        self.set(TONES, (settings.all_tones().count() * size_of::<Tone>()) as u64);
        self.set(PICTURE, pixels * 16);
        self.set(TONE_LAYER, kept(desc.layers, pixels * 16));
        self.set(OVERLAY_LAYER, kept(desc.layers, pixels * 16));
        self.set(MATTE_LAYER, kept(desc.layers, pixels * 16));
    }

    /// Whether shares of the light that arrives outlive the kernel that finds them.
    pub fn keeps_shadow(&self, desc: &Desc) -> bool {
        desc.layers || self.luminance_parts > 1 || self.channels.shade.is_some()
    }

    fn check(&self, limit: u64) -> Result<()> {
        let advice = |id: BufferId| match id {
            DENSITY | VELOCITY | DETAIL_SLICES | DETAILED | OCCUPANCY | CROSSINGS | BIRTH_COUNTS | BIRTH_SUMS
            | FIELD | FIELD_COLUMNS | CONTINUATIONS => "use a smaller volume",
            PARTICLES | DYING | DYING_STEPS | SPHERES | RADII | VIEW_SPHERES | QUADS | GROUPS | SEARCHES
            | LIST_SUMS | LIVE | VISIBLE | MOVED => "use fewer particles or less fade",
            CASTERS => "use fewer particles, less fade, or shadow = \"map\"",
            _ => "render a smaller picture",
        };
        self.sizes.check(limit, &NAMES, advice)
    }
}

impl Inventory for Layout {
    type Desc = Desc;
    const HOST_BUFFERS: usize = HOST_BUFFERS;
    const HOST_IMAGES: usize = HOST_IMAGES;

    fn buffers(&self, desc: &Desc) -> Vec<BufferDesc> {
        self.sizes.descriptions(&NAMES, [PARAMS], desc.layers).collect()
    }

    fn images(&self, desc: &Desc) -> Vec<ImageDesc> {
        let map = if desc.settings.has_shadow_map() { desc.settings.shadow_map } else { 1 };
        let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let seen = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE;
        let flat = ImageDesc {
            name: "smoke seen",
            extent: desc.size,
            layers: 1,
            array_view: false,
            format: vk::Format::R32_UINT,
            usage: seen,
            lifetime: Lifetime::Scratch,
        };
        vec![
            flat,
            ImageDesc { name: "smoke seen depth", format: vk::Format::D32_SFLOAT, usage: depth, ..flat },
            ImageDesc {
                name: "smoke shadow map",
                extent: [map, map],
                layers: self.light_faces,
                array_view: true,
                format: vk::Format::D32_SFLOAT,
                usage: depth | vk::ImageUsageFlags::SAMPLED,
                lifetime: Lifetime::Kept,
            },
        ]
    }
}

/// Each pixel looks at all from which a line can reach it.
fn check_ink(outline: &Outline) -> Result<()> {
    let (needed, limit) = (outline.reach().into(), MOST_INK_REACH.into());
    let advice = "use less smoke.outline.width or a smaller picture";
    match needed > limit {
        true => Err(Error::Limit { what: "the ink line (pixels from its middle)", needed, limit, advice }),
        false => Ok(()),
    }
}

/// Invocations of a workgroup along x.
fn lanes(shader: &Shader) -> u64 {
    shader.local_size[0].into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoke::Settings;

    #[test]
    fn what_is_too_large_says_what_to_change() {
        let new = Desc::new([8, 8], [4; 3], Settings { particles: 1, ..Settings::default() });
        let desc = Desc { layers: true, ..new };
        let limit = DeviceTraits::LEAST.storage_range;
        let layout = Layout::new(&desc, &DeviceTraits::LEAST).expect("small");
        for (id, name, advice) in [
            (DEPTH, "Depth", "render a smaller picture"),
            (PICTURE, "Picture", "render a smaller picture"),
            (BLOCK_MASKS, "BlockMasks", "render a smaller picture"),
            (ROW_ITEMS, "RowItems", "render a smaller picture"),
            (OVERLAY_LAYER, "OverlayLayer", "render a smaller picture"),
            (SPHERES, "Spheres", "use fewer particles or less fade"),
            (CASTERS, "Casters", "use fewer particles, less fade, or shadow = \"map\""),
            (FIELD, "Field", "use a smaller volume"),
        ] {
            let mut layout = layout.clone();
            layout.set(id, limit + 16);
            let said = layout.check(limit).expect_err(name).to_string();
            let expected = format!("needs 134217744, this device allows 134217728; {advice}");
            assert_eq!(said, format!("smoke's buffer {name} (in bytes) {expected}"));
        }
    }
}
