//! Which buffers and images the effect has, and how large they are. Pure.

use ash::vk;

use crate::effect::{DeviceTraits, Inventory};
use crate::error::{Error, Result};
use crate::flame::desc::{Desc, SceneFormat};
use crate::flame::limits::{Stage, buckets, is_raster, kernels, most_count, stages};
use crate::flame::settings::Mode;
use crate::flame::tables::Tables;
use crate::gpu::buffer::BufferDesc;
use crate::gpu::image::ImageDesc;
use crate::gpu::scratch::Lifetime;
use crate::layout::{Sizes, buffers};
use crate::plan::{Binding, BufferId, ImageId, Resource, Shader};
use crate::scan::{self, MOST_COUNTERS};
use crate::shaders::flame as glsl;
use crate::shaders::flame::blocks::{CellLevel, Control, FlameParams, KernelTable, Lamp, Particle};
use crate::shaders::flame::constants::{
    CELLS_ACROSS, KERNEL_CLASSES, KERNEL_DEPTHS, KERNEL_PLACES, MASK_LEVELS, MASK_SIDE, SHARE_SIDE, SUM_VECTORS, TILE,
    UNFINISHED_VECTORS, UNLAID_VECTORS,
};

/// Sums of many weights: halves would lose most of them.
pub const DISPLACEMENT_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
/// Bytes of a vector of four words.
const VECTOR: u64 = 16;

buffers! {
    "flame"
    PARAMS = "FlameParams",
    CONTROL = "ControlBuffer",
    POSITIONS = "Positions": Sequence,
    IDS = "Ids": Sequence,
    COLOURS = "Colours": Kept,
    PARTICLES = "Particles": Layer,
    CELLS = "Cells",
    CELL_SUMS = "CellSums",
    ENTRIES = "Entries",
    TILE_SUMS = "TileSums",
    OCCUPIED_TILES = "OccupiedTiles",
    ACTIVE_TILES = "ActiveTiles",
    TILE_REPETITIONS = "TileRepetitions",
    TILE_OPEN = "TileOpen",
    PART_ARGUMENTS = "PartArguments",
    SCENE_WORDS = "SceneWords",
    SCENE = "Scene",
    MASK = "Mask": Kept,
    KERNEL_STATE = "KernelState": Kept,
    SHARES = "Shares",
    SUMS = "Sums",
    SPRITE_LIST = "SpriteList",
    SPRITE_SUMS = "SpriteSums",
    LAMP = "LampBuffer",
    WINNERS = "Winners",
    UNLAID = "Unlaid",
    PICTURE = "Picture": Layer,
    MEAN = "Mean": Layer,
    VARIANCE = "Variance": Layer,
    NEAREST = "Nearest": Layer,
    PREVIOUS = "Previous",
    VELOCITIES = "Velocities": Sequence,
    STRETCHES = "Stretches": Layer,
    TILE_FIRE = "TileFire",
    TILE_SHOWN = "TileShown",
    WEIGHTS = "Weights": Kept,
    GLOW_WEIGHTS = "GlowWeights": Kept,
    GLOW_SUMS = "GlowSums",
    TONES = "Tones": Kept,
    ROW_SUMS = "RowSums",
    HEAT_LAYER = "HeatLayer": Layer,
    TONE_LAYER = "ToneLayer": Layer,
}

/// The host's particles: positions and temperatures.
pub const HOST_POSITIONS: BufferId = BufferId(BUFFERS);
/// The host's ids.
pub const HOST_IDS: BufferId = BufferId(BUFFERS + 1);
/// The host's view depths.
pub const HOST_SCENE: BufferId = BufferId(BUFFERS + 2);
/// Where the host's particles were in the frame before.
pub const HOST_PREVIOUS: BufferId = BufferId(BUFFERS + 3);
/// The host's velocities.
pub const HOST_VELOCITIES: BufferId = BufferId(BUFFERS + 4);
/// The mask, level beside level, variant below variant.
pub const LEVELS: ImageId = ImageId(0);
/// The table of the expected image.
pub const KERNEL: ImageId = ImageId(1);
/// The result of a repetition drawn the paper's way: row and depth of the nearest.
pub const DRAWN: ImageId = ImageId(2);
/// Its depth buffer.
pub const DRAWN_DEPTH: ImageId = ImageId(3);
/// Displacements of the particles at each pixel, by weight, and the weights.
pub const DISPLACEMENTS: ImageId = ImageId(4);
/// Buffers of the host's.
pub const HOST_BUFFERS: usize = 5;
/// The host's target.
pub const TARGET: ImageId = ImageId(5);
/// The host's background.
pub const BACKGROUND: ImageId = ImageId(6);
/// The host's depth image.
pub const HOST_DEPTH: ImageId = ImageId(7);
/// The host's motion vectors.
pub const MOTION: ImageId = ImageId(8);
/// The host's reactive mask.
pub const REACTIVE: ImageId = ImageId(9);
/// Images of the host's.
pub const HOST_IMAGES: usize = 5;

