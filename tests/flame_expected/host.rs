//! A host of the flame: targets with states of its own, frames in flight, other sizes, the end.

use ash::vk;
use celfx::data::Particles;
use celfx::error::Error;
use celfx::flame::{Background, DepthFormat, Desc, Flame, Frame, ParticleInput, SceneDepth, SceneFormat, Settings};
use celfx::host::{Host, HostImage, ImageState};
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM};
use celfx::view::Projection;

use crate::cases::{Case, plain};
use crate::common::allocations::allocated;
use crate::common::flame::{ball, embers};
use crate::common::host::{self, DISCARDED, Place};
use crate::common::{TestDevice, device, scenes};

pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
const SKY: [f32; 4] = [0.2, 0.5, 0.9, 1.0];

/// What one frame in flight needs of a host.
pub struct Slot {
    place: Place,
    pub target: Image,
    backdrop: Image,
    rows: Buffer,
    ids: Buffer,
    picture: Buffer,
}

impl Slot {
    pub fn new(device: &mut TestDevice, size: [u32; 2], particles: u32) -> Slot {
        Slot::in_larger_images(device, Place { size, corner: [0; 2] }, particles)
    }

    pub fn in_larger_images(device: &mut TestDevice, place: Place, particles: u32) -> Slot {
        let extent = place.extent();
        Slot {
            place,
            target: host::image(device, extent, FORMAT),
            backdrop: host::image(device, extent, FORMAT),
            rows: host::source(device, 16 * u64::from(particles)),
            ids: host::source(device, 4 * u64::from(particles)),
            picture: host::sink(device, 4 * u64::from(extent[0]) * u64::from(extent[1])),
        }
    }

    fn image(&self, image: &Image, state_in: ImageState, state_out: ImageState) -> HostImage {
        self.place.given(image, FORMAT, state_in, state_out)
    }

    /// Frame `number` over the target as it is, its particles written, with ids.
    pub fn frame(&mut self, particles: &Particles, number: u32) -> Frame {
        let rows: Vec<[f32; 4]> =
            particles.position.iter().zip(&particles.temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]).collect();
        let ids = ids(rows.len());
        let given = ParticleInput {
            count: rows.len() as u32,
            hottest: f32::INFINITY,
            position_temperature: host::fill(&mut self.rows, &rows),
            ids: Some(host::fill(&mut self.ids, &ids)),
            previous: None,
            velocity: None,
        };
        Frame {
            view: scenes::camera(25.0 + 3.0 * f64::from(number)).view(self.place.size),
            particles: Some(given),
            spread: None,
            number,
            accumulate: false,
            target: self.image(&self.target, CLEARED, COPIED_FROM),
            background: Background::Keep,
            scene: None,
            temporal: Default::default(),
        }
    }

    /// The host's own drawing: the sky into the target and into the backdrop.
    pub unsafe fn draw(&self, host: &Host, commands: vk::CommandBuffer) {
        for image in [&self.target, &self.backdrop] {
            // SAFETY: the caller's.
            unsafe {
                host::change(host, commands, (image.handle, image.aspect), DISCARDED, CLEARED);
                let colour = vk::ClearColorValue { float32: SKY };
                let range = [host::whole(image.aspect)];
                host.device.cmd_clear_color_image(commands, image.handle, CLEARED.layout, &colour, &range);
            }
        }
    }

    /// Copies the picture to where the host reads it.
    pub unsafe fn show(&self, host: &Host, commands: vk::CommandBuffer) {
        // SAFETY: the caller's; the effect left the image in the state that copies want.
        unsafe {
            host::show(host, commands, (self.target.handle, self.target.aspect), self.place.extent(), &self.picture)
        };
    }

    pub fn pixels(&self) -> Vec<[u8; 4]> {
        self.parts().0
    }

    /// The picture, and what lies beside it.
    fn parts(&self) -> (Vec<[u8; 4]>, Vec<[u8; 4]>) {
        let [width, height] = self.place.extent();
        self.place.parts(&host::values(&self.picture, (width * height) as usize))
    }

    pub fn destroy(mut self, device: &mut TestDevice) {
        let buffers = [&mut self.rows, &mut self.ids, &mut self.picture];
        host::destroy(device, buffers, [&mut self.target, &mut self.backdrop]);
    }
}

