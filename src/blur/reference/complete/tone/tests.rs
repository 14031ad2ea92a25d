use glam::{DQuat, DVec3};

use super::*;
use crate::random::{hash, unit as random};

const LIGHT: DVec3 = DVec3::new(0.36, 0.48, 0.8);

/// Two tones.
fn flat(cosine: f64) -> [f64; 3] {
    if cosine > 0.3 { [1.0; 3] } else { [0.35, 0.4, 0.6] }
}

/// Diffuse light.
fn even(cosine: f64) -> [f64; 3] {
    [0.2 + 0.8 * cosine.max(0.0); 3]
}

fn normal(index: u32) -> DVec3 {
    let [x, y, z] = [0, 1, 2].map(|i| f64::from(random(hash(3, index, 0, i))) - 0.5);
    DVec3::new(x, y, z).normalize()
}

fn paint(index: u32) -> [f64; 3] {
    [0, 1, 2].map(|i| 0.1 + 0.8 * f64::from(random(hash(4, index, 0, i))))
}

/// Places of all normals and any paint that turn, under lights.
fn sites_of(count: u32, turn: f64, lights: [DVec3; 2], tone: fn(f64) -> [f64; 3]) -> Vec<Site> {
    let site = |index: u32| {
        let first = normal(index);
        let normals = [first, DQuat::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), turn) * first];
        let colours = [0, 1].map(|k| {
            let (tone, paint) = (tone(normals[k].dot(lights[k])), paint(index));
            [0, 1, 2].map(|i| tone[i] * paint[i])
        });
        let change = [0, 1, 2].map(|i| change(colours[0][i], colours[1][i]));
        Site { surface: index % 2, normals: normals.map(|n| n.to_array()), change, weight: 1 }
    };
    (0..count).map(site).collect()
}

/// The smaller angle between a direction or its opposite and another, in degrees.
fn off(found: [f64; 3], light: DVec3) -> f64 {
    let cosine = DVec3::from_array(found).dot(light).abs();
    cosine.min(1.0).acos().to_degrees()
}

#[test]
fn logarithms_are_rounded_and_what_has_none_is_black() {
    assert_eq!(change(0.5, 0.5), 0);
    assert_eq!(change(0.49, 0.99), 177, "256 ln 2 = 177.4");
    assert_eq!(change(0.99, 0.49), -177);
    assert_eq!([change(f64::NAN, 0.0), change(-3.0, 0.0)], [0; 2]);
    assert_eq!(change(0.0, 9e9), MOST_CHANGE);
    assert_eq!([badness(0), badness(76), badness(77), badness(1000)], [0, 37, 39, 962]);
    assert_eq!(unit([0.0, 3.0, 4.0]), Some([0.0, 0.6, 0.8]));
    assert_eq!([unit([0.0; 3]), unit([f64::NAN, 1.0, 0.0])], [None; 2]);
}

#[test]
fn equations_are_solved() {
    // Steps 0 to 3, of which 0 and 3 are known to be 100 apart, and many places say so.
    let site = |from: f64, to: f64, change: i32| Site {
        surface: 0,
        normals: [[from, 0.0, 0.0], [to, 0.0, 0.0]],
        change: [change, -change, 0],
        weight: 1000,
    };
    let lights = [[1.0, 0.0, 0.0]; 2];
    let weighing = |times: usize| Weighing { times, ..SEARCHING };
    let tones = solve(&[site(-0.9, 0.9, 100)], lights, 4, weighing(1));
    assert_eq!(tones[3][0] - tones[0][0], 100);
    assert!((0..3).all(|i| (tones[0][i] + tones[3][i]).abs() <= 1), "tones tend to 0");
    assert!((33..=34).contains(&(tones[1][0] - tones[0][0])) && (tones[3][0] + tones[3][1]).abs() <= 1);
    // One that disagrees loses weight; it does not, if all count alike.
    let both = [site(-0.9, 0.9, 100), Site { weight: 300, ..site(-0.9, 0.9, 900) }];
    let apart = |times: usize| {
        let tones = solve(&both, lights, 4, weighing(times));
        tones[3][0] - tones[0][0]
    };
    assert!((280..290).contains(&apart(1)) && (100..130).contains(&apart(8)), "{} {}", apart(1), apart(8));
}

#[test]
fn the_light_is_found_whatever_the_paint() {
    for (tone, turn, most) in [(flat as fn(f64) -> _, 0.3, 3.0), (even, 0.3, 3.0), (flat, 0.8, 3.0)] {
        let all = sites_of(6000, turn, [LIGHT; 2], tone);
        let few: Vec<Site> = all.iter().step_by(3).copied().collect();
        let lights = search(&[all, few.clone(), few.into_iter().step_by(4).collect()]);
        assert!(lights.iter().all(|light| off(*light, LIGHT) < most), "{turn}: {lights:?}");
    }
}

#[test]
fn a_light_that_turns_is_found() {
    let turned = DQuat::from_rotation_y(0.3) * LIGHT;
    let all = sites_of(6000, 0.1, [LIGHT, turned], flat);
    let few: Vec<Site> = all.iter().step_by(3).copied().collect();
    let lights = search(&[all, few.clone(), few.into_iter().step_by(4).collect()]);
    let found = [off(lights[0], LIGHT), off(lights[1], turned)];
    assert!(found.iter().all(|off| *off < 4.0), "{found:?}");
}

/// Tones learnt from places.
fn learnt(sites: &[Site], lights: [[f64; 3]; 2]) -> Tones {
    Tones::under(sites, lights, 1.0)
}

