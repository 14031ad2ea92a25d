//! Motion vectors and reactive mask of the smoke, against finite differences in f64: where a sphere's point was in the frame before is known
//! from the spheres of both frames.

use ash::vk;
use celfx::host::{HostImage, TemporalImages};
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM, record_depth};
use celfx::low_level::smoke::layout;
use celfx::low_level::smoke::params::{DEAD, FULL_SIZE, Particle};
use celfx::offline::TARGET_FORMAT;
use celfx::smoke::reference::render;
use celfx::smoke::{DepthFormat, Desc, Frame, Sequence, Smoke};
use celfx::view::{Projection, View};
use glam::DVec3;

use crate::common::host::{self, DISCARDED, Place};
use crate::common::scenes::camera;
use crate::common::temporal::{FORMATS, HOSTS, Outputs, distance, place_at, vector};
use crate::common::{TestDevice, apart, device, views};
use crate::host::{SIZE, Slot, effect};

const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
/// What the host has in the mask.
const SHARE: f32 = 0.25;

/// The effect with both outputs, and what a host has for it.
struct Rig {
    device: TestDevice,
    smoke: Smoke,
    slot: Slot,
    target: Image,
    outputs: Outputs,
}

/// The spheres of a frame, and the ages of particles.
struct Moment {
    spheres: Vec<[f64; 4]>,
    ages: Vec<u32>,
}

impl Rig {
    fn new(desc: Desc, corner: [u32; 2]) -> Option<Rig> {
        let mut device = device()?;
        let place = Place { size: SIZE, corner };
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        let smoke = unsafe { Smoke::new(&host, kernels, allocator, desc) }.expect("an effect");
        let slot = Slot::new(&mut device, SIZE);
        let target = host::image(&mut device, place.extent(), TARGET_FORMAT);
        let outputs = Outputs::new(&mut device, place);
        Some(Rig { device, smoke, slot, target, outputs })
    }

    /// Frame `i` of a sequence, with both outputs.
    fn frame(&mut self, i: u32, view: View) -> Frame {
        let target = self.outputs.place.given(&self.target, TARGET_FORMAT, DISCARDED, COPIED_FROM);
        Frame { view, target: Some(target), temporal: self.outputs.given(), ..self.slot.frame(i) }
    }

    /// Renders it over a mask of [`SHARE`], after `first`.
    fn render(&mut self, frame: &Frame, first: impl FnOnce(&celfx::host::Host, vk::CommandBuffer)) {
        let Rig { device, smoke, outputs, .. } = self;
        host::run(device, |host, commands| {
            first(host, commands);
            // SAFETY: everything is the test's own and waited for.
            unsafe {
                outputs.clear(host, commands, SHARE);
                smoke.record(host, commands, frame, &mut Timing::None).expect("a frame");
            }
        });
    }

    fn picture(&mut self) -> Vec<[f32; 4]> {
        let place = self.outputs.place;
        place.parts(&host::read_image(&mut self.device, &self.target, place.extent())).0
    }

    fn moment(&mut self) -> Moment {
        let particles = self.smoke.desc().settings.particles as usize;
        let count = particles * (1 + self.smoke.desc().settings.fade as usize);
        let spheres: Vec<[f32; 4]> = host::read(&mut self.device, self.smoke.buffer(layout::SPHERES), count);
        let lives: Vec<Particle> = host::read(&mut self.device, self.smoke.buffer(layout::PARTICLES), particles);
        Moment {
            spheres: spheres.iter().map(|sphere| sphere.map(f64::from)).collect(),
            ages: lives.iter().map(|life| life.age).collect(),
        }
    }

    fn destroy(mut self) {
        self.slot.destroy(&mut self.device);
        self.outputs.destroy(&mut self.device);
        host::destroy(&mut self.device, [], [&mut self.target]);
        let (host, allocator) = self.device.parts();
        // SAFETY: every frame has been waited for.
        unsafe { self.smoke.destroy(&host, allocator) };
    }
}

fn centre(sphere: &[f64; 4]) -> DVec3 {
    DVec3::new(sphere[0], sphere[1], sphere[2])
}