/// The resource of a shader's binding: each buffer and image goes by one name everywhere.
pub fn resource(binding: &Binding) -> Option<Resource> {
    let image = match binding.name {
        "levels" => Some(LEVELS),
        "kernel" => Some(KERNEL),
        "drawn" => Some(DRAWN),
        "displacements" => Some(DISPLACEMENTS),
        _ => None,
    };
    let buffer = BLOCKS.iter().position(|name| *name == binding.name).map(|index| BufferId(index as u16));
    image.map(Resource::Image).or(buffer.map(Resource::Buffer))
}

/// Sizes of everything, from what the effect is made for.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Screen tiles across and down.
    pub tiles: [u32; 2],
    /// Levels of cells.
    pub levels: Vec<CellLevel>,
    /// Cells of all levels.
    pub cells: u32,
    /// Depth buckets.
    pub buckets: u32,
    /// Stages of the repetitions; one unless `adaptive`.
    pub stages: Vec<Stage>,
    sizes: Sizes<{ BUFFERS as usize }>,
}

impl Layout {
    /// Computes it; fails where a buffer is larger than a shader can bind.
    pub fn new(desc: &Desc, tables: &Tables, traits: &DeviceTraits) -> Result<Layout> {
        let settings = &desc.settings;
        let tiles = desc.size.map(|side| side.div_ceil(TILE));
        let (levels, cells) = levels(tiles);
        let mut layout = Layout {
            tiles,
            levels,
            cells,
            buckets: buckets(settings.mode, settings.bins),
            stages: stages(desc, traits)?,
            sizes: Sizes::LEAST,
        };
        layout.size_particles(desc, tables);
        let parts: u32 = layout.stages.iter().map(|stage| stage.parts).sum();
        layout.set(PART_ARGUMENTS, u64::from(parts * kernels(desc, traits)) * VECTOR);
        layout.size_pictures(desc);
        let counters = u64::from(layout.cells) * u64::from(layout.buckets);
        if counters > MOST_COUNTERS {
            let what = "the flame's lists (cells times depth bins)";
            let advice = "use fewer flame.bins or a smaller picture";
            return Err(Error::Limit { what, needed: counters, limit: MOST_COUNTERS, advice });
        }
        layout.check(traits.storage_range)?;
        Ok(layout)
    }

    fn set(&mut self, id: BufferId, bytes: u64) {
        self.sizes.set(id, bytes);
    }

    /// Bytes of a buffer.
    pub fn size(&self, id: BufferId) -> u64 {
        self.sizes.get(id)
    }

    fn size_particles(&mut self, desc: &Desc, tables: &Tables) {
        let particles = u64::from(desc.particles);
        let texels = u64::from(MASK_SIDE * MASK_SIDE * desc.settings.variants);
        self.set(PARAMS, size_of::<FlameParams>() as u64);
        self.set(CONTROL, size_of::<Control>() as u64);
        self.set(POSITIONS, particles * VECTOR);
        self.set(IDS, particles * 4);
        self.set(COLOURS, tables.colours.entries.len() as u64 * VECTOR);
        self.set(WEIGHTS, tables.weights.len() as u64 * 4);
        self.set(GLOW_WEIGHTS, tables.glow_weights.len() as u64 * 4);
        self.set(TONES, size_of_val(&tables.tones[..]) as u64);
        self.set(PARTICLES, particles * size_of::<Particle>() as u64);
        self.set(CELLS, u64::from(self.cells) * u64::from(self.buckets) * 4);
        self.set(CELL_SUMS, scan::sums_bytes(self.size(CELLS)));
        self.set(ENTRIES, particles * u64::from(CELLS_ACROSS * CELLS_ACROSS) * 4);
        self.set(MASK, texels * 4);
        self.set(PREVIOUS, if desc.temporal.motion.is_some() { particles * VECTOR } else { 0 });
        self.set(VELOCITIES, if desc.settings.stretches() { particles * VECTOR } else { 0 });
        self.set(STRETCHES, particles * 4);
        if desc.settings.is_expected() {
            self.set(KERNEL_STATE, size_of::<KernelTable>() as u64);
            self.set(SHARES, u64::from(KERNEL_CLASSES * SHARE_SIDE * SHARE_SIDE) * 4);
        }
    }

