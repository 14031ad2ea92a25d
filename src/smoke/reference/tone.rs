//! Tones from smoothed luminance (section 3.4 of the paper), and lines over them.
//!
//! Images have `size` = [width, height] pixels, row by row from the top.

use crate::smoke::settings::{Mask, Outline};
use crate::toon::Tone;

/// Tone colour of every pixel, linear RGB; black where `id` is 0.
///
/// `smooth` is the smoothed luminance, `softness` the width in pixels over which tones mix. Tone after tone is
/// composited over the first with the share `clamp(0.5 + (S - from) / (2 softness |grad S|), 0, 1)`: a step, open at
/// `from`, where the product is 0.
pub fn tones(size: [u32; 2], smooth: &[f64], id: &[u32], mask: Mask, tones: &[Tone], softness: f64) -> Vec<[f64; 3]> {
    let colour = |pixel: usize| {
        if id[pixel] == 0 {
            return [0.0; 3];
        }
        let slope = 2.0 * softness * gradient(size, smooth, id, mask, pixel);
        let mut colour = tones.first().map_or([0.0; 3], |tone| tone.colour.map(f64::from));
        for tone in tones.iter().skip(1) {
            let over = smooth[pixel] - f64::from(tone.from);
            let step = if over >= 0.0 { 1.0 } else { 0.0 };
            let share = if slope > 0.0 { (0.5 + over / slope).clamp(0.0, 1.0) } else { step };
            colour = mix(colour, tone.colour, share);
        }
        colour
    };
    (0..smooth.len()).map(colour).collect()
}

/// Length of the gradient per pixel: central differences within the pixel's own ID, one-sided where only one neighbour
/// has it (the image's border included), 0 where none has. Under the soft mask smooth surfaces change their ID, range of
/// depth by range, so the next ones count, too.
fn gradient(size: [u32; 2], smooth: &[f64], id: &[u32], mask: Mask, pixel: usize) -> f64 {
    let most = match mask {
        Mask::Groups => 0,
        Mask::Soft => 1,
    };
    let [x, y] = place(size, pixel);
    let along = |dx: i64, dy: i64| {
        let value = |side: i64| {
            let other = inside(size, x + side * dx, y + side * dy)?;
            (id[other] != 0 && id[other].abs_diff(id[pixel]) <= most).then(|| smooth[other])
        };
        match (value(-1), value(1)) {
            (Some(before), Some(after)) => (after - before) / 2.0,
            (Some(before), None) => smooth[pixel] - before,
            (None, Some(after)) => after - smooth[pixel],
            (None, None) => 0.0,
        }
    };
    along(1, 0).hypot(along(0, 1))
}

/// The effect's image, linear RGBA: lines over the tone, silhouettes over inner lines, which are seen where they are the
/// stronger ones; alpha 1 on smoke; all 0 where `id` is 0. `lines` has the opacities of inner lines and of silhouettes.
pub fn composite(tone: &[[f64; 3]], lines: &[[f64; 2]], id: &[u32], outline: &Outline) -> Vec<[f64; 4]> {
    let [inner, silhouettes] = [outline.inner_lines(), outline.silhouettes()].map(|line| line.colour.map(f64::from));
    let pixel = |((tone, line), id): ((&[f64; 3], &[f64; 2]), &u32)| {
        let ink = line[0].max(line[1]);
        let [r, g, b] =
            std::array::from_fn(|c| tone[c] * (1.0 - ink) + silhouettes[c] * line[1] + inner[c] * (ink - line[1]));
        if *id == 0 { [0.0; 4] } else { [r, g, b, 1.0] }
    };
    tone.iter().zip(lines).zip(id).map(pixel).collect()
}

/// The share `share` of `b` composited over `a`.
fn mix(a: [f64; 3], b: [f32; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] * (1.0 - share) + f64::from(b[c]) * share)
}

/// Column and row of a pixel.
pub(super) fn place(size: [u32; 2], pixel: usize) -> [i64; 2] {
    let width = size[0] as usize;
    [(pixel % width) as i64, (pixel / width) as i64]
}