/// Ids that are not rows.
fn ids(count: usize) -> Vec<u32> {
    (0..count as u32).map(|i| 5 * i + 2).collect()
}

fn effect(size: [u32; 2], settings: Settings) -> Desc {
    Desc { target_format: FORMAT, layers: false, ..Case::new("", size, 80, settings, scenes::camera(0.0)).desc }
}

fn settings() -> Settings {
    Settings { bins: 8, repetitions: 4, ..crate::cases::settings() }
}

pub fn make(device: &mut TestDevice, desc: Desc) -> Flame {
    let (host, kernels, allocator) = device.making();
    // SAFETY: the handles are the device's own, and the device has what is required.
    unsafe { Flame::new(&host, kernels, allocator, desc) }.expect("an effect")
}

fn destroy(device: &mut TestDevice, mut flame: Flame) {
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    unsafe { flame.destroy(&host, allocator) };
}

/// Renders a sequence with so many frames on their way; the pictures. Recording allocates nothing after two frames.
fn sequence(device: &mut TestDevice, desc: &Desc, in_flight: usize, frames: u32) -> Vec<Vec<[u8; 4]>> {
    let mut flame = make(device, desc.clone());
    let mut slots: Vec<Slot> = (0..in_flight).map(|_| Slot::new(device, desc.size, 80)).collect();
    let record = |host: &Host, commands, slot: &mut Slot, i: u32| {
        // Fewer particles, none, and every other frame those of the frame before.
        let particles = embers([60, 80, 0, 30][i as usize / 2 % 4], 7);
        let frame = slot.frame(&particles, i);
        let backdrop = slot.image(&slot.backdrop, CLEARED, COPIED_FROM);
        let background = [Background::Keep, Background::Clear(SKY), Background::Copy(backdrop)][i as usize % 3];
        let given = frame.particles.filter(|_| i.is_multiple_of(2));
        let frame = Frame { background, particles: given, ..frame };
        // SAFETY: frames are submitted in order to one queue; this slot's last frame has been waited for.
        let allocations = unsafe {
            slot.draw(host, commands);
            let before = allocated();
            flame.record(host, commands, &frame, &mut Timing::None).expect("a frame");
            let allocations = allocated() - before;
            slot.show(host, commands);
            allocations
        };
        assert!(i < 2 || allocations == 0, "frame {i}: recording allocated {allocations} times");
    };
    let pictures = host::in_flight(device, &mut slots, frames, record, Slot::pixels);
    slots.into_iter().for_each(|slot| slot.destroy(device));
    destroy(device, flame);
    pictures
}

/// Particles of every other frame are those before it: a slot that is written while the frame before reads it would show.
#[test]
fn frames_in_flight_are_those_that_are_waited_for() {
    for mode in [celfx::flame::settings::Mode::Stochastic, celfx::flame::settings::Mode::Expected] {
        let Some(mut device) = device() else { return };
        let desc = effect([48, 36], Settings { mode, ..settings() });
        let waited = sequence(&mut device, &desc, 1, 12);
        assert_eq!(sequence(&mut device, &desc, 2, 12), waited, "{mode:?}");
        let sky = [124, 188, 243, 255];
        for (i, picture) in waited.iter().enumerate() {
            let over = picture.iter().filter(|c| **c != sky).count();
            let fire = if [4, 5].contains(&i) { 0..1 } else { 100..48 * 36 };
            assert!(fire.contains(&over), "{mode:?}, frame {i}: {over} pixels of fire");
        }
        assert!(waited[0] != waited[1] && waited[0] != waited[2], "frames that are all the same show nothing");
    }
}

