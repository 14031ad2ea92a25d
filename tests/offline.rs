//! The host without a window with one effect or both.
#![cfg(feature = "cli")]

mod common;

use celfx::effect::Effort;
use celfx::error::Error;
use celfx::flame::FlameKind;
use celfx::flame::{self, SceneFormat};
use celfx::offline::{EffectBuffer, Effects, Scene};
use celfx::smoke::SmokeKind;
use celfx::smoke::{self, Sequence};
use common::TestOffline;
use common::flame::{FlameRig, ball};
use common::scenes::{camera, desc, direction, puffs};

const SIZE: [u32; 2] = [48, 36];
const SKY: [f32; 4] = [0.25, 0.5, 0.75, 1.0];

fn smoke_desc() -> smoke::Desc {
    desc(SIZE, [12; 3], smoke::Settings { particles: 50, ..smoke::Settings::default() })
}

fn flame_desc() -> flame::Desc {
    common::flame::desc(SIZE, 100, flame::Settings::default())
}

/// A host with these effects over the sky, and the verdict to be kept until it is gone.
fn offline(effects: impl Into<Effects>) -> Option<TestOffline> {
    let mut offline = common::device()?.offline(effects, Effort::Needed).expect("the effects can be made");
    offline.set_background(SKY);
    Some(offline)
}

#[test]
fn effects_are_at_least_one_and_of_one_size() {
    let small = flame::Desc { size: [8, 8], ..flame_desc() };
    let apart = Effects::from(smoke_desc()).with(small);
    for (effects, word) in [(Effects::default(), "none"), (apart, "one size")] {
        let Some(device) = common::device() else { return };
        match device.offline(effects, Effort::Needed) {
            Err(Error::HostResource { name: "effects", why }) => assert!(why.contains(word), "{why}"),
            other => panic!("{word}: {:?}", other.map(|_| ())),
        }
    }
}

#[test]
fn smoke_without_fire_is_the_smoke_alone() {
    let volume = puffs(12, 0.0);
    let first = Scene {
        sequence: Sequence::Restart,
        dt: 1.0 / 24.0,
        camera: camera(20.0),
        light: direction(-1.0, -1.5, -1.0),
        volume: Some(&volume),
        rendered: true,
        ..Scene::default()
    };
    let nothing = common::flame::particles(&[]);
    let next = Scene { sequence: Sequence::Advance, volume: None, camera: camera(35.0), ..first };
    let stepped = Scene { rendered: false, ..next };
    let pictures = |effects: Effects| {
        let has_both = effects.len() > 1;
        let mut offline = offline(effects)?;
        let mut frame = |scene: Scene| {
            offline.frame(&scene).expect("rendered");
            let times = offline.times();
            let of =
                |name: &str| times.as_ref().is_none_or(|t| t.passes.iter().any(|pass| pass.name.starts_with(name)));
            assert!(of("smoke."), "{times:?}");
            assert!(times.is_none() || of("flame.") == (has_both && scene.rendered), "{times:?}");
            offline.picture().to_vec()
        };
        let particles = has_both.then_some(&nothing);
        let mut pictures = vec![frame(Scene { particles, ..first })];
        pictures.extend([stepped, next].map(&mut frame));
        Some(pictures)
    };
    let Some(alone) = pictures(smoke_desc().into()) else { return };
    let both = pictures(Effects::from(smoke_desc()).with(flame_desc())).expect("a device");
    assert!(alone[0].iter().any(|pixel| *pixel != SKY) && alone[2] != alone[1], "there is smoke, and it is turned");
    assert!(alone == both);
}

#[test]
fn smoke_hides_the_fire_behind_it_and_not_the_fire_before_it() {
    let Some(mut offline) = offline(Effects::from(smoke_desc()).with(flame_desc())) else {
        return;
    };
    let volume = puffs(12, 0.0);
    // Rows of 100 hot particles across the picture, from 2 m behind the smoke's middle or before it.
    let wall = |z: f32| {
        let row = |i: u32| [(i % 10) as f32 * 0.3 - 1.35, (i / 10) as f32 * 0.3 - 1.35, z, 3000.0];
        common::flame::particles(&(0..100).map(row).collect::<Vec<_>>())
    };
    let mut frame = |sequence: Sequence, volume, z: f32| {
        let (particles, light) = (wall(z), direction(-1.0, -1.5, -1.0));
        let scene = Scene { sequence, dt: 0.1, camera: camera(0.0), light, volume, rendered: true, ..Scene::default() };
        offline.frame(&Scene { particles: Some(&particles), ..scene }).expect("rendered");
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let picture = offline.picture().to_vec();
        let depth: Vec<f32> = offline
            .read_as(EffectBuffer::of::<SmokeKind>(celfx::low_level::smoke::layout::DEPTH), pixels)
            .expect("read");
        let mean: Vec<[f32; 4]> = offline
            .read_as(EffectBuffer::of::<FlameKind>(celfx::low_level::flame::layout::MEAN), pixels)
            .expect("read");
        let coverage: Vec<f32> = mean.iter().map(|pixel| pixel[3]).collect();
        (picture, depth, coverage)
    };
    // Behind the camera there is no fire to be seen.
    let (alone, depth, none) = frame(Sequence::Restart, Some(&volume), 50.0);
    assert!(none.iter().all(|coverage| *coverage == 0.0));
    let is_smoke: Vec<bool> = depth.iter().map(|depth| depth.is_finite()).collect();
    assert!(is_smoke.iter().filter(|is_smoke| **is_smoke).count() > 150, "smoke");
    let (behind, same_depth, coverage) = frame(Sequence::Hold, None, -2.0);
    assert!(same_depth == depth, "the same smoke");
    let hidden = |i: usize| coverage[i] == 0.0 && behind[i] == alone[i];
    assert!((0..is_smoke.len()).all(|i| !is_smoke[i] || hidden(i)), "hidden by smoke");
    assert!((0..is_smoke.len()).any(|i| coverage[i] > 0.5 && behind[i] != alone[i]), "seen beside it");
    let (before, _, coverage) = frame(Sequence::Hold, None, 2.0);
    let seen = |i: usize| coverage[i] > 0.5 && before[i] != alone[i];
    assert!((0..is_smoke.len()).filter(|i| is_smoke[*i] && seen(*i)).count() > 50, "before the smoke");
}

