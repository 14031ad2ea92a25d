//! What is measured in one frame of smoke: airbrushed ink, seams, specks, flat sides.

use super::plane::Plane;

/// Line opacity above which a pixel is ink.
pub(super) const INK: f32 = 0.5;
/// Line opacities that darken without drawing.
const AIRBRUSH: [f32; 2] = [0.02, INK];
/// Pixels around ink within which such an opacity is the ink's antialiased border.
const INK_BORDER: i64 = 3;
/// Area in pixels below which a piece is a speck.
const SPECK: usize = 12;
/// Share of a voxel's side below which two neighbouring pixels show one surface.
const CONTINUOUS: f64 = 0.5;
/// How much steeper than the Gaussian of a step a smoothed luminance may be; see [`steepest`].
const STEEPNESS: f64 = 1.5;

/// Tones of pixels: 0 where there is no smoke, then the tone's number from 1.
pub(super) type Tones = Plane<u16>;

/// A share of what was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Share {
    /// How many have it.
    pub(super) part: u64,
    /// How many there are.
    pub(super) whole: u64,
}

impl Share {
    pub(super) fn new(part: u64, whole: u64) -> Share {
        Share { part, whole }
    }

    /// In percent; none of nothing.
    pub(super) fn percent(self) -> Option<f64> {
        (self.whole > 0).then(|| 100.0 * self.part as f64 / self.whole as f64)
    }
}

/// Mean of those that are there.
pub(super) fn mean(values: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    let (sum, count) = values.into_iter().flatten().fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// Pixels that are inked.
pub(super) fn inked(line: &Plane<f32>) -> Plane<bool> {
    line.map(|opacity| *opacity > INK)
}

/// Pixels that a line darkens without drawing: opacity 0.02 to 0.5, and no ink within 3 px.
pub(super) fn airbrushed(line: &Plane<f32>) -> Plane<bool> {
    let near = inked(line).near(INK_BORDER);
    let [faint, full] = AIRBRUSH;
    line.filled(|i| line.values[i] >= faint && line.values[i] <= full && !near.values[i])
}

/// Pixels of all pieces of less than 12 px, and how many pieces that are.
pub(super) fn specks(mask: &Plane<bool>) -> (Plane<bool>, usize) {
    let (mut found, mut count) = (mask.map(|_| false), 0);
    for piece in mask.pieces().iter().filter(|piece| piece.len() < SPECK) {
        count += 1;
        piece.iter().for_each(|at| found.values[*at] = true);
    }
    (found, count)
}

/// The largest share of one tone among pixels of smoke, ink aside.
pub(super) fn largest_tone(tone: &Tones, line: &Plane<f32>) -> Share {
    let mut counts = vec![0_u64; tone.values.iter().max().map_or(1, |most| usize::from(*most) + 1)];
    for (tone, _) in tone.values.iter().zip(&line.values).filter(|(_, line)| **line <= INK) {
        counts[usize::from(*tone)] += 1;
    }
    let seen = &counts[1..];
    Share::new(seen.iter().copied().max().unwrap_or(0), seen.iter().sum())
}

/// The largest difference of a smoothed luminance between neighbouring pixels: 1.5 / (sigma sqrt(2 pi)), for a Gaussian of
/// `sigma` pixels.
///
/// Luminances are 0 to 1, so a Gaussian of them is steepest at a straight step from 0 to 1, where its slope is the
/// Gaussian's own height, 1 / (sigma sqrt(2 pi)) a pixel; that holds within one mask and away from its borders. At a
/// straight border of a mask, where half of the window is missing, numerator and denominator change together and the slope
/// stays below that; where a mask is a thin or broken strip it can be more, up to what two lone pixels have. Half as much
/// again is allowed for that, the cut window and luminances' 24 bits. What is beyond has not been smoothed across.
/// Infinite without a Gaussian.
pub(super) fn steepest(sigma: f64) -> f64 {
    STEEPNESS / (sigma * std::f64::consts::TAU.sqrt())
}

/// One frame as its borders between tones are looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface<'a> {
    pub(super) tone: &'a Tones,
    /// View depth in metres.
    pub(super) depth: &'a Plane<f32>,
    /// The mask that each pixel was smoothed in.
    pub(super) mask: &'a Plane<u32>,
    /// Smoothed luminance, 0 to 1.
    pub(super) smooth: &'a Plane<f32>,
    /// Smallest side of a voxel in metres.
    pub(super) voxel: f64,
    /// The most that `smooth` may differ between neighbours; see [`steepest`].
    pub(super) steepest: f64,
}

/// Borders between tones: pairs of neighbouring pixels of smoke, horizontal and vertical, of different tones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Borders {
    /// Those on one surface (a step in depth below half a voxel) between two masks.
    pub(super) seams: Share,
    /// Those on one surface where the smoothed luminance is steeper than a Gaussian can be.
    pub(super) jumps: Share,
}

