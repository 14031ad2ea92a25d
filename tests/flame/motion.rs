//! Motion vectors and reactive mask of the fire, against finite differences in f64.

use celfx::data::Particles;
use celfx::flame::reference::embers::Ember;
use celfx::flame::settings::{Embers, Method, Mode};
use celfx::flame::{Background, Desc, Flame, Frame, ParticleInput, Settings};
use celfx::host::{HostBuffer, TemporalFormats, TemporalImages};
use celfx::low_level::flame::layout;
use celfx::low_level::gpu::buffer::Buffer;
use celfx::low_level::gpu::image::Image;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::COPIED_FROM;
use celfx::low_level::shaders::common::constants::LEAST_SHARE;
use celfx::offline::TARGET_FORMAT;
use celfx::view::{Projection, View};
use glam::DVec3;

use crate::common::flame::{ball, desc, particles};
use crate::common::host::{self, DISCARDED, Place};
use crate::common::scenes::{camera, random};
use crate::common::temporal::{FORMATS, Found, HOSTS, Outputs, distance, place_at, vector};
use crate::common::{TestDevice, device, views};

const SIZE: [u32; 2] = [96, 72];
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;
/// What the host has in the mask.
const SHARE: f32 = 0.25;

/// The effect with both outputs, and what a host has for it.
struct Rig {
    device: TestDevice,
    flame: Flame,
    rows: Buffer,
    previous: Buffer,
    target: Image,
    outputs: Outputs,
    /// Pixels that have shown a little of the fire.
    faint: usize,
}

fn settings(mode: Mode) -> Settings {
    let (spread, size) = (Some(0.15), Some(0.25));
    Settings { mode, repetitions: 20, count: 6.0, bins: 8, spread, size, ..Settings::paper() }
}

impl Rig {
    fn new(desc: Desc, corner: [u32; 2]) -> Option<Rig> {
        let mut device = device()?;
        let (place, rows) = (Place { size: SIZE, corner }, 16 * u64::from(desc.particles));
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        let flame = unsafe { Flame::new(&host, kernels, allocator, desc) }.expect("an effect");
        let [rows, previous] = [rows; 2].map(|bytes| host::source(&mut device, bytes));
        let target = host::image(&mut device, place.extent(), TARGET_FORMAT);
        let outputs = Outputs::new(&mut device, place);
        Some(Rig { device, flame, rows, previous, target, outputs, faint: 0 })
    }

    /// A frame of these particles, which were elsewhere in the frame before.
    fn frame(&mut self, view: View, given: &Particles, previous: Option<&[[f32; 3]]>) -> Frame {
        let rows: Vec<[f32; 4]> =
            given.position.iter().zip(&given.temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]).collect();
        let previous = previous.map(|places| {
            let rows: Vec<[f32; 4]> = places.iter().map(|[x, y, z]| [*x, *y, *z, f32::NAN]).collect();
            host::fill(&mut self.previous, &rows)
        });
        let input = ParticleInput {
            count: rows.len() as u32,
            hottest: f32::INFINITY,
            position_temperature: host::fill(&mut self.rows, &rows),
            ids: None,
            previous,
            velocity: None,
        };
        let target = self.outputs.place.given(&self.target, TARGET_FORMAT, DISCARDED, COPIED_FROM);
        let background = Background::Clear([0.0; 4]);
        let temporal = match self.flame.desc().temporal.motion {
            Some(_) => self.outputs.given(),
            None => TemporalImages::default(),
        };
        Frame { background, temporal, ..Frame::new(view, input, target) }
    }

    /// Records it over a mask of [`SHARE`].
    fn record(&mut self, frame: &Frame) {
        let Rig { device, flame, outputs, .. } = self;
        host::run(device, |host, commands| {
            // SAFETY: everything is the test's own and waited for.
            unsafe {
                outputs.clear(host, commands, SHARE);
                flame.record(host, commands, frame, &mut Timing::None).expect("a frame");
            }
        });
    }

    /// Renders it, and checks where its outputs are.
    fn render(&mut self, frame: &Frame) -> Found {
        self.record(frame);
        if self.flame.desc().temporal.motion.is_none() {
            return Found { motion: Vec::new(), reactive: Vec::new() };
        }
        let found = self.outputs.found(&mut self.device, SHARE);
        let shares: Vec<f32> = self.picture().iter().map(|colour| colour[3]).collect();
        found.assert_where(&shares, SHARE);
        self.faint += shares.iter().filter(|share| (0.0..LEAST_SHARE).contains(*share) && **share > 0.0).count();
        found
    }

    fn picture(&mut self) -> Vec<[f32; 4]> {
        let place = self.outputs.place;
        place.parts(&host::read_image(&mut self.device, &self.target, place.extent())).0
    }

    /// Mean view depth of the fire in each pixel.
    fn nearest(&mut self) -> Vec<f32> {
        host::read(&mut self.device, self.flame.buffer(layout::NEAREST), PIXELS)
    }

    fn destroy(mut self) {
        self.outputs.destroy(&mut self.device);
        host::destroy(&mut self.device, [&mut self.rows, &mut self.previous], [&mut self.target]);
        let (host, allocator) = self.device.parts();
        // SAFETY: every frame has been waited for.
        unsafe { self.flame.destroy(&host, allocator) };
    }
}

