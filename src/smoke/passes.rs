//! The passes of the smoke effect: declared once, chosen for each frame.

use ash::vk;

use crate::plan::{BufferId, ColourAttachment, Command, DepthAttachment, Pass, PassId, Plan, Raster, Shader, Usage};
use crate::shaders::smoke as glsl;
use crate::smoke::frame::{Background, Desc, Frame, Shape};
use crate::smoke::layout::*;
use crate::smoke::params::*;
use crate::smoke::settings::{Grow, Integrator, Operator, Radius, Settings, Shadow};

/// What an effect declares: its passes, and which is which.
#[derive(Debug)]
pub struct Passes {
    /// By [`PassId`].
    pub list: Vec<Pass>,
    params: PassId,
    tables: PassId,
    volume: PassId,
    background: PassId,
    restart: PassId,
    clear: PassId,
    occupancy: PassId,
    births: PassId,
    pyramid: PassId,
    field: [PassId; 3],
    advect: PassId,
    grow_field: PassId,
    grow_pyramid: PassId,
    grow_growth: PassId,
    grow_reset: PassId,
    count: PassId,
    scan: PassId,
    listing: PassId,
    shadow_reset: PassId,
    shadow_count: PassId,
    shadow_scan: PassId,
    shadow_fill: PassId,
    shadow_map: Vec<PassId>,
    spheres: PassId,
    tiles: PassId,
    occupied: PassId,
    luminance: PassId,
    dilate: PassId,
    items: PassId,
    rows: PassId,
    columns: PassId,
    outline: PassId,
    tone: PassId,
    composite: PassId,
}

/// Names that are skipped as one.
const PARTICLE_STEPS: [&str; 4] = ["smoke.occupancy", "smoke.advect", "smoke.grow", "smoke.list"];
const PICTURE_STEPS: [&str; 9] = [
    "smoke.shadow",
    "smoke.spheres",
    "smoke.tiles",
    "smoke.luminance",
    "smoke.rows",
    "smoke.columns",
    "smoke.outline",
    "smoke.tone",
    "smoke.composite",
];

/// Collects declarations.
struct Declare(Vec<Pass>);

impl Declare {
    fn add(&mut self, pass: Pass) -> PassId {
        self.0.push(pass);
        PassId(self.0.len() as u16 - 1)
    }

    fn compute(
        &mut self,
        name: &'static str,
        shader: &'static Shader,
        buffers: &[(crate::plan::Slot, BufferId)],
    ) -> PassId {
        self.add(bound(Pass::compute(name, shader), buffers))
    }
}

/// Binds buffers, and the parameters, which every kernel has.
fn bound(pass: Pass, buffers: &[(crate::plan::Slot, BufferId)]) -> Pass {
    let pass = pass.bind(glsl::advect::SMOKE_PARAMS, PARAMS);
    buffers.iter().fold(pass, |pass, (slot, buffer)| pass.bind(*slot, *buffer))
}

