//! Ways to blend fire without repetitions: each particle as fog at the depth of its centre, sorted, or
//! weighed by depth or by a function of transmittance over depth, and not sorted. Colours, counts, chances to pass and lists are those of an effect in the `expected` mode.

use std::mem::offset_of;

use crate::bench::rig::{EffectId, KernelBuffer, KernelsId, Rig};
use crate::error::Result;
use crate::flame::layout::{BUFFERS, CONTROL, resource};
use crate::flame::params::{Control, KERNEL_CLASSES, KERNEL_PLACES, PRESENT_BITS};
use crate::gpu::buffer::BufferDesc;
use crate::plan::{BufferId, Command, Pass, PassId, Plan, Resource};
use crate::shaders::flame as glsl;

use super::scene::Scene;

#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;

const FAR_TABLE: BufferId = BufferId(BUFFERS);
const RANKS: BufferId = BufferId(BUFFERS + 1);
const ORDER: BufferId = BufferId(BUFFERS + 2);
const BLENDED: BufferId = BufferId(BUFFERS + 3);

const FAR: PassId = PassId(0);
const RANK: PassId = PassId(1);
const SORTED: PassId = PassId(2);
const WEIGHTED: PassId = PassId(3);
const MOMENTS_4: PassId = PassId(4);
const MOMENTS_6: PassId = PassId(5);
const WAVELETS: PassId = PassId(6);

/// A way to blend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rival {
    /// In the order of depth.
    Sorted,
    /// McGuire and Bavoil 2013.
    Weighted,
    /// Münstermann et al. 2018, with 4 power moments.
    Moments4,
    /// And with 6.
    Moments6,
    /// Aizenshtein et al. 2022, of rank 3.
    Wavelets,
}

impl Rival {
    /// The pass over tiles.
    fn pass(self) -> PassId {
        match self {
            Rival::Sorted => SORTED,
            Rival::Weighted => WEIGHTED,
            Rival::Moments4 => MOMENTS_4,
            Rival::Moments6 => MOMENTS_6,
            Rival::Wavelets => WAVELETS,
        }
    }
}

/// All of them, on an effect's lists.
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
    pub(super) fn plan(&self, scene: &Scene, rival: Rival) -> Plan {
        let mut plan = Plan::default();
        if rival == Rival::Sorted {
            plan.step(RANK, Command::Dispatch { threads: [scene.particles.position.len() as u32, 1, 1] });
        }
        let offset = offset_of!(Control, tile_groups) as u64;
        let tiles = Command::DispatchIndirect { arguments: CONTROL, offset };
        plan.step(rival.pass(), tiles);
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
        bind("bench.moments", &glsl::bench_moments_4::SHADER),
        bind("bench.moments", &glsl::bench_moments_6::SHADER),
        bind("bench.wavelets", &glsl::bench_wavelets::SHADER),
    ]
}