#[test]
fn what_is_hidden_changes_as_its_tone_does() {
    let lights = [LIGHT.to_array(); 2];
    let tones = learnt(&sites_of(6000, 0.3, [LIGHT; 2], flat), lights);
    assert!(tones.explains(0) && tones.explains(1) && tones.explains(7));
    let across = LIGHT.any_orthonormal_vector();
    let at = |cosine: f64| (LIGHT * cosine + across * (1.0 - cosine * cosine).sqrt()).to_array();
    let known = [0.8, 0.4, 0.2, 0.5];
    let dark = tones.predict(0, 1, [at(0.9), at(-0.2)], known).unwrap();
    let expected = [0.8 * 0.35, 0.4 * 0.4, 0.2 * 0.6, 0.5];
    assert!((0..4).all(|i| (dark[i] - expected[i]).abs() < 0.02), "{dark:?}");
    let bright = tones.predict(1, 0, [at(0.9), at(-0.2)], dark).unwrap();
    // Each object has its tones from its own places.
    assert!((0..4).all(|i| (bright[i] - known[i]).abs() < 0.01), "{bright:?}");
    // What stays in its tone stays as it is, and nothing gets brighter than an image can be.
    let same = tones.predict(0, 1, [at(0.9), at(0.5)], known).unwrap();
    assert!((0..4).all(|i| (same[i] - known[i]).abs() < 4e-3), "{same:?}");
    assert_eq!(tones.predict(0, 1, [at(-0.2), at(0.9)], [0.9, 1.7, 0.0, 1.0]).unwrap()[..2], [1.0, 1.7]);
    assert_eq!(tones.predict(0, 1, [[0.0; 3], at(0.5)], known), None);
}

#[test]
fn even_tones_have_no_steps() {
    let lights = [LIGHT.to_array(); 2];
    let tones = learnt(&sites_of(12_000, 0.4, [LIGHT; 2], even), lights);
    let across = LIGHT.any_orthonormal_vector();
    let at = |cosine: f64| (LIGHT * cosine + across * (1.0 - cosine * cosine).sqrt()).to_array();
    let predicted = |cosine: f64| tones.predict(0, 1, [at(0.95), at(cosine)], [0.5, 0.5, 0.5, 1.0]).unwrap()[0];
    let places: Vec<f64> = (0..600).map(|i| 0.1 + 0.001 * f64::from(i)).collect();
    let worst = places.iter().map(|c| (predicted(*c) - 0.5 * even(*c)[0] / even(0.95)[0]).abs()).fold(0.0, f64::max);
    // A step is 0.033 of light.
    assert!(worst < 0.02, "{worst}");
    let jump = places.windows(2).map(|pair| (predicted(pair[1]) - predicted(pair[0])).abs()).fold(0.0, f64::max);
    assert!(jump < 0.004, "{jump}");
}

#[test]
fn surfaces_have_their_own_tones() {
    let lights = [LIGHT.to_array(); 2];
    let mut sites = sites_of(6000, 0.3, [LIGHT; 2], flat);
    // One changes red where the other changes blue, a third does not change at all.
    for (site, index) in sites.iter_mut().zip(0..) {
        site.surface = [0, 1, 0, 2, 0, 0][index % 6];
        match site.surface {
            1 => site.change.reverse(),
            2 => site.change = [0; 3],
            _ => {}
        }
    }
    let tones = learnt(&sites, lights);
    assert!([0, 1, 2].iter().all(|surface| tones.explains(*surface)));
    let across = LIGHT.any_orthonormal_vector();
    let at = |cosine: f64| (LIGHT * cosine + across * (1.0 - cosine * cosine).sqrt()).to_array();
    let known = [0.5, 0.5, 0.5, 1.0];
    for (surface, tone) in [(0, [0.35, 0.4, 0.6]), (1, [0.6, 0.4, 0.35]), (2, [1.0; 3])] {
        let found = tones.predict(surface, 1, [at(0.9), at(-0.2)], known).unwrap();
        // The tones of all hold a little of those that are a sixth of the places.
        assert!((0..3).all(|i| (found[i] - 0.5 * tone[i]).abs() < 0.04), "{surface}: {found:?}");
    }
}

#[test]
fn what_has_no_tones_keeps_what_is_known() {
    let lights = [LIGHT.to_array(); 2];
    let sites = sites_of(6000, 0.3, [LIGHT; 2], flat);
    let noise = |(site, index): (&Site, u32)| {
        let change = [(hash(8, index, 0, 0) % 600) as i32 - 300; 3];
        Site { change, ..*site }
    };
    // One surface flickers.
    let with = |surfaces: &[u32]| -> Vec<Site> {
        let is_noisy = |site: &Site| surfaces.contains(&site.surface);
        sites.iter().zip(0..).map(|(site, i)| if is_noisy(site) { noise((site, i)) } else { *site }).collect()
    };
    assert!(!learnt(&with(&[0, 1]), lights).explains(0));
    // Nothing at all changes: nothing is to be explained, and nothing is predicted.
    let still: Vec<Site> = sites.iter().map(|site| Site { change: [0; 3], ..*site }).collect();
    let known = [0.3, 0.2, 0.1, 1.0];
    assert_eq!(learnt(&still, lights).predict(0, 1, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], known), Some(known));
}

#[test]
fn the_order_of_places_does_not_matter() {
    let sites = sites_of(3000, 0.3, [LIGHT; 2], flat);
    let mut mixed = sites.clone();
    mixed.sort_by_key(|site| (site.change, site.normals[0].map(f64::to_bits)));
    let lights = [LIGHT.to_array(); 2];
    assert_eq!(learnt(&sites, lights), learnt(&mixed, lights));
}
