//! No frame needs what scratch memory held before it: it may be anything.

use celfx::flame::settings::{Mode, Sampling};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;

use crate::common::flame::{FlameRig, desc, embers, particles, scene};
use crate::common::rig::{Bits, unaffected_by_poison};
use crate::common::scenes::camera;
use crate::determinism;

const SIZE: [u32; 2] = [40, 30];

/// All of each frame; of one that keeps no layers, its picture. Particles come where they change, some cannot be seen, views
/// change, and frames add to those before where they may.
fn frames(desc: &Desc, poison: Option<u32>) -> Option<Vec<Bits>> {
    let wall: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(|i| if i % SIZE[0] < 16 { 3.9 } else { f32::INFINITY }).collect();
    let depth = desc.scene.is_some().then_some(wall.as_slice());
    let (some, others, cold) = (embers(50, 1), embers(30, 2), particles(&[[0.0, 0.0, 0.0, 200.0]]));
    let (front, side) = (camera(0.0), camera(60.0));
    let adds = desc.accumulates && desc.settings.adaptive == 0.0;
    let steps = [
        (Some(&cold), front, false),
        (Some(&some), front, false),
        (None, front, false),
        (None, front, adds),
        (None, front, adds),
        (None, side, false),
        (Some(&cold), side, false),
        (Some(&others), side, false),
        (None, side, adds),
    ];
    let mut rig = FlameRig::new(desc.clone())?;
    rig.poison = poison;
    let frames = steps.iter().map(|(particles, camera, accumulate)| {
        rig.render(&Scene { depth, accumulate: *accumulate, ..scene(*particles, *camera) });
        match desc.layers {
            true => determinism::bits(&mut rig),
            false => {
                let mut bits = Bits::default();
                bits.push("picture", &rig.picture());
                bits
            }
        }
    });
    Some(frames.collect())
}

#[test]
fn frames_need_nothing_of_scratch() {
    let base = Settings { repetitions: 12, count: 4.0, spread: Some(0.15), size: Some(0.3), ..Settings::paper() };
    let base = desc(SIZE, 50, base);
    let with = |settings: Settings| Desc { settings, ..base.clone() };
    let own = || base.settings.clone();
    let expected = with(Settings { mode: Mode::Expected, ..own() });
    let cases = [
        base.clone(),
        Desc { accumulates: false, ..base.clone() },
        Desc { layers: false, ..base.clone() },
        Desc { scene: Some(SceneFormat::Buffer), layers: false, ..with(Settings { light: 2.0, ..own() }) },
        Desc { layers: false, accumulates: false, ..with(Settings { adaptive: 0.05, repetitions: 60, ..own() }) },
        Desc { layers: false, ..with(Settings { sampling: Sampling::ShuffledSobol, flicker: 0.3, ..own() }) },
        // So many sprites that a repetition is cut into parts.
        Desc { layers: false, ..with(Settings { count: 2000.0, repetitions: 2, ..own() }) },
        expected.clone(),
        Desc { layers: false, accumulates: false, scene: Some(SceneFormat::Buffer), ..expected },
    ];
    for desc in cases {
        unaffected_by_poison(&format!("{desc:?}"), |poison| frames(&desc, poison));
    }
}
