//! Effects that share scratch memory make what they make without.
#![cfg(feature = "cli")]

mod common;

use std::cell::RefCell;
use std::iter::zip;
use std::sync::RwLock;

use ash::vk;
use celfx::blur::{self, Blur, FrameView, Interval, Mesh, MeshInput, Motion, Pose, Window};
use celfx::effect::{ScratchNeeds, ScratchPool, ScratchRange};
use celfx::flame::{self, Flame, ParticleInput};
use celfx::host::{Background, Host, HostBuffer, HostImage};
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::headless::Options;
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::transfer::COPIED_FROM;
use celfx::profile::Timing;
use celfx::smoke::{self, Sequence, Smoke, VolumeInput};
use celfx::view::{Light, View};
use common::flame::embers;
use common::scenes::{camera, puffs};
use common::{TestDevice, device, device_of, host};

const FORMAT: vk::Format = vk::Format::R16G16B16A16_SFLOAT;
const FRAMES: u32 = 6;
/// Frames on their way at once.
const SLOTS: usize = 2;

/// What a frame brings.
struct Input {
    density: Buffer,
    particles: Buffer,
    blurred: Buffer,
    interval: Interval,
    placed: blur::Placed,
}

/// Where a frame is drawn: each effect for itself.
struct Slot {
    targets: [Image; 3],
    sinks: [Buffer; 3],
    size: [u32; 2],
}

impl Slot {
    fn new(device: &mut TestDevice, size: [u32; 2]) -> Slot {
        let bytes = 8 * u64::from(size[0] * size[1]);
        let targets = [(); 3].map(|()| host::image(device, size, FORMAT));
        Slot { targets, sinks: [(); 3].map(|()| host::sink(device, bytes)), size }
    }
}

struct Effects {
    smoke: Smoke,
    flame: Flame,
    blur: Blur,
    mesh: Mesh,
}

/// A box that turns.
fn corners(frame: u32) -> Vec<[f32; 3]> {
    let corner = |i: u32| 0.6 * (2.0 * glam::Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 1.0);
    (0..8).map(|i| (glam::Quat::from_rotation_y(0.3 * frame as f32) * corner(i)).to_array()).collect()
}

fn view(size: [u32; 2]) -> View {
    camera(0.0).view(size)
}

fn mesh() -> Mesh {
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let input = MeshInput { vertices: 8, triangles: &triangles, objects: None, weld: None, normals: None, rest: None };
    Mesh::new(&input).expect("a mesh").faceted(|_| true)
}

fn descs(size: [u32; 2], mesh: &Mesh) -> (smoke::Desc, flame::Desc, blur::Desc) {
    let of_smoke = smoke::Settings { particles: 120, ..smoke::Settings::default() };
    let of_smoke = smoke::Desc::new(size, [16; 3], of_smoke);
    let of_flame = flame::Settings { spread: Some(0.1), repetitions: 8, ..flame::Settings::default() };
    let of_blur = blur::Desc::new(mesh, size, blur::Settings::default());
    (
        smoke::Desc { target_format: FORMAT, ..of_smoke },
        flame::Desc { target_format: FORMAT, accumulates: true, ..flame::Desc::new(size, 50, of_flame) },
        blur::Desc { target_format: FORMAT, toon: true, frames_resident: 16, most_triangles: 10_000, ..of_blur },
    )
}

/// What scratch memory must be for any of the three.
fn needs(device: &mut TestDevice, size: [u32; 2]) -> [ScratchNeeds; 3] {
    let (of_smoke, of_flame, of_blur) = descs(size, &mesh());
    let (host, kernels, allocator) = device.making();
    // SAFETY: the device's own handles.
    let needs = unsafe {
        [
            Smoke::scratch_needs(&host, kernels, allocator, &of_smoke),
            Flame::scratch_needs(&host, kernels, allocator, &of_flame),
            Blur::scratch_needs(&host, kernels, allocator, &of_blur),
        ]
    };
    needs.map(|needs| needs.expect("sizes"))
}

