//! What else is in the scene: it hides fire, and the fire shines on it.

use ash::vk;
use celfx::flame::FlameKind;
use celfx::flame::settings::Mode;
use celfx::flame::{DepthFormat, Desc, Frame, SceneDepth, SceneFormat, Settings};
use celfx::host::{Host, HostBuffer, HostImage, ImageState};
use celfx::low_level::flame::params::Particle;
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM};
use celfx::smoke::{self, Smoke};
use celfx::view::{Camera, Projection};
use glam::DVec3;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use crate::cases::{Case, plain, settings};
use crate::common::flame::{FlameRig, embers, scene};
use crate::common::host::{self, DISCARDED};
use crate::common::{TestDevice, device, scenes};
use crate::host::{FORMAT, Slot, make};

/// A depth image of any format, and what is copied into it.
struct DepthImage {
    handle: vk::Image,
    view: vk::ImageView,
    allocation: Option<Allocation>,
    words: Buffer,
    aspect: vk::ImageAspectFlags,
    size: [u32; 2],
}

impl DepthImage {
    unsafe fn new(device: &mut TestDevice, format: vk::Format, size: [u32; 2], bytes: &[u8]) -> DepthImage {
        let (host, allocator) = device.parts();
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: size[0], height: size[1], depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST | DEPTH);
        let aspect = match format {
            vk::Format::D16_UNORM | vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D32_SFLOAT => {
                vk::ImageAspectFlags::DEPTH
            }
            _ => vk::ImageAspectFlags::DEPTH | vk::ImageAspectFlags::STENCIL,
        };
        // SAFETY: the caller's.
        unsafe {
            let handle = host.device.create_image(&info, None).expect("an image");
            let request = AllocationCreateDesc {
                name: "host depth",
                requirements: host.device.get_image_memory_requirements(handle),
                location: MemoryLocation::GpuOnly,
                linear: false,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            };
            let allocation = allocator.allocate(&request).expect("memory");
            host.device.bind_image_memory(handle, allocation.memory(), allocation.offset()).expect("bound memory");
            let view = vk::ImageViewCreateInfo::default()
                .image(handle)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format)
                .subresource_range(host::whole(vk::ImageAspectFlags::DEPTH));
            let view = host.device.create_image_view(&view, None).expect("a view");
            let mut words = host::source(device, bytes.len() as u64);
            host::fill(&mut words, bytes);
            DepthImage { handle, view, allocation: Some(allocation), words, aspect, size }
        }
    }

    /// The host's own drawing.
    unsafe fn draw(&self, host: &Host, commands: vk::CommandBuffer) {
        let regions = [host::image_copy(vk::ImageAspectFlags::DEPTH, self.size)];
        // SAFETY: the caller's.
        unsafe {
            host::change(host, commands, (self.handle, self.aspect), DISCARDED, CLEARED);
            let (from, to) = (self.words.handle, self.handle);
            host.device.cmd_copy_buffer_to_image(commands, from, to, CLEARED.layout, &regions);
        }
    }

    unsafe fn destroy(mut self, device: &mut TestDevice) {
        let (host, allocator) = device.parts();
        // SAFETY: the caller's.
        unsafe {
            host.device.destroy_image_view(self.view, None);
            host.device.destroy_image(self.handle, None);
            self.words.destroy(&host, allocator);
        }
        allocator.free(self.allocation.take().expect("memory")).expect("it is given back");
    }
}

const DEPTH: vk::ImageUsageFlags = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;

fn is_supported(host: &Host, format: vk::Format) -> bool {
    let needed = vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT
        | vk::FormatFeatureFlags::TRANSFER_SRC
        | vk::FormatFeatureFlags::TRANSFER_DST;
    // SAFETY: valid handles.
    let has = unsafe { host.instance.get_physical_device_format_properties(host.physical_device, format) };
    has.optimal_tiling_features.contains(needed)
}

/// What an image of a format holds for these depths: its bytes, and the view depths in f64 that they stand for.
fn stored(format: vk::Format, terms: [f64; 2], depths: &[f32]) -> (Vec<u8>, Vec<f32>) {
    let steps = match format {
        vk::Format::D16_UNORM | vk::Format::D16_UNORM_S8_UINT => 65_535.0,
        vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D24_UNORM_S8_UINT => 16_777_215.0,
        _ => 0.0,
    };
    let mut bytes = Vec::new();
    let mut decoded = Vec::new();
    for z in depths {
        let depth = (terms[0] + terms[1] / f64::from(*z)).clamp(0.0, 1.0);
        let depth = match steps {
            0.0 => {
                bytes.extend((depth as f32).to_ne_bytes());
                f64::from(depth as f32)
            }
            _ => {
                let step = (depth * steps).round();
                let word = (step as u32).to_ne_bytes();
                bytes.extend(if steps == 65_535.0 { &word[..2] } else { &word[..] });
                step / steps
            }
        };
        let z = terms[1] / (depth - terms[0]);
        decoded.push(if z > 0.0 { z as f32 } else { f32::INFINITY });
    }
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    (bytes, decoded)
}