/// Where each sphere of frame `i` was in the frame before: a particle's in its slot, unless it has been born since; a dying one's in its own
/// place, unless it has come there from its particle's slot.
fn centres_before(desc: &Desc, i: u32, before: &Moment, now: &Moment) -> Vec<DVec3> {
    let (particles, fade) = (desc.settings.particles as usize, desc.settings.fade.max(1) as usize);
    let of = |sphere: usize| match sphere {
        slot if slot < particles => match now.ages[slot] {
            age if age != DEAD && age & !FULL_SIZE == 0 => centre(&now.spheres[slot]),
            _ => centre(&before.spheres[slot]),
        },
        dying if dying / particles - 1 == i as usize % fade => centre(&before.spheres[dying % particles]),
        dying => centre(&before.spheres[dying]),
    };
    (0..now.spheres.len()).map(of).collect()
}

/// Compares a frame's vectors; how many there are, and how many of spheres that move on their own, are dying or new.
fn compare(rig: &mut Rig, name: &str, i: u32, views: [&View; 2], moments: [&Moment; 2]) -> [usize; 4] {
    let found = rig.outputs.found(&mut rig.device, SHARE);
    let depth: Vec<f32> = host::read(&mut rig.device, rig.smoke.buffer(layout::DEPTH), PIXELS);
    let shares: Vec<f32> = rig.picture().iter().map(|colour| colour[3]).collect();
    found.assert_where(&shares, SHARE);
    let centres = centres_before(rig.smoke.desc(), i, moments[0], moments[1]);
    let hits = render::raycast(views[1], SIZE, &moments[1].spheres);
    let particles = rig.smoke.desc().settings.particles as usize;
    let (mut counts, mut worst) = ([0; 4], 0.0_f64);
    for (pixel, hit) in hits.iter().enumerate() {
        // Where rounding decides what is seen, or how deep a silhouette is, another point is meant.
        let Some(hit) = hit.filter(|hit| apart(depth[pixel], hit.depth) <= 1e-5 * hit.depth) else { continue };
        let now = centre(&moments[1].spheres[hit.sphere]);
        let moved = now - centres[hit.sphere];
        let place = place_at(views[1], SIZE, pixel, hit.depth);
        let expected = vector(views, SIZE, place - moved, place);
        worst = worst.max(distance(found.motion[pixel], expected));
        counts[0] += 1;
        counts[1] += usize::from(moved.length() > 1e-3);
        counts[2] += usize::from(hit.sphere >= particles);
        counts[3] += usize::from(hit.sphere < particles && moved == DVec3::ZERO);
    }
    println!("{name}, frame {i}: {counts:?} vectors, off by at most {worst:.1e} pixels");
    // A pixel is some 0.04 m here. Centres that are rounded to 6e-8 m make 3e-6 pixels; depths that are off by 1e-5 of 4 m make as much of
    // how depth changes the vector: some pixels a metre.
    assert!(worst < 2e-4, "{name}, frame {i}: off by {worst} pixels");
    let seen = shares.iter().filter(|share| **share > 0.0).count();
    assert!(counts[0] * 100 > seen * 95, "{name}, frame {i}: {} of {seen} pixels were compared", counts[0]);
    counts
}

