//! More light, colours in shadow and higher up, and the layers of both: whole frames against the reference.

use celfx::data::Volume;
use celfx::low_level::smoke::layout;
use celfx::offline::Scene;
use celfx::smoke::reference::tone::{Canvas, rimmed};
use celfx::smoke::reference::{Fire, Frame, Lights};
use celfx::smoke::settings::{Mask, Shadow};
use celfx::smoke::{Desc, Sequence, Settings};
use celfx::toon::Tone;
use celfx::view::{Camera, FARTHEST, FireLight, Light, LightSource, SecondLight};
use glam::DVec3;

use crate::common::apart;
use crate::common::rig::{Bits, Rig, scene};
use crate::common::scenes::{camera, desc, direction, of_voxels, point, puffs};

const SIZE: [u32; 2] = [120, 90];
const FIRE: FireLight = FireLight { position: DVec3::new(0.2, -1.2, 0.3), colour: [0.9, 0.5, 0.2], reach: 1.2 };

/// Tones with colours of their own in shadow, and others higher up.
fn settings() -> Settings {
    let tone = |from, colour, shadow| Tone { from, colour, shadow };
    Settings {
        particles: 250,
        tones: vec![
            tone(0.0, [0.1, 0.1, 0.2], None),
            tone(0.4, [0.3, 0.3, 0.3], Some([0.1, 0.2, 0.3])),
            tone(0.65, [0.5, 0.5, 0.4], Some([0.2, 0.2, 0.4])),
        ],
        tones_above: Some(vec![tone(0.0, [0.2, 0.0, 0.0], None), tone(0.5, [0.5, 0.2, 0.1], Some([0.3, 0.0, 0.2]))]),
        gradient: [-0.4, 0.5],
        ..of_voxels()
    }
}

fn made(settings: Settings, point_light: bool) -> Desc {
    Desc { point_light, rim: true, second_light: true, fire_light: true, ..desc(SIZE, [24; 3], settings) }
}

fn lit() -> Light {
    let second = SecondLight { source: LightSource::Direction(DVec3::new(1.0, 0.2, -0.5)), strength: 0.3 };
    Light { rim: 0.7, second: Some(second), ..direction(-1.0, -1.5, -1.0) }
}

/// Whether a place is in a voxel of smoke.
fn is_in(volume: &Volume, place: DVec3) -> bool {
    let along = |a: usize| ((place[a] - f64::from(volume.origin[a])) / f64::from(volume.voxel_size[a])).floor();
    let [x, y, z] = [0, 1, 2].map(along);
    let [nx, ny, nz] = volume.dimensions.map(f64::from);
    let is_inside = (0.0..nx).contains(&x) && (0.0..ny).contains(&y) && (0.0..nz).contains(&z);
    is_inside && volume.density[((z * ny + y) * nx + x) as usize] > 0.1
}

/// Renders a frame, and the reference's.
fn frames(rig: &mut Rig, camera: Camera, light: &Light, fire: Option<FireLight>, volume: &Volume) -> Frame {
    rig.frame(&Scene { fire, ..scene(Sequence::Restart, camera, *light, Some(volume)) });
    let is_smoke = |place| is_in(volume, place);
    let fire = fire.map(|light| Fire { light, is_smoke: &is_smoke });
    rig.expected(&camera.view(rig.desc().size), Lights { light, fire }, volume.voxel_size[0])
}

/// How many of the pixels that see smoke differ, and how many there are.
fn differing(actual: &[[f32; 4]], expected: &[[f64; 4]], ids: &[u32]) -> [usize; 2] {
    let seen = || actual.iter().zip(expected).zip(ids).filter(|(_, id)| **id > 0).map(|(pair, _)| pair);
    let is_apart = |(a, e): &(&[f32; 4], &[f64; 4])| (0..4).any(|c| apart(a[c], e[c]) > 1.0 / 255.0);
    [seen().filter(is_apart).count(), seen().count()]
}

