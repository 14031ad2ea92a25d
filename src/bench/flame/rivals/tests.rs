use glam::{DVec2, DVec3};

use super::reference::{Fog, moments, sorted, wavelets, weighted};
use super::*;
use crate::bench::measure::Deviation;
use crate::flame::Settings;
use crate::flame::reference::kernel::Body;
use crate::flame::reference::mask::Mask;
use crate::flame::reference::prepare::{Particle, mask_level, prepare};
use crate::flame::reference::weights::Weights;
use crate::flame::settings::{Mode, Shape};
use crate::gpu::headless::{Headless, Options};

/// The particles of a scene, each with its weights, which are the same at all pixels.
fn weighted_particles(scene: &Scene) -> Vec<(Particle, Weights)> {
    let Scene { settings, camera, size, particles, .. } = scene;
    let rows = particles.position.iter().zip(&particles.temperature).map(|([x, y, z], t)| [*x, *y, *z, *t]);
    let prepared =
        prepare(settings, 3000.0, 0, &camera.view(*size), &rows.collect::<Vec<_>>(), particles.id.as_deref());
    let mask = Mask::new(0, settings.variants);
    let level = mask_level(settings, &camera.view(*size), *size, prepared.nearest);
    let weigh = |p: Particle| {
        let weights = Weights::new(&mask, level, p.alpha, settings.threshold.into(), 64);
        (p, weights)
    };
    prepared.particles.into_iter().map(weigh).collect()
}

/// The fog at a pixel, in f64 and without a table.
fn fogs(scene: &Scene, particles: &[(Particle, Weights)], at: [usize; 2]) -> Vec<Fog> {
    let Scene { settings, camera, size, .. } = scene;
    let half = camera.half_extent(*size);
    let ray = |axis: usize, side: u32| (2.0 * at[axis] as f64 + 1.0) / f64::from(side) - 1.0;
    let slope = half * DVec2::new(ray(0, size[0]), -ray(1, size[1]));
    let rotation = camera.rotation();
    let fog = |(p, weights): &(Particle, Weights)| {
        let centre = rotation * (DVec3::from_array(p.centre.map(f64::from)) - camera.eye);
        let body = Body {
            weights,
            fill: 1.0,
            half: 0.5 * f64::from(settings.sprite()),
            spread: f64::from(settings.spread.unwrap_or_default()),
            shape: Shape::Ball,
            rotation,
        };
        let beside = centre.z * slope - centre.truncate();
        if !body.touches(beside, DVec2::ZERO) {
            return None;
        }
        let mut share = [0.0];
        let always = [f64::NEG_INFINITY, f64::INFINITY];
        body.shares(beside, DVec2::ZERO, always, &[1e3], &mut share);
        let opacity = 1.0 - (1.0 - share[0]).powi(p.count as i32);
        Some(Fog { depth: centre.z, colour: DVec3::from_array(p.colour), opacity })
    };
    let mut fogs: Vec<Fog> = particles.iter().filter_map(fog).collect();
    fogs.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    fogs
}

const RIVALS: [Rival; 5] = [Rival::Sorted, Rival::Weighted, Rival::Moments4, Rival::Moments6, Rival::Wavelets];

/// `range`: depths that anything can have.
fn blended(rival: Rival, fogs: &[Fog], range: [f64; 2]) -> DVec3 {
    match rival {
        Rival::Sorted => sorted(fogs),
        Rival::Weighted => weighted(fogs, range),
        Rival::Moments4 => moments::blended(fogs, range, 4),
        Rival::Moments6 => moments::blended(fogs, range, 6),
        Rival::Wavelets => wavelets::blended(fogs, range),
    }
}

#[test]
fn all_are_what_their_definitions_say() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let options = Options { validate: true, device: std::env::var("CELFX_DEVICE").ok(), ..Options::default() };
    let headless = match Headless::new(&options) {
        Ok(headless) => headless,
        Err(error) if std::env::var_os("CELFX_REQUIRE_VULKAN").is_some() => return Err(error.into()),
        Err(_) => return Ok(()),
    };
    let mut rig = Rig::new(headless)?;
    let messages = rig.messages();
    let scene = Scene::new(&crate::bench::flame::scene::THICK, true);
    let settings = Settings { mode: Mode::Expected, ..scene.settings.clone() };
    let effect = scene.render(&mut rig, settings)?;
    let rivals = Rivals::new(&mut rig, effect, &scene)?;
    let mut found = Vec::new();
    for rival in RIVALS {
        rig.run(rivals.kernels(), &rivals.plan(&scene, rival))?;
        found.push(rivals.mean(&mut rig)?);
    }
    let spread = f64::from(scene.settings.spread.unwrap_or_default());
    let rotation = scene.camera.rotation();
    let depths = scene
        .particles
        .position
        .iter()
        .map(|position| (rotation * (DVec3::from_array(position.map(f64::from)) - scene.camera.eye)).z);
    let range = depths.fold([f64::MAX, f64::MIN], |[a, b], z| [a.min(z - spread), b.max(z + spread)]);
    let particles = weighted_particles(&scene);
    let mut differences = RIVALS.map(|_| Vec::new());
    for y in (3..scene.size[1] as usize).step_by(9) {
        for x in (5..scene.size[0] as usize).step_by(9) {
            let fogs = fogs(&scene, &particles, [x, y]);
            let place = y * scene.size[0] as usize + x;
            for ((rival, found), differences) in RIVALS.iter().zip(&found).zip(&mut differences) {
                let expected = blended(*rival, &fogs, range);
                let [r, g, b, _] = found[place].map(f64::from);
                differences.push((DVec3::new(r, g, b) - expected).abs().max_element());
            }
        }
    }
    for (rival, differences) in RIVALS.into_iter().zip(differences) {
        // Of the table: its classes and places.
        let deviation = Deviation::of(differences).ok_or("no pixels")?;
        assert!(deviation.rms < 5e-3 && deviation.max < 5e-2, "{rival:?}: {deviation:?}");
    }
    drop(rig);
    let messages = messages.lock().map_err(|_| "a message")?;
    assert!(messages.is_empty(), "{messages:?}");
    Ok(())
}