fn moved_by(given: &Particles, way: DVec3) -> Vec<[f32; 3]> {
    given.position.iter().map(|place| (DVec3::from(place.map(f64::from)) - way).as_vec3().to_array()).collect()
}

/// Largest distance of a frame's vectors from those of places that have all moved by `way(place)`; how many there are.
fn worst(rig: &mut Rig, found: &Found, views: [&View; 2], way: impl Fn(DVec3) -> DVec3) -> (f64, usize) {
    let depth = rig.nearest();
    let seen = (0..PIXELS).filter(|pixel| found.motion[*pixel] != HOSTS);
    let of = |pixel: usize| {
        let place = place_at(views[1], SIZE, pixel, depth[pixel].into());
        distance(found.motion[pixel], vector(views, SIZE, place - way(place), place))
    };
    seen.fold((0.0, 0), |(worst, count), pixel| (f64::max(worst, of(pixel)), count + 1))
}

/// Whatever the weights: if all particles move alike, so does what they show.
#[test]
fn a_fire_that_moves_as_one_has_the_finite_difference_through_any_projection() {
    let raster = Settings { method: Method::Raster, ..settings(Mode::Stochastic) };
    for (name, settings) in
        [("tiles", settings(Mode::Stochastic)), ("raster", raster), ("expected", settings(Mode::Expected))]
    {
        let made = Desc { temporal: FORMATS, layers: name == "tiles", ..desc(SIZE, 60, settings) };
        let of = |i: u32| views::of(&camera(3.0 * f64::from(i)), SIZE, 4.0 + 0.1 * f64::from(i));
        let (way, given) = (DVec3::new(0.05, -0.11, 0.2), ball(60, 1));
        let Some(mut rig) = Rig::new(made, [3, 6]) else { return };
        for which in (0..of(0).len()).step_by(if name == "tiles" { 1 } else { 4 }) {
            let view = |i: u32| views::jittered(of(i)[which].1, i as usize);
            let frame = rig.frame(view(0), &given, None);
            rig.render(&frame);
            let frame = rig.frame(view(1), &given, Some(&moved_by(&given, way)));
            let found = rig.render(&frame);
            let (off, count) = worst(&mut rig, &found, [&view(0), &view(1)], |_| way);
            println!("{name}, {}: {count} vectors, off by at most {off:.1e} pixels", of(0)[which].0);
            // A pixel is some 0.03 m; places are rounded to 1e-7 m and depths to 3e-7 m, and the means of as many particles to some of that.
            assert!(off < 1e-4 && count > 500, "{name}, {}: {count} vectors, off by {off}", of(0)[which].0);
        }
        assert!(rig.faint > 50, "{name}: {} pixels show a little fire, and have no vector", rig.faint);
        rig.destroy();
    }
}