/// A floor that rises from behind the fire to before it, and nothing in every fifth column.
fn floor([width, height]: [u32; 2]) -> Vec<f32> {
    let depth = |i: u32| match i % width % 5 {
        0 => f32::INFINITY,
        _ => 5.2 - 2.0 * (i / width) as f32 / height as f32,
    };
    (0..width * height).map(depth).collect()
}

/// Pictures in sRGB bytes: the flame over the host's sky with a scene.
fn over_sky(
    device: &mut TestDevice,
    case: &Case,
    format: SceneFormat,
    scene: SceneDepth,
    drawn: Option<&DepthImage>,
) -> Vec<[u8; 4]> {
    let desc = Desc { target_format: FORMAT, layers: false, scene: Some(format), ..case.desc.clone() };
    let mut flame = make(device, desc);
    let mut slot = Slot::new(device, case.desc.size, case.desc.particles);
    let frame = Frame { view: case.seen(), scene: Some(scene), ..slot.frame(&case.particles, 0) };
    host::run(device, |host, commands| {
        // SAFETY: everything is the test's own and waited for.
        unsafe {
            slot.draw(host, commands);
            if let Some(drawn) = drawn {
                drawn.draw(host, commands);
            }
            flame.record(host, commands, &frame, &mut Timing::None).expect("a frame");
            slot.show(host, commands);
        }
    });
    let pixels = slot.pixels();
    slot.destroy(device);
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { flame.destroy(&host, allocator) };
    pixels
}

#[test]
fn depth_images_of_any_format_hide_what_a_buffer_does() {
    let case = plain().with(|s| (s.mode, s.repetitions, s.count) = (Mode::Stochastic, 8, 30.0));
    let depths = floor(case.desc.size);
    let Some(mut device) = device() else { return };
    let mut tried = 0;
    for format in [
        vk::Format::D16_UNORM,
        vk::Format::D32_SFLOAT,
        vk::Format::X8_D24_UNORM_PACK32,
        vk::Format::D24_UNORM_S8_UINT,
        vk::Format::D32_SFLOAT_S8_UINT,
    ] {
        if !is_supported(&device.host(), format) {
            println!("no {format:?}");
            continue;
        }
        let all = [(false, 50.0), (true, 50.0), (true, f32::INFINITY)];
        // What a projection means is the same for all; kinds of words are not.
        let tried_all = format == vk::Format::D32_SFLOAT;
        let these = all.into_iter().skip(if tried_all { 0 } else { tried % 3 }).take(if tried_all { 3 } else { 1 });
        for (reversed, far) in these {
            let camera = Camera { near: 1.0, far: far.into(), ..case.camera };
            let view = camera.view(case.desc.size).with_reversed(reversed);
            let terms = Projection::of_valid(&view, case.desc.size).depth_terms;
            let case = Case { camera, view: Some(view), ..case.clone() };
            let (bytes, decoded) = stored(format, terms, &depths);
            // SAFETY: everything is the test's own; every submission is waited for.
            let (own, buffer) = unsafe {
                let depth = DepthImage::new(&mut device, format, case.desc.size, &bytes);
                let image = HostImage::new(depth.handle, depth.view, format, case.desc.size, CLEARED, COPIED_FROM);
                let scene = SceneDepth::Image(image);
                let made = SceneFormat::Image(DepthFormat { format, reversed });
                let own = over_sky(&mut device, &case, made, scene, Some(&depth));
                depth.destroy(&mut device);
                (own, buffer_picture(&mut device, &case, &decoded))
            };
            let differing = own.iter().zip(&buffer).filter(|(a, b)| a != b).count();
            // The same depths but for a rounding in single precision, 1e-7 of which render particles lie within.
            assert!(differing <= 1, "{format:?}, reversed {reversed}, far {far}: {differing} pixels differ");
            tried += 1;
        }
    }
    assert!(tried >= 4, "{tried} images");
    // It matters: without the scene there is more fire, with a wall at the camera none.
    let open = buffer_picture(&mut device, &case, &vec![f32::INFINITY; depths.len()]);
    let hidden = buffer_picture(&mut device, &case, &depths);
    let closed = buffer_picture(&mut device, &case, &vec![0.5; depths.len()]);
    let fire = |picture: &[[u8; 4]]| picture.iter().filter(|c| **c != closed[0]).count();
    assert!(fire(&closed) == 0 && fire(&hidden) > 50 && fire(&open) > fire(&hidden) + 50);
}

