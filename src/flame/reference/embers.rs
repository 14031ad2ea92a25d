//! Sparks that fly out of the fire.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::prepare;
use crate::flame::params::{ASIDE, COLDEST, EMBER_KEY, HOTTER, LEAST_RADIUS};
use crate::flame::settings::{Look, Settings};
use crate::random::{hash, unit};
use crate::view::{FARTHEST, Projection};

/// A spark in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ember {
    /// Its middle in pixels.
    pub middle: DVec2,
    /// Its view depth in metres.
    pub depth: f64,
    /// Its radius in pixels.
    pub radius: f64,
    /// Linear RGB.
    pub colour: DVec3,
}

impl Ember {
    /// That of a particle at a place (metres, y up) with a temperature, of which those above `limit` count as that hot. None
    /// if it has none, or if it is outside of what is seen. Sizes of the settings are pixels of the picture.
    pub fn new(
        settings: &Settings,
        limit: f32,
        seed: u32,
        id: u32,
        projection: &Projection,
        [x, y, z, kelvin]: [f32; 4],
    ) -> Option<Ember> {
        let drawn = |which: u32| f64::from(unit(hash(seed, id, EMBER_KEY, which)));
        let glows = kelvin.is_finite() && kelvin >= COLDEST;
        if !glows || ![x, y, z].iter().all(|c| c.abs() <= FARTHEST) || drawn(0) >= settings.embers.share.into() {
            return None;
        }
        let [hottest, coldest, kelvin] = [settings.hottest, COLDEST, kelvin.min(limit)].map(f64::from);
        let cooled = if hottest > coldest { ((hottest - kelvin) / (hottest - coldest)).clamp(0.0, 1.0) } else { 0.0 };
        let rise = f64::from(settings.embers.height(settings.spread.unwrap_or_default())) * cooled * (0.5 + drawn(1));
        let angle = TAU * (drawn(2) + cooled * (0.5 + drawn(3)));
        let aside = f64::from(ASIDE);
        let way = DVec3::new(aside * angle.cos(), 1.0, aside * angle.sin());
        let place = projection.to_view(super::world([x, y, z]) + rise * way);
        let is_seen = (projection.near..=projection.far).contains(&place.z);
        is_seen.then(|| Ember {
            middle: projection.pixel_of(place),
            depth: place.z,
            radius: 0.5 * f64::from(settings.embers.size) * (1.0 - cooled).sqrt(),
            colour: colour(settings, kelvin + f64::from(HOTTER) * (hottest - kelvin)) * f64::from(settings.intensity),
        })
    }

    /// Share of the pixel (x, y) that it covers.
    pub fn share(&self, pixel: [u32; 2]) -> f64 {
        let radius = self.radius.max(LEAST_RADIUS.into());
        let way = DVec2::from(pixel.map(|c| f64::from(c) + 0.5)).distance(self.middle);
        (self.radius / radius).powi(2) * (radius + 0.5 - way).clamp(0.0, 1.0)
    }
}

/// Of the look "cel" that of the hottest tone that a temperature reaches, the first at least.
fn colour(settings: &Settings, kelvin: f64) -> DVec3 {
    if settings.look == Look::Light {
        return DVec3::from_array(prepare::colour(settings, kelvin));
    }
    let share = kelvin / f64::from(settings.hottest);
    let mut tones = settings.tones.shares(settings.hottest).enumerate();
    let reached = tones.by_ref().take_while(|(index, tone)| *index == 0 || f64::from(tone.from) <= share).last();
    reached.map_or(DVec3::ZERO, |(_, tone)| DVec3::from_array(tone.colour.map(f64::from)))
}

/// Lays embers, one after the other, over a picture (linear RGBA, premultiplied) of which the fire covers the shares `fire`, and
/// in which a scene has the depths `scene`, if there is one.
pub fn draw(size: [u32; 2], picture: &mut [[f64; 4]], fire: &[f64], scene: Option<&[f32]>, embers: &[Ember]) {
    for ember in embers {
        for (index, pixel) in picture.iter_mut().enumerate() {
            let at = [index as u32 % size[0], index as u32 / size[0]];
            let is_hidden = scene.is_some_and(|scene| f64::from(scene[index]) < ember.depth);
            let share = if is_hidden { 0.0 } else { ember.share(at) * (1.0 - fire[index]) };
            let drawn = (share * ember.colour).extend(share).to_array();
            *pixel = std::array::from_fn(|c| drawn[c] + (1.0 - share) * pixel[c]);
        }
    }
}
