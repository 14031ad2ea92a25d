//! A frame does not depend on how it is submitted.

use std::time::Duration;

use celfx::effect::Effort;
use celfx::flame;
use celfx::flame::FlameKind;
use celfx::offline::{BlurInput, BlurScene, EffectBuffer, Effects, Offline, Scene};
use celfx::program;
use celfx::smoke::SmokeKind;
use celfx::smoke::{self, Sequence};

use crate::common::flame::ball;
use crate::common::rig::Bits;
use crate::common::scenes::{camera, desc, direction, puffs};
use crate::common::{TestOffline, device};

const SIZE: [u32; 2] = [48, 36];

/// Bits, rows of the profile, and the span of the passes of each frame.
type Frames = Vec<(Bits, Vec<&'static str>, Vec<(&'static str, &'static str)>)>;

/// A submission a step, one for all of them, and as it is when nothing is said.
const WAYS: [Option<Option<Duration>>; 3] = [Some(Some(Duration::ZERO)), Some(None), None];

fn offline(effects: Effects, way: Option<Option<Duration>>) -> Option<TestOffline> {
    let mut offline = device()?.offline(effects, Effort::Needed).expect("the effects can be made");
    if let Some(longest) = way {
        offline.set_longest_submission(longest);
    }
    Some(offline)
}

fn keep(offline: &mut Offline, frames: &mut Frames) {
    let mut bits = Bits::default();
    bits.push("picture", offline.picture());
    for layer in offline.layers() {
        bits.push("layer", layer);
    }
    let times = offline.times().expect("lavapipe, SwiftShader and all GPUs of note have timestamps");
    assert!(times.passes.windows(2).all(|pair| pair[0].begin_ns <= pair[1].begin_ns), "{times:?}");
    frames.push((bits, times.passes.iter().map(|pass| pass.name).collect(), times.skipped));
}

fn assert_same(rendered: &[Frames]) {
    let [steps, whole, free] = rendered else { panic!("three ways") };
    assert!(!whole.is_empty() && whole.iter().all(|(_, rows, _)| rows.len() > 3), "frames of some passes");
    assert_eq!((steps, free), (whole, whole));
}

#[test]
fn smoke_and_fire_in_one_submission_and_in_many_are_the_same() {
    let fire = common_flame();
    let settings = smoke::Settings { particles: 50, ..smoke::Settings::default() };
    let effects = Effects::from(desc(SIZE, [12; 3], settings)).with(fire);
    let (volume, particles) = (puffs(12, 0.0), ball(100, 3));
    let mut rendered = Vec::new();
    for way in WAYS {
        let Some(mut offline) = offline(effects.clone(), way) else { return };
        let layers = [
            EffectBuffer::of::<SmokeKind>(celfx::low_level::smoke::layout::DEPTH),
            EffectBuffer::of::<FlameKind>(celfx::low_level::flame::layout::NEAREST),
        ];
        offline.set_layers(&layers).expect("memory");
        let mut frames = Frames::new();
        for number in 0..3 {
            let scene = Scene {
                sequence: if number == 0 { Sequence::Restart } else { Sequence::Advance },
                dt: 0.1,
                camera: camera(20.0 * f64::from(number)),
                light: direction(-1.0, -1.5, -1.0),
                volume: Some(&volume).filter(|_| number == 0),
                particles: Some(&particles),
                rendered: true,
                number,
                ..Scene::default()
            };
            offline.frame(&scene).expect("rendered");
            keep(&mut offline, &mut frames);
        }
        rendered.push(frames);
    }
    assert_same(&rendered);
}

fn common_flame() -> flame::Desc {
    crate::common::flame::desc(SIZE, 100, flame::Settings::default())
}

#[test]
fn blur_in_one_submission_and_in_many_is_the_same() {
    let sets = ["size=[48, 36]", "blur.scene=builtin:crossing", "camera.file=builtin:crossing", "blur.ghosts.count=2"];
    let shot = program::load("builtin:blur", &sets.map(str::to_owned)).expect("a shot");
    let blur = shot.part::<program::blur::Blur>().expect("a blur");
    let settings = &blur.settings;
    let mut rendered = Vec::new();
    for way in WAYS {
        let scene = blur.mesh(&shot).expect("a scene");
        let of_shot = shot.clone();
        let view = move |frame: f64| of_shot.camera(frame).view(of_shot.size);
        let mut input = BlurInput::new(scene, view, shot.frames, settings, shot.size, 2).expect("motion");
        let effects = Effects::from(input.desc(shot.size, shot.frames, shot.seed, true, false));
        let Some(mut offline) = offline(effects, way) else { return };
        let mut frames = Frames::new();
        for number in [1, 2, 3, 10] {
            let frame = input.frame(number).expect("a frame");
            let blur = Some(BlurScene { frame: &frame, images: [None; 2], outer: [None; 2] });
            let (camera, light) = (shot.camera(number), shot.light(number));
            offline
                .frame(&Scene { camera, light, blur, rendered: true, number, ..Scene::default() })
                .expect("rendered");
            keep(&mut offline, &mut frames);
        }
        rendered.push(frames);
    }
    assert_same(&rendered);
}
