//! What a host does with the effect: frames in flight, other sizes, wrong input.

use ash::vk;
use celfx::data::Volume;
use celfx::effect::{Effort, Kernels, Kind, describe};
use celfx::error::Error;
use celfx::host::{Host, HostBuffer, HostImage};
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::COPIED_FROM;
use celfx::offline::TARGET_FORMAT;
use celfx::smoke::settings::{Grow, Outline, RadiusFrom, Shadow};
use celfx::smoke::{Background, Desc, Frame, Sequence, Settings, Smoke, SmokeKind, VolumeInput};
use celfx::view::{FireLight, Light};

use crate::common::allocations::allocated;
use crate::common::host::{self, DISCARDED};
use crate::common::scenes::{camera, desc, direction, moving_puffs};
use crate::common::{TestDevice, device};

pub const SIZE: [u32; 2] = [80, 60];
/// Voxels of a volume.
const VOXELS: u64 = 20 * 20 * 20;

pub fn effect() -> Desc {
    Desc { velocity: true, ..desc(SIZE, [20; 3], Settings { particles: 200, ..Settings::default() }) }
}

/// What one frame in flight needs of a host.
pub struct Slot {
    size: [u32; 2],
    density: Buffer,
    velocity: Buffer,
    target: Image,
    picture: Buffer,
}

impl Slot {
    pub fn new(device: &mut TestDevice, size: [u32; 2]) -> Slot {
        Slot {
            size,
            density: host::source(device, 4 * VOXELS),
            velocity: host::source(device, 12 * VOXELS),
            target: host::image(device, size, TARGET_FORMAT),
            picture: host::sink(device, 16 * u64::from(size[0]) * u64::from(size[1])),
        }
    }

    /// The frame `i` of a sequence, its volume written.
    pub fn frame(&mut self, i: u32) -> Frame {
        let Volume { dimensions, voxel_size, origin, density, velocity } = moving_puffs(20, i as f32 / 24.0);
        let density = host::fill(&mut self.density, &density);
        let velocity = host::fill(&mut self.velocity, velocity.as_deref().expect("velocities"));
        let target = host::host_image(&self.target, self.size, TARGET_FORMAT, DISCARDED, COPIED_FROM);
        Frame {
            sequence: if i == 0 { Sequence::Restart } else { Sequence::Advance },
            dt: 1.0 / 24.0,
            view: camera(2.0 * f64::from(i)).view(self.size),
            light: direction(-1.0, -1.5, -1.0),
            fire: None,
            volume: Some(VolumeInput { dimensions, voxel_size, origin, density, velocity: Some(velocity) }),
            target: Some(target),
            background: Background::Clear([0.0; 4]),
            depth: None,
            edges: None,
            temporal: Default::default(),
        }
    }

    /// Copies the picture to where the host reads it.
    pub unsafe fn show(&self, host: &Host, commands: vk::CommandBuffer) {
        // SAFETY: the caller's; the effect left the image in the state that copies want.
        unsafe { host::show(host, commands, (self.target.handle, self.target.aspect), self.size, &self.picture) };
    }

    /// Bits of the picture's floats.
    pub fn pixels(&self) -> Vec<[u32; 4]> {
        host::values(&self.picture, (self.size[0] * self.size[1]) as usize)
    }

    pub fn destroy(mut self, device: &mut TestDevice) {
        host::destroy(device, [&mut self.density, &mut self.velocity, &mut self.picture], [&mut self.target]);
    }
}

/// Renders a sequence with so many frames on their way; the pictures. Recording allocates nothing after two frames.
fn sequence(in_flight: usize, frames: u32) -> Option<Vec<Vec<[u32; 4]>>> {
    let mut device = device()?;
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own, and the device has what is required.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, effect()) }.expect("an effect");
    let mut slots: Vec<Slot> = (0..in_flight).map(|_| Slot::new(&mut device, SIZE)).collect();
    let record = |host: &Host, commands, slot: &mut Slot, i| {
        let frame = slot.frame(i);
        // SAFETY: frames are submitted in order to one queue; this slot's last frame has been waited for.
        let allocations = unsafe {
            let before = allocated();
            smoke.record(host, commands, &frame, &mut Timing::None).expect("a frame");
            let allocations = allocated() - before;
            slot.show(host, commands);
            allocations
        };
        assert!(i < 2 || allocations == 0, "frame {i}: recording allocated {allocations} times");
    };
    let pictures = host::in_flight(&mut device, &mut slots, frames, record, Slot::pixels);
    slots.into_iter().for_each(|slot| slot.destroy(&mut device));
    let (host, allocator) = device.parts();
    // SAFETY: every submission has been waited for.
    unsafe { smoke.destroy(&host, allocator) };
    Some(pictures)
}