#[test]
fn layers_of_both_come_with_the_frame() {
    let Some(mut offline) = offline(Effects::from(smoke_desc()).with(flame_desc())) else {
        return;
    };
    let buffers = [
        EffectBuffer::of::<FlameKind>(celfx::low_level::flame::layout::NEAREST),
        EffectBuffer::of::<SmokeKind>(celfx::low_level::smoke::layout::DEPTH),
        EffectBuffer::of::<FlameKind>(celfx::low_level::flame::layout::MASK),
    ];
    offline.set_layers(&buffers).expect("memory");
    let (volume, particles) = (puffs(12, 0.0), ball(100, 3));
    let light = direction(-1.0, -1.5, -1.0);
    let particles = Some(&particles);
    let scene = Scene { volume: Some(&volume), light, particles, dt: 0.1, rendered: true, ..Scene::default() };
    offline.frame(&scene).expect("rendered");
    let layers: Vec<Vec<u8>> = offline.layers().into_iter().map(<[u8]>::to_vec).collect();
    for (buffer, layer) in buffers.into_iter().zip(layers) {
        assert!(!layer.is_empty() && layer == offline.read(buffer, u64::MAX).expect("read"), "{buffer:?}");
    }
}

#[test]
fn fire_without_particles_is_its_background() {
    let Some(mut rig) = FlameRig::new(flame_desc()) else { return };
    let nothing = common::flame::particles(&[]);
    rig.frame(&nothing, camera(0.0));
    assert!(rig.picture().iter().all(|pixel| *pixel == [0.0; 4]));
    rig.offline().set_background(SKY);
    rig.frame(&nothing, camera(0.0));
    assert!(rig.picture().iter().all(|pixel| *pixel == SKY));
    let sky: Vec<[f32; 4]> = (0..SIZE[0] * SIZE[1]).map(|i| [i as f32, 0.5, 0.25, 1.0]).collect();
    rig.offline().set_backdrop(&sky).expect("uploaded");
    rig.frame(&nothing, camera(0.0));
    assert!(rig.picture() == sky, "the very pixels");
    assert_eq!(rig.prepared().len(), 0);
}

#[test]
fn frames_that_do_not_fit_are_refused_and_disturb_nothing() {
    let Some(mut rig) = FlameRig::new(flame_desc()) else { return };
    let some = ball(100, 5);
    let first = common::flame::scene(None, camera(0.0));
    let refused = |rig: &mut FlameRig, scene: &Scene, what: &str| match rig.offline().frame(scene) {
        Err(Error::HostResource { name, .. }) => assert_eq!(name, what),
        other => panic!("{what}: {other:?}"),
    };
    refused(&mut rig, &first, "particles");
    let many = ball(101, 5);
    refused(&mut rig, &Scene { particles: Some(&many), ..first }, "particles");
    let depth = vec![1.0; (SIZE[0] * SIZE[1]) as usize];
    refused(&mut rig, &Scene { particles: Some(&some), depth: Some(&depth), ..first }, "scene");
    rig.frame(&some, camera(0.0));
    let bits = rig.bits();
    rig.render(&first);
    assert_eq!(rig.bits().differences(&bits), [], "the same particles again");
    rig.render(&Scene { rendered: false, ..first });
    assert_eq!(rig.bits().differences(&bits), [], "nothing was rendered");
    assert_eq!(rig.positions().len(), 100);
}

#[test]
fn a_scene_depth_is_given_exactly_if_the_flame_was_made_for_one() {
    let Some(mut rig) = FlameRig::new(flame::Desc { scene: Some(SceneFormat::Buffer), ..flame_desc() }) else { return };
    let some = ball(100, 5);
    let scene = common::flame::scene(Some(&some), camera(0.0));
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    for depth in [None, Some(&vec![1.0; pixels - 1][..])] {
        let refused = rig.offline().frame(&Scene { depth, ..scene });
        assert!(matches!(refused, Err(Error::HostResource { name: "scene", .. })), "{refused:?}");
    }
    rig.offline().set_background(SKY);
    rig.render(&Scene { depth: Some(&vec![0.5; pixels]), ..scene });
    assert!(rig.picture().iter().all(|pixel| *pixel == SKY), "a wall before all of it");
}