/// The mean of particles that are seen together, as the specification weighs them; others do not count.
#[test]
fn displacements_are_the_weighted_mean_at_the_place_that_is_seen() {
    for mode in [Mode::Stochastic, Mode::Expected] {
        let settings = settings(mode);
        let (spread, half_side) = (0.15, 0.125);
        let rows: Vec<[f32; 4]> = (0..5)
            .map(|i| {
                let at = |axis| 0.12 * (random(9, i, axis) - 0.5);
                [at(0) - 0.5, at(1), 2.0 * at(2), 1200.0 + 400.0 * i as f32]
            })
            .chain([[0.9, 0.0, 0.0, 2000.0]])
            .collect();
        let given = particles(&rows);
        let ways: Vec<DVec3> =
            (0..6).map(|i| DVec3::from([0, 1, 2].map(|axis| f64::from(random(4, i, axis)) - 0.5))).collect();
        let previous: Vec<[f32; 3]> =
            (0..6).map(|i| (DVec3::from(given.position[i].map(f64::from)) - ways[i]).as_vec3().to_array()).collect();
        let Some(mut rig) = Rig::new(Desc { temporal: FORMATS, ..desc(SIZE, 6, settings.clone()) }, [0; 2]) else {
            return;
        };
        let view = camera(0.0).view(SIZE);
        let frame = rig.frame(view, &given, Some(&previous));
        let found = rig.render(&frame);
        let depth = rig.nearest();
        let projection = Projection::of_valid(&view, SIZE);
        let centres: Vec<DVec3> = given.position.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        let reach = spread + half_side;
        let (mut off, mut counts) = (0.0_f64, [0; 2]);
        for pixel in (0..PIXELS).filter(|pixel| found.motion[*pixel] != HOSTS) {
            let place = place_at(&view, SIZE, pixel, depth[pixel].into());
            let group = if place.x < 0.2 { 0..5 } else { 5..6 };
            // Sprites of all of them reach the pixel: in the picture, where a metre at depth 4 is a pixel's share.
            let pixel_of = |place: DVec3| projection.pixel_of(projection.to_view(place));
            let apart =
                |i: usize| (pixel_of(centres[i]) - pixel_of(place)).abs().max_element() / projection.focal.y * 4.0;
            if group.clone().any(|i| apart(i) > 0.8 * reach) {
                continue;
            }
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for i in group.clone() {
                let falloff = 1.0 + (place - centres[i]).length_squared() / (reach * reach);
                let count = f64::from(settings.count * given.temperature[i] / settings.hottest);
                sum += count / (falloff * falloff) * ways[i];
                weights += count / (falloff * falloff);
            }
            let expected = vector([&view, &view], SIZE, place - sum / weights, place);
            off = off.max(distance(found.motion[pixel], expected));
            counts[usize::from(group.start == 5)] += 1;
        }
        println!("{mode:?}: {counts:?} vectors, off by at most {off:.1e} pixels");
        // Weights are rounded to 1e-6 of themselves, and vectors are 10 pixels long.
        assert!(off < 1e-4 && counts[0] > 50 && counts[1] > 30, "{mode:?}: {counts:?}, off by {off}");
        rig.destroy();
    }
}

/// A first frame, particles that are where they were, jitter: nothing has moved. And what is not finite has not.
#[test]
fn what_rests_has_exactly_no_motion() {
    let (given, made) = (ball(60, 1), Desc { temporal: FORMATS, ..desc(SIZE, 60, settings(Mode::Stochastic)) });
    let Some(mut rig) = Rig::new(made, [0; 2]) else { return };
    let view = |frame| views::jittered(camera(10.0).view(SIZE), frame);
    let unknown = vec![[f32::NAN, 0.0, f32::INFINITY]; 60];
    let moved = moved_by(&given, DVec3::X);
    let frames = [(0, None), (1, Some(&given.position[..])), (2, Some(&unknown[..])), (3, None)];
    for (number, previous) in frames.into_iter().chain([(3, Some(&moved[..]))]) {
        let frame = rig.frame(view(number), &given, previous);
        let found = rig.render(&frame);
        let seen = found.motion.iter().filter(|vector| **vector != HOSTS).count();
        let still = found.motion.iter().filter(|vector| **vector == [0.0; 2]).count();
        let expected = if previous == Some(&moved[..]) { 0 } else { seen };
        assert!(seen > 500 && still == expected, "frame {number}: {still} of {seen} rest");
    }
    // Particles that are not given anew have not moved since.
    let frame = Frame { particles: None, ..rig.frame(view(4), &given, None) };
    let found = rig.render(&frame);
    assert!(found.motion.iter().all(|vector| *vector == HOSTS || *vector == [0.0; 2]));
    // A dropped frame is followed by a first one, which other views say nothing of.
    rig.flame.frame_dropped();
    let frame = rig.frame(camera(50.0).view(SIZE), &given, None);
    let found = rig.render(&frame);
    assert!(found.motion.iter().all(|vector| *vector == HOSTS || *vector == [0.0; 2]));
    rig.destroy();
}