/// The picture and every layer of light are those of the reference.
fn assert_lit(name: &str, rig: &mut Rig, camera: Camera, light: &Light, fire: Option<FireLight>, volume: &Volume) {
    let expected = frames(rig, camera, light, fire, volume);
    let Desc { settings, size, .. } = rig.desc().clone();
    let softness = settings.tone_softness.into();
    let canvas = Canvas { size, id: &expected.id, mask: settings.mask, softness };
    let luminance = rimmed(light, &expected.smooth, &expected.channels.away);
    let mattes = canvas.mattes(&luminance, &settings.tones);
    let shaded = canvas.shaded(&expected.channels.shade);
    let rim = canvas.rim(&luminance, &expected.smooth, &settings.tones);
    let pairs = shaded.iter().zip(&rim).map(|(shaded, rim)| [*shaded, *rim, 0.0, 0.0]).collect::<Vec<_>>();
    let found = rig.colours(layout::OVERLAY_LAYER).into_iter().map(|[.., shaded, rim]| [shaded, rim, 0.0, 0.0]);
    let found: Vec<[f32; 4]> = found.collect();
    for (layer, actual, expected_layer) in [
        ("picture", rig.picture(), &expected.image),
        ("mattes", rig.colours(layout::MATTE_LAYER), &mattes),
        ("shadow and rim", found, &pairs),
    ] {
        let [apart, seen] = differing(&actual, expected_layer, &expected.id);
        println!("{name}, {layer}: {apart} of {seen} pixels differ");
        // 0.1 % as for any frame: rounding decides at borders of spheres and shadows, and whether a sample of the way to a fire is
        // in a voxel.
        assert!(apart <= (seen / 1000).max(2), "{name}, {layer}: {apart} of {seen} pixels differ");
    }
}

#[test]
fn lights_and_colours_are_those_of_the_reference() {
    let volume = puffs(24, 0.0);
    for mask in [Mask::Groups, Mask::Soft] {
        for (name, own, shadow) in [
            ("smoothed", Settings { sigma: 5.0, ..settings() }, Shadow::Exact),
            ("no Gaussian", Settings { sigma: 0.0, tone_softness: 0.0, ..settings() }, Shadow::Exact),
            ("no shadow", settings(), Shadow::None),
            ("many groups", Settings { groups: 200, ..settings() }, Shadow::Exact),
        ] {
            let Some(mut rig) = Rig::new(made(Settings { mask, shadow, ..own }, false)) else { return };
            assert_lit(&format!("{name}, {mask:?}"), &mut rig, camera(20.0), &lit(), Some(FIRE), &volume);
        }
    }
    let Some(mut rig) = Rig::new(made(settings(), true)) else { return };
    let at_a_place = SecondLight { source: LightSource::Position(DVec3::new(-1.0, 0.5, 2.0)), strength: 0.5 };
    let light = Light { rim: 1.0, second: Some(at_a_place), ..point(1.5, 2.0, 1.5) };
    assert_lit("points", &mut rig, camera(0.0), &light, Some(FIRE), &volume);
}

/// The rim brightens what is away from the light, and a second light what faces it.
#[test]
fn more_light_comes_from_where_it_is() {
    let volume = puffs(24, 0.0);
    let tones = [0.0, 0.25, 0.5, 0.75].map(|from| Tone::new(from, [from; 3])).to_vec();
    let Some(mut rig) = Rig::new(made(Settings { particles: 250, tones, ..Settings::default() }, false)) else {
        return;
    };
    let mut means = |light: Light| {
        let expected = frames(&mut rig, camera(0.0), &light, None, &volume);
        let tones = rig.colours(layout::TONE_LAYER);
        // Of the left half of the picture, and of the right one.
        [0, 1].map(|half| {
            let width = SIZE[0] as usize;
            let here = |pixel: &usize| expected.id[*pixel] > 0 && pixel % width / (width / 2) == half;
            let of: Vec<f32> = (0..tones.len()).filter(here).map(|pixel| tones[pixel][0]).collect();
            of.iter().sum::<f32>() / of.len() as f32
        })
    };
    let from_the_left = direction(1.0, 0.0, -0.2);
    let plain = means(from_the_left);
    let rim = means(Light { rim: 1.0, ..from_the_left });
    assert!(rim[1] - plain[1] > 0.01 && rim[0] >= plain[0], "{plain:?}, with a rim {rim:?}");
    assert!(rim[1] - plain[1] > 3.0 * (rim[0] - plain[0]), "{plain:?}, with a rim {rim:?}");
    let source = LightSource::Direction(DVec3::new(-1.0, 0.0, -0.2));
    let second = means(Light { second: Some(SecondLight { source, strength: 0.5 }), ..from_the_left });
    assert!(second[1] - plain[1] > 0.05, "{plain:?}, with a second light {second:?}");
}