/// As when a swapchain is out of date: recorded and never submitted. What comes after is as if it had not been.
#[test]
fn a_dropped_frame_leaves_no_trace() {
    let Some(mut device) = device() else { return };
    for mode in [celfx::flame::settings::Mode::Stochastic, celfx::flame::settings::Mode::Expected] {
        let mut flame = make(&mut device, effect([48, 36], Settings { mode, ..settings() }));
        let (dropped, shown) = (ball(80, 3), ball(60, 7));
        let mut pictures = Vec::new();
        for _ in 0..2 {
            let mut slot = Slot::new(&mut device, [48, 36], 80);
            let frame = slot.frame(&dropped, 1);
            let commands = device.begin().expect("commands");
            // SAFETY: they are not submitted.
            unsafe { flame.record(&device.host(), commands.raw(), &frame, &mut Timing::None) }.expect("a frame");
            device.discard(commands);
            flame.frame_dropped();
            let next = Frame { particles: None, ..frame };
            // SAFETY: it is refused.
            let refused = unsafe { flame.record(&device.host(), vk::CommandBuffer::null(), &next, &mut Timing::None) };
            assert!(refused.expect_err("particles that never came").to_string().starts_with("particles"));
            slot.destroy(&mut device);
            pictures.push(one_frame(&mut device, &mut flame, &shown));
        }
        destroy(&mut device, flame);
        let mut fresh = make(&mut device, effect([48, 36], Settings { mode, ..settings() }));
        let expected = one_frame(&mut device, &mut fresh, &shown);
        assert!(pictures.iter().all(|picture| *picture == expected), "{mode:?}");
        destroy(&mut device, fresh);
    }
}

/// One frame over the host's sky, by an effect that exists.
fn one_frame(device: &mut TestDevice, flame: &mut Flame, particles: &Particles) -> Vec<[u8; 4]> {
    numbered(device, flame, particles, 0)
}

fn numbered(device: &mut TestDevice, flame: &mut Flame, particles: &Particles, number: u32) -> Vec<[u8; 4]> {
    let mut slot = Slot::new(device, flame.desc().size, 80);
    let frame = slot.frame(particles, number);
    host::run(device, |host, commands| {
        // SAFETY: everything is the test's own and waited for.
        unsafe {
            slot.draw(host, commands);
            flame.record(host, commands, &frame, &mut Timing::None).expect("a frame");
            slot.show(host, commands);
        }
    });
    let pixels = slot.pixels();
    slot.destroy(device);
    pixels
}

