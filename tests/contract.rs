//! Mistakes of hosts: told by name, before the first command, and without a trace.
#![cfg(feature = "cli")]

mod common;

use std::ffi::c_void;

use ash::vk;
use ash::vk::Handle as _;
use celfx::blur::{self, Blur, Mesh, MeshInput};
use celfx::effect::{Effect, Kernels, Kind};
use celfx::flame::{self, Flame, ParticleInput, SceneDepth, SceneFormat};
use celfx::host::{
    Background, CallbackAllocation, CallbackRequest, DepthFormat, Host, HostBuffer, HostImage, ImageState,
    MOTION_FORMATS, Memory, MemoryCallbacks, REACTIVE_FORMATS, TemporalFormats,
};
use celfx::profile::Timing;
use celfx::smoke::{self, Sequence, Smoke, VolumeInput};
use celfx::view::Camera;

use common::handles::handle;
use common::scenes::{desc, direction, point};
use common::{TestDevice, device};

const SIZE: [u32; 2] = [8, 6];
const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;
const REVERSED: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };

fn image(format: vk::Format) -> HostImage {
    let state = state(vk::ImageLayout::GENERAL);
    HostImage::new(handle(), handle(), format, SIZE, state, state)
}

fn state(layout: vk::ImageLayout) -> ImageState {
    ImageState { layout, ..ImageState::default() }
}

fn buffer(size: u64) -> HostBuffer {
    let (stage, access) = (vk::PipelineStageFlags2::NONE, vk::AccessFlags2::NONE);
    HostBuffer { buffer: handle(), offset: 0, size, stage, access }
}

fn depth() -> HostImage {
    image(REVERSED.format)
}

fn make<K: Kind>(device: &mut TestDevice, desc: &K::Desc) -> celfx::error::Result<Effect<K>> {
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own, and the device has what is required.
    unsafe { Effect::new(&host, kernels, allocator, desc.clone()) }
}

fn destroy<K: Kind>(device: &mut TestDevice, mut effect: Effect<K>) {
    let (host, allocator) = device.parts();
    // SAFETY: nothing of it was submitted.
    unsafe { effect.destroy(&host, allocator) };
}

/// Records a wrong frame. There is no command buffer: the first command would end the test.
fn refusal<K: Kind>(host: &Host, effect: &mut Effect<K>, frame: &K::Frame<'_>, timing: &mut Timing) -> String {
    // SAFETY: none of what the frame names is touched before all is checked.
    let refused = unsafe { effect.record(host, vk::CommandBuffer::null(), frame, timing) };
    refused.expect_err("a wrong frame").to_string()
}

fn smoke_desc() -> smoke::Desc {
    let settings = smoke::Settings { particles: 100, ..smoke::Settings::default() };
    smoke::Desc { target_format: FORMAT, depth: Some(REVERSED), edges: true, ..desc(SIZE, [4; 3], settings) }
}

fn smoke_frame() -> smoke::Frame {
    let volume = VolumeInput {
        dimensions: [4; 3],
        voxel_size: [0.1; 3],
        origin: [0.0; 3],
        density: buffer(4 * 64),
        velocity: None,
    };
    smoke::Frame {
        sequence: Sequence::Restart,
        dt: 0.04,
        view: Camera::default().view(SIZE),
        light: direction(-1.0, -1.5, -1.0),
        fire: None,
        volume: Some(volume),
        target: Some(image(FORMAT)),
        background: Background::Clear([0.0; 4]),
        depth: Some(depth()),
        edges: Some(buffer(16 * 48)),
        temporal: Default::default(),
    }
}

