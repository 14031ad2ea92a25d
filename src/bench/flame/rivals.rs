//! Ways to blend fire without repetitions: each particle as fog at the depth of its centre, sorted, or weighed
//! and not sorted. Colours, counts, chances to pass and lists are those of an effect in the `expected` mode.

use std::mem::offset_of;

use crate::bench::rig::{EffectId, KernelBuffer, KernelsId, Rig};
use crate::error::Result;
use crate::flame::layout::{BUFFERS, CONTROL, resource};
use crate::flame::params::{Control, KERNEL_CLASSES, KERNEL_PLACES, PRESENT_BITS};
use crate::gpu::buffer::BufferDesc;
use crate::plan::{BufferId, Command, Pass, PassId, Plan, Resource};
use crate::shaders::flame as glsl;

use super::scene::Scene;

const FAR_TABLE: BufferId = BufferId(BUFFERS);
const RANKS: BufferId = BufferId(BUFFERS + 1);
const ORDER: BufferId = BufferId(BUFFERS + 2);
const BLENDED: BufferId = BufferId(BUFFERS + 3);

const FAR: PassId = PassId(0);
const RANK: PassId = PassId(1);
const SORTED: PassId = PassId(2);
const WEIGHTED: PassId = PassId(3);

/// The two of them, on an effect's lists.
#[derive(Clone, Copy)]
pub(super) struct Rivals {
    kernels: KernelsId,
    pixels: usize,
}

impl Rivals {
    /// On the lists of a frame that the effect has rendered; it is in the `expected` mode.
    pub(super) fn new(rig: &mut Rig, effect: EffectId, scene: &Scene) -> Result<Rivals> {
        let particles = scene.particles.position.len();
        assert!(particles <= PRESENT_BITS as usize, "a workload has at most {PRESENT_BITS} particles");
        let pixels = scene.size[0] as usize * scene.size[1] as usize;
        let mut buffers: Vec<_> = (0..BUFFERS).map(|id| KernelBuffer::Shared(effect, BufferId(id))).collect();
        let table = u64::from(KERNEL_CLASSES * KERNEL_PLACES * KERNEL_PLACES);
        let own = [("far table", table), ("ranks", particles as u64), ("order", particles as u64)];
        buffers.extend(own.map(|(name, words)| KernelBuffer::Own(BufferDesc::storage(name, words * 4))));
        buffers.push(KernelBuffer::Own(BufferDesc::storage("blended", pixels as u64 * 16)));
        let kernels = rig.kernels(buffers, passes())?;
        // The table stays as long as settings do.
        let mut plan = Plan::default();
        plan.step(FAR, Command::Dispatch { threads: [table as u32, 1, 1] });
        rig.run(kernels, &plan)?;
        Ok(Rivals { kernels, pixels })
    }

    pub(super) fn kernels(&self) -> KernelsId {
        self.kernels
    }

    /// The steps of one of them.
    pub(super) fn plan(&self, scene: &Scene, sorted: bool) -> Plan {
        let mut plan = Plan::default();
        if sorted {
            plan.step(RANK, Command::Dispatch { threads: [scene.particles.position.len() as u32, 1, 1] });
        }
        let offset = offset_of!(Control, tile_groups) as u64;
        let tiles = Command::DispatchIndirect { arguments: CONTROL, offset };
        plan.step(if sorted { SORTED } else { WEIGHTED }, tiles);
        plan
    }

    /// Mean colour of each pixel after the run before.
    pub(super) fn mean(&self, rig: &mut Rig) -> Result<Vec<[f32; 4]>> {
        rig.read_kernels(self.kernels, BLENDED, self.pixels)
    }
}

