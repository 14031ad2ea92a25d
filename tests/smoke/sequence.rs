//! Frames in sequences: skipping changes nothing, a frame alone is the sequence's, and the same seed gives the same bits.

use celfx::data::Volume;
use celfx::effect::Effort;
use celfx::smoke::SmokeKind;
use celfx::smoke::settings::Shadow;
use celfx::smoke::{Desc, Sequence, Settings};
use celfx::view::{Camera, Light};

use crate::common::rig::{Bits, Rig, scene};
use crate::common::scenes::{camera, desc, direction, moving_puffs, point, puffs, volume};

const SIZE: [u32; 2] = [100, 75];

fn effect(settings: Settings, velocity: bool) -> Desc {
    Desc { velocity, ..desc(SIZE, [20; 3], Settings { particles: 200, ..settings }) }
}

/// What a frame is made of.
type Step<'a> = (Sequence, Camera, Light, Option<&'a Volume>);

fn rendered(desc: &Desc, effort: Effort, steps: &[Step]) -> Option<(Vec<Bits>, usize)> {
    let mut rig = Rig::with_effort(desc.clone(), effort)?;
    let mut run = 0;
    let bits = steps.iter().map(|(sequence, camera, light, volume)| {
        rig.frame(&scene(*sequence, *camera, *light, *volume));
        run += rig.offline().effect::<SmokeKind>().expect("an effect").plan().steps.len();
        rig.bits()
    });
    Some((bits.collect(), run))
}

/// Frames with skipping on and off are the same, bit for bit, and skipping saves steps.
fn assert_skipping(name: &str, desc: &Desc, steps: &[Step], saves: bool) {
    let Some((on, few)) = rendered(desc, Effort::Needed, steps) else { return };
    let Some((off, many)) = rendered(desc, Effort::Everything, steps) else { return };
    for (frame, (on, off)) in on.iter().zip(&off).enumerate() {
        assert!(on == off, "{name}, frame {frame}: (layer, words) that differ: {:?}", on.differences(off));
    }
    println!("{name}: {few} steps instead of {many}");
    assert!(if saves { few < many } else { few <= many }, "{name}: {few} steps with skipping, {many} without");
}

#[test]
fn skipping_changes_nothing() {
    use Sequence::{Advance, Again, Hold, Restart};
    let (a, b) = (puffs(20, 0.0), puffs(20, 1.0));
    let (front, side) = (camera(0.0), camera(70.0));
    let (sun, low) = (direction(-1.0, -1.5, -1.0), direction(1.0, -0.2, 0.1));
    let still = |n| vec![(Advance, front, sun, None); n];
    for shadow in [Shadow::Exact, Shadow::Map, Shadow::None] {
        for fade in [0, 3] {
            let settings = Settings { shadow, fade, shadow_map: 256, ..Settings::default() };
            let mut steps = vec![(Restart, front, sun, Some(&a))];
            // Nothing changes; then the camera, then the light, then back.
            steps.extend(still(5));
            steps.extend([(Advance, side, sun, None), (Advance, side, low, None), (Hold, front, low, None)]);
            steps.extend([(Advance, front, low, None), (Again, side, low, None), (Again, front, sun, None)]);
            steps.extend([(Hold, front, sun, None), (Hold, side, sun, None)]);
            // Another volume in a hold, one while things move, and the first again.
            steps.extend([(Advance, front, sun, Some(&b))]);
            steps.extend(still(5));
            steps.extend([(Hold, front, sun, Some(&a)), (Advance, front, sun, None), (Advance, side, sun, Some(&b))]);
            steps.extend([(Restart, front, low, None), (Advance, front, low, None), (Hold, front, low, None)]);
            assert_skipping(&format!("{shadow:?}, fade {fade}"), &effect(settings, false), &steps, true);
        }
    }
}