#[test]
fn smoke_refuses_before_the_first_command() {
    let Some(mut device) = device() else { return };
    let mut smoke = make::<smoke::SmokeKind>(&mut device, &smoke_desc()).expect("an effect");
    let host = device.host();
    let good = smoke_frame();
    let target = good.target.expect("a target");
    let lost = HostImage { state_in: state(vk::ImageLayout::UNDEFINED), ..target };
    let left = HostImage { state_out: state(vk::ImageLayout::UNDEFINED), ..target };
    let empty = HostImage { state_in: state(vk::ImageLayout::UNDEFINED), ..depth() };
    let cases = [
        ("edges: 16 bytes; 768 expected", smoke::Frame { edges: Some(buffer(16)), ..good }),
        ("depth: missing; the effect was made with depth = D32_SFLOAT", smoke::Frame { depth: None, ..good }),
        (
            "light: a point light; the effect was made with point_light = false",
            smoke::Frame { light: point(1.0, 2.0, 3.0), ..good },
        ),
        (
            "volume: velocities are given; the effect was made with velocity = false",
            smoke::Frame { volume: good.volume.map(|v| VolumeInput { velocity: Some(v.density), ..v }), ..good },
        ),
        (
            "target: state_in has layout UNDEFINED",
            smoke::Frame { target: Some(lost), background: Background::Keep, ..good },
        ),
        ("target: state_out has layout UNDEFINED", smoke::Frame { target: Some(left), ..good }),
        ("depth: state_in has layout UNDEFINED", smoke::Frame { depth: Some(empty), ..good }),
        ("view.reversed = false: true", smoke::Frame { view: good.view.with_reversed(false), ..good }),
        ("background: it is the target's image", smoke::Frame { background: Background::Copy(target), ..good }),
    ];
    for (expected, frame) in cases {
        let said = refusal(&host, &mut smoke, &frame, &mut Timing::None);
        assert!(said.starts_with(expected), "{expected}: {said}");
    }
    let mut timing = Timing::Queries { pool: handle(), first: 4, count: 24 };
    let said = refusal(&host, &mut smoke, &good, &mut timing);
    assert!(said.starts_with("timing: 20 queries are left from 4 of 24; this frame of "), "{said}");
    assert!(matches!(timing, Timing::Queries { first: 4, .. }), "nothing was written");
    // It still waits for its first frame.
    let said = refusal(&host, &mut smoke, &smoke::Frame { sequence: Sequence::Advance, ..good }, &mut Timing::None);
    assert!(said.starts_with("frame.sequence = Advance"), "{said}");
    destroy(&mut device, smoke);
}

fn flame_desc() -> flame::Desc {
    let settings = flame::Settings { spread: Some(0.1), ..flame::Settings::default() };
    let (hottest, scene) = (settings.hottest, Some(SceneFormat::Image(REVERSED)));
    flame::Desc {
        size: SIZE,
        lines: None,
        target_format: FORMAT,
        scene,
        accumulates: false,
        particles: 9,
        hottest,
        seed: 1,
        settings,
        layers: false,
        temporal: Default::default(),
    }
}

#[test]
fn flame_refuses_before_the_first_command() {
    let Some(mut device) = device() else { return };
    let mut flame = make::<flame::FlameKind>(&mut device, &flame_desc()).expect("an effect");
    let host = device.host();
    let position_temperature = buffer(16 * 9);
    let given = ParticleInput::new(9, position_temperature);
    let good = flame::Frame {
        view: Camera::default().view(SIZE),
        particles: Some(given),
        spread: None,
        number: 0,
        accumulate: false,
        target: image(FORMAT),
        background: Background::Keep,
        scene: Some(SceneDepth::Image(depth())),
        temporal: Default::default(),
    };
    let lost = HostImage { state_in: state(vk::ImageLayout::UNDEFINED), ..good.target };
    let short = ParticleInput { position_temperature: buffer(16 * 8), ..given };
    let cases = [
        ("target: state_in has layout UNDEFINED", flame::Frame { target: lost, ..good }),
        ("background: it is the target's image", flame::Frame { background: Background::Copy(good.target), ..good }),
        ("view.reversed = false: true", flame::Frame { view: good.view.with_reversed(false), ..good }),
        ("scene: a buffer", flame::Frame { scene: Some(SceneDepth::Buffer(buffer(4 * 48))), ..good }),
        ("particles", flame::Frame { particles: Some(short), ..good }),
        ("particles: the first frame needs some", flame::Frame { particles: None, ..good }),
        ("frame.accumulate = true: not unless", flame::Frame { accumulate: true, ..good }),
    ];
    for (expected, frame) in cases {
        let said = refusal(&host, &mut flame, &frame, &mut Timing::None);
        assert!(said.starts_with(expected), "{expected}: {said}");
    }
    let mut timing = Timing::Queries { pool: handle(), first: 0, count: 2 };
    let said = refusal(&host, &mut flame, &good, &mut timing);
    assert!(said.starts_with("timing: 2 queries are left"), "{said}");
    destroy(&mut device, flame);
}

fn blur_desc() -> blur::Desc {
    let triangles = &[[0, 1, 2], [2, 1, 3]];
    let input = MeshInput { vertices: 4, triangles, objects: None, weld: None, normals: None, rest: None };
    let mesh = Mesh::new(&input).expect("a mesh");
    blur::Desc {
        target_format: FORMAT,
        depth: Some(REVERSED),
        ..blur::Desc::new(&mesh, SIZE, blur::Settings::default())
    }
}

