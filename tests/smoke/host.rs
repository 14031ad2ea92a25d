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
use celfx::smoke::{Background, Desc, Frame, HostDepth, Sequence, Settings, Smoke, SmokeKind, VolumeInput};

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
            camera: camera(2.0 * f64::from(i)),
            light: direction(-1.0, -1.5, -1.0),
            volume: Some(VolumeInput { dimensions, voxel_size, origin, density, velocity: Some(velocity) }),
            target: Some(target),
            background: Background::Clear([0.0; 4]),
            depth: None,
            edges: None,
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
    let slot = Slot::new(device, size);
    one_into(device, smoke, slot, 0)
}

/// Renders frame `i` of a sequence.
fn one_of(device: &mut TestDevice, smoke: &mut Smoke, i: u32) -> Vec<[u32; 4]> {
    let slot = Slot::new(device, SIZE);
    one_into(device, smoke, slot, i)
}

fn one_into(device: &mut TestDevice, smoke: &mut Smoke, mut slot: Slot, i: u32) -> Vec<[u32; 4]> {
    let frame = slot.frame(i);
    host::run(device, |host, commands| {
        // SAFETY: everything is the test's own and waited for.
        unsafe {
            smoke.record(host, commands, &frame, &mut Timing::None).expect("a frame");
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
    let passes = describe(&mut kind, &effect()).passes;
    let (host, mut shared, mut alone) = (device.host(), Kernels::new(), Kernels::new());
    // SAFETY: valid handles, of one device; nothing is submitted.
    unsafe {
        passes.iter().for_each(|pass| alone.make(&host, pass).expect("a pipeline"));
        let make = || passes.iter().for_each(|pass| shared.make(&host, pass).expect("a pipeline"));
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
            smoke.resize(&host, kernels, allocator, size).expect("another size");
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
        ("camera", Frame { camera: celfx::view::Camera { near: 0.0, ..good.camera }, ..good }),
        ("target", Frame { target: Some(HostImage { extent: [79, 60], ..target }), ..good }),
        ("target", Frame { target: Some(HostImage { format: vk::Format::R8G8B8A8_UNORM, ..target }), ..good }),
        ("depth", Frame { depth: Some(HostDepth { image: target, terms: [0.0, 0.1] }), ..good }),
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
