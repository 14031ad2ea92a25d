//! The paper's way (section 2.8, equation 13): a colour changes from frame to frame as those of its neighbours do.

use super::inward;
use crate::blur::reference::visible::{Colour, Frame, Shaded};

/// Saturation below which a colour has no hue; the kernels have the nearest float.
const NO_HUE: f64 = 0.05;

/// Hue, saturation, value of a colour that is not premultiplied: hue and saturation from 0 to 1, hue 0 where there is
/// none, value the largest channel.
pub fn hsv([r, g, b]: [f64; 3]) -> [f64; 3] {
    let (value, least) = (r.max(g).max(b), r.min(g).min(b));
    let range = value - least;
    if value <= 0.0 || range <= 0.0 {
        return [0.0, 0.0, value.max(0.0)];
    }
    let sixths = match value {
        _ if value == r => (g - b) / range,
        _ if value == g => 2.0 + (b - r) / range,
        _ => 4.0 + (r - g) / range,
    };
    [(sixths / 6.0).rem_euclid(1.0), range / value, value]
}

/// The inverse of [`hsv`]; hues repeat at 1.
pub fn rgb([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    let channel = |sixth: f64| {
        let place = (sixth + 6.0 * hue).rem_euclid(6.0);
        value - value * saturation * place.min(4.0 - place).clamp(0.0, 1.0)
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

/// The difference of two hues the short way round: from -1/2 to below 1/2.
pub fn hue_difference(a: f64, b: f64) -> f64 {
    let difference = a - b;
    difference - (difference + 0.5).floor()
}

/// [`hsv`] of a premultiplied colour, and its alpha.
fn hsva([r, g, b, a]: Colour) -> [f64; 4] {
    let [h, s, v] = hsv(if a > 0.0 { [r / a, g / a, b / a] } else { [0.0; 3] });
    [h, s, v, a]
}

fn premultiplied([h, s, v, a]: [f64; 4]) -> Colour {
    let [r, g, b] = rgb([h, s, v]);
    [r * a, g * a, b * a, a]
}

/// The difference of two colours in HSV and alpha. None in hue where either has none.
fn change(to: Colour, from: Colour) -> [f64; 4] {
    let (to, from) = (hsva(to), hsva(from));
    let hue = if to[1].min(from[1]) < NO_HUE { 0.0 } else { hue_difference(to[0], from[0]) };
    [hue, to[1] - from[1], to[2] - from[2], to[3] - from[3]]
}

/// `known` with the mean of changes added: saturation and alpha clamped to 0 to 1, value to 0 to `most`.
pub fn predict(known: Colour, changes: &[[Colour; 2]], most: f64) -> Colour {
    let changes: Vec<[f64; 4]> = changes.iter().map(|[to, from]| change(*to, *from)).collect();
    let mean = |i: usize| changes.iter().map(|change| change[i]).sum::<f64>() / changes.len() as f64;
    let [h, s, v, a] = hsva(known);
    let hue = h + mean(0);
    premultiplied([hue, (s + mean(1)).clamp(0.0, 1.0), (v + mean(2)).clamp(0.0, most), (a + mean(3)).clamp(0.0, 1.0)])
}

/// The largest value that two images show of the mesh, at least 1: colours do not become brighter.
fn most_of(frames: [&Frame; 2]) -> f64 {
    let pixels = frames.iter().flat_map(|frame| frame.shown());
    pixels.map(|pixel| hsva(pixel.map(f64::from))[2]).fold(1.0, f64::max)
}

/// Gives samples of which one side is known their colour: their own of that side, changed by the mean of what changes from
/// the same side's colour to the finished colour of those neighbours of which both are known. By `inward`; samples that
/// it does not reach keep the side that is known.
pub fn fill(size: [u32; 2], frames: [&Frame; 2], shaded: &[Shaded], colours: &mut [Option<Colour>]) {
    let most = most_of(frames);
    let side = |place: usize| match shaded[place].mask {
        1 => Some(0),
        2 => Some(1),
        _ => None,
    };
    // That of another place in the frame that shows `place`. Samples that frames i - 1 and i + 2 helped do not count.
    let same_side = |place: usize, other: usize| match shaded[other].mask {
        0 | 4 => None,
        _ => shaded[other].sides[side(place)?],
    };
    let pending = (0..shaded.len()).filter(|place| colours[*place].is_none() && side(*place).is_some()).collect();
    let value = |place: usize, others: &[usize], colours: &[Option<Colour>]| {
        let pairs = others.iter().filter_map(|other| Some([colours[*other]?, same_side(place, *other)?]));
        let known = same_side(place, place).unwrap_or([0.0; 4]);
        predict(known, &pairs.collect::<Vec<_>>(), most)
    };
    let left = inward(size, pending, colours, |place, other| same_side(place, other).is_some(), value);
    left.iter().for_each(|place| colours[*place] = same_side(*place, *place));
}
