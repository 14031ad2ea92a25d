//! Pictures of what was found: the frame in grey, faults in colours.

use super::motion::Carried;
use super::plane::Plane;
use crate::io::image::srgb8;

/// Airbrushed pixels: orange.
const AIRBRUSH: [u8; 3] = [255, 150, 0];
/// Pixels whose tone flips: magenta.
const BOIL: [u8; 3] = [230, 0, 200];
/// Ink that is gone a frame later: blue.
const LOST: [u8; 3] = [0, 110, 255];
/// Specks: green.
const SPECKS: [u8; 3] = [0, 220, 60];

/// The colours, for people.
pub(super) const LEGEND: &str =
    "*_faults.png: airbrush orange, tones that flip magenta, lines that are lost blue, specks green";

/// A frame as the program writes it, and what of it is marked. 8-bit sRGB.
pub(super) struct Faults {
    pub(super) picture: Vec<[u8; 4]>,
    pub(super) marked: Vec<[u8; 4]>,
}

impl Faults {
    /// Of a frame (linear RGBA, premultiplied); nothing is marked yet.
    pub(super) fn new(picture: &[[f32; 4]]) -> Faults {
        let picture = srgb8(picture);
        let grey = |[r, g, b, _]: [u8; 4]| {
            let sum = 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b);
            let grey = (sum / 1000) as u8;
            [grey, grey, grey, 255]
        };
        let marked = picture.iter().map(|pixel| grey(*pixel)).collect();
        Faults { picture, marked }
    }

    /// Marks what is found in the frame itself.
    pub(super) fn mark_still(&mut self, airbrush: &Plane<bool>, specks: [&Plane<bool>; 2]) {
        self.mark(airbrush, AIRBRUSH);
        specks.iter().for_each(|specks| self.mark(specks, SPECKS));
    }

    /// Marks what the next frame has shown.
    pub(super) fn mark_carried(&mut self, carried: &Carried) {
        self.mark(&carried.tone_faults, BOIL);
        self.mark(&carried.lines_lost_faults, LOST);
    }

    fn mark(&mut self, mask: &Plane<bool>, [r, g, b]: [u8; 3]) {
        let marked = self.marked.iter_mut().zip(&mask.values).filter(|(_, set)| **set);
        marked.for_each(|(pixel, _)| *pixel = [r, g, b, 255]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_coloured_and_the_rest_is_grey() {
        let mut faults = Faults::new(&[[1.0, 0.0, 0.0, 1.0], [1.0; 4], [0.0, 0.0, 0.0, 1.0]]);
        let mask = |values: [bool; 3]| Plane::new(3, values.to_vec());
        faults.mark_still(&mask([false, false, true]), [&mask([false; 3]), &mask([false, true, false])]);
        assert_eq!(faults.picture[0], [255, 0, 0, 255]);
        assert_eq!(faults.marked, [[76, 76, 76, 255], [0, 220, 60, 255], [255, 150, 0, 255]]);
    }
}