#[test]
fn frames_in_flight_are_those_that_are_waited_for() {
    let Some(waited) = sequence(1, 9) else { return };
    for in_flight in [2, 3] {
        let Some(flying) = sequence(in_flight, 9) else { return };
        assert_eq!(flying.len(), waited.len());
        for (i, (a, b)) in flying.iter().zip(&waited).enumerate() {
            assert!(a == b, "{in_flight} in flight: frame {i} differs");
        }
    }
    assert!(waited.windows(2).all(|pair| pair[0] != pair[1]), "frames that are all the same show nothing");
}

/// Renders the first frame of an effect that exists.
fn one_frame(device: &mut TestDevice, smoke: &mut Smoke, size: [u32; 2]) -> Vec<[u32; 4]> {
    let mut slot = Slot::new(device, size);
    let frame = slot.frame(0);
    one_into(device, smoke, slot, &frame)
}

/// Renders frame `i` of a sequence.
fn one_of(device: &mut TestDevice, smoke: &mut Smoke, i: u32) -> Vec<[u32; 4]> {
    let mut slot = Slot::new(device, SIZE);
    let frame = slot.frame(i);
    one_into(device, smoke, slot, &frame)
}

fn one_into(device: &mut TestDevice, smoke: &mut Smoke, slot: Slot, frame: &Frame) -> Vec<[u32; 4]> {
    host::run(device, |host, commands| {
        // SAFETY: everything is the test's own and waited for.
        unsafe {
            smoke.record(host, commands, frame, &mut Timing::None).expect("a frame");
            slot.show(host, commands);
        }
    });
    let pixels = slot.pixels();
    slot.destroy(device);
    pixels
}

/// Pipelines may be made by any threads: each is kept once.
#[test]
fn threads_share_pipelines() {
    let Some(device) = device() else { return };
    let mut kind = SmokeKind::new(&effect(), &device.traits(), Effort::Needed).expect("an effect");
    let passes = describe(&mut kind, &effect(), Effort::Needed).passes;
    let (host, mut shared, mut alone) = (device.host(), Kernels::new(), Kernels::new());
    // SAFETY: valid handles, of one device; nothing is submitted.
    unsafe {
        alone.make(&host, &passes).expect("pipelines");
        let make = || shared.make(&host, &passes).expect("pipelines");
        std::thread::scope(|scope| (0..3).for_each(|_| drop(scope.spawn(make))));
        assert!(alone.count() > 20 && shared.count() == alone.count(), "{}", shared.count());
        shared.destroy(&host);
        alone.destroy(&host);
    }
}

/// As when a swapchain is out of date: recorded and never submitted. What comes after is as if it had not been.
#[test]
fn a_dropped_frame_leaves_no_trace() {
    let Some(mut device) = device() else { return };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, effect()) }.expect("an effect");
    let mut expected = None;
    // The first frame, one in the middle of a sequence, and one that a restart follows without a word.
    for (before, tells) in [(0, true), (0, false), (2, true), (1, false)] {
        for i in 0..before {
            one_of(&mut device, &mut smoke, i);
        }
        let mut slot = Slot::new(&mut device, SIZE);
        let frame = slot.frame(before);
        let commands = device.begin().expect("commands");
        // SAFETY: they are not submitted.
        unsafe { smoke.record(&device.host(), commands.raw(), &frame, &mut Timing::None) }.expect("a frame");
        device.discard(commands);
        if tells {
            smoke.frame_dropped();
            let next = slot.frame(before + 1);
            // SAFETY: it is refused.
            let refused = unsafe { smoke.record(&device.host(), vk::CommandBuffer::null(), &next, &mut Timing::None) };
            assert!(refused.expect_err("it went on").to_string().starts_with("frame.sequence = Advance"));
        }
        slot.destroy(&mut device);
        let again = [0, 1].map(|i| one_of(&mut device, &mut smoke, i));
        let expected = expected.get_or_insert_with(|| again.clone());
        assert!(again == *expected, "{before} frames before, told: {tells}");
    }
    let (host, kernels, allocator) = device.making();
    // SAFETY: every frame has been waited for.
    let mut fresh = unsafe {
        smoke.destroy(&host, allocator);
        Smoke::new(&host, kernels, allocator, effect()).expect("an effect")
    };
    let fresh_pictures = [0, 1].map(|i| one_of(&mut device, &mut fresh, i));
    assert!(Some(fresh_pictures) == expected, "unlike an effect that never dropped a frame");
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { fresh.destroy(&host, allocator) };
}