/// The picture with view depths in a buffer.
fn buffer_picture(device: &mut TestDevice, case: &Case, depths: &[f32]) -> Vec<[u8; 4]> {
    let mut words = host::source(device, 4 * depths.len() as u64);
    let buffer = host::fill(&mut words, depths);
    let picture = over_sky(device, case, SceneFormat::Buffer, SceneDepth::Buffer(buffer), None);
    host::destroy(device, [&mut words], []);
    picture
}

/// The middle of the fire in view space, the square of its width, and its colour: what `flame.light` goes by.
fn lamp(particles: &[Particle], strength: f64) -> (DVec3, f64, DVec3) {
    let (mut place, mut squares, mut brightness, mut colour) = (DVec3::ZERO, 0.0, 0.0, DVec3::ZERO);
    for particle in particles.iter().filter(|p| p.count > 0) {
        let own = f64::from(particle.count) * DVec3::from_array([0, 1, 2].map(|c| f64::from(particle.colour[c])));
        let view = DVec3::from_array([particle.view[0], particle.view[1], particle.depth].map(f64::from));
        place += own.max_element() * view;
        squares += own.max_element() * view.length_squared();
        brightness += own.max_element();
        colour += own;
    }
    let middle = place / brightness;
    let variance = squares / brightness - middle.length_squared();
    (middle, 4.0 * variance, strength * colour / colour.max_element())
}

#[test]
fn fire_shines_on_the_scene_alone() {
    let strength = 0.7_f32;
    let mut case = Case::new("lit", [48, 36], 60, Settings { light: strength, ..settings() }, scenes::camera(25.0));
    case.desc.scene = Some(SceneFormat::Buffer);
    case.depth = Some(floor(case.desc.size));
    let sky = [0.3_f32, 0.2, 0.1, 1.0];
    let Some(mut rig) = FlameRig::new(case.desc.clone()) else { return };
    rig.offline().set_background(sky);
    let depths = case.depth.clone().unwrap_or_default();
    let shot = celfx::offline::Scene { depth: Some(&depths), ..scene(Some(&case.particles), case.camera) };
    rig.render(&shot);
    let (middle, width, colour) = lamp(&rig.prepared(), strength.into());
    let half = case.camera.half_extent(case.desc.size);
    let (picture, effect) = (rig.picture(), rig.effect());
    let mut brightened = 0.0_f64;
    for (i, (found, own)) in picture.iter().zip(&effect).enumerate() {
        let (x, y) = ((i % 48) as f64, (i / 48) as f64);
        let slope = DVec3::new(half.x * ((x + 0.5) / 24.0 - 1.0), half.y * (1.0 - (y + 0.5) / 18.0), 1.0);
        let z = f64::from(depths[i]);
        let factor = match z.is_finite() {
            true => 1.0 + colour / (1.0 + (z * slope - middle).length_squared() / width),
            false => DVec3::ONE,
        };
        brightened = brightened.max(factor.max_element());
        for c in 0..3 {
            let expected = f64::from(own[c]) + f64::from(1.0 - own[3]) * f64::from(sky[c]) * factor[c];
            // Some twenty roundings of numbers around 1, and sums over 60 particles.
            let apart = crate::common::apart(found[c], expected);
            assert!(apart < 1e-5, "pixel {i}: {} instead of {expected}", found[c]);
        }
    }
    assert!(brightened > 1.3, "{brightened}");
    check_unlit(&case, &shot);
}

/// Off, the step is not there, and neither is it without a scene.
fn check_unlit(case: &Case, shot: &celfx::offline::Scene) {
    let without_scene = Case { desc: Desc { scene: None, ..case.desc.clone() }, depth: None, ..case.clone() };
    let off = case.with(|s| s.light = 0.0);
    for (case, depth) in [(off, shot.depth), (without_scene, None)] {
        let Some(mut rig) = FlameRig::new(case.desc.clone()) else { return };
        rig.offline().set_background([0.3, 0.2, 0.1, 1.0]);
        rig.render(&celfx::offline::Scene { depth, ..*shot });
        let (picture, effect) = (rig.picture(), rig.effect());
        let empty = effect.iter().zip(&picture).filter(|(own, _)| own[3] == 0.0);
        assert!(empty.clone().count() > 100 && empty.clone().all(|(_, c)| *c == [0.3, 0.2, 0.1, 1.0]));
        let flame = rig.offline().effect::<FlameKind>().expect("a flame");
        let passes = flame.passes();
        assert!(flame.plan().steps.iter().all(|step| passes[usize::from(step.pass.0)].name != "flame.light"));
        assert!(flame.skipped().any(|(name, _)| name == "flame.light"));
    }
}

