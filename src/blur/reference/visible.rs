//! Which colours the two frames show of what a sample sees, and what is made of them.

use super::distort::{Drawing, Fragment, interpolate};
use super::raster::{Clip, Raster, Shape, raster, volume};
use crate::blur::settings::Mix;

/// Share by which the depth that a tap sees may differ from that of the surface looked for.
const DEPTH_TOLERANCE: f64 = 0.003;
/// Weight of the visible taps above which a colour is known.
const KNOWN_WEIGHT: f64 = 0.25;
/// A device's error of a depth, as a share of it, besides what a moved corner changes.
const DEPTH_ROUNDING: f64 = 1e-5;
/// How far a device may have a place on screen from where it is, in pixels.
const PLACE_ROUNDING: f64 = 1e-3;

/// Linear RGBA, premultiplied.
pub type Colour = [f64; 4];

/// The constant data of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// The surface of each triangle of the mesh: what an object has of one material.
    pub surfaces: &'a [u32],
    /// Whether each triangle is of a closed surface that is seen from outside.
    pub closed: &'a [bool],
    /// Whether each triangle stays where it is in frame i + 1: its three points are in no cluster.
    pub still: &'a [bool],
    /// The nearest depth seen in metres.
    pub near: f64,
}

/// The mesh in one frame, and the frame's image.
#[derive(Clone, Debug)]
pub struct Frame<'a> {
    /// Corners of each triangle of the mesh.
    pub corners: &'a [[Clip; 3]],
    /// World normals of these corners, of any length.
    pub normals: &'a [[[f64; 3]; 3]],
    /// Pixels of the image: linear light, premultiplied.
    pub image: &'a [[f32; 4]],
    /// The triangles that its pixels see, in both orientations.
    pub seen: Raster,
    shapes: Vec<Option<Shape>>,
}

/// A colour looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Mean of the visible taps by their weights; 0 where there are none.
    pub colour: Colour,
    /// Sum of the visible taps' weights, 0 to 1.
    pub weight: f64,
    /// Whether rounding may have decided about a tap.
    pub uncertain: bool,
}

impl Look {
    /// The colour, where it is known.
    pub fn known(&self) -> Option<Colour> {
        (self.weight > KNOWN_WEIGHT).then_some(self.colour)
    }
}