/// Steps go to two command buffers in turn, and the host fills a buffer of its own between them.
#[test]
fn a_prepared_frame_is_recorded_in_parts() {
    let Some(mut device) = device() else { return };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, effect()) }.expect("an effect");
    // SAFETY: nothing is prepared, and nothing recorded.
    let early = unsafe { smoke.record_steps(&host, vk::CommandBuffer::null(), 1, &mut Timing::None) };
    assert_eq!(early.expect_err("there is none").to_string(), "frame: none is prepared");
    let mut own = host::sink(&mut device, 1024);
    let mut parts = Vec::new();
    for i in 0..3 {
        let mut slot = Slot::new(&mut device, SIZE);
        let frame = slot.frame(i);
        let before = allocated();
        let steps = smoke.prepare(&frame).expect("a frame").steps.len();
        assert!(i < 2 || allocated() == before, "preparing allocates");
        let commands = [device.begin().expect("commands"), device.begin().expect("commands")];
        let mut left = steps;
        for (turn, many) in [3, 1, 0, 5, usize::MAX].into_iter().enumerate() {
            // The first buffer has the first two parts, and is submitted before the second.
            let place = usize::from(turn > 1);
            let raw = commands[place].raw();
            let host = device.host();
            // SAFETY: everything is the test's own; frames are submitted in order.
            unsafe {
                left = smoke.record_steps(&host, raw, many, &mut Timing::None).expect("steps");
                host.device.cmd_fill_buffer(raw, own.handle, 4 * turn as u64, 4, turn as u32);
            }
        }
        assert_eq!(left, 0, "of {steps}");
        // SAFETY: as above.
        unsafe { slot.show(&device.host(), commands[1].raw()) };
        let started = commands.map(|commands| device.start(commands, "frame").expect("it starts"));
        started.into_iter().for_each(|submission| device.wait(submission).expect("it ends"));
        parts.push(slot.pixels());
        slot.destroy(&mut device);
    }
    let Some(whole) = sequence(1, 3) else { return };
    assert!(parts == whole);
    assert_eq!(host::values::<u32>(&own, 5), [0, 1, 2, 3, 4]);
    // What is left half recorded is dropped.
    let mut slot = Slot::new(&mut device, SIZE);
    let commands = device.begin().expect("commands");
    smoke.prepare(&slot.frame(3)).expect("a frame");
    // SAFETY: it is not submitted.
    unsafe { smoke.record_steps(&device.host(), commands.raw(), 2, &mut Timing::None) }.expect("steps");
    device.discard(commands);
    let refused = smoke.prepare(&slot.frame(4)).expect_err("it went on").to_string();
    assert!(refused.starts_with("frame.sequence = Advance"), "{refused}");
    // So it is if the effect is changed then.
    smoke.prepare(&slot.frame(0)).expect("a frame");
    let commands = device.begin().expect("commands");
    // SAFETY: it is not submitted; nothing is on its way.
    unsafe {
        smoke.record_steps(&device.host(), commands.raw(), 2, &mut Timing::None).expect("steps");
        device.discard(commands);
        let (host, kernels, allocator) = device.making();
        smoke.change(&host, kernels, allocator, effect()).expect("a change").destroy(&host, allocator);
    }
    let refused = smoke.prepare(&slot.frame(1)).expect_err("it went on").to_string();
    assert!(refused.starts_with("frame.sequence = Advance"), "{refused}");
    slot.destroy(&mut device);
    host::destroy(&mut device, [&mut own], []);
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.retire().destroy(&host, allocator) };
}