impl Passes {
    /// Declares every pass that some frame of this effect may need.
    pub fn new(desc: &Desc, layout: &Layout) -> Passes {
        let mut d = Declare(Vec::new());
        let target = |usage: Usage, name| Pass::transfer(name).uses(TARGET, usage);
        let across = [(layout.cells_across as f32).to_bits()];
        let (field, grow) = (declare_field(&mut d), declare_grow(&mut d));
        let (shadow, shadow_map) = (declare_shadow(&mut d, &across), declare_map(&mut d, desc, layout));
        let gaussian = declare_gaussian(&mut d);
        Passes {
            params: d
                .add(Pass::transfer("smoke.params").uses(PARAMS, Usage::COPY_TARGET).uses(CONTROL, Usage::COPY_TARGET)),
            tables: d
                .add(Pass::transfer("smoke.tables").uses(WEIGHTS, Usage::COPY_TARGET).uses(TONES, Usage::COPY_TARGET)),
            volume: d.add(
                Pass::transfer("smoke.volume")
                    .uses(HOST_DENSITY, Usage::COPY_SOURCE)
                    .uses(HOST_VELOCITY, Usage::COPY_SOURCE)
                    .uses(DENSITY, Usage::COPY_TARGET)
                    .uses(VELOCITY, Usage::COPY_TARGET),
            ),
            background: d.add(target(Usage::COPY_TARGET, "smoke.background").uses(BACKGROUND, Usage::COPY_SOURCE)),
            restart: d.add(
                [DYING, SPHERES, GROUPS]
                    .iter()
                    .fold(Pass::transfer("smoke.restart"), |pass, id| pass.uses(*id, Usage::COPY_TARGET)),
            ),
            clear: d.add(
                [PIXELS, DEPTH, LINES, SHADOW, SMOOTH, PICTURE, TONE_LAYER, OUTLINE_LAYER]
                    .iter()
                    .fold(Pass::transfer("smoke.clear"), |pass, id| pass.uses(*id, Usage::COPY_TARGET)),
            ),
            occupancy: d.compute(
                "smoke.occupancy",
                &glsl::occupancy::SHADER,
                &[
                    (glsl::occupancy::DENSITY, DENSITY),
                    (glsl::occupancy::OCCUPANCY, OCCUPANCY),
                    (glsl::occupancy::BIRTH_COUNTS, BIRTH_COUNTS),
                ],
            ),
            births: d.compute(
                "smoke.occupancy",
                &glsl::births::SHADER,
                &[(glsl::births::BIRTH_COUNTS, BIRTH_COUNTS), (glsl::births::HISTORY_BUFFER, HISTORY)],
            ),
            pyramid: d.compute("smoke.pyramid", &glsl::pyramid::SHADER, &[(glsl::pyramid::OCCUPANCY, OCCUPANCY)]),
            field,
            advect: declare_advect(&mut d, desc),
            grow_field: grow[0],
            grow_pyramid: grow[1],
            grow_growth: grow[2],
            grow_reset: grow[3],
            count: d.compute(
                "smoke.list",
                &glsl::count::SHADER,
                &[
                    (glsl::count::SPHERES, SPHERES),
                    (glsl::count::LIST_COUNTS, LIST_COUNTS),
                    (glsl::count::CONTROL_BUFFER, CONTROL),
                ],
            ),
            scan: d.compute(
                "smoke.list",
                &glsl::scan::SHADER,
                &[
                    (glsl::scan::LIST_COUNTS, LIST_COUNTS),
                    (glsl::scan::CONTROL_BUFFER, CONTROL),
                    (glsl::scan::HISTORY_BUFFER, HISTORY),
                ],
            ),
            listing: d.compute(
                "smoke.list",
                &glsl::list::SHADER,
                &[
                    (glsl::list::SPHERES, SPHERES),
                    (glsl::list::LIST_COUNTS, LIST_COUNTS),
                    (glsl::list::HISTORY_BUFFER, HISTORY),
                    (glsl::list::GROUPS, GROUPS),
                    (glsl::list::LIVE, LIVE),
                    (glsl::list::VISIBLE, VISIBLE),
                ],
            ),
            shadow_reset: shadow[0],
            shadow_count: shadow[1],
            shadow_scan: shadow[2],
            shadow_fill: shadow[3],
            shadow_map,
            spheres: d.add(declare_spheres(desc)),
            tiles: d.add(
                bound(
                    Pass::compute("smoke.tiles", &glsl::tiles::SHADER),
                    &[(glsl::tiles::BLOCK_MASKS, BLOCK_MASKS), (glsl::tiles::TILE_GROUPS, TILE_GROUPS)],
                )
                .bind(glsl::tiles::SEEN, SEEN),
            ),
            occupied: d.compute(
                "smoke.tiles",
                &glsl::occupied::SHADER,
                &[
                    (glsl::occupied::TILE_GROUPS, TILE_GROUPS),
                    (glsl::occupied::OCCUPIED_TILES, OCCUPIED_TILES),
                    (glsl::occupied::CONTROL_BUFFER, CONTROL),
                    (glsl::occupied::HISTORY_BUFFER, HISTORY),
                    (glsl::occupied::LUMINANCE_PARTS, LUMINANCE_PARTS),
                ],
            ),
            luminance: d.add(declare_luminance(desc, layout, across[0])),
            dilate: gaussian[0],
            items: gaussian[1],
            rows: gaussian[2],
            columns: gaussian[3],
            outline: d.add(
                bound(
                    Pass::compute("smoke.outline", &glsl::outline::SHADER),
                    &[
                        (glsl::outline::OCCUPIED_TILES, OCCUPIED_TILES),
                        (glsl::outline::DEPTH, DEPTH),
                        (glsl::outline::LINES, LINES),
                    ],
                )
                .specialise([u32::from(desc.settings.outline.operator == Operator::Second)]),
            ),
            tone: d.add(declare_tone(desc)),
            composite: d.add(declare_composite(desc)),
            list: d.0,
        }
    }
}

