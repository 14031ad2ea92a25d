//! The repetitions against the image that they converge to.

use celfx::flame::settings::Mode;

use crate::cases::{Case, apart, plain, rgb, settings};
use crate::common::flame::FlameRig;

/// The case in repetitions.
pub fn repeated(case: &Case, repetitions: u32) -> Case {
    case.with(|s| (s.mode, s.repetitions) = (Mode::Stochastic, repetitions))
}

/// Sums of mean RGB over the picture.
fn light(rig: &mut FlameRig) -> f64 {
    rgb(&rig.mean()).into_iter().flatten().sum()
}

#[test]
fn noise_falls_with_the_square_root_of_the_repetitions() {
    let case = plain();
    let Some(mut expected) = case.render() else { return };
    let truth = rgb(&expected.mean());
    let mut points = Vec::new();
    for power in 0..=5 {
        let repetitions = 1_u32 << (2 * power);
        let Some(mut rig) = repeated(&case, repetitions).render() else { return };
        let [rms, _] = apart(&rig.mean(), &truth);
        println!("{repetitions} repetitions: {rms:.2e} RMS");
        points.push([f64::from(repetitions).ln(), rms.ln()]);
    }
    let n = points.len() as f64;
    let [x, y] = [0, 1].map(|c| points.iter().map(|p| p[c]).sum::<f64>() / n);
    let (top, bottom) =
        points.iter().fold((0.0, 0.0), |(top, bottom), p| (top + (p[0] - x) * (p[1] - y), bottom + (p[0] - x).powi(2)));
    let slope = top / bottom;
    println!("slope {slope:.3}");
    // Some 200 independent spots of 5 pixels: each RMS scatters by 5 %, the slope over 5 factors of 4 by 0.01; what the
    // table leaves is a third of the noise of the last, which flattens the slope by as much.
    assert!((slope + 0.5).abs() < 0.04, "{slope}");
}

/// What is left of the difference when the noise, which the variance tells, is taken off.
#[test]
fn there_is_no_floor_under_the_noise() {
    let case = plain();
    let Some(mut expected) = case.render() else { return };
    let truth = rgb(&expected.mean());
    let repetitions = 16_384;
    let Some(mut rig) = repeated(&case, repetitions).render() else { return };
    let [rms, _] = apart(&rig.mean(), &truth);
    let variance = rig.variance().iter().flat_map(|v| [v[0], v[1], v[2]]).map(f64::from).sum::<f64>();
    let noise = variance / (3 * truth.len()) as f64 / f64::from(repetitions);
    let floor = (rms * rms - noise).max(0.0).sqrt();
    println!("{repetitions} repetitions: {rms:.2e} RMS, noise {:.2e}, floor {floor:.2e}", noise.sqrt());
    // The specified bound, and what is not known of the noise: a tenth of its square.
    assert!(floor * floor < 5e-4 * 5e-4 + 0.1 * noise, "{floor}");
}

#[test]
fn the_mean_is_as_bright_as_that_of_repetitions() {
    for case in [crate::cases::near(), crate::cases::usual()] {
        let Some(mut expected) = case.render() else { return };
        let Some(mut rig) = repeated(&case, 1024).render() else { return };
        let [all, own] = [light(&mut rig), light(&mut expected)];
        println!("{}: {:.4} of the brightness of 1024 repetitions", case.name, own / all);
        // 1024 repetitions know it to some 2e-3.
        assert!((own / all - 1.0).abs() < 0.01, "{}: {own} of {all}", case.name);
    }
}

/// The expected image has no octaves. Repetitions that have them keep the mean of the mask, not quite what passes of it.
#[test]
fn octaves_change_little_of_the_light() {
    // Most sprites are some 150 pixels wide.
    let case = crate::cases::near().with(|s| s.size = Some(6.0));
    let with = |octaves| Some(light(&mut repeated(&case, 256).with(|s| s.octaves = octaves).render()?));
    let (Some(without), Some(with)) = (with(0), with(6)) else { return };
    println!("with octaves: {:.4} of the light", with / without);
    assert!(with != without && (with / without - 1.0).abs() < 0.1, "{with} of {without}");
}

#[test]
fn variance_is_that_of_repetitions() {
    let case = Case::new("variance", [32, 24], 40, settings(), crate::common::scenes::camera(25.0));
    let Some(mut expected) = case.render() else { return };
    let Some(mut rig) = repeated(&case, 8192).render() else { return };
    let (own, sample) = (expected.variance(), rig.variance());
    assert!(own.iter().all(|v| v[3] == 0.0) && sample.iter().all(|v| v[3] == 8192.0));
    let sum = |all: &[[f32; 4]]| all.iter().flat_map(|v| [v[0], v[1], v[2]]).map(f64::from).sum::<f64>();
    let ratio = sum(&own) / sum(&sample);
    println!("variance: {ratio:.4} of that of the sample, {:?} RMS", apart(&own, &rgb(&sample)));
    // A sample of 8192 knows its variance to 2 % a pixel, to some 1e-3 over the picture.
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}