#[test]
fn vectors_are_finite_differences_through_any_projection() {
    let mut desc = Desc { temporal: FORMATS, ..effect() };
    desc.settings.lifetime = Some(4);
    let of = |i: u32| views::of(&camera(3.0 * f64::from(i)), SIZE, 4.0 + 0.1 * f64::from(i));
    let mut all = [0; 4];
    let names = of(0).into_iter().map(|(name, _)| name).enumerate();
    // What is born is small at first, unless nothing fades.
    let fade = desc.settings.fade;
    for ((which, name), fade) in names.map(|named| (named, fade)).chain([((0, "unfaded"), 0)]) {
        desc.settings.fade = fade;
        let Some(mut rig) = Rig::new(desc.clone(), [3, 6]) else { return };
        let mut before: Option<(View, Moment)> = None;
        for i in 0..4 {
            let view = views::jittered(of(i)[which].1, i as usize);
            let frame = rig.frame(i, view);
            rig.render(&frame, |_, _| {});
            let now = rig.moment();
            match &before {
                Some((view_before, moment)) => {
                    let counts = compare(&mut rig, name, i, [view_before, &view], [moment, &now]);
                    all = [0, 1, 2, 3].map(|k| all[k] + counts[k]);
                }
                None => {
                    let found = rig.outputs.found(&mut rig.device, SHARE);
                    let still = found.motion.iter().filter(|vector| **vector == [0.0; 2]).count();
                    let seen = rig.picture().iter().filter(|colour| colour[3] > 0.0).count();
                    assert!(still == seen && seen > 500, "{name}: a first frame has not moved: {still} of {seen}");
                }
            }
            before = Some((view, now));
        }
        rig.destroy();
    }
    assert!(all.iter().all(|count| *count > 300), "all kinds are seen: {all:?}");
}

/// The same moment again: nothing but the camera moves, and jitter is no motion.
#[test]
fn a_held_moment_moves_with_the_camera_alone() {
    let Some(mut rig) = Rig::new(Desc { temporal: FORMATS, ..effect() }, [0; 2]) else { return };
    let view = |degrees: f64, frame| views::jittered(camera(degrees).view(SIZE), frame);
    for i in 0..2 {
        let frame = rig.frame(i, view(0.0, 0));
        rig.render(&frame, |_, _| {});
    }
    let moment = rig.moment();
    for (degrees, number) in [([0.0, 0.0], 1), ([0.0, 5.0], 2), ([5.0, 5.0], 3)] {
        let frame = Frame { sequence: Sequence::Hold, volume: None, ..rig.frame(1, view(degrees[1], number)) };
        rig.render(&frame, |_, _| {});
        let found = rig.outputs.found(&mut rig.device, SHARE);
        let still = found.motion.iter().filter(|vector| **vector == [0.0; 2]).count();
        let seen = rig.picture().iter().filter(|colour| colour[3] > 0.0).count();
        if degrees[0] == degrees[1] {
            assert!(still == seen && seen > 500, "{still} of {seen} are exactly 0");
        } else {
            let views = [view(degrees[0], number - 1), view(degrees[1], number)];
            let hits = render::raycast(&views[1], SIZE, &moment.spheres);
            let mut worst = 0.0_f64;
            for (pixel, hit) in hits.iter().enumerate() {
                let Some(hit) = hit.filter(|_| found.motion[pixel] != HOSTS) else { continue };
                let place = place_at(&views[1], SIZE, pixel, hit.depth);
                let expected = vector([&views[0], &views[1]], SIZE, place, place);
                // Silhouettes are off by up to a root of rounding in depth.
                worst = worst.max(distance(found.motion[pixel], expected));
            }
            assert!(worst < 0.01 && still < 50, "off by {worst} pixels, {still} are still");
        }
    }
    rig.destroy();
}