fn declare_advect(d: &mut Declare, desc: &Desc) -> PassId {
    let midpoint = u32::from(desc.settings.integrator == Integrator::Rk2);
    let pass = bound(
        Pass::compute("smoke.advect", &glsl::advect::SHADER),
        &[
            (glsl::advect::VELOCITY, VELOCITY),
            (glsl::advect::OCCUPANCY, OCCUPANCY),
            (glsl::advect::BIRTH_COUNTS, BIRTH_COUNTS),
            (glsl::advect::HISTORY_BUFFER, HISTORY),
            (glsl::advect::PARTICLES, PARTICLES),
            (glsl::advect::DYING, DYING),
            (glsl::advect::DYING_STEPS, DYING_STEPS),
            (glsl::advect::SPHERES, SPHERES),
            (glsl::advect::GROUPS, GROUPS),
        ],
    );
    d.add(pass.specialise([midpoint]))
}

fn declare_field(d: &mut Declare) -> [PassId; 3] {
    [
        d.compute(
            "smoke.field",
            &glsl::field_rows::SHADER,
            &[(glsl::field_rows::OCCUPANCY, OCCUPANCY), (glsl::field_rows::FIELD_ROWS, FIELD)],
        ),
        d.compute(
            "smoke.field",
            &glsl::field_columns::SHADER,
            &[(glsl::field_columns::FIELD_FROM, FIELD), (glsl::field_columns::FIELD_TO, FIELD_TO)],
        ),
        d.compute(
            "smoke.field",
            &glsl::field_slices::SHADER,
            &[(glsl::field_slices::FIELD_FROM, FIELD_TO), (glsl::field_slices::FIELD_TO, FIELD)],
        ),
    ]
}

/// Field, pyramid, growth, and the reset of the searches' continuations.
fn declare_grow(d: &mut Declare) -> [PassId; 4] {
    let field = d.compute(
        "smoke.grow",
        &glsl::grow_field::SHADER,
        &[
            (glsl::grow_field::PARTICLES, PARTICLES),
            (glsl::grow_field::SPHERES, SPHERES),
            (glsl::grow_field::FIELD, FIELD),
        ],
    );
    let pyramid = d.compute(
        "smoke.grow",
        &glsl::grow_pyramid::SHADER,
        &[
            (glsl::grow_pyramid::PARTICLES, PARTICLES),
            (glsl::grow_pyramid::SPHERES, SPHERES),
            (glsl::grow_pyramid::OCCUPANCY, OCCUPANCY),
            (glsl::grow_pyramid::SEARCHES, SEARCHES),
            (glsl::grow_pyramid::CONTINUATIONS, CONTINUATIONS),
        ],
    );
    let growth = d.compute(
        "smoke.grow",
        &glsl::grow_growth::SHADER,
        &[
            (glsl::grow_growth::PARTICLES, PARTICLES),
            (glsl::grow_growth::SPHERES, SPHERES),
            (glsl::grow_growth::OCCUPANCY, OCCUPANCY),
            (glsl::grow_growth::SEARCHES, SEARCHES),
            (glsl::grow_growth::CONTINUATIONS, CONTINUATIONS),
        ],
    );
    let reset = d.add(Pass::transfer("smoke.grow").uses(CONTINUATIONS, Usage::COPY_TARGET));
    [field, pyramid, growth, reset]
}

/// Reset, count, scan and fill of the light-space tiles.
fn declare_shadow(d: &mut Declare, across: &[u32; 1]) -> [PassId; 4] {
    let count = bound(
        Pass::compute("smoke.shadow", &glsl::shadow_count::SHADER),
        &[
            (glsl::shadow_count::SPHERES, SPHERES),
            (glsl::shadow_count::LIVE, LIVE),
            (glsl::shadow_count::CONTROL_BUFFER, CONTROL),
            (glsl::shadow_count::CELLS, CELLS),
        ],
    );
    let fill = bound(
        Pass::compute("smoke.shadow", &glsl::shadow_fill::SHADER),
        &[
            (glsl::shadow_fill::SPHERES, SPHERES),
            (glsl::shadow_fill::LIVE, LIVE),
            (glsl::shadow_fill::CONTROL_BUFFER, CONTROL),
            (glsl::shadow_fill::CELLS, CELLS),
            (glsl::shadow_fill::CASTERS, CASTERS),
        ],
    );
    [
        d.add(Pass::transfer("smoke.shadow").uses(CELLS, Usage::COPY_TARGET)),
        d.add(count.specialise(*across)),
        d.compute(
            "smoke.shadow",
            &glsl::shadow_scan::SHADER,
            &[(glsl::shadow_scan::CELLS, CELLS), (glsl::shadow_scan::HISTORY_BUFFER, HISTORY)],
        ),
        d.add(fill.specialise(*across)),
    ]
}

