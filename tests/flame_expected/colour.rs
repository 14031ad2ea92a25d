//! Colours of particles on the device.

use celfx::flame::settings::Colour;
use celfx::flame::{Desc, Settings};
use celfx::low_level::flame::colour;
use celfx::low_level::flame::params::Particle;
use celfx::view::Camera;
use glam::DVec3;

use crate::common::flame::{FlameRig, desc, particles};

const COUNT: u32 = 4000;

/// Colours that the device gives to particles of these temperatures, whether they are seen or not.
fn colours(settings: &Settings, hottest: f32, temperatures: &[f32]) -> Option<Vec<(f32, [f32; 3])>> {
    let settings = Settings { repetitions: 1, count: 1.0, size: Some(0.01), ..settings.clone() };
    let mut rig = FlameRig::new(Desc { hottest, ..desc([8, 8], COUNT, settings) })?;
    let camera = Camera { eye: DVec3::ZERO, target: -DVec3::Z, ..Camera::default() };
    let rows: Vec<_> = temperatures.iter().map(|t| [0.0, 0.0, -50.0, *t]).collect();
    rig.frame(&particles(&rows), camera);
    let colour = |(t, p): (&f32, Particle)| (*t, [p.colour[0], p.colour[1], p.colour[2]]);
    Some(temperatures.iter().zip(rig.prepared()).map(colour).collect())
}

fn ramp() -> Vec<[f32; 3]> {
    vec![[0.0, 0.1, 0.3], [0.2, 0.0, 0.0], [1.0, 0.3, 0.0], [1.5, 1.2, 0.7], [0.9, 1.0, 1.0]]
}

/// Linear RGB at a temperature in kelvin.
type Formula = Box<dyn Fn(f64) -> [f64; 3]>;

/// Every way to colour, and its formula in f64.
fn ways() -> Vec<(Settings, Formula)> {
    let mut all: Vec<(Settings, Formula)> = Vec::new();
    for adaptation in [0.0_f32, 0.5, 1.0] {
        let a = f64::from(adaptation);
        let physical = Settings { colour: Colour::Physical, adaptation, ..Settings::paper() };
        all.push((physical, Box::new(move |t| colour::physical(t, 3000.0, a))));
        let displayable = Settings { adaptation, ..Settings::paper() };
        all.push((displayable, Box::new(move |t| colour::displayable(t, 3000.0, 2.0, a))));
    }
    let settings = Settings { colour: Colour::Ramp(ramp()), ..Settings::paper() };
    all.push((settings, Box::new(|t| colour::ramp(t, 3000.0, &ramp()))));
    all
}

#[test]
fn colours_are_those_of_the_formulas() {
    let temperatures: Vec<f32> = (0..COUNT).map(|i| 800.0 + 2200.0 * i as f32 / (COUNT - 1) as f32).collect();
    for (settings, formula) in ways() {
        let Some(found) = colours(&settings, 3000.0, &temperatures) else { return };
        let apart = |(t, c): &(f32, [f32; 3])| {
            let exact = formula(f64::from(*t));
            (0..3).map(|i| crate::common::apart(c[i], exact[i])).fold(0.0, f64::max)
        };
        let most = found.iter().map(apart).fold(0.0, f64::max);
        println!("{:?}, adaptation {}: {most:.1e} of f64", settings.colour, settings.adaptation);
        // The specified bound: 256 entries leave 2e-5 of the formula.
        assert!(most < 1e-4, "{:?}, adaptation {}: {most}", settings.colour, settings.adaptation);
    }
}

#[test]
fn colours_are_never_negative_and_end_where_they_should() {
    // 1 K to 1e6 K, evenly in the logarithm; and both sides of where glowing begins and of what is hottest.
    let mut temperatures: Vec<f32> =
        (0..COUNT - 6).map(|i| 10.0_f32.powf(6.0 * i as f32 / (COUNT - 7) as f32)).collect();
    temperatures.extend([699.99, 700.0, 700.01, 2999.9, 3000.0, 3000.1]);
    for (settings, formula) in ways() {
        let Some(found) = colours(&settings, 1e6, &temperatures) else { return };
        let at_hottest = formula(3000.0);
        for (t, c) in found {
            assert!(c.iter().all(|c| (0.0..f32::MAX).contains(c)), "{t} K: {c:?}");
            assert!(t >= 700.0 || c == [0.0; 3], "{t} K: {c:?}");
            let hotter = settings.colour == Colour::Physical;
            if t > 3000.0 && !hotter {
                let same = (0..3).all(|i| crate::common::apart(c[i], at_hottest[i]) < 1e-4);
                assert!(same, "{t} K: {c:?} instead of {at_hottest:?}");
            }
            if t > 3100.0 && hotter {
                assert!((0..3).all(|i| f64::from(c[i]) > at_hottest[i]), "{t} K: {c:?}");
            }
        }
    }
    // A host's promise holds for all of them: what is hotter is as hot as it says.
    let physical = Settings { colour: Colour::Physical, ..Settings::paper() };
    let Some(found) = colours(&physical, 2000.0, &temperatures) else { return };
    let hot = |(t, c): &(f32, [f32; 3])| (*t > 2000.0).then_some(c[0]);
    let exact = colour::physical(2000.0, 3000.0, 1.0)[0];
    assert!(found.iter().filter_map(hot).all(|r| crate::common::apart(r, exact) < 1e-4));
}