/// What hides the smoke keeps its vectors, and outputs change no bit of the picture.
#[test]
fn outputs_are_where_the_smoke_is_seen_and_change_nothing() {
    let made = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
    let desc = Desc { depth: Some(made), ..effect() };
    let Some(mut plain) = Rig::new(desc.clone(), [0; 2]) else { return };
    let Some(mut rig) = Rig::new(Desc { temporal: FORMATS, ..desc }, [0; 2]) else { return };
    let mut wall = host::image(&mut rig.device, SIZE, made.format);
    let mut plain_wall = host::image(&mut plain.device, SIZE, made.format);
    let mut hidden = 0;
    for i in 0..3 {
        let view = camera(2.0 * f64::from(i)).view(SIZE);
        let stored = {
            let terms = Projection::of_valid(&view, SIZE).depth_terms;
            (terms[0] + terms[1] / 4.0) as f32
        };
        let with_wall = |image: &Image| host::host_image(image, SIZE, made.format, CLEARED, COPIED_FROM);
        let frame =
            Frame { depth: Some(with_wall(&plain_wall)), temporal: TemporalImages::default(), ..plain.frame(i, view) };
        let handle = plain_wall.handle;
        // SAFETY: the image is the test's own.
        plain.render(&frame, |host, commands| unsafe { record_depth(host, commands, handle, stored) });
        let frame = Frame { depth: Some(with_wall(&wall)), ..rig.frame(i, view) };
        let handle = wall.handle;
        // SAFETY: as there.
        rig.render(&frame, |host, commands| unsafe { record_depth(host, commands, handle, stored) });
        let picture = rig.picture();
        let bits = |picture: &[[f32; 4]]| picture.iter().map(|colour| colour.map(f32::to_bits)).collect::<Vec<_>>();
        assert!(bits(&picture) == bits(&plain.picture()), "frame {i}: the picture is another");
        let depths = [
            host::read_image::<u32>(&mut rig.device, &wall, SIZE),
            host::read_image(&mut plain.device, &plain_wall, SIZE),
        ];
        assert!(depths[0] == depths[1], "frame {i}: the depth is another");
        let shares: Vec<f32> = picture.iter().map(|colour| colour[3]).collect();
        rig.outputs.found(&mut rig.device, SHARE).assert_where(&shares, SHARE);
        let own: Vec<f32> = host::read(&mut rig.device, rig.smoke.buffer(layout::DEPTH), PIXELS);
        hidden += (0..PIXELS).filter(|pixel| own[*pixel].is_finite() && shares[*pixel] == 0.0).count();
    }
    assert!(hidden > 100, "{hidden} pixels of smoke are behind the wall");
    host::destroy(&mut rig.device, [], [&mut wall]);
    host::destroy(&mut plain.device, [], [&mut plain_wall]);
    rig.destroy();
    plain.destroy();
}

#[test]
fn outputs_that_do_not_fit_are_refused_by_name() {
    let Some(mut rig) = Rig::new(Desc { temporal: FORMATS, ..effect() }, [0; 2]) else { return };
    let good = rig.frame(0, camera(0.0).view(SIZE));
    let (images, target) = (good.temporal, good.target.expect("a target"));
    let motion = images.motion.expect("an image");
    let with_motion = |motion: HostImage| TemporalImages { motion: Some(motion), ..images };
    let cases = [
        (
            "temporal.motion: missing; the effect was made with temporal.motion = R32G32_SFLOAT",
            TemporalImages { motion: None, ..images },
        ),
        (
            "temporal.reactive: missing; the effect was made with temporal.reactive = R32_SFLOAT",
            TemporalImages { reactive: None, ..images },
        ),
        (
            "temporal.previous.jitter",
            TemporalImages { previous: Some(View { jitter: [99.0; 2], ..good.view }), ..images },
        ),
        ("temporal.motion: [79, 60] pixels", with_motion(HostImage { extent: [79, 60], ..motion })),
        ("temporal.motion: offset [0, 1]", with_motion(HostImage { offset: [0, 1], extent: [80, 61], ..motion })),
        ("temporal.motion: R16G16_SFLOAT", with_motion(HostImage { format: vk::Format::R16G16_SFLOAT, ..motion })),
        ("temporal.motion: state_in", with_motion(HostImage { state_in: DISCARDED, ..motion })),
        ("temporal.motion: it is the target's", with_motion(HostImage { image: target.image, ..motion })),
        (
            "temporal.reactive: it is the image",
            TemporalImages {
                reactive: images.reactive.map(|image| HostImage { image: motion.image, ..image }),
                ..images
            },
        ),
    ];
    for (expected, temporal) in cases {
        let said = rig.smoke.prepare(&Frame { temporal, ..good }).expect_err(expected).to_string();
        assert!(said.starts_with(expected), "{expected}: {said}");
    }
    // Nothing of it without a picture.
    for (expected, temporal) in [
        ("temporal.motion: given; a frame without a target", images),
        ("temporal.reactive: given", TemporalImages { motion: None, ..images }),
        ("temporal.previous: given", TemporalImages { previous: Some(good.view), ..TemporalImages::default() }),
    ] {
        let said = rig.smoke.prepare(&Frame { target: None, temporal, ..good }).expect_err(expected).to_string();
        assert!(said.starts_with(expected), "{expected}: {said}");
    }
    // What a second view was seen through before, only the host knows.
    for i in 0..2 {
        let frame = rig.frame(i, good.view);
        rig.render(&frame, |_, _| {});
    }
    let again = Frame { sequence: Sequence::Again, volume: None, ..rig.frame(1, camera(9.0).view(SIZE)) };
    let said = rig.smoke.prepare(&again).expect_err("no view before").to_string();
    assert!(said.starts_with("temporal.previous: missing; motion vectors of Sequence::Again"), "{said}");
    rig.destroy();
    let Some(mut plain) = Rig::new(effect(), [0; 2]) else { return };
    let temporal = TemporalImages { previous: Some(good.view), ..TemporalImages::default() };
    let frame = Frame { temporal, ..plain.frame(0, good.view) };
    let said = plain.smoke.prepare(&frame).expect_err("a view before").to_string();
    assert_eq!(said, "temporal.previous: given; the effect was made without temporal.motion");
    plain.destroy();
}