fn pool(device: &mut TestDevice, size: [u32; 2]) -> ScratchPool {
    let needs = needs(device, size).into_iter().fold(ScratchNeeds::NONE, ScratchNeeds::or);
    ScratchPool::new(device.parts().1, needs).expect("memory")
}

impl Effects {
    fn new(device: &mut TestDevice, size: [u32; 2], pool: Option<&ScratchPool>) -> Effects {
        let mesh = mesh();
        let (of_smoke, of_flame, of_blur) = descs(size, &mesh);
        let (host, kernels, allocator) = device.making();
        // SAFETY: the device's own handles.
        unsafe {
            let (smoke, flame, blur) = match pool {
                Some(pool) => (
                    Smoke::new_in(&host, kernels, allocator, of_smoke, pool),
                    Flame::new_in(&host, kernels, allocator, of_flame, pool),
                    Blur::new_in(&host, kernels, allocator, of_blur, pool),
                ),
                None => (
                    Smoke::new(&host, kernels, allocator, of_smoke),
                    Flame::new(&host, kernels, allocator, of_flame),
                    Blur::new(&host, kernels, allocator, of_blur),
                ),
            };
            let (smoke, flame, blur) = (smoke.expect("smoke"), flame.expect("a fire"), blur.expect("a blur"));
            Effects { smoke, flame, blur, mesh }
        }
    }

