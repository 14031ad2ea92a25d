//! The same bits whatever the order of particles and whatever was rendered before.

use celfx::data::Particles;
use celfx::effect::Effort;
use celfx::flame::settings::{Mode, Shape};
use celfx::flame::{Desc, FlameKind, Settings};
use celfx::low_level::flame::layout;
use celfx::low_level::flame::params::KernelTable;
use celfx::offline::{EffectBuffer, Scene};
use celfx::view::Camera;
use glam::DVec3;

use crate::cases::{Case, control, near, plain, settings};
use crate::common::flame::{FlameRig, ball, scene};
use crate::common::rig::Bits;
use crate::common::scenes;

/// Every layer that does not follow the order of the particles.
fn picture(rig: &mut FlameRig) -> Bits {
    let mut bits = Bits::default();
    bits.push("picture", &rig.picture());
    bits.push("mean", &rig.mean());
    bits.push("variance", &rig.variance());
    bits.push("nearest", &rig.nearest());
    bits
}

/// The particles in another order, each with the id that it has.
fn shuffled(particles: &Particles, by: usize) -> Particles {
    let count = particles.position.len();
    let order: Vec<usize> = (0..count).map(|i| (i * by + 7) % count).collect();
    let ids: Vec<u32> = particles.id.clone().unwrap_or((0..count as u32).collect());
    Particles {
        position: order.iter().map(|i| particles.position[*i]).collect(),
        temperature: order.iter().map(|i| particles.temperature[*i]).collect(),
        id: Some(order.iter().map(|i| ids[*i]).collect()),
        velocity: None,
    }
}

#[test]
fn a_frame_has_the_same_bits_again_and_in_any_order() {
    for case in [plain(), near()] {
        let count = case.particles.position.len() as u32;
        let case = Case {
            particles: Particles { id: Some((0..count).map(|i| 3 * i + 1).collect()), ..case.particles },
            ..case
        };
        let Some(mut rig) = case.render() else { return };
        let first = picture(&mut rig);
        rig.frame(&case.particles, case.camera);
        assert_eq!(first.differences(&picture(&mut rig)), [], "{}: again", case.name);
        // 11 and 1 have no divisor in common with 60 and 24: every row once.
        for by in [11, 1] {
            rig.frame(&shuffled(&case.particles, by), case.camera);
            assert_eq!(first.differences(&picture(&mut rig)), [], "{}: rows by {by}", case.name);
        }
        let Some(mut other) = case.render() else { return };
        assert_eq!(first.differences(&picture(&mut other)), [], "{}: another effect", case.name);
    }
}

#[test]
fn leaving_out_what_is_not_needed_changes_nothing() {
    let mut occluded = plain();
    occluded.desc.scene = Some(celfx::flame::SceneFormat::Buffer);
    let pixels = occluded.desc.size[0] * occluded.desc.size[1];
    occluded.depth = Some((0..pixels).map(|i| if i % 3 == 0 { 3.9 } else { f32::INFINITY }).collect());
    for case in [plain(), near(), occluded, plain().with(|s| s.count = 300.0)] {
        let (needed, everything) = (case.render(), case.render_with(Effort::Everything));
        let (Some(mut quick), Some(mut thorough)) = (needed, everything) else { return };
        assert_eq!(picture(&mut quick).differences(&picture(&mut thorough)), [], "{}", case.name);
    }
}

