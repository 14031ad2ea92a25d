//! Sprites that are drawn out along their motion, against the reference, and drawn the paper's way.

use celfx::flame::Settings;
use celfx::flame::settings::{Sampling, Shape};
use celfx::view::Camera;
use glam::DVec3;

use crate::common::flame::{FlameRig, ball, desc, moving};
use crate::common::scenes::camera;
use crate::determinism::bits;
use crate::oracle::{Shot, Tally, check, occupied};
use crate::raster::compared;

const SIZE: [u32; 2] = [65, 47];
const PARTICLES: u32 = 60;

fn base() -> Settings {
    Settings { repetitions: 12, count: 6.0, spread: Some(0.1), size: Some(0.15), stretch: 0.15, ..Settings::paper() }
}

#[test]
fn sums_are_those_of_the_reference() {
    let given = moving(ball(PARTICLES, 1), 9);
    let near = Camera { eye: DVec3::new(0.1, 0.0, 1.3), target: DVec3::ZERO, vertical_fov: 60.0, ..Camera::default() };
    let far = Camera { eye: DVec3::new(0.0, 0.0, 40.0), target: DVec3::ZERO, ..Camera::default() };
    let mut total = Tally::default();
    for (name, settings, camera) in [
        ("usual", base(), camera(20.0)),
        ("long", Settings { stretch: 10.0, ..base() }, camera(0.0)),
        ("magnified", base(), near),
        ("below a pixel", Settings { count: 60.0, ..base() }, far),
        ("cube", Settings { shape: Shape::Cube, sampling: Sampling::ShuffledSobol, ..base() }, camera(-30.0)),
        ("in pixels", Settings { size: None, size_pixels: Some(5.0), ..base() }, camera(0.0)),
    ] {
        let Some(mut rig) = FlameRig::new(desc(SIZE, PARTICLES, settings)) else { return };
        let tally = check(name, &mut rig, &Shot::new(&given, camera));
        assert!(tally.hits > 100, "{name}: {tally:?} is empty");
        assert!(rig.stretches().iter().any(|w| w[0].hypot(w[1]) > 0.1), "{name}: nothing is drawn out");
        total.add(tally);
    }
    // As without: decisions that rounding turns.
    total.assert_few("drawn out", 1e-5);
}

#[test]
fn raster_draws_the_same() {
    let given = moving(ball(PARTICLES, 1), 9);
    let effect = desc(SIZE, PARTICLES, base());
    let Some((samples, hits, differing)) = compared(&effect, &[Shot::new(&given, camera(0.0)).scene()]) else { return };
    assert!(differing as f64 <= 1e-4 * samples as f64 && hits * 50 > samples, "{differing} of {samples}, {hits} hits");
}

/// Velocities alone, or a stretch alone, change no bit; both reach into more tiles.
#[test]
fn what_stands_still_is_not_drawn_out() {
    let still = ball(PARTICLES, 1);
    let given = moving(still.clone(), 9);
    let settings = Settings { spread: Some(0.01), size: Some(0.05), ..base() };
    let plain = desc([320, 200], PARTICLES, Settings { stretch: 0.0, ..settings.clone() });
    let render = |desc: &_, particles| {
        let mut rig = FlameRig::new(Clone::clone(desc))?;
        rig.frame(particles, camera(0.0));
        let tiles = occupied(&mut rig).len();
        Some((bits(&mut rig), tiles))
    };
    let stretched = desc([320, 200], PARTICLES, settings);
    let (Some(a), Some(b), Some(c), Some(d)) =
        (render(&plain, &still), render(&plain, &given), render(&stretched, &still), render(&stretched, &given))
    else {
        return;
    };
    assert_eq!(a.0.differences(&b.0), []);
    assert_eq!(a.0.differences(&c.0), []);
    assert!(!a.0.differences(&d.0).is_empty() && d.1 > a.1, "{} and {} tiles", a.1, d.1);
}