/// In the order of the ids above.
fn passes() -> Vec<Pass> {
    let bind = |name, shader| {
        Pass::compute(name, shader).bind_all(|binding| match binding.name {
            "FarTable" => Some(Resource::Buffer(FAR_TABLE)),
            "Ranks" => Some(Resource::Buffer(RANKS)),
            "Order" => Some(Resource::Buffer(ORDER)),
            "Blended" => Some(Resource::Buffer(BLENDED)),
            _ => resource(binding),
        })
    };
    vec![
        bind("bench.far", &glsl::bench_far::SHADER),
        bind("bench.sorted", &glsl::bench_rank::SHADER),
        bind("bench.sorted", &glsl::bench_sorted::SHADER),
        bind("bench.weighted", &glsl::bench_weighted::SHADER),
    ]
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::bench::measure::Deviation;
    use crate::flame::Settings;
    use crate::flame::reference::kernel::Body;
    use crate::flame::reference::mask::Mask;
    use crate::flame::reference::prepare::{mask_level, prepare};
    use crate::flame::reference::weights::Weights;
    use crate::flame::settings::{Mode, Shape};
    use crate::gpu::headless::{Headless, Options};

    /// A particle as fog at one pixel.
    struct Fog {
        depth: f64,
        colour: DVec3,
        opacity: f64,
    }

    /// The fog at a pixel, in f64 and without a table.
    fn fogs(scene: &super::Scene, at: [usize; 2]) -> Vec<Fog> {
        let Scene { settings, camera, size, particles, .. } = scene;
        let rows = particles.position.iter().zip(&particles.temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]);
        let prepared = prepare(settings, 3000.0, 0, camera, &rows.collect::<Vec<_>>(), particles.id.as_deref());
        let mask = Mask::new(0, settings.variants);
        let level = mask_level(settings, camera, *size, prepared.nearest);
        let half = camera.half_extent(*size);
        let ray = |axis: usize, side: u32| (2.0 * at[axis] as f64 + 1.0) / f64::from(side) - 1.0;
        let slope = half * DVec2::new(ray(0, size[0]), -ray(1, size[1]));
        let rotation = camera.rotation();
        let fog = |p: &crate::flame::reference::prepare::Particle| {
            let centre = rotation * (DVec3::from_array(p.centre.map(f64::from)) - camera.eye);
            let body = |weights| Body {
                weights,
                fill: 1.0,
                half: 0.5 * f64::from(settings.sprite()),
                spread: f64::from(settings.spread.unwrap_or_default()),
                shape: Shape::Ball,
                rotation,
            };
            let beside = centre.z * slope - centre.truncate();
            let none = Weights::from_values(vec![], 1);
            if !body(&none).touches(beside, DVec2::ZERO) {
                return None;
            }
            let weights = Weights::new(&mask, level, p.alpha, settings.threshold.into(), 64);
            let mut share = [0.0];
            let always = [f64::NEG_INFINITY, f64::INFINITY];
            body(&weights).shares(beside, DVec2::ZERO, always, &[1e3], &mut share);
            let opacity = 1.0 - (1.0 - share[0]).powi(p.count as i32);
            Some(Fog { depth: centre.z, colour: DVec3::from_array(p.colour), opacity })
        };
        let mut fogs: Vec<Fog> = prepared.particles.iter().filter_map(fog).collect();
        fogs.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        fogs
    }

    fn sorted(fogs: &[Fog]) -> DVec3 {
        let step = |(mean, left): (DVec3, f64), fog: &Fog| {
            (mean + left * fog.opacity * fog.colour, left * (1.0 - fog.opacity))
        };
        fogs.iter().fold((DVec3::ZERO, 1.0), step).0
    }

    /// `range`: depths that anything can have.
    fn weighted(fogs: &[Fog], range: [f64; 2]) -> DVec3 {
        let weight = |fog: &Fog| {
            let depth = (fog.depth - range[0]) / (range[1] - range[0]);
            fog.opacity * fog.opacity * (3e3 * (1.0 - depth).powi(3)).max(1e-2)
        };
        let sum: f64 = fogs.iter().map(weight).sum();
        let colour: DVec3 = fogs.iter().map(|fog| weight(fog) * fog.colour).sum();
        let left: f64 = fogs.iter().map(|fog| 1.0 - fog.opacity).product();
        if sum > 0.0 { (1.0 - left) * colour / sum } else { DVec3::ZERO }
    }

    #[test]
    fn both_are_what_their_definitions_say() -> std::result::Result<(), Box<dyn std::error::Error>> {
        let options = Options { validate: true, device: std::env::var("CELFX_DEVICE").ok(), ..Options::default() };
        let headless = match Headless::new(&options) {
            Ok(headless) => headless,
            Err(error) if std::env::var_os("CELFX_REQUIRE_VULKAN").is_some() => return Err(error.into()),
            Err(_) => return Ok(()),
        };
        let mut rig = Rig::new(headless)?;
        let messages = rig.messages();
        let scene = Scene::new(&crate::bench::flame::scene::THICK, true);
        let settings = Settings { mode: Mode::Expected, ..scene.settings.clone() };
        let effect = scene.render(&mut rig, settings)?;
        let rivals = Rivals::new(&mut rig, effect, &scene)?;
        let mut found = Vec::new();
        for is_sorted in [true, false] {
            rig.run(rivals.kernels(), &rivals.plan(&scene, is_sorted))?;
            found.push(rivals.mean(&mut rig)?);
        }
        let spread = f64::from(scene.settings.spread.unwrap_or_default());
        let rotation = scene.camera.rotation();
        let depths = scene
            .particles
            .position
            .iter()
            .map(|position| (rotation * (DVec3::from_array(position.map(f64::from)) - scene.camera.eye)).z);
        let range = depths.fold([f64::MAX, f64::MIN], |[a, b], z| [a.min(z - spread), b.max(z + spread)]);
        let mut differences = [Vec::new(), Vec::new()];
        for y in (3..scene.size[1] as usize).step_by(9) {
            for x in (5..scene.size[0] as usize).step_by(9) {
                let fogs = fogs(&scene, [x, y]);
                let place = y * scene.size[0] as usize + x;
                for (rival, expected) in [sorted(&fogs), weighted(&fogs, range)].into_iter().enumerate() {
                    let [r, g, b, _] = found[rival][place].map(f64::from);
                    differences[rival].push((DVec3::new(r, g, b) - expected).abs().max_element());
                }
            }
        }
        for differences in differences {
            // Of the table: its classes and places.
            let deviation = Deviation::of(differences).ok_or("no pixels")?;
            assert!(deviation.rms < 5e-3 && deviation.max < 5e-2, "{deviation:?}");
        }
        drop(rig);
        let messages = messages.lock().map_err(|_| "a message")?;
        assert!(messages.is_empty(), "{messages:?}");
        Ok(())
    }
}
