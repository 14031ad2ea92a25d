//! The same input gives the same bits: whenever, in whatever order, in however many dispatches, on however wide vectors.

use std::process::Command;

use celfx::data::Particles;
use celfx::effect::Effort;
use celfx::flame::FlameKind;
use celfx::flame::settings::{Sampling, Shape};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;

use crate::common::device;
use crate::common::flame::{FlameRig, ball, desc, particles, scene};
use crate::common::rig::Bits;
use crate::common::scenes::camera;
use crate::oracle::{Shot, control, sums};

const SIZE: [u32; 2] = [60, 45];
const PARTICLES: u32 = 120;

fn base() -> Settings {
    Settings { repetitions: 20, count: 6.0, spread: Some(0.15), size: Some(0.25), ..Settings::paper() }
}

fn effect(settings: Settings) -> Desc {
    desc(SIZE, PARTICLES, settings)
}

/// Every layer, and the sums behind them.
pub fn bits(rig: &mut FlameRig) -> Bits {
    let mut bits = rig.bits();
    let sums = sums(rig, 1);
    bits.push("light", sums.light.as_flattened());
    bits.push("squares", sums.squares.as_flattened());
    bits.push("hits", &sums.hits);
    bits
}

/// What two frames differ in, besides their list of particles.
pub fn unlike(a: &Bits, b: &Bits) -> Vec<(&'static str, usize)> {
    a.differences(b).into_iter().filter(|(layer, _)| *layer != "particles").collect()
}

/// Frames of a rising cloud.
fn cloud(i: u32) -> Particles {
    let mut particles = ball(PARTICLES, 2);
    particles.position.iter_mut().for_each(|p| p[1] += 0.1 * i as f32);
    particles
}

fn last_of(desc: &Desc, frames: impl Iterator<Item = u32>) -> Option<Bits> {
    let mut rig = FlameRig::new(desc.clone())?;
    for number in frames {
        let particles = cloud(number);
        let camera = camera(5.0 * f64::from(number));
        rig.render(&Scene { number, ..scene(Some(&particles), camera) });
    }
    Some(bits(&mut rig))
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    for settings in [base(), Settings { sampling: Sampling::ShuffledSobol, shape: Shape::Cube, ..base() }] {
        let desc = effect(settings);
        let Some(once) = last_of(&desc, 0..1) else { return };
        let Some(again) = last_of(&desc, [0, 0, 0].into_iter()) else { return };
        let Some(other) = last_of(&Desc { seed: 2, ..desc }, 0..1) else { return };
        assert_eq!(once.differences(&again), []);
        assert!(!once.differences(&other).is_empty());
    }
}

#[test]
fn a_frame_alone_is_the_sequences() {
    for flicker in [0.0, 0.37] {
        let desc = effect(Settings { flicker, ..base() });
        let Some(all) = last_of(&desc, 0..6) else { return };
        let Some(alone) = last_of(&desc, 5..6) else { return };
        let Some(back) = last_of(&desc, (0..9).rev().take(4)) else { return };
        assert_eq!(all.differences(&alone), [], "flicker {flicker}");
        assert_eq!(all.differences(&back), [], "flicker {flicker}");
    }
    // Without flicker the number alone changes nothing; with it, something.
    for flicker in [0.0, 0.2] {
        let Some(mut rig) = FlameRig::new(effect(Settings { flicker, ..base() })) else { return };
        let particles = cloud(0);
        let mut number = |number| {
            rig.render(&Scene { number, ..scene(Some(&particles), camera(0.0)) });
            bits(&mut rig)
        };
        assert_eq!(number(3).differences(&number(4)).is_empty(), flicker == 0.0);
    }
}

/// A host shows each frame through two views in turn: each is that of an effect that sees through one of them alone.
#[test]
fn two_views_of_each_frame() {
    let make = || FlameRig::new(effect(Settings { flicker: 0.37, ..base() }));
    let (Some(mut both), Some(mut left), Some(mut right)) = (make(), make(), make()) else { return };
    for number in 0..3 {
        let particles = cloud(number);
        for (angle, alone) in [(0.0, &mut left), (4.0, &mut right)] {
            let frame = Scene { number, ..scene(Some(&particles), camera(angle)) };
            both.render(&frame);
            alone.render(&frame);
            assert_eq!(bits(&mut both).differences(&bits(alone)), [], "frame {number}");
        }
    }
}

#[test]
fn rows_may_come_in_any_order() {
    let mut sorted = ball(PARTICLES, 2);
    // Some in the same place: the id decides. One is not valid, one too cold, one out of sight.
    (0..30).for_each(|i| sorted.position[i] = sorted.position[60]);
    (sorted.temperature[7], sorted.temperature[8], sorted.position[9]) = (f32::NAN, 20.0, [0.0, 0.0, 900.0]);
    for settings in [base(), Settings { spread: Some(0.0), ..base() }] {
        let desc = effect(settings);
        let mut frames = Vec::new();
        for step in [1, 7, 77, 119] {
            let order: Vec<usize> = (0..PARTICLES).map(|i| (i * step % PARTICLES) as usize).collect();
            let order = if step == 119 { (0..120).rev().collect() } else { order };
            let shuffled = Particles {
                position: order.iter().map(|i| sorted.position[*i]).collect(),
                temperature: order.iter().map(|i| sorted.temperature[*i]).collect(),
                id: Some(order.iter().map(|i| 1000 + *i as u32).collect()),
                velocity: None,
            };
            let mut seen = order.clone();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..PARTICLES as usize), "{step}: not a permutation");
            let Some(mut rig) = FlameRig::new(desc.clone()) else { return };
            rig.frame(&shuffled, camera(0.0));
            frames.push(bits(&mut rig));
        }
        for frame in &frames[1..] {
            assert_eq!(unlike(&frames[0], frame), []);
        }
    }
}

