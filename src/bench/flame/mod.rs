//! The flame effect: repetitions against the integral, against the paper's own way and against blending; whole frames.

mod accumulate;
mod frame;
mod rivals;
mod scene;
mod truth;

use super::rig::{EffectId, Rig};
use super::{Outcome, Session};
use crate::error::Result;
use crate::plan::Plan;

/// Name of the effect in rows.
const EFFECT: &str = "flame";

pub(crate) fn measure(session: &mut Session) -> Outcome {
    accumulate::measure(session)?;
    frame::measure(session)
}

/// What the shape of the fire's kernels is chosen by: repetitions, and the expected image.
pub(crate) fn accumulations(rig: &mut Rig, quick: bool) -> Result<[(EffectId, Plan); 2]> {
    accumulate::accumulations(rig, &scene::Scene::new(&scene::PAPER, quick))
}
