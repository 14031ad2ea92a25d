//! Pass `gaussian`: the masked Gaussian by its definition, by the wrong separable form, by the exact one with and without
//! skipping, and a plain Gaussian without mask, which shows what the mask costs.
//!
//! `soft_tiles` is the same picture's Gaussian under the soft mask, a definition of its own: so is what its error is taken from.
//!
//! The time of `per_id_tiles` and of `soft_tiles` is that of everything that a frame has because of the mask (dilated block masks, items, rows
//! and columns), less the pass `tiles`, which a frame needs anyway: the later steps work on occupied tiles.

use std::collections::BTreeSet;

use super::{EFFECT, scene};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, KernelBuffer, KernelsId, Measured, Rig};
use crate::bench::{Outcome, Session};
use crate::error::Result;
use crate::gpu::buffer::BufferDesc;
use crate::plan::{BufferId, Command, Kernel, Pass, PassId, Plan};
use crate::shaders::smoke as glsl;
use crate::smoke::Settings;
use crate::smoke::layout::{DEPTH, PARAMS, PIXELS, REACHED, SMOOTH, WEIGHTS};
use crate::smoke::params::{GROUP_BITS, GROUP_MASK, ImageConstants, LUMINANCE_ONE, SLOT_PIXELS, TILE};
use crate::smoke::reference::masked;
use crate::smoke::settings::{LINES, Mask};

const PASS: &str = "gaussian";
const VARIANTS: [(&str, Variant); 6] = [
    ("direct", Variant::Direct),
    ("naive", Variant::Naive),
    ("per_id_image", Variant::PerIdImage),
    ("per_id_tiles", Variant::PerIdTiles),
    ("soft_tiles", Variant::SoftTiles),
    ("plain", Variant::Plain),
];
/// Name, pixels, what `--quick` divides the sides by, sigma.
const WORKLOADS: [(&str, [u32; 2], u32, f32); 3] = [
    ("512x512 sigma 4", scene::PAPER, 1, 4.0),
    ("512x512 sigma 8", scene::PAPER, 1, 8.0),
    ("1920x1080 sigma 8", scene::FULL_HD, 4, 8.0),
];
const PARTICLES: u32 = 1000;
const GROUPS: u32 = 8;
/// Share of the picture that is covered.
const COVER: f64 = 0.5;
const VOXELS: [u32; 3] = [48, 72, 48];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Variant {
    Direct,
    Naive,
    PerIdImage,
    PerIdTiles,
    SoftTiles,
    Plain,
}

// Buffers and passes of the kernels that only the benchmark has, in this order.
const OWN_PARAMS: BufferId = BufferId(0);
const OWN_WEIGHTS: BufferId = BufferId(1);
const OWN_REACHED: BufferId = BufferId(2);
const OWN_PIXELS: BufferId = BufferId(3);
const OWN_ROWS: BufferId = BufferId(4);
const OWN_SMOOTH: BufferId = BufferId(5);
const DIRECT: PassId = PassId(0);
const NAIVE: [PassId; 2] = [PassId(1), PassId(2)];
const IMAGE: [PassId; 2] = [PassId(3), PassId(4)];
const PLAIN: [PassId; 2] = [PassId(5), PassId(6)];