#[test]
fn particles_may_be_kept() {
    let Some(mut rig) = FlameRig::new(effect(base())) else { return };
    let ids: Vec<u32> = (0..PARTICLES).map(|i| 7 * i + 3).collect();
    let with_ids = Particles { id: Some(ids), ..cloud(0) };
    let fewer = particles(&[[0.1, 0.2, 0.3, 2000.0], [-0.1, 0.0, 0.1, 1500.0]]);
    for given in [&cloud(1), &with_ids, &fewer, &with_ids, &cloud(1)] {
        rig.frame(given, camera(0.0));
        rig.render(&scene(None, camera(30.0)));
        let kept = bits(&mut rig);
        rig.frame(given, camera(30.0));
        assert_eq!(kept.differences(&bits(&mut rig)), []);
    }
}

#[test]
fn an_effect_may_be_made_for_more() {
    let particles = cloud(0);
    let settings = Settings { repetitions: 150, ..base() };
    let small = effect(settings.clone());
    let frame = |desc: &Desc| {
        let mut rig = FlameRig::new(desc.clone())?;
        rig.frame(&particles, camera(0.0));
        let steps = rig.offline().effect::<FlameKind>().expect("a flame").plan().steps.len();
        let repetitions = control(&mut rig).part_repetitions;
        Some((bits(&mut rig), steps, repetitions))
    };
    let Some((bits, steps, at_once)) = frame(&small) else { return };
    // Made for more particles, or hotter ones: lists could be longer, so more dispatches stand ready, which stay empty.
    let many = Desc { particles: 20_000, ..small.clone() };
    let hot = Desc { hottest: 30_000.0, ..small.clone() };
    for (name, desc) in [("many", many), ("hot", hot)] {
        let Some((others, more, at_once_too)) = frame(&desc) else { return };
        println!("{name}: {more} steps instead of {steps}, {at_once} repetitions a dispatch");
        assert!(more > steps && at_once == at_once_too && at_once < settings.repetitions, "{name}");
        assert_eq!(bits.differences(&others), [], "{name}");
    }
}

/// Skipping on and off.
#[test]
fn skipping_changes_nothing() {
    let cloud = cloud(0);
    let wall: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| if i % SIZE[0] < 20 { 1.0 } else { 4.2 }).collect();
    let sparks = Settings { threshold: 0.97, alpha_scale: 1.5, size: Some(0.1), ..base() };
    let tiny = Settings { size: Some(0.004), count: 200.0, ..base() };
    let sobol = Settings { sampling: Sampling::ShuffledSobol, shape: Shape::Cube, size: Some(1.5), ..base() };
    let negative = Settings { threshold: -1.0, ..base() };
    for (index, settings) in [base(), sparks, tiny, sobol, negative].into_iter().enumerate() {
        let given = Desc { scene: (index == 0).then_some(SceneFormat::Buffer), ..effect(settings) };
        let frames = |effort| {
            let mut rig = FlameRig::with_effort(given.clone(), effort)?;
            let frame = |turn| {
                let depth = given.scene.map(|_| wall.as_slice());
                rig.render(&Shot { depth, ..Shot::new(&cloud, camera(turn)) }.scene());
                (bits(&mut rig), rig.variance())
            };
            Some([0.0, 20.0].map(frame))
        };
        let (Some(on), Some(off)) = (frames(Effort::Needed), frames(Effort::Everything)) else { return };
        for ((on, on_variance), (off, off_variance)) in on.iter().zip(&off) {
            // Nothing is repeated in tiles without particles: that alone is another number of repetitions.
            let pairs = on_variance.iter().zip(off_variance);
            let skipped = pairs.filter(|(on, off)| on != off).map(|(on, off)| {
                assert_eq!((*on, off[3]), ([0.0; 4], given.settings.repetitions as f32));
            });
            let skipped = skipped.count();
            let expected = if skipped > 0 { vec![("variance", skipped)] } else { Vec::new() };
            assert_eq!(unlike(on, off), expected, "look {index}");
        }
    }
}

const HASH: &str = "hash of the bits: ";

/// What the test below runs in processes of their own; on its own it says what a frame's bits are.
#[test]
fn a_frame_is_hashed() {
    let Some(bits) = last_of(&effect(base()), 0..1) else { return };
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    format!("{bits:?}").hash(&mut hasher);
    println!("{HASH}{:016x}", hasher.finish());
}

/// Lavapipe's vectors are as wide as the processor's unless it is told otherwise; other drivers do not listen.
#[test]
fn vectors_may_be_of_any_width() {
    if device().is_none() {
        return;
    }
    let hash = |width: &str| {
        let program = std::env::current_exe().expect("the test's program");
        let arguments = ["--exact", "determinism::a_frame_is_hashed", "--nocapture"];
        // The driver's cache of compiled shaders does not know the width: what it holds is of any.
        let variables = [("LP_NATIVE_VECTOR_WIDTH", width), ("MESA_SHADER_CACHE_DISABLE", "true")];
        let output = Command::new(program).args(arguments).envs(variables).output().expect("a process");
        let text = String::from_utf8(output.stdout).expect("text");
        let (_, hash) = text.split_once(HASH).unwrap_or_else(|| panic!("no hash, {width} bits wide: {text}"));
        hash[..16].to_owned()
    };
    let [narrow, wide] = ["128", "256"].map(hash);
    assert_eq!(narrow, wide);
}