    fn input(&self, device: &mut TestDevice, frame: u32, size: [u32; 2]) -> Input {
        let poses: Vec<_> = (0..8).map(|pose| self.mesh.gather(&corners(pose)).expect("a pose")).collect();
        let view = view(size);
        let window: Vec<_> = poses.iter().map(|positions| Pose { positions, view: &view, cut: false }).collect();
        let window = Window { frame, poses: &window, current: frame as usize, between: &[] };
        let motion = Motion::new(&self.blur.desc().settings, size).expect("settings");
        let interval = motion.interval(&self.mesh, &window, 1).expect("an interval");
        let mut packed = blur::Upload::default();
        if frame == 0 {
            packed.mesh(&self.mesh, &[[0.9, 0.5, 0.2]; 8]);
            packed.poses(0, &poses);
        }
        packed.interval(&interval, true);
        let fire = embers(50, frame);
        let rows = zip(&fire.position, &fire.temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]);
        let (rows, density) = (rows.collect::<Vec<_>>(), puffs(16, 0.2 * frame as f32).density);
        let mut blurred = host::source(device, packed.bytes().len() as u64);
        let placed = packed.placed(host::fill(&mut blurred, packed.bytes()));
        let (mut from, mut hot) = (host::source(device, 4 * density.len() as u64), host::source(device, 16 * 50));
        host::fill(&mut from, &density);
        host::fill(&mut hot, &rows);
        Input { density: from, particles: hot, blurred, interval, placed }
    }

    /// One of them, in a frame of a sequence that goes on.
    unsafe fn record(
        &mut self,
        host: &Host,
        commands: vk::CommandBuffer,
        which: usize,
        n: u32,
        input: &Input,
        slot: &Slot,
    ) {
        let (size, timing) = (slot.size, &mut Timing::None);
        let given = |buffer: &Buffer| {
            let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
            HostBuffer { buffer: buffer.handle, offset: 0, size: buffer.size, stage, access }
        };
        let image = &slot.targets[which];
        let target = HostImage::new(image.handle, image.view, FORMAT, size, host::DISCARDED, COPIED_FROM);
        let (view, background) = (view(size), Background::Clear([0.25, 0.5, 0.75, 1.0]));
        // SAFETY: the caller's.
        let done = unsafe {
            match which {
                0 => {
                    let (dimensions, voxel_size, origin) = ([16; 3], [2.0 / 16.0; 3], [-1.0; 3]);
                    let density = given(&input.density);
                    let volume = VolumeInput { dimensions, voxel_size, origin, density, velocity: None };
                    let sequence = if n == 0 { Sequence::Restart } else { Sequence::Advance };
                    let frame = smoke::Frame { sequence, background, ..smoke::Frame::new(view, volume, target) };
                    // The volume and the shadow of the frame before serve every second one.
                    let volume = frame.volume.filter(|_| n.is_multiple_of(2));
                    self.smoke.record(host, commands, &smoke::Frame { volume, ..frame }, timing)
                }
                1 => {
                    let position_temperature = given(&input.particles);
                    let given = ParticleInput {
                        count: 50,
                        hottest: f32::INFINITY,
                        position_temperature,
                        previous: None,
                        velocity: None,
                        ids: None,
                    };
                    let frame = flame::Frame { background, ..flame::Frame::new(view, given, target) };
                    let particles = frame.particles.filter(|_| n.is_multiple_of(3));
                    let accumulate = particles.is_none();
                    self.flame.record(host, commands, &flame::Frame { particles, accumulate, ..frame }, timing)
                }
                _ => {
                    let seen = |frame| FrameView { frame, view };
                    let views = [n.saturating_sub(1), n, n + 1, n + 2].map(seen);
                    let frame = blur::Frame {
                        mesh: input.placed.mesh,
                        poses: input.placed.poses,
                        interval: input.placed.interval(&input.interval, &self.mesh, views, None),
                        toon: Some(blur::ToonInput { view: seen(n + 1), light: Light::default() }),
                        background,
                        ..blur::Frame::new(target)
                    };
                    self.blur.record(host, commands, &frame, timing)
                }
            }
        };
        done.expect("a frame");
    }

    /// The pictures of all three in frames from this number, recorded in an order that changes, and several on their way at once.
    /// Before each of an effect, this memory is filled with a word.
    fn frames(
        &mut self,
        device: &mut TestDevice,
        first: u32,
        size: [u32; 2],
        poison: Option<(ScratchRange, u32)>,
    ) -> Vec<[Vec<u64>; 3]> {
        let pixels = (size[0] * size[1]) as usize;
        let poison = poison.map(|(range, word)| (host::over(&device.host(), range), word));
        let mut inputs: Vec<_> = (first..first + FRAMES / 2).map(|n| self.input(device, n, size)).collect();
        let mut slots = [(); SLOTS].map(|()| Slot::new(device, size));
        let record = |host: &Host, commands, slot: &mut Slot, number: u32| {
            for place in 0..3 {
                let which = (place + number as usize) % 3;
                let input = &inputs[number as usize];
                // SAFETY: everything is the test's own, in the declared states; frames go to one queue in order.
                unsafe {
                    if let Some((buffer, word)) = poison {
                        host::barrier(host, commands, host::ALL_WRITTEN, host::TRANSFERRED);
                        host.device.cmd_fill_buffer(commands, buffer, 0, vk::WHOLE_SIZE, word);
                    }
                    self.record(host, commands, which, first + number, input, slot);
                    let image = (slot.targets[which].handle, slot.targets[which].aspect);
                    host::show(host, commands, image, size, &slot.sinks[which]);
                }
            }
        };
        let shown = |slot: &Slot| slot.sinks.each_ref().map(|sink| host::values(sink, pixels));
        let pictures = host::in_flight(device, &mut slots, FRAMES / 2, record, shown);
        destroy(device, &mut slots, &mut inputs);
        // SAFETY: every frame has been waited for.
        poison.iter().for_each(|(buffer, _)| unsafe { device.host().device.destroy_buffer(*buffer, None) });
        pictures
    }

    fn resize(&mut self, device: &mut TestDevice, size: [u32; 2]) -> celfx::error::Result<()> {
        let (host, kernels, allocator) = device.making();
        // SAFETY: the device's own handles; every frame has been waited for.
        unsafe {
            self.smoke.resize(&host, kernels, allocator, size)?.destroy(&host, allocator);
            self.flame.resize(&host, kernels, allocator, size)?.destroy(&host, allocator);
            self.blur.resize(&host, kernels, allocator, size)?.destroy(&host, allocator);
        }
        Ok(())
    }

    /// Another size and another pool at once.
    fn resize_in(&mut self, device: &mut TestDevice, size: [u32; 2], pool: &ScratchPool) {
        let (host, kernels, allocator) = device.making();
        // SAFETY: the device's own handles; every frame has been waited for.
        unsafe {
            let desc = smoke::Desc { size, ..self.smoke.desc().clone() };
            let retired = self.smoke.change_in(&host, kernels, allocator, desc, pool);
            retired.expect("it fits").destroy(&host, allocator);
            let desc = flame::Desc { size, ..self.flame.desc().clone() };
            let retired = self.flame.change_in(&host, kernels, allocator, desc, pool);
            retired.expect("it fits").destroy(&host, allocator);
            let desc = blur::Desc { size, ..self.blur.desc().clone() };
            let retired = self.blur.change_in(&host, kernels, allocator, desc, pool);
            retired.expect("it fits").destroy(&host, allocator);
        }
    }

    fn destroy(mut self, device: &mut TestDevice) {
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        unsafe {
            self.smoke.destroy(&host, allocator);
            self.flame.destroy(&host, allocator);
            self.blur.destroy(&host, allocator);
        }
    }
}