/// Depth of images is there exactly beside each image, if the effect was made for it.
#[test]
fn occluders_are_beside_images() {
    let Some(mut device) = device() else { return };
    for (made, given, expected) in [
        (None, true, "occluders: given of frame i; the effect was made without occluders"),
        (Some(REVERSED), false, "occluders: missing of frame i; the effect was made with occluders = D32_SFLOAT"),
    ] {
        let desc = blur::Desc { occluders: made, depth: None, ..blur_desc() };
        let mut blur = make::<blur::BlurKind>(&mut device, &desc).expect("an effect");
        let mesh = blur::TopologyInput {
            triangles: buffer(4096),
            neighbour_starts: buffer(4096),
            neighbours: buffer(4096),
            groups: Some(blur::GroupInput { corners: buffer(4096), starts: buffer(4096), triangles: buffer(4096) }),
            colours: None,
            textures: None,
            shares: None,
            parts: None,
            source_rows: None,
            sizes: None,
        };
        let inner = given.then(depth);
        let frame = blur::Frame {
            mesh: Some(mesh),
            images: Some([image(FORMAT); 2]),
            occluders: [None, inner, inner, None],
            ..blur::Frame::new(image(FORMAT))
        };
        let said = refusal(&device.host(), &mut blur, &frame, &mut Timing::None);
        assert_eq!(said, expected);
        destroy(&mut device, blur);
    }
}

/// Positions that are read in place: where, how far apart, how many.
#[test]
fn sources_are_checked() {
    let Some(mut device) = device() else { return };
    let points = blur_desc().points;
    let source = |offset, stride, points, size| {
        let buffer = HostBuffer { offset, ..buffer(size) };
        vec![blur::Source { buffer, stride, vertices: points, points }]
    };
    for (sources, expected) in [
        (source(4, 3, points, 4096), "blur's source's offset = 4: a multiple of 256"),
        (source(4, 3, points, 44), "blur's source's offset = 4: a multiple of 256, from which on 48 bytes are read"),
        (source(0, 2, points, 4096), "blur's source's stride = 2"),
        (source(0, 3, points + 1, 4096), "blur's sources = 1 of 5 points"),
        (source(256, 3, points, 44), "a source of blur's positions: 44 bytes; 48 expected"),
        (source(0, 3, 1, 4096).repeat(9), "blur's sources = 9"),
    ] {
        refuses::<blur::BlurKind>(&mut device, &blur::Desc { sources, ..blur_desc() }, expected);
    }
}

/// A format that a target or a depth image cannot have, and what is said of it.
#[test]
fn formats_are_asked_for() {
    let Some(mut device) = device() else { return };
    let targets = [
        (vk::Format::UNDEFINED, "target_format: UNDEFINED, which this device has not as"),
        (vk::Format::R8G8B8A8_UINT, "target_format: R8G8B8A8_UINT, which this device has not as"),
        (vk::Format::D32_SFLOAT, "target_format: D32_SFLOAT, which this device has not as COLOR_ATTACHMENT"),
        (vk::Format::BC1_RGB_UNORM_BLOCK, "target_format: BC1_RGB_UNORM_BLOCK, which this device has not as"),
    ];
    for (target_format, expected) in targets {
        refuses::<smoke::SmokeKind>(&mut device, &smoke::Desc { target_format, ..smoke_desc() }, expected);
        refuses::<flame::FlameKind>(&mut device, &flame::Desc { target_format, ..flame_desc() }, expected);
        refuses::<blur::BlurKind>(&mut device, &blur::Desc { target_format, ..blur_desc() }, expected);
    }
    for format in [vk::Format::R8G8B8A8_UNORM, vk::Format::S8_UINT] {
        let (made, expected) = (DepthFormat { format, ..REVERSED }, format!("depth.format: {format:?}, which "));
        refuses::<smoke::SmokeKind>(&mut device, &smoke::Desc { depth: Some(made), ..smoke_desc() }, &expected);
        let scene = Some(SceneFormat::Image(made));
        refuses::<flame::FlameKind>(&mut device, &flame::Desc { scene, ..flame_desc() }, &expected);
        refuses::<blur::BlurKind>(&mut device, &blur::Desc { depth: Some(made), ..blur_desc() }, &expected);
    }
    let of = |motion, reactive| TemporalFormats { motion, reactive };
    for (temporal, expected) in [
        (of(Some(vk::Format::R16G16_SNORM), None), "temporal.motion: R16G16_SNORM; expected one of [R16G16_SFLOAT"),
        (of(None, Some(vk::Format::R16_UINT)), "temporal.reactive: R16_UINT; expected one of [R8_UNORM"),
    ] {
        refuses::<smoke::SmokeKind>(&mut device, &smoke::Desc { temporal, ..smoke_desc() }, expected);
        refuses::<flame::FlameKind>(&mut device, &flame::Desc { temporal, ..flame_desc() }, expected);
        refuses::<blur::BlurKind>(&mut device, &blur::Desc { temporal, ..blur_desc() }, expected);
    }
    // All that can be, this device has.
    let every = |motion: &vk::Format| REACTIVE_FORMATS.map(|reactive| of(Some(*motion), Some(reactive)));
    for temporal in MOTION_FORMATS.iter().flat_map(every) {
        let effect = make::<smoke::SmokeKind>(&mut device, &smoke::Desc { temporal, ..smoke_desc() });
        destroy(&mut device, effect.expect("an effect"));
    }
}

