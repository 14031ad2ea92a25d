//! A fire as a lamp: what lights the smoke beside it.

use glam::DVec3;

use crate::flame::settings::Settings;
use crate::shaders::flame::constants::COLDEST;
use crate::view::{FARTHEST, FireLight};

/// The light of a fire of these particles on smoke ([`crate::smoke::Frame::fire`]), `settings.light` strong: as bright where
/// it is as they are, each as often as it has sprites, and reaching four standard deviations from its middle, or as far as
/// `settings.reach` says. Positions in metres, temperatures in kelvin, of which those above `hottest` count as that hot. None where nothing glows, and if
/// `settings.light` is 0.
pub fn fire_light(settings: &Settings, hottest: f32, position: &[[f32; 3]], temperature: &[f32]) -> Option<FireLight> {
    let table = super::tables::colours(settings, hottest);
    let glowing = position
        .iter()
        .zip(temperature)
        .filter(|(p, kelvin)| p.iter().all(|c| c.abs() <= FARTHEST) && kelvin.is_finite() && **kelvin >= COLDEST);
    // The number of sprites of a particle goes with its temperature.
    let light = |(p, kelvin): (&[f32; 3], &f32)| {
        let kelvin = kelvin.min(hottest);
        let colour = DVec3::from_array(table.look_up(kelvin).map(f64::from)) * f64::from(kelvin / settings.hottest);
        (DVec3::from_array(p.map(f64::from)), colour, colour.max_element())
    };
    let (mut place, mut colour, mut brightness) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (at, own, bright) in glowing.clone().map(light) {
        (place, colour, brightness) = (place + bright * at, colour + own, brightness + bright);
    }
    let brightest = colour.max_element();
    if !(brightness > 0.0 && brightest > 0.0 && settings.lights()) {
        return None;
    }
    let position = place / brightness;
    let spread = glowing.map(light).map(|(at, _, bright)| bright * at.distance_squared(position)).sum::<f64>();
    let colour = (f64::from(settings.light) / brightest * colour).as_vec3().to_array();
    let reach = settings.reach.map_or(4.0 * (spread / brightness).sqrt(), f64::from);
    Some(FireLight { position, colour, reach: reach.clamp(1e-3, FARTHEST.into()) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::settings::Colour;

    fn settings(light: f32) -> Settings {
        // A colour of its own each 1000 K.
        let colour = Colour::Ramp(vec![[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.25]]);
        Settings { light, colour, hottest: 3000.0, ..Settings::default() }
    }

    #[test]
    fn the_middle_is_weighed_by_brightness_and_the_reach_is_four_deviations() {
        // Equally hot ones at -1 and 3: the middle is 1, the deviation 2.
        let two = [[-1.0, 0.0, 5.0], [3.0, 0.0, 5.0]];
        let light = fire_light(&settings(2.0), 3000.0, &two, &[1500.0; 2]).expect("it glows");
        assert!((light.position - DVec3::new(1.0, 0.0, 5.0)).length() < 1e-12 && (light.reach - 8.0).abs() < 1e-12);
        // The table is one of single floats.
        assert!(light.colour.iter().zip([0.0, 2.0, 0.0]).all(|(found, expected)| (found - expected).abs() < 1e-6));
        // At 500 K, below the glow's least, and not a number: no part of it.
        let more = [[-1.0, 0.0, 5.0], [3.0, 0.0, 5.0], [99.0, 0.0, 0.0], [f32::NAN, 0.0, 0.0]];
        assert_eq!(fire_light(&settings(2.0), 3000.0, &more, &[1500.0, 1500.0, 500.0, 1500.0]), Some(light));
        // 2500 K has 5 sprites where 1500 K has 3, each half as bright.
        let light = fire_light(&settings(1.0), 3000.0, &two, &[1500.0, 2500.0]).expect("it glows");
        let [near, far] = [0.5 * 1.5, 0.25 * 2.5];
        assert!((light.position.x - (3.0 * far - near) / (near + far)).abs() < 1e-6);
    }

    #[test]
    fn nothing_lights_nothing() {
        assert_eq!(fire_light(&settings(2.0), 3000.0, &[], &[]), None);
        assert_eq!(fire_light(&settings(2.0), 3000.0, &[[0.0; 3]], &[600.0]), None);
        assert_eq!(fire_light(&settings(0.0), 3000.0, &[[0.0; 3]], &[1500.0]), None);
        // One particle: a point, but no reach of 0.
        let light = fire_light(&settings(2.0), 3000.0, &[[0.0; 3]], &[1500.0]).expect("it glows");
        assert!(light.validate().is_ok() && light.reach == 1e-3);
    }
}