/// Two eyes of one effect have the vectors of two effects with one view each, bit for bit, in frames that move and in a pause; whatever
/// scratch memory held between them.
#[test]
fn two_views_have_the_vectors_of_two_effects() {
    let mut desc = Desc { temporal: FORMATS, ..effect() };
    desc.settings.lifetime = Some(4);
    let rigs = [(); 3].map(|()| Rig::new(desc.clone(), [3, 6]));
    let [Some(mut both), Some(mut left), Some(mut right)] = rigs else { return };
    let eye = |i: u32, side: f64| views::jittered(camera(3.0 * f64::from(i) + side).view(SIZE), i as usize);
    let mut before: Option<[View; 2]> = None;
    let sequences = [Sequence::Restart, Sequence::Advance, Sequence::Advance, Sequence::Advance, Sequence::Hold];
    for (i, sequence) in (0..).zip(sequences).chain([(5, Sequence::Hold), (6, Sequence::Advance)]) {
        let views = [eye(i, 0.0), eye(i, 14.0)];
        let singles = [(&mut left, views[0]), (&mut right, views[1])].map(|(rig, view)| {
            let frame = Frame { sequence, ..rig.frame(i, view) };
            rig.render(&frame, |_, _| {});
            rig.outputs.found(&mut rig.device, SHARE)
        });
        for (side, single) in singles.iter().enumerate() {
            let frame = both.frame(i, views[side]);
            let previous = before.map(|views| views[side]);
            let temporal = TemporalImages { previous, ..frame.temporal };
            let frame = match side {
                0 => Frame { sequence, temporal, ..frame },
                _ => Frame { sequence: Sequence::Again, volume: None, temporal, ..frame },
            };
            host::poison(&mut both.device, both.smoke.scratch(), host::POISONS[0]);
            both.render(&frame, |_, _| {});
            let found = both.outputs.found(&mut both.device, SHARE);
            assert!(found.bits() == single.bits(), "frame {i}, {sequence:?}, view {side}");
        }
        let [_, single] = singles;
        let seen = single.motion.iter().filter(|vector| **vector != HOSTS && **vector != [0.0; 2]).count();
        assert!(i == 0 || seen > 500, "frame {i}: {seen} vectors");
        before = Some(views);
    }
    // A frame that only moves on, and then each eye: the same again.
    let views = [eye(7, 0.0), eye(7, 14.0)];
    let unseen = Frame { target: None, temporal: TemporalImages::default(), ..both.frame(7, views[0]) };
    both.render(&unseen, |_, _| {});
    for (side, rig) in [&mut left, &mut right].into_iter().enumerate() {
        let frame = rig.frame(7, views[side]);
        rig.render(&frame, |_, _| {});
        let single = rig.outputs.found(&mut rig.device, SHARE);
        let frame = both.frame(7, views[side]);
        let temporal = TemporalImages { previous: before.map(|views| views[side]), ..frame.temporal };
        let frame = Frame { sequence: Sequence::Again, volume: None, temporal, ..frame };
        both.render(&frame, |_, _| {});
        assert!(
            both.outputs.found(&mut both.device, SHARE).bits() == single.bits(),
            "view {side} after a frame unseen"
        );
    }
    [both, left, right].into_iter().for_each(Rig::destroy);
}

