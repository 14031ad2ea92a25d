//! How much there may be of everything, and how repetitions are cut into dispatches within the loop budget.

use crate::effect::DeviceTraits;
use crate::error::{Error, Result};
use crate::flame::desc::Desc;
use crate::flame::settings::{Method, Mode, Sampling, Settings};
use crate::shaders::flame::constants::MOST_COUNT;

/// Depth buckets of the stochastic mode.
pub const BUCKETS: u32 = 32;
/// Loop iterations that an invocation may take for a tile's list: less than [`crate::layout::LOOP_BUDGET`], for what leads up to it.
pub const ITERATIONS: u32 = 44_000;
/// Repetitions after which a tile is looked at for the first time with `adaptive`.
pub const FIRST_STAGE: u32 = 16;
/// The most dispatches of a frame's repetitions.
pub const MOST_PARTS: u64 = 1 << 15;
/// The most repetitions that are drawn one after the other.
const MOST_DRAWN: u32 = 4096;
/// Loop iterations of what an invocation does with a tile's list in a repetition, or in a bin of the expected image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Whatever is in the list.
    pub base: u32,
    /// For each entry.
    pub visit: u32,
    /// For each of the entry's render particles, in eighths.
    pub eighths: u32,
}

impl Cost {
    /// The most that the kernels of this effect take.
    pub fn new(desc: &Desc) -> Cost {
        match (desc.settings.mode, desc.settings.sampling) {
            // A batch of 32 entries looks them up in up to 12 lists; a round makes 32 sprites in 3 iterations, each of which a
            // column of pixels then tests at most once. The last round of a batch, and the last batch, may be short.
            (Mode::Stochastic, Sampling::Independent) => Cost { base: 48, visit: 1, eighths: 9 },
            // And a round's Sobol points take up to 20 iterations.
            (Mode::Stochastic, Sampling::ShuffledSobol) => Cost { base: 48, visit: 2, eighths: 14 },
            // A particle meets the 8 pixels of a column.
            (Mode::Expected, _) => Cost { base: 48, visit: 11, eighths: 0 },
        }
    }
}

/// A run of repetitions after which tiles may be done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stage {
    /// Its first repetition.
    pub first: u32,
    /// The one after its last.
    pub last: u32,
    /// Dispatches that it may need.
    pub parts: u32,
    /// Its place in the dispatches' arguments.
    pub arguments: u32,
}

impl Stage {
    /// Repetitions that are drawn, where it has no dispatches.
    pub fn drawn(&self) -> u32 {
        if self.parts == 0 { self.last - self.first } else { 0 }
    }
}

/// Loop iterations that an invocation may take for a tile's list on a device with these traits.
pub fn iterations(traits: &DeviceTraits) -> u32 {
    if traits.ends_loops { ITERATIONS } else { u32::MAX }
}

/// Kernels that repetitions are made with: each has a dispatch of its own.
pub fn kernels(desc: &Desc, traits: &DeviceTraits) -> u32 {
    if desc.settings.is_expected() { 1 } else { traits.tuning.mask_kernels }
}

/// Parts that the longest possible list asks for, and how many repetitions or bins one of them does.
fn parts(desc: &Desc, traits: &DeviceTraits) -> (u64, u64) {
    if !traits.ends_loops {
        return (1, u64::MAX);
    }
    let particles = u64::from(desc.particles.max(1));
    let cost = Cost::new(desc);
    let visit = u64::from(cost.visit) + (most_count(desc) * u64::from(cost.eighths)).div_ceil(8);
    let segments = particles.div_ceil((u64::from(ITERATIONS - cost.base) / visit).max(1));
    let of_all = u64::from(cost.base) + particles * visit;
    (segments, if segments > 1 { 1 } else { (u64::from(ITERATIONS) / of_all).max(1) })
}

/// Repetitions, or the bins of the expected image, are done in as many dispatches as the longest possible list asks for.
pub fn stages(desc: &Desc, traits: &DeviceTraits) -> Result<Vec<Stage>> {
    let settings = &desc.settings;
    let expected = settings.is_expected();
    let (segments, at_once) = parts(desc, traits);
    let all = if expected { settings.bins } else { settings.repetitions };
    if is_raster(desc) {
        // No dispatches, but all of the repetitions.
        check_raster(desc)?;
        return Ok(vec![Stage { last: settings.repetitions, ..Stage::default() }]);
    }
    let mut ends = Vec::new();
    if settings.is_adaptive() && !expected {
        ends.extend((0..).map(|i| FIRST_STAGE << i).take_while(|end| *end < all));
    }
    ends.push(all);
    let (mut first, mut arguments, mut sum, mut stages) = (0, 0, 0_u64, Vec::new());
    for last in ends {
        let parts = segments * u64::from(last - first).div_ceil(at_once);
        sum += parts;
        let parts = parts.min(MOST_PARTS) as u32;
        stages.push(Stage { first, last, parts, arguments });
        (first, arguments) = (last, arguments + kernels(desc, traits) * parts);
    }
    match sum > MOST_PARTS {
        true => Err(Error::Limit {
            what: "the flame (dispatches over the longest list possible)",
            needed: sum,
            limit: MOST_PARTS,
            advice: match expected {
                true => "use fewer particles or fewer flame.bins",
                false => "use fewer particles, a smaller flame.count or fewer flame.repetitions",
            },
        }),
        false => Ok(stages),
    }
}

/// A step a repetition must be recorded.
fn check_raster(desc: &Desc) -> Result<()> {
    let Settings { repetitions, adaptive, .. } = desc.settings;
    match () {
        _ if repetitions > MOST_DRAWN => {
            let allowed = "1 to 4096 with method = \"raster\"";
            Err(Error::setting("flame.repetitions", repetitions, allowed))
        }
        _ if desc.settings.is_adaptive() => {
            Err(Error::setting("flame.adaptive", adaptive, "0 with method = \"raster\""))
        }
        _ => Ok(()),
    }
}

/// Whether repetitions are drawn, one after the other.
pub fn is_raster(desc: &Desc) -> bool {
    !desc.settings.is_expected() && desc.settings.method == Method::Raster
}

/// The most render particles that a particle can have.
pub fn most_count(desc: &Desc) -> u64 {
    let settings = &desc.settings;
    let mean = f64::from(settings.count) * f64::from(desc.hottest) / f64::from(settings.hottest);
    // Rounding may differ on the device.
    (mean * 1.000001).min(f64::from(MOST_COUNT)) as u64 + 1
}

/// Depth buckets of an effect.
pub fn buckets(mode: Mode, bins: u32) -> u32 {
    match mode {
        Mode::Stochastic => BUCKETS,
        Mode::Expected => bins,
    }
}