fn destroy(device: &mut TestDevice, slots: &mut [Slot], inputs: &mut [Input]) {
    for Slot { targets, sinks, .. } in slots {
        host::destroy(device, sinks, targets);
    }
    for Input { density, particles, blurred, .. } in inputs {
        host::destroy(device, [density, particles, blurred], []);
    }
}

thread_local! {
    /// Barriers of this thread: whether each waits for all commands and all that they have written.
    static BARRIERS: RefCell<Vec<bool>> = const { RefCell::new(Vec::new()) };
}
static BARRIER: RwLock<Option<vk::PFN_vkCmdPipelineBarrier2>> = RwLock::new(None);

unsafe extern "system" fn noted(commands: vk::CommandBuffer, dependency: *const vk::DependencyInfo<'_>) {
    // SAFETY: the caller's: arrays of so many.
    let is_full = unsafe {
        let info = &*dependency;
        let all = |stage: vk::PipelineStageFlags2, access: vk::AccessFlags2| {
            stage.contains(vk::PipelineStageFlags2::ALL_COMMANDS) && access.contains(vk::AccessFlags2::MEMORY_WRITE)
        };
        let memory = (0..info.memory_barrier_count as usize).map(|i| &*info.p_memory_barriers.add(i));
        let images = (0..info.image_memory_barrier_count as usize).map(|i| &*info.p_image_memory_barriers.add(i));
        info.memory_barrier_count == 1
            && memory.into_iter().all(|barrier| all(barrier.src_stage_mask, barrier.src_access_mask))
            && images.into_iter().all(|barrier| all(barrier.src_stage_mask, barrier.src_access_mask))
    };
    BARRIERS.with_borrow_mut(|barriers| barriers.push(is_full));
    let real = BARRIER.read().ok().and_then(|real| *real).expect("it was replaced");
    // SAFETY: the caller's.
    unsafe { real(commands, dependency) };
}

/// The device with barriers that are noted.
fn watched(device: ash::Device) -> ash::Device {
    let (core, v11, v12) = (device.fp_v1_0().clone(), device.fp_v1_1().clone(), device.fp_v1_2().clone());
    let mut v13 = device.fp_v1_3().clone();
    *BARRIER.write().expect("nobody panicked") = Some(v13.cmd_pipeline_barrier2);
    v13.cmd_pipeline_barrier2 = noted;
    ash::Device::from_parts_1_3(device.handle(), core, v11, v12, v13)
}