/// Linear light as an sRGB number, 0 to 255.
fn srgb(v: f32) -> f32 {
    255.0 * if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn a_hosts_picture_is_the_effect_over_its_sky() {
    let mut case = plain();
    case.particles.id = Some(ids(case.particles.position.len()));
    let Some(mut rig) = case.render() else { return };
    let effect = rig.effect();
    let Some(mut device) = device() else { return };
    let mut flame = make(&mut device, Desc { target_format: FORMAT, layers: false, ..case.desc.clone() });
    let picture = one_frame(&mut device, &mut flame, &case.particles);
    destroy(&mut device, flame);
    for (i, (found, own)) in picture.iter().zip(&effect).enumerate() {
        for c in 0..3 {
            let expected = srgb((own[c] + (1.0 - own[3]) * SKY[c]).min(1.0));
            // The sky is rounded to half a 255th of sRGB before the blending, which is as much of a darker sum as its
            // slope there is steeper; and the sum to another half.
            let apart = (f32::from(found[c]) - expected).abs();
            assert!(apart < 1.5, "pixel {i}: {found:?}, {expected}");
        }
        assert_eq!(found[3], 255, "pixel {i}");
    }
}

#[test]
fn resizing_is_like_making_anew() {
    let Some(mut device) = device() else { return };
    let particles = embers(80, 7);
    let mut flame = make(&mut device, effect([48, 36], settings()));
    for size in [[33, 70], [90, 10], [1, 1]] {
        one_frame(&mut device, &mut flame, &particles);
        let (host, kernels, allocator) = device.making();
        // SAFETY: every frame has been waited for.
        unsafe { flame.resize(&host, kernels, allocator, size).expect("another size").destroy(&host, allocator) };
        let resized = one_frame(&mut device, &mut flame, &particles);
        let mut fresh = make(&mut device, effect(size, settings()));
        assert!(resized == one_frame(&mut device, &mut fresh, &particles), "{size:?}");
        destroy(&mut device, fresh);
    }
    // A size that cannot be leaves the effect as it was, with its frame.
    let last = one_frame(&mut device, &mut flame, &particles);
    let (host, kernels, allocator) = device.making();
    // SAFETY: every frame has been waited for.
    let refused = unsafe { flame.resize(&host, kernels, allocator, [1 << 20, 4]) };
    assert!(matches!(refused, Err(Error::Limit { .. })), "{refused:?}");
    assert!(one_frame(&mut device, &mut flame, &particles) == last);
    destroy(&mut device, flame);
}

/// Sizes and settings change from frame to frame while frames are on their way. Particles came once.
#[test]
fn a_sequence_goes_on_through_changes() {
    use celfx::flame::settings::{Mode, Shape};
    let Some(mut device) = device() else { return };
    let particles = ball(80, 7);
    let bright = Settings { adaptation: 0.5, ..settings() };
    let cubes = Settings { shape: Shape::Cube, mode: Mode::Expected, ..settings() };
    let few = Settings { mode: Mode::Expected, variants: 3, hottest: 2500.0, ..settings() };
    let looks =
        [([48, 36], settings()), ([48, 36], bright), ([33, 70], cubes), ([48, 36], few), ([48, 36], settings())];
    let looks = looks.map(|(size, settings)| effect(size, settings));
    let mut flame = make(&mut device, looks[0].clone());
    let (mut on_their_way, mut slots, mut replaced) = (Vec::new(), Vec::new(), Vec::new());
    for (number, desc) in (0..).zip(&looks) {
        let (host, kernels, allocator) = device.making();
        // SAFETY: what is replaced is kept until all frames have been waited for.
        replaced.push(unsafe { flame.change(&host, kernels, allocator, desc.clone()) }.expect("a change"));
        let mut slot = Slot::new(&mut device, desc.size, 80);
        let frame = slot.frame(&particles, number);
        let frame = Frame { particles: frame.particles.filter(|_| number == 0), ..frame };
        let commands = device.begin().expect("commands");
        // SAFETY: everything is the test's own, and frames are submitted in order.
        unsafe {
            slot.draw(&device.host(), commands.raw());
            flame.record(&device.host(), commands.raw(), &frame, &mut Timing::None).expect("a frame");
            slot.show(&device.host(), commands.raw());
        }
        on_their_way.push(device.start(commands, "frame").expect("it starts"));
        slots.push(slot);
    }
    on_their_way.into_iter().for_each(|submission| device.wait(submission).expect("it ends"));
    let (host, allocator) = device.parts();
    // SAFETY: every frame has been waited for.
    replaced.into_iter().for_each(|retired| unsafe { retired.destroy(&host, allocator) });
    for ((number, desc), slot) in (0..).zip(&looks).zip(slots) {
        let mut fresh = make(&mut device, desc.clone());
        assert!(slot.pixels() == numbered(&mut device, &mut fresh, &particles, number), "frame {number}");
        destroy(&mut device, fresh);
        slot.destroy(&mut device);
    }
    destroy(&mut device, flame);
}

/// What the allocator has given out, and to whom it was given under the effect's name.
fn given_out(device: &mut TestDevice) -> (u64, u64, u64) {
    let report = device.parts().1.generate_report();
    let own = report.allocations.iter().filter(|allocation| allocation.name.starts_with("flame "));
    let (count, bytes) = own.fold((0, 0), |(count, bytes), allocation| (count + 1, bytes + allocation.size));
    (report.total_allocated_bytes, count, bytes)
}

#[test]
fn memory_is_what_is_allocated_and_all_of_it_is_given_back() {
    use celfx::flame::settings::{Method, Mode};
    let Some(mut device) = device() else { return };
    let large = Settings { bins: 100, repetitions: 100, ..settings() };
    for (settings, layers) in [
        (settings(), false),
        (large, true),
        (Settings { mode: Mode::Stochastic, ..settings() }, true),
        (Settings { mode: Mode::Stochastic, method: Method::Raster, ..settings() }, false),
    ] {
        let (before, ..) = given_out(&mut device);
        let desc = Desc { layers, ..effect([150, 110], settings) };
        let memory = Flame::memory(&desc, &device.traits()).expect("it fits").total();
        let mut flame = make(&mut device, desc);
        let (_, count, bytes) = given_out(&mut device);
        assert!(count > 5, "{count} allocations");
        // What a device rounds up to: at most 4 KiB on lavapipe, for each; less for what lies in scratch memory.
        assert!(bytes >= memory && bytes <= memory + 4096 * count, "{bytes} bytes given out, {memory} said");
        one_frame(&mut device, &mut flame, &embers(80, 7));
        destroy(&mut device, flame);
        assert_eq!(given_out(&mut device).0, before, "bytes are left behind");
    }
}

/// Target, backdrop and depth are parts of larger images: the same, and what lies beside stays.
#[test]
fn a_part_of_larger_images_is_as_a_whole_one() {
    let Some(mut device) = device() else { return };
    let particles = ball(80, 7);
    let depth_format = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
    let scene = Some(SceneFormat::Image(depth_format));
    let desc = Desc { scene, ..effect([48, 36], Settings { light: 0.5, ..settings() }) };
    let mut flame = make(&mut device, desc.clone());
    let mut wholes = Vec::new();
    for corner in [[0, 0], [9, 2]] {
        let place = Place { size: desc.size, corner };
        // Depth may lie elsewhere than the target: it is copied.
        let of_depth = Place { corner: [2 * corner[1], corner[0]], ..place };
        let mut slot = Slot::in_larger_images(&mut device, place, 80);
        let mut depth = host::image(&mut device, of_depth.extent(), depth_format.format);
        // A wall in the right half, through the middle of the fire.
        let view = scenes::camera(25.0).view(desc.size);
        let terms = Projection::of_valid(&view, desc.size).depth_terms;
        let wall = (terms[0] + terms[1] / scenes::camera(25.0).eye.length()) as f32;
        let walls: Vec<f32> = (0..48 * 36).map(|i| if i % 48 < 24 { 0.0 } else { wall }).collect();
        let walls = of_depth.around(&walls, 1.0);
        let mut words = host::source(&mut device, 4 * walls.len() as u64);
        host::fill(&mut words, &walls);
        for background in 0..3 {
            let frame = slot.frame(&particles, 0);
            let depth_image = of_depth.given(&depth, depth_format.format, CLEARED, COPIED_FROM);
            let backdrop = slot.image(&slot.backdrop, CLEARED, COPIED_FROM);
            let background =
                [Background::Keep, Background::Clear([0.1, 0.2, 0.3, 1.0]), Background::Copy(backdrop)][background];
            let frame = Frame { scene: Some(SceneDepth::Image(depth_image)), background, ..frame };
            host::run(&mut device, |host, commands| {
                // SAFETY: everything is the test's own and waited for.
                unsafe {
                    slot.draw(host, commands);
                    host::change(host, commands, (depth.handle, depth.aspect), DISCARDED, CLEARED);
                    let regions = [host::image_copy(depth.aspect, of_depth.extent())];
                    let (from, to) = (words.handle, depth.handle);
                    host.device.cmd_copy_buffer_to_image(commands, from, to, CLEARED.layout, &regions);
                    flame.record(host, commands, &frame, &mut Timing::None).expect("a frame");
                    slot.show(host, commands);
                }
            });
            let (picture, beside) = slot.parts();
            let sky = SKY.map(|c| (255.0 * if c == 1.0 { c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }).round() as u8);
            assert!(beside.iter().all(|pixel| *pixel == sky), "what lies beside has changed: {beside:?}");
            assert!(picture.iter().any(|pixel| *pixel != picture[0]), "no fire");
            wholes.push(picture);
        }
        slot.destroy(&mut device);
        host::destroy(&mut device, [&mut words], [&mut depth]);
    }
    destroy(&mut device, flame);
    let (whole, part) = wholes.split_at(3);
    assert!(whole == part, "to the bit");
}
