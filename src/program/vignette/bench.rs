//! Pass `darkness` in a full-HD picture.

use super::effect::{DARKNESS, Desc};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Row, Subject};
use crate::bench::{Outcome, Session};
use crate::offline::{Scene, TARGET_FORMAT};

const PASS: &str = "darkness";
const SIZE: [u32; 2] = [1920, 1080];
const NAME: &str = "1920x1080";
const VARIANTS: [(&str, f32); 2] = [("default", 0.75), ("all over", 0.0)];

pub(super) fn measure(session: &mut Session) -> Outcome {
    let variants = session.wanted(PASS, NAME, &VARIANTS);
    if variants.is_empty() {
        return Ok(());
    }
    session.next("vignette darkness")?;
    let pixels = SIZE[0] as usize * SIZE[1] as usize;
    let (mut effects, mut found) = (Vec::new(), Vec::new());
    for (_, radius) in &variants {
        let desc = Desc { size: SIZE, target_format: TARGET_FORMAT, strength: 0.5, radius: *radius };
        let effect = session.rig.effect(desc)?;
        session.rig.frame(effect, &Scene { rendered: true, ..Scene::default() })?;
        let darkness: Vec<f32> = session.rig.read(effect, DARKNESS, pixels)?;
        let expected = (0..pixels).map(|pixel| darkness_at(pixel, f64::from(*radius)));
        let differences = darkness.iter().zip(expected).map(|(d, expected)| (f64::from(*d) - expected).abs()).collect();
        found.push(Deviation::of(differences).map(|deviation| (deviation, "f64, share of black".to_owned())));
        effects.push((effect, session.rig.steps(effect, |pass| pass.name == "vignette.darkness")));
    }
    let rig = &mut session.rig;
    let times = interleaved(variants.len(), session.quick, |i| rig.replay(effects[i].0, &effects[i].1))?;
    for ((((variant, _), times), accuracy), (effect, plan)) in variants.iter().zip(&times).zip(&found).zip(effects) {
        let work = session.rig.work_of_replay(effect, &plan)?;
        let (variant, workload) = ((*variant).to_owned(), NAME.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: pixels as u64 };
        session.rows.push(Row::new("vignette", subject, times, accuracy, work, &session.limits));
    }
    session.rig.clear();
    Ok(())
}

/// Half of the smooth step from the radius to the corner.
fn darkness_at(pixel: usize, radius: f64) -> f64 {
    let [width, height] = SIZE.map(|side| side as usize);
    let [x, y] =
        [(pixel % width, width), (pixel / width, height)].map(|(at, side)| (2.0 * at as f64 + 1.0) / side as f64 - 1.0);
    let way = ((x.hypot(y) / 2.0_f64.sqrt() - radius) / (1.0 - radius)).clamp(0.0, 1.0);
    0.5 * way * way * (3.0 - 2.0 * way)
}