/// The first barrier of a frame waits for whatever was done in its memory before; there is none but those of its plan.
#[test]
fn frames_wait_for_all_that_others_have_done_in_their_memory() {
    let options = Options { table: watched, ..common::options() };
    let Some(mut device) = device_of(&options) else { return };
    let pool = pool(&mut device, SIZE);
    let mut effects = Effects::new(&mut device, SIZE, Some(&pool));
    let mut slots = [Slot::new(&mut device, SIZE)];
    let mut inputs = [0, 1].map(|n| effects.input(&mut device, n, SIZE));
    for (n, input) in (0..).zip(&inputs) {
        host::run(&mut device, |host, commands| {
            for which in 0..3 {
                BARRIERS.take();
                // SAFETY: everything is the test's own, in the declared states; it is waited for.
                unsafe { effects.record(host, commands, which, n, input, &slots[0]) };
                let barriers = BARRIERS.take();
                let plans = [effects.smoke.plan(), effects.flame.plan(), effects.blur.plan()];
                // Before the first of all, what is kept between frames leaves layout UNDEFINED.
                let begin = barriers.len() - plans[which].barriers as usize;
                assert!(begin <= usize::from(n == 0), "frame {n} of {which}: {} barriers", barriers.len());
                assert!(barriers[begin], "frame {n} of {which} does not wait");
            }
        });
    }
    destroy(&mut device, &mut slots, &mut inputs);
    effects.destroy(&mut device);
    // SAFETY: nothing is in it any more.
    unsafe { pool.destroy(device.parts().1) };
}

const SIZE: [u32; 2] = [80, 60];
const LARGER: [u32; 2] = [112, 84];

/// Three that share a pool, and are resized and moved to a larger one in a step, make the bits of three that share nothing,
/// whatever is in the pool between them.
#[test]
fn effects_in_one_pool_are_as_apart() {
    let Some(mut device) = device() else { return };
    let mut apart = Effects::new(&mut device, SIZE, None);
    let mut expected = apart.frames(&mut device, 0, SIZE, None);
    apart.resize(&mut device, LARGER).expect("a size");
    expected.extend(apart.frames(&mut device, FRAMES / 2, LARGER, None));
    apart.destroy(&mut device);
    for word in [None, Some(host::POISONS[0]), Some(host::POISONS[1])] {
        let shared = sharing(&mut device, word);
        assert_eq!((shared.len(), expected.len()), (FRAMES as usize, FRAMES as usize));
        for (number, (shared, expected)) in zip(&shared, &expected).enumerate() {
            for (name, (shared, expected)) in zip(["smoke", "flame", "blur"], zip(shared, expected)) {
                let background = expected[0];
                assert!(expected.iter().any(|pixel| *pixel != background), "{name}, frame {number}: it shows nothing");
                assert!(shared == expected, "{name}, frame {number}, {word:x?}");
            }
        }
    }
}

/// The pictures of three in one pool, which is filled with a word before each of them.
fn sharing(device: &mut TestDevice, word: Option<u32>) -> Vec<[Vec<u64>; 3]> {
    let small = pool(device, SIZE);
    let mut effects = Effects::new(device, SIZE, Some(&small));
    let ranges = [effects.smoke.scratch(), effects.flame.scratch(), effects.blur.scratch()];
    assert_eq!(ranges, [Some(small.range()); 3]);
    let mut pictures = effects.frames(device, 0, SIZE, word.map(|word| (small.range(), word)));
    let said = effects.resize(device, LARGER).expect_err("too small").to_string();
    let needed = needs(device, LARGER).map(|needs| needs.bytes);
    assert!(needed.iter().any(|bytes| said.contains(&format!("scratch needs {bytes}: make a pool"))), "{said}");
    let large = pool(device, LARGER);
    effects.resize_in(device, LARGER, &large);
    // SAFETY: nothing is in it any more.
    unsafe { small.destroy(device.parts().1) };
    pictures.extend(effects.frames(device, FRAMES / 2, LARGER, word.map(|word| (large.range(), word))));
    effects.destroy(device);
    // SAFETY: as above.
    unsafe { large.destroy(device.parts().1) };
    pictures
}