#[test]
fn skipping_changes_nothing_in_motion() {
    use Sequence::{Advance, Hold, Restart};
    let volumes: Vec<Volume> = (0..6).map(|i| moving_puffs(20, i as f32 / 24.0)).collect();
    let nothing = volume([20; 3], [0.1; 3], [-1.0; 3], |_, _, _| 0.0);
    let nothing = Volume { velocity: Some(vec![[1.0, f32::NAN, 0.0]; 8000]), ..nothing };
    let lamp = point(1.5, 2.0, 1.0);
    let mut steps = vec![(Restart, camera(0.0), lamp, Some(&volumes[0]))];
    steps.extend(volumes.iter().skip(1).map(|volume| (Advance, camera(5.0), lamp, Some(volume))));
    // The last volume goes on; a hold; all die; all are born.
    steps.extend([(Advance, camera(5.0), lamp, None), (Hold, camera(50.0), lamp, None)]);
    steps.extend([(Hold, camera(50.0), lamp, None), (Advance, camera(50.0), lamp, Some(&nothing))]);
    steps.extend(vec![(Advance, camera(50.0), lamp, None); 8]);
    steps.extend([(Advance, camera(50.0), lamp, Some(&volumes[2])), (Advance, camera(50.0), lamp, None)]);
    let desc = Desc { point_light: true, ..effect(Settings { lifetime: Some(4), ..Settings::default() }, true) };
    assert_skipping("in motion", &desc, &steps, true);
}

fn frame_of_sequence(desc: &Desc, last: u32, rendered: impl Fn(u32) -> bool) -> Option<Bits> {
    let mut rig = Rig::new(desc.clone())?;
    for i in 0..=last {
        let volume = moving_puffs(20, i as f32 / 24.0);
        let sequence = if i == 0 { Sequence::Restart } else { Sequence::Advance };
        let light = direction(-1.0, -1.5, -1.0);
        let mut scene = scene(sequence, camera(4.0 * f64::from(i)), light, Some(&volume));
        scene.rendered = rendered(i);
        rig.frame(&scene);
    }
    Some(rig.bits())
}

#[test]
fn a_frame_alone_is_the_sequences() {
    let desc = effect(Settings { lifetime: Some(7), ..Settings::default() }, true);
    let Some(all) = frame_of_sequence(&desc, 11, |_| true) else { return };
    let Some(alone) = frame_of_sequence(&desc, 11, |i| i == 11) else { return };
    let Some(some) = frame_of_sequence(&desc, 11, |i| i % 2 == 1) else { return };
    assert_eq!(all.differences(&alone), []);
    assert_eq!(all.differences(&some), []);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let desc = effect(Settings::default(), true);
    let Some(once) = frame_of_sequence(&desc, 8, |_| true) else { return };
    let Some(again) = frame_of_sequence(&desc, 8, |_| true) else { return };
    let Some(other) = frame_of_sequence(&Desc { seed: 2, ..desc }, 8, |_| true) else { return };
    assert_eq!(once.differences(&again), []);
    assert!(!once.differences(&other).is_empty());
}

/// With a range of depth that is still on its way to that of the smoke.
#[test]
fn a_held_moment_is_drawn_as_it_was_until_the_camera_moves() {
    use Sequence::{Advance, Again, Hold, Restart};
    let volumes: Vec<Volume> = (0..3).map(|i| moving_puffs(20, i as f32)).collect();
    let (front, side, sun) = (camera(0.0), camera(20.0), direction(-1.0, -1.5, -1.0));
    let next = |i: usize| (if i == 0 { Restart } else { Advance }, front, sun, Some(&volumes[i]));
    let steps =
        [next(0), next(1), next(2), (Hold, front, sun, None), (Hold, front, sun, None), (Again, front, sun, None)];
    let desc = effect(Settings { range_smoothing: 0.9, ..Settings::default() }, true);
    let Some((frames, _)) = rendered(&desc, Effort::Needed, &steps) else { return };
    for held in &frames[3..] {
        assert!(frames[2] == *held, "(layer, words) that differ: {:?}", frames[2].differences(held));
    }
    assert!(frames[1] != frames[2]);
    // The way of the camera does not count, nor how long it took.
    let way = |cameras: &[Camera]| {
        let held = cameras.iter().map(|camera| (Hold, *camera, sun, None));
        rendered(&desc, Effort::Needed, &steps[..3].iter().copied().chain(held).collect::<Vec<_>>())
    };
    let Some((back, _)) = way(&[side, front]) else { return };
    let differing = back[4].differences(&frames[2]);
    // The range may be off by a rounding each way.
    assert!(differing.iter().all(|(_, words)| *words < 100), "{differing:?}");
}
