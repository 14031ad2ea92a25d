//! `celfx bench calibrate`: which of several ways to the same bits is the fastest on a device, as the table that
//! [`crate::tuning::Tuning`] is read from.

use std::fmt::Write as _;

use super::measure::interleaved;
use super::rig::Rig;
use super::{BenchError, Request, Watch, flame, smoke};
use crate::gpu::headless::Headless;
use crate::tuning::{GrowCosts, Tuning};

/// Measures, and prints the table.
///
/// # Errors
/// No device, a failure of the device, an interruption.
pub fn calibrate(request: &Request, watch: &dyn Watch) -> Result<String, BenchError> {
    let mut rig = Rig::new(Headless::new(&request.device)?)?;
    let (device, driver) = rig.device();
    let mut tuning = rig.tuning();
    let mut notes =
        format!("# Measured on {device}, {driver}.\n# For celfx --tuning FILE, or as celfx::tuning::Tuning.\n");
    let next = |text: &str| match watch.is_interrupted() {
        true => Err(BenchError::Interrupted),
        false => {
            watch.progress(text);
            Ok(())
        }
    };
    next("calibrate: the fire")?;
    shape_fire(&mut rig, request.quick, &mut tuning, &mut notes)?;
    let mut samples = Vec::new();
    for (side, particles) in VOLUMES.into_iter().filter(|(side, _)| !request.quick || *side <= 64) {
        next(&format!("calibrate: smoke, {particles} particles in {side}^3 voxels"))?;
        samples.push(Sample::new(&mut rig, request.quick, side, particles)?);
    }
    tuning.grow = fitted(&samples);
    write_samples(&mut notes, &samples);
    let table = toml::to_string(&tuning).unwrap_or_default();
    Ok(format!("{notes}{table}"))
}

/// Invocations that may share a tile.
const SHAPES: [u32; 4] = [32, 64, 128, 256];

/// Volumes and particles that searches are compared in.
const VOLUMES: [(u32, u32); 8] =
    [(16, 500), (16, 10_000), (32, 2000), (64, 500), (64, 10_000), (128, 2000), (128, 50_000), (256, 10_000)];

/// The fastest shape of the fire's kernels: by repetitions and the expected image together.
fn shape_fire(rig: &mut Rig, quick: bool, tuning: &mut Tuning, notes: &mut String) -> Result<(), BenchError> {
    let ways: Vec<(u32, u32)> = [1, 2].into_iter().flat_map(|kernels| SHAPES.map(|shape| (shape, kernels))).collect();
    let mut runs = Vec::new();
    for (tile_invocations, mask_kernels) in &ways {
        let way = Tuning { tile_invocations: *tile_invocations, mask_kernels: *mask_kernels, ..*tuning };
        rig.tune(Some(way));
        runs.push(flame::accumulations(rig, quick)?);
    }
    rig.tune(None);
    let repetitions = interleaved(ways.len(), quick, |i| rig.replay(runs[i][0].0, &runs[i][0].1))?;
    let expected = interleaved(ways.len(), quick, |i| rig.replay(runs[i][1].0, &runs[i][1].1))?;
    rig.clear();
    let _ = writeln!(notes, "# The fire: invocations a tile, kernels; ms of 16 repetitions and of the expected image.");
    let mut best = f64::INFINITY;
    for (((tile_invocations, mask_kernels), repetitions), expected) in ways.iter().zip(&repetitions).zip(&expected) {
        let (a, b) = (repetitions.gpu_ms, expected.gpu_ms);
        let _ = writeln!(notes, "#   {tile_invocations:3} {mask_kernels}: {a:9.3} {b:9.3}");
        if a * b < best {
            best = a * b;
            (tuning.tile_invocations, tuning.mask_kernels) = (*tile_invocations, *mask_kernels);
        }
    }
    Ok(())
}

/// Microseconds of each search in a volume; the paper's loop only in small ones.
struct Sample {
    side: u32,
    particles: u32,
    field: f64,
    pyramid: f64,
    growth: Option<f64>,
}

impl Sample {
    fn new(rig: &mut Rig, quick: bool, side: u32, particles: u32) -> Result<Sample, BenchError> {
        let has_growth = side <= 16;
        let runs = smoke::searches(rig, side, particles, has_growth)?;
        let times = interleaved(runs.len(), quick, |i| rig.replay(runs[i].0, &runs[i].1))?;
        rig.clear();
        let microseconds = |index: usize| times.get(index).map(|time: &super::measure::Spread| 1e3 * time.gpu_ms);
        let (field, pyramid) = (microseconds(0).unwrap_or_default(), microseconds(1).unwrap_or_default());
        Ok(Sample { side, particles, field, pyramid, growth: microseconds(2) })
    }
}