/// One render pass a face.
fn declare_map(d: &mut Declare, desc: &Desc, layout: &Layout) -> Vec<PassId> {
    let faces = if desc.settings.shadow == Shadow::Map { layout.light_faces } else { 0 };
    let depth = |layer| DepthAttachment {
        image: SHADOW_MAP,
        format: vk::Format::D32_SFLOAT,
        clear: Some(0.0),
        compare: vk::CompareOp::GREATER,
        layer,
    };
    (0..faces)
        .map(|face| {
            let raster = Raster {
                vertex: &glsl::shadow_vertex::SHADER,
                fragment: &glsl::shadow_fragment::SHADER,
                colour: None,
                depth: Some(depth(face)),
                extent: [desc.settings.shadow_map; 2],
            };
            d.add(bound(
                Pass::raster("smoke.shadow", raster),
                &[
                    (glsl::shadow_vertex::SPHERES, SPHERES),
                    (glsl::shadow_vertex::LIVE, LIVE),
                    (glsl::shadow_vertex::CONTROL_BUFFER, CONTROL),
                ],
            ))
        })
        .collect()
}

fn declare_spheres(desc: &Desc) -> Pass {
    let raster = Raster {
        vertex: &glsl::spheres_vertex::SHADER,
        fragment: &glsl::spheres_fragment::SHADER,
        colour: Some(ColourAttachment { image: SEEN, format: vk::Format::R32_UINT, clear: Some([0; 4]), blend: false }),
        depth: Some(DepthAttachment {
            image: SEEN_DEPTH,
            format: vk::Format::D32_SFLOAT,
            clear: Some(0.0),
            compare: vk::CompareOp::GREATER,
            layer: 0,
        }),
        extent: desc.size,
    };
    bound(
        Pass::raster("smoke.spheres", raster),
        &[
            (glsl::spheres_vertex::SPHERES, SPHERES),
            (glsl::spheres_vertex::VISIBLE, VISIBLE),
            (glsl::spheres_vertex::GROUPS, GROUPS),
        ],
    )
}

fn declare_luminance(desc: &Desc, layout: &Layout, across: u32) -> Pass {
    let shader = match desc.settings.shadow {
        Shadow::None => &glsl::luminance::SHADER,
        Shadow::Exact => &glsl::luminance_exact::SHADER,
        Shadow::Map => &glsl::luminance_map::SHADER,
    };
    let pass = bound(
        Pass::compute("smoke.luminance", shader),
        &[
            (glsl::luminance::SPHERES, SPHERES),
            (glsl::luminance::OCCUPIED_TILES, OCCUPIED_TILES),
            (glsl::luminance::PIXELS, PIXELS),
            (glsl::luminance::DEPTH, DEPTH),
            (glsl::luminance::SHADOW, SHADOW),
        ],
    )
    .bind(glsl::luminance::SEEN, SEEN)
    .specialise([across, u32::from(desc.layers || layout.luminance_parts > 1)]);
    match desc.settings.shadow {
        Shadow::None => pass,
        Shadow::Exact => pass.bind(glsl::luminance_exact::CELLS, CELLS).bind(glsl::luminance_exact::CASTERS, CASTERS),
        Shadow::Map => {
            pass.bind(glsl::luminance_map::SHADOW_MAP, SHADOW_MAP).bind(glsl::luminance_map::CONTROL_BUFFER, CONTROL)
        }
    }
}

