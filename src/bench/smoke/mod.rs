//! The smoke effect: how radii are searched, the masked Gaussian, shadows, whole frames.

mod frame;
mod gaussian;
mod grow;
pub(super) mod scene;
mod shadow;

use super::{Outcome, Session};
pub(super) use grow::searches;

/// Name of the effect in rows.
const EFFECT: &str = "smoke";

pub(crate) fn measure(session: &mut Session) -> Outcome {
    grow::measure(session)?;
    gaussian::measure(session)?;
    shadow::measure(session)?;
    frame::measure(session)
}