/// Two eyes of one effect have the vectors of two effects with one view each, bit for bit.
#[test]
fn two_views_have_the_vectors_of_two_effects() {
    for mode in [Mode::Stochastic, Mode::Expected] {
        let (given, made) = (ball(60, 1), Desc { temporal: FORMATS, ..desc(SIZE, 60, settings(mode)) });
        let rigs = [(); 3].map(|()| Rig::new(made.clone(), [3, 6]));
        let [Some(mut both), Some(mut left), Some(mut right)] = rigs else { return };
        let eye = |i: u32, side: f64| views::jittered(camera(3.0 * f64::from(i) + side).view(SIZE), i as usize);
        let mut before: Option<[View; 2]> = None;
        for i in 0..4 {
            let moved = moved_by(&given, DVec3::new(0.02, -0.11, 0.05) * f64::from(i));
            let previous = (i > 0 && i < 3).then_some(&moved[..]);
            for (side, rig) in [&mut left, &mut right].into_iter().enumerate() {
                let view = eye(i, 14.0 * side as f64);
                let frame = rig.frame(view, &given, previous);
                let single = rig.render(&frame);
                let frame = both.frame(view, &given, previous);
                let temporal = TemporalImages { previous: before.map(|views| views[side]), ..frame.temporal };
                let found = both.render(&Frame { temporal, ..frame });
                // A first frame has no view before, and the second eye's is not the first's.
                if i > 0 {
                    assert!(found.bits() == single.bits(), "{mode:?}, frame {i}, view {side}");
                    assert!(
                        found.motion.iter().filter(|vector| **vector != HOSTS && **vector != [0.0; 2]).count() > 300
                    );
                }
            }
            before = Some([eye(i, 0.0), eye(i, 14.0)]);
        }
        [both, left, right].into_iter().for_each(Rig::destroy);
    }
}

/// A resize resets no vector: they are in pixels of the new picture, as if the one before had had its size.
#[test]
fn vectors_go_on_over_a_resize() {
    let (given, small) = (ball(60, 1), [SIZE[0] / 2, SIZE[1] / 2]);
    let made = Desc { temporal: FORMATS, ..desc(small, 60, settings(Mode::Stochastic)) };
    let Some(mut rig) = Rig::new(made, [0; 2]) else { return };
    let views = [0.0, 5.0].map(|degrees| camera(degrees).view(SIZE));
    let frame = rig.frame(views[0], &given, None);
    rig.record(&frame);
    let (host, kernels, allocator) = rig.device.making();
    // SAFETY: the device's own handles; every frame has been waited for.
    unsafe { rig.flame.resize(&host, kernels, allocator, SIZE).expect("a size").destroy(&host, allocator) };
    let way = DVec3::new(0.05, -0.11, 0.2);
    let frame = rig.frame(views[1], &given, Some(&moved_by(&given, way)));
    let found = rig.render(&frame);
    let (off, count) = worst(&mut rig, &found, [&views[0], &views[1]], |_| way);
    assert!(off < 1e-4 && count > 500, "{count} vectors, off by {off}");
    rig.destroy();
}