/// A resize resets no vector: they are in pixels of the new picture, as if the one before had had its size.
#[test]
fn vectors_go_on_over_a_resize() {
    let small = [SIZE[0] / 2, SIZE[1] / 2];
    let Some(mut rig) = Rig::new(Desc { temporal: FORMATS, size: small, ..effect() }, [0; 2]) else { return };
    let view = |degrees: f64| camera(degrees).view(SIZE);
    for i in 0..2 {
        let frame = rig.frame(i, view(0.0));
        rig.render(&frame, |_, _| {});
    }
    let moment = rig.moment();
    let (host, kernels, allocator) = rig.device.making();
    // SAFETY: the device's own handles; every frame has been waited for.
    unsafe { rig.smoke.resize(&host, kernels, allocator, SIZE).expect("a size").destroy(&host, allocator) };
    let views = [view(0.0), view(5.0)];
    let frame = Frame { sequence: Sequence::Hold, volume: None, ..rig.frame(1, views[1]) };
    rig.render(&frame, |_, _| {});
    let found = rig.outputs.found(&mut rig.device, SHARE);
    let (mut worst, mut count) = (0.0_f64, 0);
    for (pixel, hit) in render::raycast(&views[1], SIZE, &moment.spheres).iter().enumerate() {
        let Some(hit) = hit.filter(|_| found.motion[pixel] != HOSTS) else { continue };
        let place = place_at(&views[1], SIZE, pixel, hit.depth);
        worst = worst.max(distance(found.motion[pixel], vector([&views[0], &views[1]], SIZE, place, place)));
        count += usize::from(found.motion[pixel] != [0.0; 2]);
    }
    // As in a held moment.
    assert!(worst < 0.01 && count > 500, "{count} vectors, off by {worst}");
    rig.destroy();
}

/// What covers more than half of a pixel before the smoke has its own vector there.
#[test]
fn what_covers_most_of_a_pixel_keeps_its_vector() {
    let made = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };
    let desc = Desc { depth: Some(made), edges: true, temporal: FORMATS, ..effect() };
    let Some(mut rig) = Rig::new(desc, [0; 2]) else { return };
    let mut far = host::image(&mut rig.device, SIZE, made.format);
    let mut edges = host::source(&mut rig.device, 16 * PIXELS as u64);
    // Shares as halves of 0.25, 0.5 and 0.75, before the smoke or behind it.
    let kinds = [(0x3400, 0.5), (0x3800, 0.5), (0x3a00, 0.5), (0x3a00, 100.0_f32)];
    let rows: Vec<[u32; 4]> = (0..PIXELS)
        .map(|pixel| {
            let (share, depth) = kinds[pixel % 4];
            [0, share << 16, depth.to_bits(), 0]
        })
        .collect();
    let given = host::fill(&mut edges, &rows);
    let depth = host::host_image(&far, SIZE, made.format, CLEARED, COPIED_FROM);
    let frame = Frame { depth: Some(depth), edges: Some(given), ..rig.frame(0, camera(0.0).view(SIZE)) };
    let handle = far.handle;
    // SAFETY: the image is the test's own.
    rig.render(&frame, |host, commands| unsafe { record_depth(host, commands, handle, 0.0) });
    let found = rig.outputs.found(&mut rig.device, SHARE);
    let own: Vec<f32> = host::read(&mut rig.device, rig.smoke.buffer(layout::DEPTH), PIXELS);
    let mut counts = [0; 4];
    for pixel in (0..PIXELS).filter(|pixel| own[*pixel].is_finite()) {
        counts[pixel % 4] += 1;
        assert_eq!(found.motion[pixel] != HOSTS, pixel % 4 != 2, "pixel {pixel}");
    }
    assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
    host::destroy(&mut rig.device, [&mut edges], [&mut far]);
    rig.destroy();
}