/// The picture that is filtered.
struct Picture {
    id: Vec<u32>,
    /// Its values after the masked Gaussian.
    smooth: Vec<f64>,
}

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, size, cut, sigma) in WORKLOADS {
        let (name, size) = session.picture(name, size, cut);
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("smoke gaussian {name}"))?;
            measure_workload(session, &name, size, sigma, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(
    session: &mut Session,
    name: &str,
    size: [u32; 2],
    sigma: f32,
    variants: &[&(&str, Variant)],
) -> Outcome {
    let rig = &mut session.rig;
    let mask = Mask::Groups;
    let settings = Settings { particles: PARTICLES, mask, groups: GROUPS, sigma, fade: 0, ..Settings::default() };
    let soft_settings = Settings { mask: Mask::Soft, ..settings.clone() };
    let [grouped, soft] = [Masked::new(rig, size, &settings)?, Masked::new(rig, size, &soft_settings)?];
    let effect = grouped.effect;
    let of = |variant: Variant| if variant == Variant::SoftTiles { &soft } else { &grouped };
    let kernels = kernels(rig, effect, size, &settings)?;
    let plans: Vec<Plan> = variants.iter().map(|(_, variant)| plan(*variant, size)).collect();
    for plan in &plans {
        rig.warm_up(kernels, plan)?;
    }
    let mut results: Vec<Vec<f32>> = vec![Vec::new(); variants.len()];
    let times = interleaved(variants.len(), session.quick, |i| {
        let (variant, pixels) = (variants[i].1, grouped.picture.id.len());
        let Masked { effect, steps, .. } = of(variant);
        let time: Measured = if variant.is_ours() { rig.replay(*effect, steps)? } else { rig.run(kernels, &plans[i])? };
        if results[i].is_empty() {
            results[i] = match variant.is_ours() {
                true => rig.read(*effect, SMOOTH, pixels)?,
                false => rig.read_kernels(kernels, OWN_SMOOTH, pixels)?,
            };
        }
        Ok(time)
    })?;
    for ((((variant, kind), times), result), plan) in variants.iter().zip(&times).zip(results).zip(&plans) {
        let (variant, workload) = ((*variant).to_owned(), name.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: PARTICLES.into() };
        let Masked { effect, steps, picture } = of(*kind);
        let work = match kind.is_ours() {
            true => session.rig.work_of_replay(*effect, steps)?,
            false => session.rig.work_of_run(kernels, plan)?,
        };
        session.rows.push(Row::new(EFFECT, subject, times, &picture.accuracy(&result), work, &session.limits));
    }
    Ok(())
}

impl Variant {
    /// Whether the effect's own kernels are measured.
    fn is_ours(self) -> bool {
        matches!(self, Variant::PerIdTiles | Variant::SoftTiles)
    }
}

/// The scene under a mask.
struct Masked {
    effect: EffectId,
    /// What a frame has because of the mask.
    steps: Plan,
    picture: Picture,
}

impl Masked {
    fn new(rig: &mut Rig, size: [u32; 2], settings: &Settings) -> Result<Masked> {
        let effect = render(rig, size, settings)?;
        Ok(Masked { effect, steps: rig.effect_steps(effect), picture: Picture::read(rig, effect, size, settings)? })
    }
}

/// Renders the scene, the camera so near that about half of the picture is covered.
fn render(rig: &mut Rig, size: [u32; 2], settings: &Settings) -> Result<EffectId> {
    let volume = scene::still_plume(VOXELS);
    let effect = rig.effect(scene::desc(size, &volume, settings.clone(), false))?;
    rig.frame(effect, &scene::first_scene(scene::camera(), &volume))?;
    let (spheres, _) = scene::spheres(rig, effect, PARTICLES, settings.fade)?;
    let camera = scene::camera_covering(&spheres, size, COVER);
    rig.frame(effect, &scene::first_scene(camera, &volume))?;
    Ok(effect)
}

impl Rig {
    /// The steps that a frame has because of the mask.
    fn effect_steps(&self, effect: EffectId) -> Plan {
        self.steps(effect, |pass| match &pass.kernel {
            Kernel::Compute(shader) => {
                matches!(pass.name, "smoke.rows" | "smoke.columns")
                    || matches!(shader.file, "smoke/dilate.comp" | "smoke/items_sum.comp" | "smoke/items.comp")
            }
            _ => false,
        })
    }
}

fn kernels(rig: &mut Rig, effect: EffectId, size: [u32; 2], settings: &Settings) -> Result<KernelsId> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    let padded = u64::from(tiles(size)) * u64::from(SLOT_PIXELS);
    let buffers = vec![
        KernelBuffer::Shared(effect, PARAMS),
        KernelBuffer::Shared(effect, WEIGHTS),
        KernelBuffer::Shared(effect, REACHED),
        KernelBuffer::Shared(effect, PIXELS),
        KernelBuffer::Own(BufferDesc::storage("row sums", padded * 8)),
        KernelBuffer::Own(BufferDesc::storage("smooth", pixels * 4)),
    ];
    let sigma = f64::from(settings.sigma);
    let weight = |distance: u32| (-f64::from(distance).powi(2) / (2.0 * sigma * sigma)).exp();
    let sum = 1.0 + 2.0 * (1..=settings.pixels(LINES).window()).map(weight).sum::<f64>();
    rig.kernels(buffers, passes((1.0 / sum) as f32))
}