impl<'a> Frame<'a> {
    /// Draws the mesh as it is in a frame.
    pub fn new(
        corners: &'a [[Clip; 3]],
        normals: &'a [[[f64; 3]; 3]],
        image: &'a [[f32; 4]],
        size: [u32; 2],
        near: f64,
    ) -> Frame<'a> {
        let shapes: Vec<Option<Shape>> = corners.iter().map(|corners| Shape::new(*corners)).collect();
        Frame { corners, normals, image, seen: raster(&shapes, size, near), shapes }
    }

    /// The pixels of the image that see the mesh.
    pub fn shown(&self) -> impl Iterator<Item = &'a [f32; 4]> {
        self.image.iter().zip(&self.seen.seen).filter(|(_, seen)| **seen > 0).map(|(pixel, _)| pixel)
    }

    /// The colour of a place, given by its triangle and its barycentric coordinates there: four bilinear taps, of which
    /// those count that see the same surface at the depth that the triangle's plane has at the tap's centre, within
    /// `DEPTH_TOLERANCE`. Of a triangle without area the place's own depth counts. Taps off screen see nothing, and
    /// neither does what is nearer than the near plane. A tap has its [surface's colour](Frame::surface).
    pub fn look_up(&self, surface: &Surface, base: u32, weights: [f64; 3]) -> Look {
        let [x, y, w] = interpolate(weights, self.corners[base as usize]);
        let mut look =
            Look { colour: [0.0; 4], weight: 0.0, uncertain: (w / surface.near - 1.0).abs() < DEPTH_ROUNDING };
        let [u, v] = [x / w - 0.5, y / w - 0.5];
        if w < surface.near || !(u.is_finite() && v.is_finite()) {
            return look;
        }
        let mut colour = [0.0; 4];
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let tap = [u.floor() + dx, v.floor() + dy];
            let share = (1.0 - (u - tap[0]).abs()) * (1.0 - (v - tap[1]).abs());
            let Some(pixel) = self.pixel(tap) else { continue };
            let (sees, uncertain) = self.sees(surface, pixel, tap.map(|c| c + 0.5), base, w);
            look.uncertain |= uncertain && share > PLACE_ROUNDING;
            if sees {
                look.weight += share;
                let value = self.surface(surface, pixel, surface.surfaces[base as usize]);
                (0..4).for_each(|i| colour[i] += share * value[i]);
            }
        }
        look.uncertain |= (look.weight - KNOWN_WEIGHT).abs() < 2.0 * PLACE_ROUNDING;
        look.colour = if look.weight > 0.0 { colour.map(|c| c / look.weight) } else { [0.0; 4] };
        look
    }

    /// The colour of the surface of that number in a pixel that sees it. A pixel at its border is covered in part: if its
    /// alpha is between 0 and 1, and one of its eight neighbours does not see the surface, then its colour is brought to
    /// the largest alpha of it and of those that do. Without this a border that is stretched would be full of holes.
    pub fn surface(&self, surface: &Surface, pixel: usize, number: u32) -> Colour {
        let own = self.image[pixel].map(f64::from);
        let width = self.seen.size[0] as usize;
        let [x, y] = [(pixel % width) as f64, (pixel / width) as f64];
        let around = (0..9).filter_map(|i| self.pixel([x + f64::from(i % 3) - 1.0, y + f64::from(i / 3) - 1.0]));
        let sees = |pixel: &usize| {
            self.seen.seen[*pixel].checked_sub(1).is_some_and(|other| surface.surfaces[other as usize] == number)
        };
        let (of_it, beside): (Vec<usize>, Vec<usize>) = around.partition(sees);
        if beside.is_empty() || !(own[3] > 0.0 && own[3] < 1.0) {
            return own;
        }
        let opacity = of_it.iter().map(|pixel| f64::from(self.image[*pixel][3])).fold(own[3], f64::max);
        own.map(|c| c * opacity / own[3])
    }

    /// The triangle that a pixel's centre sees, and the barycentric coordinates there.
    pub fn place(&self, pixel: usize) -> Option<(u32, [f64; 3])> {
        let base = self.seen.seen[pixel].checked_sub(1)?;
        let width = self.seen.size[0] as usize;
        let centre = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
        Some((base, self.shapes[base as usize].as_ref()?.weights(centre)?))
    }

    /// The world normal at a place, of any length: interpolated between the corners, and turned over where the triangle
    /// is turned away in this frame and of nothing closed, for such a one is seen from both sides.
    pub fn normal(&self, surface: &Surface, base: u32, weights: [f64; 3]) -> [f64; 3] {
        let normal = interpolate(weights, self.normals[base as usize]);
        let is_turned = !surface.closed[base as usize] && volume(self.corners[base as usize]) > 0.0;
        if is_turned { normal.map(|c| -c) } else { normal }
    }

    fn pixel(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let [width, height] = self.seen.size.map(f64::from);
        let inside = (0.0..width).contains(&x) && (0.0..height).contains(&y);
        inside.then(|| y as usize * self.seen.size[0] as usize + x as usize)
    }

    /// Whether a pixel sees the surface that triangle `base` is a part of, and whether rounding may have decided.
    fn sees(&self, surface: &Surface, pixel: usize, centre: [f64; 2], base: u32, depth: f64) -> (bool, bool) {
        let uncertain = self.seen.uncertain[pixel];
        let Some(other) = self.seen.seen[pixel].checked_sub(1) else { return (false, uncertain) };
        let is_same = surface.surfaces[other as usize] == surface.surfaces[base as usize];
        let (own, slope) = match &self.shapes[base as usize] {
            Some(shape) => (shape.inverse_depth(centre), shape.slope()),
            None => (1.0 / depth, 0.0),
        };
        let seen = 1.0 / self.seen.depth[pixel];
        // |W - W'| <= tolerance W, both multiplied by 1 / W and 1 / W'. A plane that is not seen there differs by more.
        let (difference, allowed) = ((own - seen).abs(), DEPTH_TOLERANCE * seen);
        let margin = DEPTH_ROUNDING * seen + slope * PLACE_ROUNDING;
        (is_same && difference <= allowed, uncertain || (is_same && (difference - allowed).abs() < margin))
    }
}

