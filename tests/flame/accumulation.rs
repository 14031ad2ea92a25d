//! Frames that add up are one frame with all of their repetitions.

use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::offline::Scene;

use crate::common::flame::{FlameRig, ball, desc, scene};
use crate::common::scenes::camera;
use crate::determinism::bits;
use crate::oracle::{Shot, control};

fn base() -> Settings {
    Settings { repetitions: 60, count: 5.0, spread: Some(0.15), size: Some(0.25), ..Settings::paper() }
}

#[test]
fn frames_add_up_bit_for_bit() {
    let wall: Vec<f32> = (0..50 * 37).map(|i| if i % 50 < 20 { 3.9 } else { f32::INFINITY }).collect();
    for has_scene in [false, true] {
        let depth = has_scene.then_some(wall.as_slice());
        let desc = desc([50, 37], 80, Settings { repetitions: 60, flicker: 0.3, ..base() });
        let desc = Desc { scene: has_scene.then_some(SceneFormat::Buffer), ..desc };
        let particles = ball(80, 3);
        let shot = Shot { number: 5, depth, ..Shot::new(&particles, camera(0.0)) };
        let Some(mut whole) = FlameRig::new(desc.clone()) else { return };
        whole.render(&shot.scene());
        let whole = bits(&mut whole);
        for (each, frames) in [(15, 4), (1, 60)] {
            let settings = Settings { repetitions: each, ..desc.settings.clone() };
            let Some(mut parts) = FlameRig::new(Desc { settings, ..desc.clone() }) else { return };
            // What was added up before this is forgotten.
            let elsewhere = Scene { camera: camera(90.0), ..shot.scene() };
            parts.render(&elsewhere);
            parts.render(&Scene { accumulate: true, particles: None, ..elsewhere });
            for i in 0..frames {
                parts.render(&Scene { accumulate: i > 0, particles: (i == 0).then_some(&particles), ..shot.scene() });
            }
            assert_eq!(whole.differences(&bits(&mut parts)), [], "{frames} of {each}");
        }
    }
}

/// Repetitions that take several dispatches, added to others that do.
#[test]
fn parts_add_up() {
    let particles = ball(100, 3);
    let desc = |repetitions| desc([40, 33], 100, Settings { repetitions, count: 25.0, ..base() });
    let Some(mut whole) = FlameRig::new(desc(120)) else { return };
    whole.frame(&particles, camera(0.0));
    let Some(mut halves) = FlameRig::new(desc(60)) else { return };
    halves.frame(&particles, camera(0.0));
    halves.render(&Scene { accumulate: true, ..scene(None, camera(0.0)) });
    for rig in [&mut whole, &mut halves] {
        let at_once = control(rig).part_repetitions;
        assert!(at_once < 60, "{at_once} in one dispatch");
    }
    assert_eq!(bits(&mut whole).differences(&bits(&mut halves)), []);
}

#[test]
fn only_what_is_the_same_is_added_to() {
    let particles = ball(80, 3);
    let desc = desc([50, 37], 80, Settings { repetitions: 600_000, count: 0.0, ..base() });
    let refused = |rig: &mut FlameRig, scene: &Scene, why: &str| {
        let text = rig.offline().frame(scene).expect_err(why).to_string();
        assert!(text.contains("accumulate") && text.contains(why), "{text}");
    };
    let still = Scene { accumulate: true, ..scene(None, camera(0.0)) };
    let Some(mut rig) = FlameRig::new(desc.clone()) else { return };
    refused(&mut rig, &Scene { particles: Some(&particles), ..still }, "nothing to add to");
    rig.frame(&particles, camera(0.0));
    refused(&mut rig, &Scene { particles: Some(&particles), ..still }, "not with new particles");
    refused(&mut rig, &Scene { camera: camera(1.0), ..still }, "not with another view");
    refused(&mut rig, &still, "1048576");
    let settings = Settings { adaptive: 0.1, repetitions: 60, ..desc.settings.clone() };
    let Some(mut adaptive) = FlameRig::new(Desc { settings, ..desc }) else { return };
    adaptive.frame(&particles, camera(0.0));
    refused(&mut adaptive, &still, "adaptive");
}

/// A frame that is refused leaves what was added up before.
#[test]
fn refusals_change_nothing() {
    let particles = ball(80, 3);
    let Some(mut rig) = FlameRig::new(desc([50, 37], 80, base())) else { return };
    let still = Scene { accumulate: true, ..scene(None, camera(0.0)) };
    rig.frame(&particles, camera(0.0));
    rig.render(&still);
    let expected = bits(&mut rig);
    rig.frame(&particles, camera(0.0));
    rig.offline().frame(&Scene { camera: camera(1.0), ..still }).expect_err("another camera");
    rig.render(&still);
    assert_eq!(expected.differences(&bits(&mut rig)), []);
}