/// Dilated block masks, items, rows and columns.
fn declare_gaussian(d: &mut Declare) -> [PassId; 4] {
    [
        d.compute(
            "smoke.tiles",
            &glsl::dilate::SHADER,
            &[(glsl::dilate::BLOCK_MASKS, BLOCK_MASKS), (glsl::dilate::REACHED, REACHED)],
        ),
        d.compute(
            "smoke.tiles",
            &glsl::items::SHADER,
            &[
                (glsl::items::TILE_GROUPS, TILE_GROUPS),
                (glsl::items::ROW_ITEMS, ROW_ITEMS),
                (glsl::items::COLUMN_ITEMS, COLUMN_ITEMS),
                (glsl::items::ROW_SLOTS, ROW_SLOTS),
                (glsl::items::ITEM_ARGUMENTS, ITEM_ARGUMENTS),
            ],
        ),
        d.compute(
            "smoke.rows",
            &glsl::rows::SHADER,
            &[
                (glsl::rows::WEIGHTS, WEIGHTS),
                (glsl::rows::REACHED, REACHED),
                (glsl::rows::BLOCK_MASKS, BLOCK_MASKS),
                (glsl::rows::ROW_ITEMS, ROW_ITEMS),
                (glsl::rows::PIXELS, PIXELS),
                (glsl::rows::ROW_SUMS, ROW_SUMS),
            ],
        ),
        d.compute(
            "smoke.columns",
            &glsl::columns::SHADER,
            &[
                (glsl::columns::WEIGHTS, WEIGHTS),
                (glsl::columns::REACHED, REACHED),
                (glsl::columns::BLOCK_MASKS, BLOCK_MASKS),
                (glsl::columns::COLUMN_ITEMS, COLUMN_ITEMS),
                (glsl::columns::ROW_SLOTS, ROW_SLOTS),
                (glsl::columns::ROW_SUMS, ROW_SUMS),
                (glsl::columns::PIXELS, PIXELS),
                (glsl::columns::SMOOTH, SMOOTH),
            ],
        ),
    ]
}

fn declare_tone(desc: &Desc) -> Pass {
    let settings = &desc.settings;
    let reach = settings.outline.width.ceil() as u32 - 1;
    bound(
        Pass::compute("smoke.tone", &glsl::tone::SHADER),
        &[
            (glsl::tone::OCCUPIED_TILES, OCCUPIED_TILES),
            (glsl::tone::PIXELS, PIXELS),
            (glsl::tone::SMOOTH, SMOOTH),
            (glsl::tone::LINES, LINES),
            (glsl::tone::TONES, TONES),
            (glsl::tone::PICTURE, PICTURE),
            (glsl::tone::TONE_LAYER, TONE_LAYER),
            (glsl::tone::OUTLINE_LAYER, OUTLINE_LAYER),
        ],
    )
    .specialise([
        u32::from(settings.sigma > 0.0),
        u32::from(settings.outline.strength > 0.0),
        u32::from(desc.layers),
        reach,
    ])
}

fn declare_composite(desc: &Desc) -> Pass {
    let raster = Raster {
        vertex: &glsl::composite_vertex::SHADER,
        fragment: &glsl::composite_fragment::SHADER,
        colour: Some(ColourAttachment { image: TARGET, format: desc.target_format, clear: None, blend: true }),
        depth: None,
        extent: desc.size,
    };
    bound(
        Pass::raster("smoke.composite", raster),
        &[(glsl::composite_vertex::OCCUPIED_TILES, OCCUPIED_TILES), (glsl::composite_fragment::PICTURE, PICTURE)],
    )
}

/// What the effect knows of a frame when it chooses the steps.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Shape of the volume.
    pub shape: Shape,
    /// All particles are born anew.
    pub restart: bool,
    /// A volume came with this frame.
    pub new_volume: bool,
    /// First frame: tables are to be written.
    pub first: bool,
    /// Why particles stay as they are, if they do.
    pub still: Option<&'static str>,
    /// Why the shadows of the last frame serve, if they do.
    pub same_shadow: Option<&'static str>,
}

/// The way a radius is searched in a volume of this shape.
pub fn chosen_grow(settings: &Settings, shape: &Shape) -> Grow {
    let field_works = shape.is_cubic() && settings.radius == Radius::Box && shape.dimensions.iter().min() <= Some(&500);
    match settings.grow {
        Grow::Chosen if !field_works => Grow::Pyramid,
        Grow::Chosen => {
            // Measured on lavapipe (`celfx bench smoke`, rows `grow`): the field costs as much as some 4 searched
            // particles per 1000 voxels.
            let per_search = 250.0;
            let field_pays = f64::from(settings.particles) * per_search > shape.voxels() as f64;
            if field_pays { Grow::Field } else { Grow::Pyramid }
        }
        other => other,
    }
}

