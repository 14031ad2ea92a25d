//! Runs what is compared in turns, and what comes out of it: medians, quartiles, errors. Pure but for the closure.

use glam::DVec3;

use super::rig::Measured;
use crate::error::Result;

/// Runs of each variant.
const RUNS: usize = 7;
/// Enough once a variant has taken [`LONG_MS`].
const FEW_RUNS: usize = 3;
const LONG_MS: f64 = 20_000.0;

/// Times of one variant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    /// Median.
    pub(crate) gpu_ms: f64,
    /// First quartile.
    pub(crate) low: f64,
    /// Third quartile.
    pub(crate) high: f64,
    /// Median of the recording.
    pub(crate) cpu_ms: f64,
    pub(crate) runs: u32,
}

/// Runs variants 0 .. `variants` in turns, so that whatever else the machine does meets all of them: 7 runs each, 3 of
/// one that has taken 20 s, 1 if `quick`.
pub(crate) fn interleaved(
    variants: usize,
    quick: bool,
    mut run: impl FnMut(usize) -> Result<Measured>,
) -> Result<Vec<Spread>> {
    let mut times: Vec<Vec<Measured>> = vec![Vec::new(); variants];
    loop {
        let mut ran = false;
        for (variant, times) in times.iter_mut().enumerate() {
            if is_enough(times, quick) {
                continue;
            }
            times.push(run(variant)?);
            ran = true;
        }
        if !ran {
            return Ok(times.iter().map(|times| spread(times)).collect());
        }
    }
}

fn is_enough(times: &[Measured], quick: bool) -> bool {
    let taken: f64 = times.iter().map(|time| time.gpu_ms).sum();
    let needed = match () {
        _ if quick => 1,
        _ if taken >= LONG_MS => FEW_RUNS,
        _ => RUNS,
    };
    times.len() >= needed
}

fn spread(times: &[Measured]) -> Spread {
    let mut gpu: Vec<f64> = times.iter().map(|time| time.gpu_ms).collect();
    let mut cpu: Vec<f64> = times.iter().map(|time| time.cpu_ms).collect();
    Spread {
        gpu_ms: quantile(&mut gpu, 0.5),
        low: quantile(&mut gpu, 0.25),
        high: quantile(&mut gpu, 0.75),
        cpu_ms: quantile(&mut cpu, 0.5),
        runs: times.len() as u32,
    }
}

/// The share `q` of the values lies below it, linear between values; 0 of none.
fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return 0.0 };
    let place = q.clamp(0.0, 1.0) * last as f64;
    let (below, share) = (place.floor() as usize, place.fract());
    let above = (below + 1).min(last);
    values[below] * (1.0 - share) + values[above] * share
}

/// How far results are from what they should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deviation {
    /// Root of the mean square.
    pub(crate) rms: f64,
    /// 99 % are not above it.
    pub(crate) p99: f64,
    pub(crate) max: f64,
}

impl Deviation {
    /// Of absolute differences; none of none.
    pub(crate) fn of(mut differences: Vec<f64>) -> Option<Deviation> {
        let count = differences.len();
        if count == 0 {
            return None;
        }
        let squares: f64 = differences.iter().map(|d| d * d).sum();
        let place = (count * 99).div_ceil(100).max(1) - 1;
        let (_, p99, _) = differences.select_nth_unstable_by(place, f64::total_cmp);
        let p99 = *p99;
        let max = differences.iter().copied().fold(0.0, |a, b| if b.total_cmp(&a).is_gt() { b } else { a });
        Some(Deviation { rms: (squares / count as f64).sqrt(), p99, max })
    }
}

/// Lightness and two opponent colours of a linear sRGB colour (Ottosson 2020): equal distances look equal.
pub(crate) fn oklab([r, g, b, _]: [f32; 4]) -> DVec3 {
    let [r, g, b] = [r, g, b].map(f64::from);
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    DVec3::new(
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(gpu_ms: f64) -> Measured {
        Measured { gpu_ms, cpu_ms: gpu_ms / 10.0 }
    }

    #[test]
    fn quantiles_are_linear_between_values() {
        assert_eq!(quantile(&mut [], 0.5), 0.0);
        assert_eq!(quantile(&mut [3.0], 0.25), 3.0);
        assert_eq!(quantile(&mut [4.0, 1.0, 2.0, 3.0], 0.5), 2.5);
        assert_eq!(quantile(&mut [5.0, 1.0, 2.0, 4.0, 3.0], 0.25), 2.0);
        assert_eq!(quantile(&mut [5.0, 1.0], 1.0), 5.0);
    }

    #[test]
    fn variants_take_turns_and_slow_ones_run_less() -> Result<()> {
        let mut order = Vec::new();
        let spreads = interleaved(3, false, |variant| {
            order.push(variant);
            Ok(time([1.0, 8_000.0, 25_000.0][variant]))
        })?;
        assert_eq!(spreads.map_runs(), [7, 3, 3]);
        assert_eq!(order[..9], [0, 1, 2, 0, 1, 2, 0, 1, 2]);
        let quick = interleaved(2, true, |variant| Ok(time(variant as f64)))?;
        assert_eq!(quick.map_runs(), [1, 1]);
        assert_eq!((quick[1].gpu_ms, quick[1].low, quick[1].high, quick[1].cpu_ms), (1.0, 1.0, 1.0, 0.1));
        Ok(())
    }

    trait Runs {
        fn map_runs(&self) -> Vec<u32>;
    }

    impl Runs for Vec<Spread> {
        fn map_runs(&self) -> Vec<u32> {
            self.iter().map(|spread| spread.runs).collect()
        }
    }

    #[test]
    fn deviations() {
        assert_eq!(Deviation::of(vec![]), None);
        let mut differences = vec![0.0; 200];
        differences[7] = 2.0;
        differences[100] = 1.0;
        differences[150] = 0.5;
        // 198 of 200 are not above 0.5.
        let expected = Deviation { rms: (5.25_f64 / 200.0).sqrt(), p99: 0.5, max: 2.0 };
        assert_eq!(Deviation::of(differences), Some(expected));
        assert!(Deviation::of(vec![0.0, f64::NAN]).is_some_and(|d| d.max.is_nan() && d.rms.is_nan()), "NaN is no zero");
    }

    #[test]
    fn white_is_one_and_grey_has_no_colour() {
        assert!((oklab([1.0; 4]) - DVec3::X).length() < 1e-6);
        let grey = oklab([0.125, 0.125, 0.125, 1.0]);
        assert!((grey - 0.5 * DVec3::X).length() < 1e-6);
        assert!((oklab([1.0, 0.0, 0.0, 1.0]) - DVec3::new(0.627_955, 0.224_863, 0.125_846)).length() < 1e-5);
    }
}