fn refuses<K: Kind>(device: &mut TestDevice, desc: &K::Desc, expected: &str) {
    let said = make::<K>(device, desc).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(said.starts_with(expected), "{}: {expected}: {said}", K::NAME);
}

/// What is said before anything exists is what is taken, but for alignment, whatever the target's format.
#[test]
fn memory_is_known_before() {
    let Some(mut device) = device() else { return };
    let size = [640, 360];
    for target_format in [FORMAT, vk::Format::R16G16B16A16_SFLOAT, vk::Format::R32G32B32A32_SFLOAT] {
        takes::<smoke::SmokeKind>(&mut device, &smoke::Desc { size, target_format, ..smoke_desc() });
        takes::<flame::FlameKind>(&mut device, &flame::Desc { size, target_format, ..flame_desc() });
        takes::<blur::BlurKind>(&mut device, &blur::Desc { size, target_format, outer: true, ..blur_desc() });
    }
}

fn takes<K: Kind>(device: &mut TestDevice, desc: &K::Desc) {
    let memory = Effect::<K>::memory(desc, &device.traits()).expect("a size");
    let effect = make::<K>(device, desc).expect("an effect");
    let report = device.parts().1.generate_report();
    let (prefix, scratch) = (format!("{} ", K::NAME), format!("{} scratch", K::NAME));
    let taken = |is_scratch: bool| -> u64 {
        let own =
            report.allocations.iter().filter(|a| a.name.starts_with(&prefix) && (a.name == scratch) == is_scratch);
        own.map(|a| a.size).sum()
    };
    let (history, scratch) = (taken(false), taken(true));
    let needs = {
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        unsafe { Effect::<K>::scratch_needs(&host, kernels, allocator, desc) }.expect("a size")
    };
    destroy(device, effect);
    assert_eq!(needs.bytes, scratch, "{}", K::NAME);
    assert!(memory.images > 0 && memory.images < memory.total(), "{}: {memory:?}", K::NAME);
    // Images are padded to whole tiles and rows.
    for (said, taken) in [(memory.history, history), (memory.scratch, scratch)] {
        assert!(said <= taken && taken - said <= taken / 100, "{}: {said} bytes said, {taken} taken", K::NAME);
    }
}

/// Effects are made by one thread and recorded by another; what is shared is only read.
#[test]
fn effects_go_between_threads() {
    fn send<T: Send>() {}
    fn sync<T: Sync>() {}
    send::<Smoke>();
    send::<Flame>();
    send::<Blur>();
    sync::<Smoke>();
    sync::<Flame>();
    sync::<Blur>();
    send::<Kernels>();
    sync::<Kernels>();
    send::<Mesh>();
    sync::<blur::Motion>();
}

/// A host's own memory: a pair of functions, each allocation of its own.
struct OwnMemory<'a> {
    host: Host<'a>,
    types: vk::PhysicalDeviceMemoryProperties,
    /// Allocations that are out, and bytes.
    out: (usize, u64),
    most: u64,
    /// Refuses what comes when so many are out.
    limit: usize,
}