impl Passes {
    /// Fills `plan` with the steps of a frame.
    pub fn plan(
        &self,
        plan: &mut Plan,
        desc: &Desc,
        layout: &Layout,
        frame: &Frame,
        moment: &Moment,
        params: &SmokeParams,
        tables: &Tables,
    ) {
        plan.clear();
        if let Some(target) = &frame.target {
            self.plan_background(plan, desc, &frame.background, target.extent);
        }
        if desc.settings.particles == 0 {
            for name in PARTICLE_STEPS.into_iter().chain(PICTURE_STEPS) {
                plan.skip(name, "no particles");
            }
            return;
        }
        plan.update(self.params, PARAMS, params);
        plan.update(self.params, CONTROL, &Control::reset());
        if moment.first {
            plan.update_slice(self.tables, WEIGHTS, &tables.weights);
            plan.update_slice(self.tables, TONES, &tables.tones);
        } else {
            plan.skip("smoke.tables", "unchanged");
        }
        self.plan_volume(plan, desc, moment);
        self.plan_particles(plan, desc, layout, moment);
        let reason = frame.target.is_none().then_some("no target: the frame only moves the particles on");
        match reason {
            Some(reason) => PICTURE_STEPS.into_iter().for_each(|name| plan.skip(name, reason)),
            None => self.plan_picture(plan, desc, layout, moment),
        }
    }

    fn plan_background(&self, plan: &mut Plan, desc: &Desc, background: &Background, extent: [u32; 2]) {
        debug_assert_eq!(extent, desc.size);
        match background {
            Background::Keep => plan.skip("smoke.background", "the target is kept"),
            Background::Clear(colour) => {
                plan.step(self.background, Command::Clear { image: TARGET, value: colour.map(f32::to_bits) });
            }
            Background::Copy(_) => {
                plan.step(self.background, Command::CopyImage { from: BACKGROUND, to: TARGET, extent });
            }
        }
    }

    fn plan_volume(&self, plan: &mut Plan, desc: &Desc, moment: &Moment) {
        if !moment.new_volume {
            plan.skip("smoke.volume", "unchanged");
            plan.skip("smoke.occupancy", "volume and threshold unchanged");
            return;
        }
        let shape = &moment.shape;
        let bytes = 4 * shape.voxels();
        plan.step(self.volume, Command::CopyBuffer { from: HOST_DENSITY, to: DENSITY, bytes });
        if desc.velocity {
            plan.step(self.volume, Command::CopyBuffer { from: HOST_VELOCITY, to: VELOCITY, bytes: 3 * bytes });
        }
        let pyramid = Pyramid::new(shape.dimensions);
        let words = pyramid.row_words * shape.dimensions[1] * shape.dimensions[2];
        let blocks = words.div_ceil(BIRTH_BLOCK);
        plan.step(self.occupancy, Command::Dispatch { threads: [words, 1, 1] });
        plan.step_with(self.births, Command::Dispatch { threads: [256, 1, 1] }, &BirthsConstants { blocks });
        match chosen_grow(&desc.settings, shape) {
            Grow::Field => {
                let [nx, ny, nz] = shape.dimensions;
                for pass in self.field {
                    plan.step(pass, Command::Dispatch { threads: [nx.div_ceil(4) * ny * nz, 1, 1] });
                }
                plan.skip("smoke.pyramid", "the field is searched");
            }
            Grow::Pyramid => {
                for level in 1..pyramid.count {
                    let [_, y, z, _] = pyramid.levels[level as usize];
                    let threads = [pyramid.row_words * y * z, 1, 1];
                    plan.step_with(self.pyramid, Command::Dispatch { threads }, &PyramidConstants { level });
                }
                plan.skip("smoke.field", "the pyramid is searched");
            }
            _ => plan.skip("smoke.field", "voxels are searched one by one"),
        }
    }