/// Sizes and settings change from frame to frame while frames are on their way. Each picture is that of an effect that had
/// them from the start, so particles and their history have gone on.
#[test]
fn a_sequence_goes_on_through_changes() {
    let Some(mut device) = device() else { return };
    let with = |size, settings| Desc { size, settings, ..effect() };
    let plain = Settings { grow: Grow::Growth, radius_from: RadiusFrom::Voxels, ..effect().settings };
    let soft = Settings { sigma: 1.5, tone_softness: 2.0, ..plain.clone() };
    let mapped = Settings {
        shadow: Shadow::Map,
        shadow_map: 256,
        outline: Outline { width: 3.0, ..plain.outline },
        ..plain.clone()
    };
    // The same radii, searched in what the last volume did not make.
    let searched = Settings { grow: Grow::Field, ..plain.clone() };
    let looks = [
        with(SIZE, plain.clone()),
        with(SIZE, soft.clone()),
        with([33, 90], mapped),
        with([33, 90], searched),
        with([200, 10], soft),
        with(SIZE, plain),
    ];
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, looks[0].clone()) }.expect("an effect");
    let (mut on_their_way, mut slots, mut replaced) = (Vec::new(), Vec::new(), Vec::new());
    for (i, desc) in (0..).zip(&looks) {
        let (host, kernels, allocator) = device.making();
        // SAFETY: what is replaced is kept until all frames have been waited for.
        replaced.push(unsafe { smoke.change(&host, kernels, allocator, desc.clone()) }.expect("a change"));
        let mut slot = Slot::new(&mut device, desc.size);
        let frame = slot.frame(i);
        // Frames without a volume: what is made from it is made anew.
        let frame = Frame { volume: frame.volume.filter(|_| i < 3), ..frame };
        let commands = device.begin().expect("commands");
        // SAFETY: everything is the test's own, and frames are submitted in order.
        unsafe {
            smoke.record(&device.host(), commands.raw(), &frame, &mut Timing::None).expect("a frame");
            slot.show(&device.host(), commands.raw());
        }
        on_their_way.push(device.start(commands, "frame").expect("it starts"));
        slots.push(slot);
    }
    on_their_way.into_iter().for_each(|submission| device.wait(submission).expect("it ends"));
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe {
        replaced.into_iter().for_each(|retired| retired.destroy(&host, allocator));
        smoke.retire().destroy(&host, allocator);
    }
    for ((last, desc), slot) in (0..).zip(&looks).zip(slots) {
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        let mut fresh = unsafe { Smoke::new(&host, kernels, allocator, desc.clone()) }.expect("an effect");
        let mut expected = Vec::new();
        for i in 0..=last {
            let mut other = Slot::new(&mut device, desc.size);
            let frame = other.frame(i);
            let frame = Frame { volume: frame.volume.filter(|_| i < 3), ..frame };
            expected = one_into(&mut device, &mut fresh, other, &frame);
        }
        assert!(slot.pixels() == expected, "frame {last} is not that of an effect that was made so");
        slot.destroy(&mut device);
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        unsafe { fresh.destroy(&host, allocator) };
    }
}

/// What a sequence needs has another size: it must begin anew, and says so.
#[test]
fn a_change_that_loses_history_asks_for_a_restart() {
    let Some(mut device) = device() else { return };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, effect()) }.expect("an effect");
    one_of(&mut device, &mut smoke, 0);
    let more = Settings { particles: 300, ..effect().settings };
    let (host, kernels, allocator) = device.making();
    let mut slot = None;
    // SAFETY: every frame has been waited for; the next is refused.
    let refused = unsafe {
        let changed = smoke.change(&host, kernels, allocator, Desc { settings: more, ..effect() });
        changed.expect("a change").destroy(&host, allocator);
        let slot = slot.insert(Slot::new(&mut device, SIZE));
        smoke.record(&device.host(), vk::CommandBuffer::null(), &slot.frame(1), &mut Timing::None)
    };
    assert!(refused.expect_err("it went on").to_string().starts_with("frame.sequence = Advance"));
    slot.into_iter().for_each(|slot| slot.destroy(&mut device));
    let picture = one_of(&mut device, &mut smoke, 0);
    let (host, kernels, allocator) = device.making();
    // SAFETY: every frame has been waited for.
    let mut fresh = unsafe {
        let desc = smoke.desc().clone();
        smoke.destroy(&host, allocator);
        Smoke::new(&host, kernels, allocator, desc).expect("an effect")
    };
    assert!(picture == one_of(&mut device, &mut fresh, 0));
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { fresh.destroy(&host, allocator) };
}

/// Pipelines are made before they are needed, and making the effect makes none.
#[test]
fn an_effect_takes_pipelines_that_were_compiled() {
    let Some(mut device) = device() else { return };
    let mut kernels = Kernels::new();
    let host = device.host();
    // SAFETY: the handles are the device's own.
    unsafe { Smoke::compile(&host, &kernels, &effect()) }.expect("pipelines");
    let made = kernels.count();
    assert!(made > 20, "{made}");
    let (host, allocator) = device.parts();
    // SAFETY: as above; nothing is submitted.
    unsafe {
        let smoke = Smoke::new(&host, &kernels, allocator, effect()).expect("an effect");
        assert_eq!(kernels.count(), made);
        smoke.retire().destroy(&host, allocator);
        kernels.destroy(&host);
    }
}