unsafe extern "C" fn allocate(
    user: *mut c_void,
    request: *const CallbackRequest,
    to: *mut CallbackAllocation,
) -> vk::Result {
    // SAFETY: both are the test's own, and valid during the call.
    let (own, request) = unsafe { (&mut *user.cast::<OwnMemory>(), &*request) };
    // SAFETY: a string of the library's.
    let name = unsafe { std::ffi::CStr::from_ptr(request.name) };
    assert!(!name.is_empty() && request.properties == vk::MemoryPropertyFlags::DEVICE_LOCAL);
    if own.out.0 == own.limit {
        return vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
    }
    let fits = |index: &u32| {
        let kind = own.types.memory_types[*index as usize].property_flags;
        request.requirements.memory_type_bits >> index & 1 == 1 && kind.contains(request.properties)
    };
    let kind = (0..own.types.memory_type_count).find(fits).expect("a type");
    let size = request.requirements.size;
    let info = vk::MemoryAllocateInfo::default().allocation_size(size).memory_type_index(kind);
    // SAFETY: valid handles.
    let memory = unsafe { own.host.device.allocate_memory(&info, None) }.expect("memory");
    own.out = (own.out.0 + 1, own.out.1 + size);
    own.most = own.most.max(own.out.1);
    // What a source knows an allocation by comes back as it was.
    let known = memory.as_raw() as *mut c_void;
    // SAFETY: the library's, to be filled in.
    unsafe { to.write(CallbackAllocation { memory, offset: 0, size, mapped: std::ptr::null_mut(), own: known }) };
    vk::Result::SUCCESS
}

unsafe extern "C" fn free(user: *mut c_void, given: *const CallbackAllocation) {
    // SAFETY: both are the test's own, and valid during the call.
    let (own, given) = unsafe { (&mut *user.cast::<OwnMemory>(), &*given) };
    assert_eq!(given.own as u64, given.memory.as_raw());
    own.out = (own.out.0 - 1, own.out.1 - given.size);
    // SAFETY: nothing uses it any more.
    unsafe { own.host.device.free_memory(given.memory, None) };
}

/// Each effect takes what it said it would from the host's functions, gives all of it back, and leaves nothing where there is
/// not enough.
#[test]
fn memory_comes_from_the_hosts_own_functions() {
    let Some(device) = device() else { return };
    let host = device.host();
    // SAFETY: valid handles.
    let types = unsafe { host.instance.get_physical_device_memory_properties(host.physical_device) };
    let kernels = device.kernels();
    fn check<K: Kind>(own: &mut OwnMemory, kernels: &celfx::effect::Kernels, desc: &K::Desc, memory: Memory) {
        let mut callbacks = MemoryCallbacks { user: (&raw mut *own).cast(), allocate, free };
        let host = own.host;
        // SAFETY: the device's own handles; nothing is ever recorded.
        unsafe {
            let effect = Effect::<K>::new(&host, kernels, &mut callbacks, desc.clone()).expect("an effect");
            let (count, taken) = own.out;
            let apart = taken.abs_diff(memory.total()) as f64 / taken as f64;
            // Pages of 4 KiB round up what is as small as here.
            assert!(count > 5 && apart < 0.5, "{}: {taken} bytes, {memory:?} said", K::NAME);
            effect.retire().destroy(&host, &mut callbacks);
            assert_eq!(own.out, (0, 0), "{}: all is given back", K::NAME);
            own.limit = count / 2;
            let refused =
                Effect::<K>::new(&host, kernels, &mut callbacks, desc.clone()).expect_err("not enough memory");
            assert!(refused.to_string().starts_with("no memory for "), "{refused}");
            assert_eq!(own.out, (0, 0), "{}: nothing is left behind", K::NAME);
            own.limit = usize::MAX;
        }
    }
    let mut own = OwnMemory { host, types, out: (0, 0), most: 0, limit: usize::MAX };
    let memory = |memory: celfx::error::Result<Memory>| memory.expect("sizes");
    let (smoke, flame, blur) = (smoke_desc(), flame_desc(), blur_desc());
    // SAFETY: valid handles.
    let traits = unsafe { kernels.traits(&host) };
    let said = [Smoke::memory(&smoke, &traits), Flame::memory(&flame, &traits), Blur::memory(&blur, &traits)];
    let [of_smoke, of_flame, of_blur] = said.map(memory);
    check::<smoke::SmokeKind>(&mut own, kernels, &smoke, of_smoke);
    check::<flame::FlameKind>(&mut own, kernels, &flame, of_flame);
    check::<blur::BlurKind>(&mut own, kernels, &blur, of_blur);
    assert!(own.most > 0);
}