/// Where embers are seen, the mask is the larger of what they cover of a pixel and of what it was; vectors are those of the fire.
#[test]
fn embers_are_in_the_reactive_mask() {
    let embers = Embers { share: 0.5, size: 5.0, rise: Some(1.5) };
    for mode in [Mode::Stochastic, Mode::Expected] {
        let (given, view) = (ball(60, 3), views::jittered(camera(10.0).view(SIZE), 3));
        let made = [settings(mode), Settings { embers, ..settings(mode) }]
            .map(|settings| Rig::new(Desc { temporal: FORMATS, ..desc(SIZE, 60, settings) }, [3, 6]));
        let [Some(mut without), Some(mut with)] = made else { return };
        let frame = without.frame(view, &given, None);
        let (fire, shares) = (without.render(&frame), without.picture().into_iter().map(|colour| colour[3]));
        let frame = with.frame(view, &given, None);
        with.record(&frame);
        let found = with.outputs.found(&mut with.device, SHARE);
        assert!(found.motion == fire.motion, "{mode:?}: the vectors are others");
        let (desc, projection) = (with.flame.desc(), Projection::of_valid(&view, SIZE));
        let seen: Vec<Ember> = (0..60)
            .filter_map(|i: u32| {
                let [x, y, z] = given.position[i as usize];
                let row = [x, y, z, given.temperature[i as usize]];
                Ember::new(&desc.settings, desc.hottest, desc.seed, i, &projection, row)
            })
            .collect();
        let (mut off, mut count) = (0.0_f64, 0);
        for (index, share) in shares.enumerate() {
            let at = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
            let covered = seen.iter().map(|ember| ember.share(at)).fold(0.0, f64::max) * (1.0 - f64::from(share));
            off = off.max((f64::from(found.reactive[index]) - covered.max(fire.reactive[index].into())).abs());
            count += usize::from(covered > fire.reactive[index].into());
        }
        println!("{mode:?}: {count} pixels are of embers, off by at most {off:.1e}");
        // A place in single precision is good for 1e-4 pixels.
        assert!(off < 1e-3 && count > 20, "{mode:?}: {count} pixels, off by {off}");
        [without, with].into_iter().for_each(Rig::destroy);
    }
}

#[test]
fn outputs_change_no_bit_of_the_picture() {
    for mode in [Mode::Stochastic, Mode::Expected] {
        let given = ball(60, 1);
        let pictures = [TemporalFormats::default(), FORMATS].map(|temporal| {
            let mut rig = Rig::new(Desc { temporal, layers: false, ..desc(SIZE, 60, settings(mode)) }, [0; 2])?;
            let moved = moved_by(&given, DVec3::X);
            let previous = temporal.motion.map(|_| &moved[..]);
            let pictures = [0, 1].map(|i| {
                let frame = rig.frame(camera(f64::from(i)).view(SIZE), &given, previous);
                rig.render(&frame);
                rig.picture().into_iter().map(|colour| colour.map(f32::to_bits)).collect::<Vec<_>>()
            });
            rig.destroy();
            Some(pictures)
        });
        assert!(pictures[0] == pictures[1], "{mode:?}: the picture is another");
    }
}

#[test]
fn outputs_that_do_not_fit_are_refused_by_name() {
    let (given, made) = (ball(60, 1), desc(SIZE, 60, settings(Mode::Stochastic)));
    let Some(mut rig) = Rig::new(Desc { temporal: FORMATS, ..made.clone() }, [0; 2]) else { return };
    let good = rig.frame(camera(0.0).view(SIZE), &given, Some(&given.position));
    let input = good.particles.expect("particles");
    let short = input.previous.map(|previous| HostBuffer { size: 16, ..previous });
    let images = good.temporal;
    let cases = [
        ("temporal.motion: missing", Frame { temporal: TemporalImages { motion: None, ..images }, ..good }),
        ("temporal.reactive: missing", Frame { temporal: TemporalImages { reactive: None, ..images }, ..good }),
        ("particles: 16 bytes", Frame { particles: Some(ParticleInput { previous: short, ..input }), ..good }),
    ];
    for (expected, frame) in cases {
        let said = rig.flame.prepare(&frame).expect_err(expected).to_string();
        assert!(said.starts_with(expected), "{expected}: {said}");
    }
    rig.destroy();
    let Some(mut plain) = Rig::new(made, [0; 2]) else { return };
    let frame = plain.frame(camera(0.0).view(SIZE), &given, Some(&given.position));
    let said = plain.flame.prepare(&frame).expect_err("previous places").to_string();
    let expected = "particles: ParticleInput::previous is given; the effect was made without Desc::temporal.motion";
    assert_eq!(said, expected);
    let unasked = Frame { temporal: plain.outputs.given(), ..plain.frame(camera(0.0).view(SIZE), &given, None) };
    let said = plain.flame.prepare(&unasked).expect_err("images").to_string();
    assert_eq!(said, "temporal.motion: given; the effect was made without temporal.motion");
    plain.destroy();
}