    fn plan_particles(&self, plan: &mut Plan, desc: &Desc, layout: &Layout, moment: &Moment) {
        let threads = [desc.settings.particles, 1, 1];
        if moment.restart {
            for buffer in [DYING, SPHERES, GROUPS] {
                plan.step(self.restart, Command::Fill { buffer, word: 0 });
            }
        }
        if let Some(reason) = moment.still {
            plan.skip("smoke.advect", reason);
            plan.skip("smoke.grow", reason);
        } else {
            plan.step(self.advect, Command::Dispatch { threads });
            let pyramid = Pyramid::new(moment.shape.dimensions);
            match chosen_grow(&desc.settings, &moment.shape) {
                Grow::Field => plan.step(self.grow_field, Command::Dispatch { threads }),
                Grow::Growth => {
                    self.plan_search(plan, desc, self.grow_growth, &pyramid, growth_rows(&moment.shape));
                }
                _ => self.plan_search(plan, desc, self.grow_pyramid, &pyramid, pyramid.leaves()),
            }
        }
        let spheres = [layout.spheres.div_ceil(LIST_RUN), 1, 1];
        plan.step(self.count, Command::Dispatch { threads: spheres });
        plan.step(self.scan, Command::Dispatch { threads: [256, 1, 1] });
        plan.step(self.listing, Command::Dispatch { threads: spheres });
    }

    /// A search in as many dispatches as the loop budget may ask for; all but the first are empty unless needed.
    fn plan_search(&self, plan: &mut Plan, desc: &Desc, pass: PassId, pyramid: &Pyramid, last: u32) {
        let turns = pyramid.turns();
        // A walk of the pyramid also visits the inner nodes.
        let visits = if pass == self.grow_pyramid { last.saturating_mul(4).div_ceil(3) } else { last };
        let parts = visits.div_ceil(turns).max(1);
        let ball = u32::from(desc.settings.radius == Radius::Ball);
        plan.step(self.grow_reset, Command::Fill { buffer: CONTINUATIONS, word: 0 });
        for part in 0..parts {
            let constants = SearchConstants { part, turns, ball, last };
            let command = match part {
                0 => Command::Dispatch { threads: [desc.settings.particles, 1, 1] },
                _ => Command::DispatchIndirect { arguments: CONTINUATIONS, offset: 16 * u64::from(part - 1) },
            };
            plan.step_with(pass, command, &constants);
        }
    }

    fn plan_picture(&self, plan: &mut Plan, desc: &Desc, layout: &Layout, moment: &Moment) {
        let settings = &desc.settings;
        self.plan_shadow(plan, desc, moment);
        self.plan_clear(plan, desc);
        let offset = |member: usize| member as u64;
        let draw = offset(std::mem::offset_of!(Control, draw));
        plan.step(self.spheres, Command::DrawIndirect { arguments: CONTROL, offset: draw });
        let threads = [layout.tiles[0] * 8, layout.tiles[1] * 16, 1];
        plan.step(self.tiles, Command::Dispatch { threads });
        let parts = OccupiedConstants { parts: layout.luminance_parts, part_turns: LUMINANCE_TURNS };
        plan.step_with(self.occupied, Command::Dispatch { threads: [256, 1, 1] }, &parts);
        for part in 0..layout.luminance_parts {
            let command = Command::DispatchIndirect { arguments: LUMINANCE_PARTS, offset: 16 * u64::from(part) };
            match settings.shadow {
                Shadow::None => plan.step(self.luminance, command),
                Shadow::Exact => {
                    let constants = LuminanceConstants { part, turns: LUMINANCE_TURNS };
                    plan.step_with(self.luminance, command, &constants);
                }
                Shadow::Map => plan.step_with(self.luminance, command, &MapConstants { texels: settings.shadow_map }),
            }
        }
        self.plan_gaussian(plan, desc, layout);
        let tiles = Command::DispatchIndirect {
            arguments: CONTROL,
            offset: offset(std::mem::offset_of!(Control, tile_groups)),
        };
        match settings.outline.strength > 0.0 {
            true => plan.step(self.outline, tiles),
            false => plan.skip("smoke.outline", "strength is 0"),
        }
        plan.step(self.tone, tiles);
        let draw = offset(std::mem::offset_of!(Control, tile_draw));
        plan.step(self.composite, Command::DrawIndirect { arguments: CONTROL, offset: draw });
    }