pub(super) fn borders(surface: &Surface) -> Borders {
    let Surface { tone, depth, mask, smooth, voxel, steepest } = *surface;
    let (mut borders, mut seams, mut jumps) = (0, 0, 0);
    for [a, b] in tone.pairs() {
        let [one, other] = [a, b].map(|i| tone.values[i]);
        if one == 0 || other == 0 || one == other {
            continue;
        }
        borders += 1;
        let difference = |values: &Plane<f32>| f64::from(values.values[a] - values.values[b]).abs();
        if difference(depth) < CONTINUOUS * voxel {
            seams += u64::from(mask.values[a] != mask.values[b]);
            jumps += u64::from(difference(smooth) > steepest);
        }
    }
    Borders { seams: Share::new(seams, borders), jumps: Share::new(jumps, borders) }
}

#[cfg(test)]
mod tests {
    use super::super::plane::drawn;
    use super::*;

    #[test]
    fn what_is_faint_and_far_from_ink_is_airbrushed() {
        let line = drawn(&["#...a.a", "......o"], |c| match c {
            '#' => 1.0,
            'a' => 0.3,
            'o' => 0.01,
            _ => 0.0,
        });
        // Four columns away and six; the one before is too faint.
        let found = airbrushed(&line);
        assert_eq!(found, drawn(&["....x.x", "......."], |c| c == 'x'));
        let near = drawn(&["#..a", "...."], |c| {
            if c == '#' {
                0.51
            } else if c == 'a' {
                0.5
            } else {
                0.0
            }
        });
        assert_eq!(airbrushed(&near).count(), 0);
        assert_eq!((inked(&near).count(), inked(&line).count()), (1, 1));
    }

    #[test]
    fn specks_are_pieces_below_twelve_pixels() {
        let mask = drawn(&["xxxx.xxxx.x", "xxxx.xxxx..", "xxxx.xxx..."], |c| c == 'x');
        let (found, count) = specks(&mask);
        assert_eq!((found.count(), count), (12, 2));
        assert!(!found.values[0] && found.values[5] && found.values[10]);
    }

    #[test]
    fn the_largest_tone_is_that_of_what_is_not_ink() {
        let tone = drawn(&["1122", "1.22"], |c| c.to_digit(10).unwrap_or(0) as u16);
        let line = drawn(&["...#", "..##"], |c| if c == '#' { 1.0 } else { 0.0 });
        assert_eq!(largest_tone(&tone, &line), Share::new(3, 4));
        assert_eq!(largest_tone(&tone.map(|_| 0), &line).percent(), None);
        assert_eq!(mean([None, Some(1.0), Some(2.0)]), Some(1.5));
        assert_eq!(mean([None]), None);
    }

    #[test]
    fn seams_are_borders_of_masks_on_one_surface() {
        // Three columns: tone 1, 2, 1; rows: one mask and surface; masks differ; a step in depth, too; luminance jumps.
        let tone = drawn(&["121", "121", "121", "121", "1.1"], |c| c.to_digit(10).unwrap_or(0) as u16);
        let mask = drawn(&["111", "122", "122", "111", "1.2"], |c| c.to_digit(10).unwrap_or(0));
        let depth = drawn(&["000", "000", "055", "000", "0.0"], |c| c.to_digit(10).unwrap_or(0) as f32);
        let smooth = drawn(&["011", "011", "099", "099", "0.9"], |c| 0.1 * c.to_digit(10).unwrap_or(0) as f32);
        let surface =
            Surface { tone: &tone, depth: &depth, mask: &mask, smooth: &smooth, voxel: 1.0, steepest: steepest(4.0) };
        let found = borders(&surface);
        assert_eq!((found.seams, found.jumps), (Share::new(1, 8), Share::new(1, 8)));
    }

    /// Of a step from 0 to 1, smoothed as the paper does within one mask and beside the border of one.
    #[test]
    fn a_gaussian_is_not_steeper_than_is_allowed() {
        let sigma = 4.0_f64;
        let weight = |a: i64, b: i64| (-0.5 * ((a - b) as f64 / sigma).powi(2)).exp();
        for (step, begin) in [(0, -40), (0, -1), (0, 0), (2, 0), (5, 0), (9, 0)] {
            let smooth = |x: i64| {
                let all = (begin..40).map(|y| weight(x, y)).sum::<f64>();
                (begin.max(step)..40).map(|y| weight(x, y)).sum::<f64>() / all
            };
            let most = (begin.max(-20)..20).map(|x| (smooth(x + 1) - smooth(x)).abs()).fold(0.0, f64::max);
            assert!(most < steepest(sigma) / STEEPNESS * 1.001, "{step} {begin}: {most}");
        }
        assert_eq!(steepest(0.0), f64::INFINITY);
    }
}