    fn size_pictures(&mut self, desc: &Desc) {
        let pixels = u64::from(desc.size[0]) * u64::from(desc.size[1]);
        let tiles = u64::from(self.tiles[0]) * u64::from(self.tiles[1]);
        let kept = |needed: bool, bytes: u64| if needed { bytes } else { 0 };
        let words = matches!(desc.scene, Some(SceneFormat::Image(_)));
        let segmented = !is_raster(desc) && self.stages.iter().any(|stage| stage.parts > stage.last - stage.first);
        // What a tile's pixels have of a repetition, or of a bin, that is not done yet.
        let unfinished = match desc.settings.mode {
            Mode::Stochastic => VECTOR,
            Mode::Expected => VECTOR * u64::from(UNFINISHED_VECTORS),
        };
        // Between dispatches, the last two bins of each pixel of the expected image, which lean on their neighbours.
        let is_cut = desc.settings.is_expected() && self.stages.iter().any(|stage| stage.parts > 1);
        self.set(UNLAID, kept(is_cut, pixels * VECTOR * u64::from(UNLAID_VECTORS + u32::from(desc.layers))));
        self.set(TILE_SUMS, tiles.div_ceil(lanes(&glsl::tiles::SHADER)) * 4);
        self.set(OCCUPIED_TILES, tiles * 4);
        self.set(ACTIVE_TILES, tiles * 4);
        self.set(TILE_REPETITIONS, tiles * 4);
        self.set(TILE_OPEN, tiles * 4);
        self.set(SCENE_WORDS, kept(words, pixels * 4));
        self.set(SCENE, kept(desc.scene.is_some(), pixels * 4));
        self.set(SUMS, pixels * VECTOR * u64::from(SUM_VECTORS));
        let sprites = u64::from(desc.particles) * most_count(desc);
        self.set(SPRITE_LIST, kept(is_raster(desc), sprites * 8));
        self.set(SPRITE_SUMS, u64::from(desc.particles).div_ceil(lanes(&glsl::sprites::SHADER)) * 4);
        self.set(LAMP, size_of::<Lamp>() as u64);
        self.set(WINNERS, kept(segmented, pixels * unfinished));
        self.set(PICTURE, pixels * VECTOR);
        self.set(MEAN, kept(desc.layers, pixels * VECTOR));
        self.set(VARIANCE, kept(desc.layers, pixels * VECTOR));
        self.set(NEAREST, kept(desc.keeps_depth(), pixels * 4));
        self.set(TILE_FIRE, tiles * 4);
        self.set(TILE_SHOWN, kept(desc.settings.spreads(), tiles * 4));
        self.set(GLOW_SUMS, kept(desc.settings.glow.is_on(), pixels * VECTOR));
        self.set(ROW_SUMS, kept(desc.settings.is_cel(), pixels * 8));
        self.set(HEAT_LAYER, kept(desc.layers, pixels * 8));
        self.set(TONE_LAYER, kept(desc.layers, pixels * VECTOR));
    }

    fn check(&self, limit: u64) -> Result<()> {
        let advice = |id: BufferId| match id {
            POSITIONS | PREVIOUS | VELOCITIES | STRETCHES | IDS | PARTICLES | ENTRIES | SPRITE_LIST => {
                "use fewer particles"
            }
            CELLS => "use fewer flame.bins or a smaller picture",
            MASK => "use fewer flame.variants",
            PART_ARGUMENTS => "use fewer particles or fewer flame.repetitions",
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
        let mut buffers: Vec<_> = self.sizes.descriptions(&NAMES, [PARAMS], desc.layers).collect();
        if desc.accumulates {
            buffers[usize::from(SUMS.0)].lifetime = Lifetime::Kept;
        }
        buffers
    }

    fn images(&self, desc: &Desc) -> Vec<ImageDesc> {
        let levels = ImageDesc {
            name: "flame levels",
            extent: [MASK_SIDE * MASK_LEVELS, MASK_SIDE * desc.settings.variants],
            layers: 1,
            array_view: false,
            format: vk::Format::R32_SFLOAT,
            usage: vk::ImageUsageFlags::STORAGE,
            lifetime: Lifetime::Kept,
        };
        let extent = match desc.settings.mode {
            Mode::Expected => [KERNEL_DEPTHS * KERNEL_PLACES, KERNEL_PLACES * KERNEL_CLASSES],
            Mode::Stochastic => [1, 1],
        };
        let kernel = ImageDesc { name: "flame kernel", extent, ..levels };
        let drawn = ImageDesc {
            name: "flame drawn",
            extent: if is_raster(desc) { desc.size } else { [1, 1] },
            format: vk::Format::R32G32_UINT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
            lifetime: Lifetime::Scratch,
            ..levels
        };
        let (format, usage) = (vk::Format::D32_SFLOAT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT);
        let drawn_depth = ImageDesc { name: "flame drawn depth", format, usage, ..drawn };
        let displacements = ImageDesc {
            name: "flame displacements",
            extent: if desc.temporal.motion.is_some() { desc.size } else { [1, 1] },
            format: DISPLACEMENT_FORMAT,
            ..drawn
        };
        vec![levels, kernel, drawn, drawn_depth, displacements]
    }
}

/// Invocations of a workgroup.
fn lanes(shader: &Shader) -> u64 {
    shader.local_size[0].into()
}

/// Levels of cells: tiles, and squares of 2 x 2 of the level before, up to where a particle that covers the picture stands.
fn levels(tiles: [u32; 2]) -> (Vec<CellLevel>, u32) {
    let (mut levels, mut cells, mut sides) = (Vec::new(), 0, tiles);
    loop {
        let [across, down] = sides;
        let end = cells + across * down;
        levels.push(CellLevel { first: cells, across, down, end });
        cells = end;
        if sides[0].max(sides[1]) <= CELLS_ACROSS {
            return (levels, cells);
        }
        sides = sides.map(|side| side.div_ceil(2));
    }
}