fn write_samples(notes: &mut String, samples: &[Sample]) {
    let _ = writeln!(notes, "# Radii: voxels a side, particles; ms with field, pyramid, growth.");
    for Sample { side, particles, field, pyramid, growth } in samples {
        let growth = growth.map_or("-".into(), |growth| format!("{:.3}", 1e-3 * growth));
        let (field, pyramid) = (1e-3 * field, 1e-3 * pyramid);
        let _ = writeln!(notes, "#   {side:3} {particles:6}: {field:9.3} {pyramid:9.3} {growth:>9}");
    }
}

/// The costs that come nearest to what was measured, by their ratio.
fn fitted(samples: &[Sample]) -> GrowCosts {
    let of = |sample: &Sample| (f64::from(sample.side), f64::from(sample.particles));
    let field = least_squares(samples.iter().map(|sample| {
        let (side, particles) = of(sample);
        ([1.0, side.powi(3), particles], sample.field)
    }));
    let pyramid = least_squares(samples.iter().map(|sample| {
        let (side, particles) = of(sample);
        let levels = f64::from(sample.side.next_power_of_two().ilog2() + 1);
        ([1.0, levels, side, particles, side * particles], sample.pyramid)
    }));
    let growth = least_squares(samples.iter().filter_map(|sample| {
        let (_, particles) = of(sample);
        Some(([1.0, particles], sample.growth?))
    }));
    GrowCosts {
        growth_base: growth[0],
        growth_particle: growth[1],
        field_base: field[0],
        field_voxel: field[1],
        field_particle: field[2],
        pyramid_base: pyramid[0],
        pyramid_level: pyramid[1],
        pyramid_side: pyramid[2],
        pyramid_particle: pyramid[3],
        pyramid_visit: pyramid[4],
    }
}

/// The factors, none below 0, whose sums of products differ least from what was measured, as shares of it: by coordinate
/// descent, which ends at the least of a convex sum.
fn least_squares<const N: usize>(rows: impl Iterator<Item = ([f64; N], f64)>) -> [f64; N] {
    let scale = |(row, measured): ([f64; N], f64)| row.map(|x| x / measured.max(1e-9));
    let rows: Vec<[f64; N]> = rows.map(scale).collect();
    let mut factors = [0.0; N];
    for _ in 0..20_000 {
        for i in 0..N {
            let square: f64 = rows.iter().map(|row| row[i] * row[i]).sum();
            let rest = |row: &[f64; N]| 1.0 - (0..N).filter(|j| *j != i).map(|j| row[j] * factors[j]).sum::<f64>();
            let along: f64 = rows.iter().map(|row| row[i] * rest(row)).sum();
            factors[i] = if square > 0.0 { (along / square).max(0.0) } else { 0.0 };
        }
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What costs predict is fitted by these costs again.
    #[test]
    fn costs_are_found_from_what_they_cost() {
        let costs = GrowCosts::CPU;
        let samples: Vec<Sample> = VOLUMES
            .into_iter()
            .map(|(side, particles)| {
                let (voxels, count) = (f64::from(side).powi(3), f64::from(particles));
                let levels = side.ilog2() + 1;
                let growth = (side <= 16).then(|| costs.growth(count));
                let (field, pyramid) = (costs.field(count, voxels), costs.pyramid(count, voxels, levels));
                Sample { side, particles, field, pyramid, growth }
            })
            .collect();
        let found = fitted(&samples);
        for sample in &samples {
            let (voxels, count) = (f64::from(sample.side).powi(3), f64::from(sample.particles));
            let levels = sample.side.ilog2() + 1;
            let ratios = [
                found.field(count, voxels) / sample.field,
                found.pyramid(count, voxels, levels) / sample.pyramid,
                sample.growth.map_or(1.0, |growth| found.growth(count) / growth),
            ];
            // The descent ends before the last digits.
            assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.02), "{ratios:?}");
        }
    }

    #[test]
    fn a_table_that_was_printed_is_read_back() {
        for tuning in [Tuning::CPU, Tuning::GPU] {
            let text = toml::to_string(&tuning).expect("a table");
            assert_eq!(toml::from_str::<Tuning>(&text).expect("the same"), tuning);
            assert!(toml::from_str::<Tuning>(&format!("unknown = 1\n{text}")).is_err());
        }
        let wrong = Tuning { tile_invocations: 48, ..Tuning::CPU };
        assert!(wrong.validate().is_err_and(|error| error.to_string().contains("32, 64, 128 or 256")));
    }
}
