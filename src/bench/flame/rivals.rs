//! What fire would be blended by without repetitions: each particle as fog at the depth of its centre, sorted, or weighed
//! and not sorted. Colours, counts, chances to pass and lists are those of an effect in the `expected` mode.

use std::mem::offset_of;

use crate::bench::rig::{EffectId, KernelBuffer, KernelsId, Rig};
use crate::error::Result;
use crate::flame::layout::{BUFFERS, CONTROL, resource};
use crate::flame::params::{Control, KERNEL_CLASSES, KERNEL_PLACES};
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

/// Bits that a workgroup of `bench_blend.glsl` has for particles.
const MOST_PARTICLES: usize = 256 * 32;

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
        assert!(particles <= MOST_PARTICLES, "a workload has at most {MOST_PARTICLES} particles");
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
        Pass::compute(name, shader).bind_all(|slot| match slot.name {
            "FarTable" => Some(Resource::Buffer(FAR_TABLE)),
            "Ranks" => Some(Resource::Buffer(RANKS)),
            "Order" => Some(Resource::Buffer(ORDER)),
            "Blended" => Some(Resource::Buffer(BLENDED)),
            _ => resource(slot),
        })
    };
    vec![
        bind("bench.far", &glsl::bench_far::SHADER),
        bind("bench.sorted", &glsl::bench_rank::SHADER),
        bind("bench.sorted", &glsl::bench_sorted::SHADER),
        bind("bench.weighted", &glsl::bench_weighted::SHADER),
    ]
}
