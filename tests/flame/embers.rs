//! Embers on a device, against the reference in f64.

use celfx::data::Particles;
use celfx::effect::Effort;
use celfx::flame::reference::embers::{self, Ember};
use celfx::flame::settings::{Embers, Look, Mode};
use celfx::flame::{Desc, SceneFormat, Settings};
use celfx::view::{Camera, Projection, View};

use crate::common::flame::{FlameRig, ball, desc, particles};
use crate::common::scenes::camera;
use crate::common::views;
use crate::oracle::Shot;

const SIZE: [u32; 2] = [85, 67];

fn base() -> Settings {
    let embers = Embers { share: 0.5, size: 5.0, rise: Some(0.8) };
    Settings { repetitions: 4, count: 4.0, spread: Some(0.1), size: Some(0.2), embers, ..Settings::default() }
}

/// What a device draws with embers is what it draws without, and those of the reference. They must cover so many pixels.
#[track_caller]
fn compare(name: &str, desc: &Desc, given: &Particles, view: View, depth: Option<&[f32]>, covered: usize) {
    let plain = Settings { embers: Embers::default(), ..desc.settings.clone() };
    let made = [FlameRig::new(desc.clone()), FlameRig::new(Desc { settings: plain, ..desc.clone() })];
    let [Some(mut with), Some(mut without)] = made else { return };
    for rig in [&mut with, &mut without] {
        rig.render(&Shot { depth, view: Some(view), ..Shot::new(given, camera(0.0)) }.scene());
    }
    assert_eq!(with.effect(), without.effect(), "{name}: the fire is another");
    let projection = Projection::of_valid(&view, desc.size);
    let rows = with.positions().into_iter().zip(0..);
    let id = |row: u32| given.id.as_ref().map_or(row, |ids| ids[row as usize]);
    let embers: Vec<Ember> = rows
        .filter_map(|(row, at)| Ember::new(&desc.settings, desc.hottest, desc.seed, id(at), &projection, row))
        .collect();
    let mut expected: Vec<[f64; 4]> = without.picture().iter().map(|pixel| pixel.map(f64::from)).collect();
    let fire: Vec<f64> = without.effect().iter().map(|pixel| pixel[3].into()).collect();
    embers::draw(desc.size, &mut expected, &fire, depth, &embers);
    let found = with.picture();
    // A place in single precision is good for 1e-4 pixels, and up to ten embers lie over one another.
    let brightest = expected.as_flattened().iter().copied().fold(1.0, f64::max);
    for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
        for c in 0..4 {
            let error = (f64::from(found[c]) - expected[c]).abs();
            assert!(error < 1e-3 * brightest, "{name}: {error} off at {at}: {found:?}, {expected:?}");
        }
    }
    let changed = found.iter().zip(without.picture()).filter(|(with, without)| *with != without).count();
    assert!(changed >= covered, "{name}: {changed} pixels have embers");
}

#[test]
fn embers_are_those_of_the_reference() {
    let mut named = ball(60, 3);
    named.id = Some((0..60).map(|row| 7 * row + 3).collect());
    let small = Embers { size: 0.7, ..base().embers };
    for (name, settings, view) in [
        ("usual", base(), camera(20.0)),
        ("light", Settings { look: Look::Light, intensity: 3.0, ..base() }, camera(20.0)),
        ("expected", Settings { mode: Mode::Expected, bins: 8, ..base() }, camera(20.0)),
        ("smaller than pixels", Settings { embers: small, ..base() }, camera(0.0)),
        (
            "all, as far as their spread says",
            Settings { embers: Embers { share: 1.0, rise: None, ..base().embers }, ..base() },
            camera(0.0),
        ),
        (
            "among them",
            Settings { threshold: 0.95, ..base() },
            Camera { eye: glam::DVec3::new(0.1, 0.3, 0.2), ..camera(0.0) },
        ),
    ] {
        compare(name, &desc(SIZE, 60, settings), &named, view.view(SIZE), None, 20);
    }
}

#[test]
fn embers_are_seen_through_any_projection() {
    let given = ball(60, 3);
    for (name, view) in views::of(&camera(20.0), SIZE, camera(20.0).eye.length()) {
        compare(name, &desc(SIZE, 60, base()), &given, view, None, 20);
    }
}

/// A wall hides those behind it, pixel by pixel.
#[test]
fn what_is_before_them_hides_embers() {
    let given = ball(60, 4);
    let scene = Some(SceneFormat::Buffer);
    let eye = camera(0.0).eye.length() as f32;
    let depth: Vec<f32> =
        (0..SIZE[0] * SIZE[1]).map(|at| if at % SIZE[0] < SIZE[0] / 2 { eye } else { f32::INFINITY }).collect();
    compare("a wall", &Desc { scene, ..desc(SIZE, 60, base()) }, &given, camera(0.0).view(SIZE), Some(&depth), 40);
}

/// Those of the hottest are where their particles are, the coldest are gone, and what is no number has none.
#[test]
fn embers_begin_at_their_particles_and_shrink_to_nothing() {
    let (hottest, projection) = (3000.0, Projection::of_valid(&camera(0.0).view(SIZE), SIZE));
    let settings = Settings { hottest, embers: Embers { share: 1.0, ..base().embers }, ..base() };
    let ember = |row| Ember::new(&settings, 3000.0, 1, 5, &projection, row);
    let place = |y: f64| projection.pixel_of(projection.to_view(glam::DVec3::new(0.2, y, 0.1)));
    let hot = ember([0.2, 0.3, 0.1, 3000.0]).expect("it glows");
    assert!(hot.middle.distance(place(f64::from(0.3_f32))) < 1e-4 && hot.radius == 2.5);
    let cool = ember([0.2, 0.3, 0.1, 1200.0]).expect("it glows");
    assert!(cool.middle.y < hot.middle.y - 5.0 && cool.radius < 0.5 * hot.radius);
    assert_eq!(ember([0.2, 0.3, 0.1, 700.0]).map(|ember| ember.radius), Some(0.0));
    assert_eq!(ember([0.2, 0.3, 0.1, 699.0]), None);
    let given = [
        [0.0, 0.0, 0.0, f32::NAN],
        [f32::NAN, 0.0, 0.0, 2000.0],
        [f32::INFINITY, 0.0, 0.0, 2000.0],
        [0.0, 0.0, 0.0, 650.0],
    ];
    assert!(given.into_iter().all(|row| ember(row).is_none()));
    let all = [&given[..], &[[0.3, 0.1, 0.0, 2000.0], [0.0, 0.0, 0.0, f32::INFINITY]]].concat();
    compare("extremes", &desc(SIZE, 6, settings.clone()), &particles(&all), camera(0.0).view(SIZE), None, 4);
}

/// What is skipped, and what memory held, changes nothing.
#[test]
fn embers_are_the_same_with_every_effort() {
    let given = ball(60, 5);
    let frame = |effort| {
        let mut rig = FlameRig::with_effort(desc(SIZE, 60, base()), effort)?;
        rig.frame(&given, camera(30.0));
        Some(rig.picture())
    };
    assert_eq!(frame(Effort::Needed), frame(Effort::Everything));
}