/// What may be there and is not changes no bit.
#[test]
fn light_that_is_not_there_changes_nothing() {
    let volume = puffs(24, 0.0);
    let bits = |desc: Desc, light: Light| -> Option<Bits> {
        let mut rig = Rig::new(desc)?;
        rig.frame(&scene(Sequence::Restart, camera(20.0), light, Some(&volume)));
        Some(rig.bits())
    };
    let plain = Settings { particles: 250, ..Settings::default() };
    let nothing = SecondLight { source: LightSource::Position(DVec3::ZERO), strength: 0.0 };
    let light = direction(-1.0, -1.5, -1.0);
    let Some(without) = bits(desc(SIZE, [24; 3], plain.clone()), light) else { return };
    let dark = Light { second: Some(nothing), ..light };
    let with = bits(made(plain.clone(), false), dark).expect("a device");
    assert_eq!(without.differences(&with), []);
    // Tones above that are the tones, and colours in shadow that are the colours: but for the rounding of mixtures of equals.
    let tones: Vec<Tone> = plain.tones.iter().map(|tone| Tone { shadow: Some(tone.colour), ..*tone }).collect();
    let same = Settings { tones_above: Some(tones.clone()), tones, ..plain };
    let mut rig = Rig::new(desc(SIZE, [24; 3], same)).expect("a device");
    rig.frame(&scene(Sequence::Restart, camera(20.0), light, Some(&volume)));
    let mut other =
        Rig::new(desc(SIZE, [24; 3], Settings { particles: 250, ..Settings::default() })).expect("a device");
    other.frame(&scene(Sequence::Restart, camera(20.0), light, Some(&volume)));
    let (a, b) = (rig.picture(), other.picture());
    assert!(a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() <= 3e-7));
}

/// Grazing edges, lights in the eye and in a sphere's centre, a fire in smoke, one tone, no height to change over.
#[test]
fn lights_and_colours_at_the_ends_of_what_is_allowed() {
    let volume = puffs(24, 0.0);
    let eye = camera(0.0).eye;
    let one = vec![Tone { from: 0.0, colour: [0.4; 3], shadow: Some([0.1; 3]) }];
    let centre = DVec3::new(0.3, -0.1, -0.25);
    for (name, own) in [
        ("one tone", Settings { tones: one.clone(), tones_above: Some(one), ..settings() }),
        ("a step", Settings { gradient: [0.0; 2], ..settings() }),
        ("far below", Settings { gradient: [-1e12, -1e12], ..settings() }),
        ("as high as can be", Settings { gradient: [-1e12, 1e12], ..settings() }),
    ] {
        let Some(mut rig) = Rig::new(made(own, true)) else { return };
        for (place, strength, rim) in [(eye, 1.0, 1.0), (centre, 1.0, 1.0), (DVec3::splat(FARTHEST.into()), 0.5, 1.0)] {
            let second = SecondLight { source: LightSource::Position(place), strength };
            let light = Light { rim, second: Some(second), ..point(place.x, place.y, place.z) };
            for (fire, reach) in [(place, 1e-6), (centre, FARTHEST.into()), (eye, 1.0)] {
                let fire = FireLight { position: fire, colour: [1.0, 0.0, 0.5], reach };
                assert_lit(&format!("{name}, {place}, {reach}"), &mut rig, camera(0.0), &light, Some(fire), &volume);
            }
        }
    }
}

/// Layers that say what became of the light add up.
#[test]
fn layers_add_up() {
    let volume = puffs(24, 0.0);
    // A rim is narrow, and lost under a wide Gaussian.
    let Some(mut rig) = Rig::new(made(Settings { sigma: 1.0, ..settings() }, false)) else { return };
    frames(&mut rig, camera(20.0), &lit(), None, &volume);
    let (_, id) = rig.pixels();
    let mattes = rig.colours(layout::MATTE_LAYER);
    let is_whole = |(mattes, id): (&[f32; 4], &u32)| {
        (mattes.iter().sum::<f32>() - if *id > 0 { 1.0 } else { 0.0 }).abs() < 1e-6 && mattes[3] == 0.0
    };
    assert!(mattes.iter().zip(&id).all(is_whole));
    let overlay = rig.colours(layout::OVERLAY_LAYER);
    assert!(overlay.iter().all(|[ink, silhouette, ..]| silhouette <= ink && (0.0..=1.0).contains(ink)));
    assert!(overlay.iter().any(|[ink, silhouette, ..]| *ink > 0.9 && *silhouette == 0.0), "inner lines");
    assert!(overlay.iter().any(|[_, silhouette, ..]| *silhouette > 0.9), "silhouettes");
    for layer in [2, 3] {
        let [dark, lit] = [0.05, 0.95].map(|limit| overlay.iter().filter(|all| all[layer] > limit).count());
        assert!(lit > 20 && lit < 1500 && dark > lit, "layer {layer}: {dark} and {lit} pixels");
    }
}