/// Smoke, and fire in it, in the same commands; so many frames on their way.
fn with_smoke(in_flight: usize) -> Option<Vec<Vec<[u8; 4]>>> {
    let size = [48, 36];
    let mut device = device()?;
    let smoke_settings = smoke::Settings { particles: 150, ..smoke::Settings::default() };
    let smoke_desc = smoke::Desc { target_format: FORMAT, ..scenes::desc(size, [20; 3], smoke_settings) };
    let flame_desc = Desc {
        target_format: FORMAT,
        scene: Some(SceneFormat::Buffer),
        ..Case::new("", size, 80, Settings { light: 0.5, bins: 8, ..settings() }, scenes::camera(0.0)).desc
    };
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own.
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, smoke_desc) }.expect("smoke");
    let mut flame = make(&mut device, flame_desc);
    let slot = |_| (Slot::new(&mut device, size, 80), host::source(&mut device, 4 * 20 * 20 * 20));
    let mut slots: Vec<(Slot, Buffer)> = (0..in_flight).map(slot).collect();
    let (buffer, offset, bytes) = smoke.buffer(celfx::low_level::smoke::layout::DEPTH);
    let depth = HostBuffer {
        buffer,
        offset,
        size: bytes,
        stage: vk::PipelineStageFlags2::COMPUTE_SHADER | vk::PipelineStageFlags2::ALL_TRANSFER,
        access: vk::AccessFlags2::SHADER_STORAGE_WRITE | vk::AccessFlags2::TRANSFER_WRITE,
    };
    let record = |host: &Host, commands, (slot, density): &mut (Slot, Buffer), i: u32| {
        let volume = scenes::puffs(20, i as f32 / 12.0);
        let fire = slot.frame(&embers(80, 7), i);
        let smoke_frame = smoke::Frame {
            sequence: if i == 0 { smoke::Sequence::Restart } else { smoke::Sequence::Advance },
            dt: 1.0 / 24.0,
            view: fire.view,
            light: scenes::direction(-1.0, -1.5, -1.0),
            fire: None,
            volume: Some(smoke::VolumeInput {
                dimensions: volume.dimensions,
                voxel_size: volume.voxel_size,
                origin: volume.origin,
                density: host::fill(density, &volume.density),
                velocity: None,
            }),
            target: Some(HostImage { state_out: SMOKED, ..fire.target }),
            background: smoke::Background::Keep,
            depth: None,
            edges: None,
            temporal: Default::default(),
        };
        let target = HostImage { state_in: SMOKED, ..fire.target };
        let fire = Frame { scene: Some(SceneDepth::Buffer(depth)), target, ..fire };
        // SAFETY: frames are submitted in order to one queue; this slot's last frame has been waited for.
        unsafe {
            slot.draw(host, commands);
            smoke.record(host, commands, &smoke_frame, &mut Timing::None).expect("smoke");
            flame.record(host, commands, &fire, &mut Timing::None).expect("fire");
            slot.show(host, commands);
        }
    };
    let pictures = host::in_flight(&mut device, &mut slots, 6, record, |(slot, _)| slot.pixels());
    for (slot, mut density) in slots {
        slot.destroy(&mut device);
        host::destroy(&mut device, [&mut density], []);
    }
    let (host, allocator) = device.parts();
    // SAFETY: every submission has been waited for.
    unsafe {
        smoke.destroy(&host, allocator);
        flame.destroy(&host, allocator);
    }
    Some(pictures)
}

/// How smoke leaves the target for the fire.
const SMOKED: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT,
    access: vk::AccessFlags2::COLOR_ATTACHMENT_WRITE,
    layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
};

#[test]
fn smoke_and_fire_in_flight_are_those_that_are_waited_for() {
    let Some(waited) = with_smoke(1) else { return };
    let Some(flying) = with_smoke(2) else { return };
    for (i, (a, b)) in flying.iter().zip(&waited).enumerate() {
        assert!(a == b, "frame {i} differs");
    }
    let colours: std::collections::BTreeSet<_> = waited[3].iter().collect();
    assert!(waited.len() == 6 && colours.len() > 50, "{} colours of smoke and fire", colours.len());
    assert!(waited.windows(2).all(|pair| pair[0] != pair[1]), "frames that are all the same show nothing");
}