#[test]
fn resizing_is_like_making_anew() {
    let Some(mut device) = device() else { return };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, effect()) }.expect("an effect");
    let made = device.kernels().count();
    for size in [[33, 90], [200, 10], SIZE, [1, 1]] {
        let before = smoke.desc().size;
        one_frame(&mut device, &mut smoke, before);
        let (host, kernels, allocator) = device.making();
        // SAFETY: every frame has been waited for.
        let mut fresh = unsafe {
            smoke.resize(&host, kernels, allocator, size).expect("another size").destroy(&host, allocator);
            Smoke::new(&host, kernels, allocator, Desc { size, ..effect() }).expect("an effect")
        };
        let resized = one_frame(&mut device, &mut smoke, size);
        assert!(resized == one_frame(&mut device, &mut fresh, size), "{size:?}");
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        unsafe { fresh.destroy(&host, allocator) };
    }
    assert_eq!(device.kernels().count(), made, "no pipeline depends on the size");
    // A size that cannot be leaves the effect as it was.
    let (host, kernels, allocator) = device.making();
    // SAFETY: every frame has been waited for.
    let refused = unsafe { smoke.resize(&host, kernels, allocator, [1 << 20, 4]) };
    assert!(matches!(refused, Err(Error::Limit { .. })), "{refused:?}");
    one_frame(&mut device, &mut smoke, [1, 1]);
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.destroy(&host, allocator) };
}

#[test]
fn frames_that_do_not_fit_are_refused_by_name() {
    let Some(mut device) = device() else { return };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, effect()) }.expect("an effect");
    let mut slot = Slot::new(&mut device, SIZE);
    let good = slot.frame(0);
    let volume = good.volume.expect("a volume");
    let target = good.target.expect("a target");
    let with_volume = |volume| Frame { volume: Some(volume), ..good };
    let fire = FireLight { position: glam::DVec3::ZERO, colour: [1.0; 3], reach: 1.0 };
    let cases = [
        ("volume", Frame { volume: None, ..good }),
        ("volume", with_volume(VolumeInput { dimensions: [21, 20, 20], ..volume })),
        ("volume", with_volume(VolumeInput { dimensions: [0, 20, 20], ..volume })),
        ("volume", with_volume(VolumeInput { voxel_size: [0.1, -0.1, 0.1], ..volume })),
        ("volume", with_volume(VolumeInput { origin: [f32::NAN, 0.0, 0.0], ..volume })),
        ("volume", with_volume(VolumeInput { velocity: None, ..volume })),
        ("volume", with_volume(VolumeInput { density: HostBuffer { size: 100, ..volume.density }, ..volume })),
        ("frame.dt", Frame { dt: 0.0, ..good }),
        ("frame.sequence", Frame { sequence: Sequence::Advance, ..good }),
        ("light", Frame { light: crate::common::scenes::point(0.0, 1.0, 0.0), ..good }),
        ("light", Frame { light: Light { rim: 0.5, ..good.light }, ..good }),
        ("fire", Frame { fire: Some(fire), ..good }),
        ("fire.reach", Frame { fire: Some(FireLight { reach: 0.0, ..fire }), ..good }),
        ("view.jitter", Frame { view: celfx::view::View { jitter: [20.0, 0.0], ..good.view }, ..good }),
        ("target", Frame { target: Some(HostImage { extent: [79, 60], ..target }), ..good }),
        ("target", Frame { target: Some(HostImage { format: vk::Format::R8G8B8A8_UNORM, ..target }), ..good }),
        ("depth", Frame { depth: Some(target), ..good }),
        ("background", Frame { background: Background::Copy(HostImage { extent: [1, 1], ..target }), ..good }),
    ];
    for (name, frame) in cases {
        let refused = device.one_time("frame", |host, commands| {
            // SAFETY: everything is the test's own.
            unsafe { smoke.record(host, commands, &frame, &mut Timing::None) }
        });
        let text = refused.expect_err(name).to_string();
        assert!(text.starts_with(name), "{name}: {text}");
    }
    // None of them has changed anything.
    one_frame(&mut device, &mut smoke, SIZE);
    slot.destroy(&mut device);
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { smoke.destroy(&host, allocator) };
}