/// The pixel in column `x` and row `y`, if there is one.
pub(super) fn inside(size: [u32; 2], x: i64, y: i64) -> Option<usize> {
    let [width, height] = size.map(i64::from);
    ((0..width).contains(&x) && (0..height).contains(&y)).then_some((y * width + x) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smoke::settings::Line;

    const SIZE: [u32; 2] = [9, 7];

    fn image<T>(value: impl Fn(i64, i64) -> T) -> Vec<T> {
        (0..63).map(|pixel| value(pixel % 9, pixel / 9)).collect()
    }

    fn two_tones(from: f32) -> [Tone; 2] {
        [Tone { from: 0.0, colour: [0.0, 0.5, 1.0] }, Tone { from, colour: [1.0, 0.5, 0.0] }]
    }

    #[test]
    fn hard_tones_step_at_their_threshold() {
        let smooth = image(|x, _| x as f64 / 8.0);
        let colours = tones(SIZE, &smooth, &image(|_, _| 1), Mask::Groups, &two_tones(0.5), 0.0);
        let red: Vec<f64> = colours[..9].iter().map(|c| c[0]).collect();
        assert_eq!(red, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(colours[0], [0.0, 0.5, 1.0]);
        assert_eq!(tones(SIZE, &smooth, &image(|_, _| 0), Mask::Groups, &two_tones(0.5), 0.0), [[0.0; 3]; 63]);
    }

    #[test]
    fn soft_tones_mix_by_the_distance_in_pixels() {
        // Slope 1/8 per pixel; softness 2: the border is 4 pixels wide, and the share 1/2 lies at x = 4.
        let smooth = image(|x, _| x as f64 / 8.0);
        let colours = tones(SIZE, &smooth, &image(|_, _| 1), Mask::Groups, &two_tones(0.5), 2.0);
        let red: Vec<f64> = colours[9..18].iter().map(|c| c[0]).collect();
        assert_eq!(red, [0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0]);
        // Three tones are composited over each other in order.
        let three = [two_tones(0.5)[0], two_tones(0.5)[1], Tone { from: 0.625, colour: [0.0, 0.0, 0.0] }];
        let colour = tones(SIZE, &smooth, &image(|_, _| 1), Mask::Groups, &three, 2.0)[4];
        assert_eq!(colour, [0.375, 0.375, 0.375]);
    }

    #[test]
    fn gradients_stay_within_their_id() {
        // A jump of 5 between columns 3 and 4; the slope is 0.1 on the left, 0.3 on the right, 0.2 downwards.
        let smooth = image(|x, y| if x < 4 { 0.1 * x as f64 } else { 5.0 + 0.3 * x as f64 } + 0.2 * y as f64);
        let id = image(|x, _| if x < 4 { 1 } else { 2 });
        for (x, across) in [(0, 0.1), (1, 0.1), (3, 0.1), (4, 0.3), (8, 0.3)] {
            for y in [0, 3, 6] {
                let expected = f64::hypot(across, 0.2);
                assert!(
                    (gradient(SIZE, &smooth, &id, Mask::Groups, y * 9 + x) - expected).abs() < 1e-14,
                    "at {x}, {y}"
                );
            }
        }
        // Under the soft mask the jump counts from one range to the next, and not over two.
        let across_ids = |id: &[u32]| gradient(SIZE, &smooth, id, Mask::Soft, 3 * 9 + 3);
        let jump = (5.0 + 0.3 * 4.0 - 0.2) / 2.0;
        assert!((across_ids(&id) - f64::hypot(jump, 0.2)).abs() < 1e-14);
        assert!((across_ids(&image(|x, _| if x < 4 { 1 } else { 3 })) - f64::hypot(0.1, 0.2)).abs() < 1e-14);
        assert!((across_ids(&image(|x, _| if x < 4 { 1 } else { 0 })) - f64::hypot(0.1, 0.2)).abs() < 1e-14);
        // An ID of its own everywhere: no gradient, hence a step.
        let alone = image(|x, y| 1 + (y * 9 + x) as u32);
        assert_eq!(gradient(SIZE, &smooth, &alone, Mask::Groups, 30), 0.0);
    }

    #[test]
    fn silhouettes_lie_over_inner_lines_and_both_over_the_tone() {
        let of = |colour| Line { colour: Some(colour), ..Line::default() };
        let outline = Outline { inner: of([0.5, 1.0, 0.0]), silhouette: of([0.0, 0.0, 1.0]), ..Outline::default() };
        let lines = [[0.0; 2], [0.5, 0.0], [1.0, 0.25], [0.25, 1.0], [1.0; 2]];
        let image = composite(&[[0.5, 0.25, 1.0]; 5], &lines, &[1, 2, 3, 3, 0], &outline);
        let both = [0.375, 0.75, 0.25, 1.0];
        assert_eq!(image, [[0.5, 0.25, 1.0, 1.0], [0.5, 0.625, 0.5, 1.0], both, [0.0, 0.0, 1.0, 1.0], [0.0; 4]]);
    }
}