/// In the order of the ids above. `scale` is 1 / the sum of a row's weights.
fn passes(scale: f32) -> Vec<Pass> {
    use glsl::{
        bench_direct as direct, bench_image_columns as image_columns, bench_image_rows as image_rows,
        bench_naive_columns as naive_columns, bench_naive_rows as naive_rows, bench_plain_columns as plain_columns,
        bench_plain_rows as plain_rows,
    };
    let pass = |name, shader| {
        let pass = Pass::compute(name, shader);
        let pass = pass.bind(direct::SMOKE_PARAMS, OWN_PARAMS).bind(direct::WEIGHTS, OWN_WEIGHTS);
        if name == "bench.direct" || name == "bench.naive" { pass.bind(direct::PIXELS, OWN_PIXELS) } else { pass }
    };
    let ours = |name, shader| pass(name, shader).bind(image_rows::REACHED, OWN_REACHED);
    vec![
        pass("bench.direct", &direct::SHADER).bind(direct::SMOOTH, OWN_SMOOTH),
        pass("bench.naive", &naive_rows::SHADER).bind(naive_rows::ROW_SUMS, OWN_ROWS),
        pass("bench.naive", &naive_columns::SHADER)
            .bind(naive_columns::ROW_SUMS, OWN_ROWS)
            .bind(naive_columns::SMOOTH, OWN_SMOOTH),
        ours("bench.per_id_image", &image_rows::SHADER)
            .bind(image_rows::PIXELS, OWN_PIXELS)
            .bind(image_rows::ROW_SUMS, OWN_ROWS),
        ours("bench.per_id_image", &image_columns::SHADER)
            .bind(image_columns::PIXELS, OWN_PIXELS)
            .bind(image_columns::ROW_SUMS, OWN_ROWS)
            .bind(image_columns::SMOOTH, OWN_SMOOTH),
        ours("bench.plain", &plain_rows::SHADER)
            .bind(plain_rows::PIXELS, OWN_PIXELS)
            .bind(plain_rows::PLAIN_ROWS, OWN_ROWS)
            .specialise([scale.to_bits()]),
        ours("bench.plain", &plain_columns::SHADER)
            .bind(plain_columns::PLAIN_ROWS, OWN_ROWS)
            .bind(plain_columns::SMOOTH, OWN_SMOOTH)
            .specialise([scale.to_bits()]),
    ]
}

fn tiles(size: [u32; 2]) -> u32 {
    size[0].div_ceil(TILE) * size[1].div_ceil(TILE)
}

/// The plan of a variant; nothing for the effect's own steps.
fn plan(variant: Variant, size: [u32; 2]) -> Plan {
    let mut plan = Plan::default();
    let image = Command::Dispatch { threads: [size[0], size[1], 1] };
    // One workgroup a tile, of the shape that gaussian.glsl has.
    let [x, y, _] = glsl::bench_plain_rows::SHADER.local_size;
    let by_tile = Command::Dispatch { threads: [tiles(size) * x, y, 1] };
    match variant {
        Variant::Direct => plan.step(DIRECT, image),
        Variant::Naive => NAIVE.into_iter().for_each(|pass| plan.step(pass, image)),
        Variant::PerIdImage => {
            for group in 1..=GROUPS {
                let constants = ImageConstants { group };
                IMAGE.into_iter().for_each(|pass| plan.step_with(pass, by_tile, &constants));
            }
        }
        Variant::Plain => PLAIN.into_iter().for_each(|pass| plan.step(pass, by_tile)),
        Variant::PerIdTiles | Variant::SoftTiles => {}
    }
    plan
}

impl Picture {
    fn read(rig: &mut Rig, effect: EffectId, size: [u32; 2], settings: &Settings) -> Result<Picture> {
        let pixels: Vec<u32> = rig.read(effect, PIXELS, size[0] as usize * size[1] as usize)?;
        let luminance = |pixel: &u32| f64::from(pixel >> GROUP_BITS) / f64::from(LUMINANCE_ONE);
        let luminance: Vec<f64> = pixels.iter().map(luminance).collect();
        let id: Vec<u32> = pixels.iter().map(|pixel| pixel & GROUP_MASK).collect();
        let depth: Vec<f32> = rig.read(effect, DEPTH, pixels.len())?;
        let depth: Vec<f64> = depth.into_iter().map(f64::from).collect();
        let ranges = scene::ranges(rig, effect, settings)?;
        let (_, smooth) = masked(settings, size, &luminance, &depth, id.clone(), &ranges);
        Ok(Picture { id, smooth })
    }

    fn accuracy(&self, result: &[f32]) -> Accuracy {
        let pixels = result.iter().zip(&self.smooth).zip(&self.id).filter(|(_, id)| **id != 0);
        let differences = pixels.map(|((result, smooth), _)| (f64::from(*result) - smooth).abs()).collect();
        let covered = 100.0 * self.id.iter().filter(|id| **id != 0).count() as f64 / self.id.len().max(1) as f64;
        let groups = self.id.iter().filter(|id| **id != 0).collect::<BTreeSet<_>>().len();
        let of = format!("direct 2-D sum in f64, of luminance 0 to 1, {covered:.0} % covered by {groups} groups");
        Deviation::of(differences).map(|deviation| (deviation, of))
    }
}