    /// What reads beyond occupied tiles must find them empty; layers are whole images.
    fn plan_clear(&self, plan: &mut Plan, desc: &Desc) {
        plan.step(self.clear, Command::Fill { buffer: PIXELS, word: 0 });
        plan.step(self.clear, Command::Fill { buffer: DEPTH, word: f32::INFINITY.to_bits() });
        if desc.settings.outline.strength > 0.0 {
            plan.step(self.clear, Command::Fill { buffer: LINES, word: 0 });
        }
        if desc.layers {
            plan.step(self.clear, Command::Fill { buffer: SHADOW, word: 1.0_f32.to_bits() });
            for buffer in [SMOOTH, PICTURE, TONE_LAYER, OUTLINE_LAYER] {
                plan.step(self.clear, Command::Fill { buffer, word: 0 });
            }
        }
    }

    fn plan_shadow(&self, plan: &mut Plan, desc: &Desc, moment: &Moment) {
        let settings = &desc.settings;
        let reason = match settings.shadow {
            Shadow::None => Some("shadow is \"none\""),
            _ => moment.same_shadow,
        };
        if let Some(reason) = reason {
            plan.skip("smoke.shadow", reason);
            return;
        }
        let live =
            Command::DispatchIndirect { arguments: CONTROL, offset: std::mem::offset_of!(Control, live_groups) as u64 };
        if settings.shadow == Shadow::Exact {
            plan.step(self.shadow_reset, Command::Fill { buffer: CELLS, word: 0 });
            plan.step(self.shadow_count, live);
            plan.step(self.shadow_scan, Command::Dispatch { threads: [256, 1, 1] });
            plan.step(self.shadow_fill, live);
        }
        for (face, pass) in self.shadow_map.iter().enumerate() {
            let draw =
                Command::DrawIndirect { arguments: CONTROL, offset: std::mem::offset_of!(Control, light_draw) as u64 };
            let constants = ShadowConstants { face: face as u32, texels: settings.shadow_map as f32 };
            plan.step_with(*pass, draw, &constants);
        }
    }

    fn plan_gaussian(&self, plan: &mut Plan, desc: &Desc, layout: &Layout) {
        if desc.settings.sigma == 0.0 {
            plan.skip("smoke.rows", "sigma is 0");
            plan.skip("smoke.columns", "sigma is 0");
            return;
        }
        let blocks = layout.tiles[0] * layout.tiles[1] * TILE_BLOCKS * TILE_BLOCKS;
        plan.step(self.dilate, Command::Dispatch { threads: [blocks, 1, 1] });
        for batch in 0..layout.batches {
            let first_group = 1 + batch * layout.batch_groups;
            let group_count = layout.batch_groups.min(desc.settings.group_count() + 1 - first_group);
            let capacity = layout.batch_capacity;
            let items = ItemsConstants { batch, first_group, group_count, capacity };
            plan.step_with(self.items, Command::Dispatch { threads: [256, 1, 1] }, &items);
            let constants = GaussianConstants { base: batch * capacity, first_group };
            for (pass, argument) in [(self.rows, 2 * batch), (self.columns, 2 * batch + 1)] {
                let offset = 16 * u64::from(argument);
                let command = Command::DispatchIndirect { arguments: ITEM_ARGUMENTS, offset };
                plan.step_with(pass, command, &constants);
            }
        }
    }

    /// Room that a plan of this effect needs: steps, and bytes of updates.
    pub fn capacity(layout: &Layout, tables: &Tables) -> (usize, usize) {
        let steps = 80 + layout.search_parts + layout.luminance_parts + 3 * layout.batches;
        let bytes =
            size_of::<SmokeParams>() + size_of::<Control>() + 4 * tables.weights.len() + 16 * tables.tones.len();
        (steps as usize, bytes)
    }
}

/// What never changes: the Gaussian's weights by distance, and the tones.
#[derive(Clone, Debug)]
pub struct Tables {
    weights: Vec<f32>,
    tones: Vec<[f32; 4]>,
}

impl Tables {
    /// From settings.
    pub fn new(settings: &Settings, layout: &Layout) -> Tables {
        let sigma = f64::from(settings.sigma);
        let weight = |distance: u32| match distance <= settings.window() {
            true => (-f64::from(distance).powi(2) / (2.0 * sigma * sigma)).exp() as f32,
            false => 0.0,
        };
        let weights = match settings.sigma > 0.0 {
            true => (0..(layout.window_blocks + 1) * BLOCK).map(weight).collect(),
            false => vec![1.0],
        };
        let tones = settings.tones.iter().map(|tone| {
            let [r, g, b] = tone.colour;
            [r, g, b, tone.from]
        });
        Tables { weights, tones: tones.collect() }
    }
}