#[test]
fn a_frame_after_others_is_as_it_is_alone() {
    let from = |eye: [f64; 3]| Camera {
        eye: DVec3::from_array(eye),
        target: DVec3::ZERO,
        vertical_fov: 32.0,
        ..Camera::default()
    };
    // Turned; farther and nearer, where the mask has other levels; away from the fire, and back.
    let away = Camera { target: DVec3::new(0.0, 0.0, 9.0), ..from([0.0, 0.6, 4.0]) };
    let cameras = [scenes::camera(0.0), scenes::camera(50.0), from([0.0, 1.0, 9.0]), away, scenes::camera(0.0)];
    // A cube needs another table whenever the camera turns, a ball only at another level.
    for (shape, cameras) in [(Shape::Ball, &cameras[..]), (Shape::Cube, &[cameras[0], cameras[1], cameras[0]])] {
        let settings = Settings { shape, bins: 16, ..settings() };
        let case = Case::new("sequence", [32, 24], 20, settings, cameras[0]);
        let Some(mut rig) = FlameRig::new(case.desc.clone()) else { return };
        let mut levels = Vec::new();
        for (i, camera) in cameras.iter().copied().enumerate() {
            rig.frame(&case.particles, camera);
            let Some(mut alone) = (Case { camera, ..case.clone() }).render() else { return };
            assert_eq!(picture(&mut rig).differences(&picture(&mut alone)), [], "{shape:?}: frame {i}");
            levels.push(crate::cases::level(&Case { camera, ..case.clone() }, &mut rig));
            let seen = control(&mut rig).visible;
            assert_eq!(seen == 0, camera == away, "frame {i}: {seen} particles");
        }
        levels.dedup();
        assert!(shape == Shape::Cube || levels.len() > 2, "the level does not change: {levels:?}");
        // No fire at all from elsewhere, and some again.
        let last = picture(&mut rig);
        rig.frame(&ball(0, 1), cameras[1]);
        rig.frame(&case.particles, cameras[0]);
        assert_eq!(picture(&mut rig).differences(&last), [], "{shape:?}: after a frame without fire");
    }
}

/// The table is made class by class, as temperatures come; those that it has stay.
#[test]
fn temperatures_that_come_later_are_as_they_are_alone() {
    let case = plain();
    let at = |kelvin: &[f32]| {
        let temperatures = kelvin.iter().cycle().copied();
        let temperature = temperatures.take(case.particles.temperature.len()).collect();
        Case { particles: Particles { temperature, ..case.particles.clone() }, ..case.clone() }
    };
    let frames = [at(&[2950.0]), at(&[2300.0]), at(&[2950.0, 2600.0, 2300.0])];
    let Some(mut rig) = frames[0].render() else { return };
    for (number, frame) in (1..).zip(&frames[1..]) {
        rig.frame(&frame.particles, frame.camera);
        let Some(mut alone) = frame.render() else { return };
        assert_eq!(picture(&mut rig).differences(&picture(&mut alone)), [], "frame {number}");
        let burning = rig.mean().iter().filter(|mean| mean[3] > 0.01).count();
        assert!(burning > 50, "frame {number}: {burning} pixels");
    }
    assert_ne!(picture(&mut rig).differences(&picture(&mut frames[0].render().expect("a device"))), []);
}

/// The table is in spreads: frames with a spread of their own make nothing anew while sprites grow with it.
#[test]
fn a_frame_may_have_a_spread_of_its_own() {
    for (mode, size) in [(Mode::Expected, None), (Mode::Expected, Some(0.2)), (Mode::Stochastic, None)] {
        let case = plain().with(|s| (s.mode, s.spread, s.size, s.bins) = (mode, None, size, 16));
        let settings = Settings { spread: None, ..case.desc.settings.clone() };
        let Some(mut rig) = FlameRig::new(Desc { settings, ..case.desc.clone() }) else { return };
        for (number, spread) in (0..).zip([0.2_f32, 0.17, 0.19, 0.2]) {
            rig.render(&Scene { spread: Some(spread), ..scene(Some(&case.particles), case.camera) });
            let Some(mut alone) = case.with(|s| s.spread = Some(spread)).render() else { return };
            assert_eq!(picture(&mut rig).differences(&picture(&mut alone)), [], "{mode:?} {size:?}: frame {number}");
            if mode == Mode::Expected && number > 0 {
                let state = EffectBuffer::of::<FlameKind>(layout::KERNEL_STATE);
                let state: KernelTable = rig.offline().read_as(state, 1).expect("the buffer can be read")[0];
                assert_eq!(state.new_classes != 0, size.is_some(), "frame {number}");
            }
        }
        // None: that of the last frame.
        let last = picture(&mut rig);
        rig.render(&scene(None, case.camera));
        assert_eq!(picture(&mut rig).differences(&last), []);
    }
}