/// The colour of a sample, and how it came about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaded {
    /// 0: neither frame shows what the sample sees, 1: only frame i, 2: only frame i + 1, 3: both, 4: it sees nothing.
    pub mask: u8,
    /// The surface that it sees.
    pub fragment: Option<Fragment>,
    /// Colours of frames i and i + 1. With mask 0: those of frames i - 1 and i + 2 instead.
    pub sides: [Option<Colour>; 2],
    /// Whether rounding may have decided about anything here.
    pub uncertain: bool,
}

/// Looks up every sample in frames i and i + 1, and where neither shows it in frames i - 1 and i + 2 (`outer`), where
/// there are such frames.
pub fn shade(surface: &Surface, drawing: &Drawing, frames: [&Frame; 2], outer: [Option<&Frame>; 2]) -> Vec<Shaded> {
    let one = |(fragment, uncertain): (&Option<Fragment>, &bool)| {
        let mut uncertain = *uncertain;
        let Some(seen) = *fragment else { return Shaded { mask: 4, fragment: None, sides: [None; 2], uncertain } };
        let mut look = |frame: &Frame| {
            let look = frame.look_up(surface, seen.base, seen.weights);
            uncertain |= look.uncertain;
            look.known()
        };
        let mut sides = frames.map(&mut look);
        let mask = u8::from(sides[0].is_some()) + 2 * u8::from(sides[1].is_some());
        if mask == 0 {
            sides = outer.map(|frame| frame.and_then(&mut look));
        }
        Shaded { mask, fragment: *fragment, sides, uncertain }
    };
    drawing.fragments.iter().zip(&drawing.raster.uncertain).map(one).collect()
}

/// `(1 - k') c_i + k' c_{i+1}`, k' from 0 to 1.
pub fn mix(time: f64, sides: [Colour; 2]) -> Colour {
    let share = time.clamp(0.0, 1.0);
    std::array::from_fn(|i| (1.0 - share) * sides[0][i] + share * sides[1][i])
}

/// What `how` makes of two colours at a time: [`mix`], or the later one from the middle on.
pub fn mixture(how: Mix, time: f64, sides: [Colour; 2]) -> Colour {
    match how {
        Mix::Blend => mix(time, sides),
        Mix::Choose => sides[usize::from(time >= 0.5)],
    }
}

/// The finished image, pixel by pixel: the mean of each pixel's samples. `colours` is the distorted mesh alone
/// ([`super::complete::complete`]), sample by sample.
///
/// A sample that sees nothing, or a triangle that stays, is the pixel of image i + 1, if the pixel's centre sees nothing
/// in frame i + 1, or a triangle that stays. Any other that sees nothing is the pixel of image i, if the pixel's centre
/// sees nothing in frame i, or a triangle that stays; else `background`. Any other is its colour, over what the sample
/// would be if it saw nothing.
///
/// So a pixel around which nothing moves has four equal samples: it is image i + 1's, bit for bit.
pub fn compose(
    surface: &Surface,
    drawing: &Drawing,
    frames: [&Frame; 2],
    shaded: &[Shaded],
    colours: &[Colour],
    background: [f32; 4],
) -> Vec<Colour> {
    let samples = drawing.samples as usize;
    let size = drawing.raster.size.map(|side| side as usize / samples);
    let is_still = |base: u32| surface.still[base as usize];
    let pixel = |place: usize| {
        let [x, y] = [place % size[0], place / size[0]];
        let is_free = frames.map(|frame| frame.seen.seen[place].checked_sub(1).is_none_or(is_still));
        let behind = match is_free {
            [_, true] => frames[1].image[place],
            [true, false] => frames[0].image[place],
            [false, false] => background,
        };
        let behind = behind.map(f64::from);
        let sample = |i: usize| {
            let sample = (y * samples + i / samples) * samples * size[0] + x * samples + i % samples;
            match shaded[sample].fragment {
                Some(fragment) if !(is_free[1] && is_still(fragment.base)) => {
                    let colour = colours[sample];
                    [0, 1, 2, 3].map(|i| colour[i] + (1.0 - colour[3]) * behind[i])
                }
                _ => behind,
            }
        };
        let all: Vec<Colour> = (0..samples * samples).map(sample).collect();
        [0, 1, 2, 3].map(|i| all.iter().map(|colour| colour[i]).sum::<f64>() / all.len() as f64)
    };
    (0..size[0] * size[1]).map(pixel).collect()
}

#[cfg(test)]
pub(super) mod rig;
#[cfg(test)]
mod tests;
