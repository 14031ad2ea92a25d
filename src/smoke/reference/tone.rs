//! Tones from smoothed luminance (section 3.4 of the paper), and lines over them.
//!
//! Images have `size` = [width, height] pixels, row by row from the top.

use crate::smoke::settings::{Mask, Outline, Settings};
use crate::toon::Tone;
use crate::view::Light;

/// Pixels with what is smoothed compared as the mask says.
#[derive(Clone, Copy, Debug)]
pub struct Canvas<'a> {
    /// Width and height.
    pub size: [u32; 2],
    /// Group of every pixel; 0 where nothing is seen.
    pub id: &'a [u32],
    /// Which groups are compared.
    pub mask: Mask,
    /// Width in pixels over which borders are drawn.
    pub softness: f64,
}

/// The light on a picture, all smoothed: what [`Canvas::painted`] makes colours of.
#[derive(Clone, Copy, Debug)]
pub struct Lit<'a> {
    /// Luminance, with the rim.
    pub luminance: &'a [f64],
    /// Share of the light that arrives; without it, no shadow is looked at.
    pub shade: Option<&'a [f64]>,
    /// The fire's colour and its light.
    pub fire: Option<([f32; 3], &'a [f64])>,
}

impl Canvas<'_> {
    /// Share of a pixel where a smoothed value is at least `from`: `clamp(0.5 + (S - from) / (2 softness |grad S|), 0, 1)`; a
    /// step, open at `from`, where the product is 0.
    fn share(&self, smooth: &[f64], pixel: usize, from: f64) -> f64 {
        self.share_of(smooth, pixel, smooth[pixel] - from)
    }

    /// The same of a value that is `over` what it begins at, with the border of `smooth`.
    fn share_of(&self, smooth: &[f64], pixel: usize, over: f64) -> f64 {
        let slope = 2.0 * self.softness * gradient(self.size, smooth, self.id, self.mask, pixel);
        let step = if over >= 0.0 { 1.0 } else { 0.0 };
        if slope > 0.0 { (0.5 + over / slope).clamp(0.0, 1.0) } else { step }
    }

    /// The pixels that show something.
    fn seen(&self) -> impl Iterator<Item = usize> {
        (0..self.id.len()).filter(|pixel| self.id[*pixel] != 0)
    }

    /// Share of each pixel that is in shadow: where less than half of the light arrives.
    pub fn shaded(&self, shade: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; self.id.len()];
        self.seen().for_each(|pixel| image[pixel] = 1.0 - self.share(shade, pixel, 0.5));
        image
    }

    /// Shares of each pixel of the first three tones, and of all others together: they add up to 1.
    pub fn mattes(&self, smooth: &[f64], tones: &[Tone]) -> Vec<[f64; 4]> {
        let mut image = vec![[0.0; 4]; self.id.len()];
        for pixel in self.seen() {
            // A tone has what the higher ones leave of it.
            let mut left = 1.0;
            for (i, tone) in tones.iter().enumerate().rev() {
                let share = if i == 0 { 1.0 } else { self.share(smooth, pixel, tone.from.into()) };
                image[pixel][i.min(3)] += left * share;
                left *= 1.0 - share;
            }
        }
        image
    }

    /// Share of each pixel whose tone is a higher one because of the rim, which luminance has in it.
    pub fn rim(&self, smooth: &[f64], without: &[f64], tones: &[Tone]) -> Vec<f64> {
        let mut image = vec![0.0; self.id.len()];
        for pixel in self.seen() {
            let risen = tones.iter().skip(1).map(|tone| {
                let [over, before] = [smooth, without].map(|of| of[pixel] - f64::from(tone.from));
                self.share_of(smooth, pixel, over) - self.share_of(smooth, pixel, before)
            });
            image[pixel] = risen.sum::<f64>().clamp(0.0, 1.0);
        }
        image
    }

    /// Tone colour of every pixel, linear RGB; black where nothing is seen. Tone after tone is composited over the first, in
    /// its colour in shadow over the share that is [`shaded`](Canvas::shaded). A share `above` of every pixel, if there are
    /// `tones_above`, has those instead. The fire adds its colour times the lightest tone, by the mean of the shares where its
    /// light is at least 1 / 2n, 3 / 2n, ... for n tones.
    pub fn painted(&self, settings: &Settings, lit: &Lit, above: &[f64]) -> Vec<[f64; 3]> {
        let shaded = lit.shade.map(|shade| self.shaded(shade));
        let colour = |tone: &Tone, pixel: usize| {
            let own = tone.colour.map(f64::from);
            mix(own, tone.shadow.unwrap_or(tone.colour), shaded.as_ref().map_or(0.0, |shaded| shaded[pixel]))
        };
        let of = |tones: &[Tone], pixel: usize| {
            let first = tones.first().map_or([0.0; 3], |tone| colour(tone, pixel));
            tones.iter().skip(1).fold(first, |below, tone| {
                let share = self.share(lit.luminance, pixel, tone.from.into());
                let own = colour(tone, pixel);
                std::array::from_fn(|c| below[c] * (1.0 - share) + own[c] * share)
            })
        };
        let last = |tones: &[Tone]| tones.last().map_or([0.0; 3], |tone| tone.colour);
        let mut image = vec![[0.0; 3]; self.id.len()];
        for pixel in self.seen() {
            let (mut own, mut lightest) = (of(&settings.tones, pixel), last(&settings.tones).map(f64::from));
            if let Some(tones) = &settings.tones_above {
                let higher = of(tones, pixel);
                own = std::array::from_fn(|c| own[c] * (1.0 - above[pixel]) + higher[c] * above[pixel]);
                lightest = mix(lightest, last(tones), above[pixel]);
            }
            if let Some((fire, light)) = lit.fire {
                let count = settings.tones.len();
                let steps = (1..count).map(|i| self.share(light, pixel, (i as f64 - 0.5) / count as f64)).sum::<f64>();
                let bright = steps / (count as f64 - 1.0).max(1.0);
                own = std::array::from_fn(|c| own[c] + f64::from(fire[c]) * lightest[c] * bright);
            }
            image[pixel] = own;
        }
        image
    }
}

/// Tone colour of every pixel, linear RGB, by luminance alone; black where `id` is 0.
///
/// `smooth` is the smoothed luminance, `softness` the width in pixels over which tones mix.
pub fn tones(size: [u32; 2], smooth: &[f64], id: &[u32], mask: Mask, tones: &[Tone], softness: f64) -> Vec<[f64; 3]> {
    let settings = Settings { tones: tones.to_vec(), ..Settings::default() };
    Canvas { size, id, mask, softness }.painted(&settings, &Lit { luminance: smooth, shade: None, fire: None }, &[])
}

/// Smoothed luminance with a light's rim over it, where surfaces, smoothed, are turned away.
pub fn rimmed(light: &Light, smooth: &[f64], away: &[f64]) -> Vec<f64> {
    smooth.iter().zip(away).map(|(luminance, away)| light.with_rim(*luminance, *away)).collect()
}

/// How far the colours at heights have changed to those of `tones_above`: 0 to 1; where the heights are one, a step.
pub fn gradient_share(heights: &[f64], [from, to]: [f32; 2]) -> Vec<f64> {
    let [from, to] = [from, to].map(f64::from);
    let share = |height: &f64| match to > from {
        true => ((height - from) / (to - from)).clamp(0.0, 1.0),
        false if *height >= from => 1.0,
        false => 0.0,
    };
    heights.iter().map(share).collect()
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
        [Tone::new(0.0, [0.0, 0.5, 1.0]), Tone::new(from, [1.0, 0.5, 0.0])]
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
        let three = [two_tones(0.5)[0], two_tones(0.5)[1], Tone::new(0.625, [0.0, 0.0, 0.0])];
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

    /// Columns of luminance 0, 1/8, ... 1 in one group.
    fn columns() -> (Vec<f64>, Vec<u32>) {
        (image(|x, _| x as f64 / 8.0), image(|_, _| 1))
    }

    #[test]
    fn shadows_fire_and_height_colour_what_they_reach() {
        let (smooth, id) = columns();
        let canvas = Canvas { size: SIZE, id: &id, mask: Mask::Groups, softness: 0.0 };
        let shadowed = Tone { shadow: Some([0.25, 0.0, 0.0]), ..Tone::new(0.5, [1.0, 0.0, 0.0]) };
        let tones_above = Some(vec![Tone::new(0.0, [0.0, 0.0, 0.5])]);
        let settings = Settings { tones: vec![Tone::new(0.0, [0.5, 0.0, 0.0]), shadowed], ..Settings::default() };
        // In shadow in the first rows.
        let shade = image(|_, y| if y < 3 { 0.0 } else { 1.0 });
        let lit = Lit { luminance: &smooth, shade: Some(&shade), fire: None };
        let colours = canvas.painted(&settings, &lit, &[]);
        assert_eq!([0, 8, 54, 62].map(|pixel| colours[pixel][0]), [0.5, 0.25, 0.5, 1.0]);
        assert_eq!([0, 62].map(|pixel| canvas.shaded(&shade)[pixel]), [1.0, 0.0]);
        // Two tones: one step, at a quarter of the light.
        let light = image(|_, y| if y < 2 { 0.24 } else { 0.25 });
        let lit = Lit { luminance: &smooth, shade: None, fire: Some(([2.0, 1.0, 1.0], &light)) };
        let colours = canvas.painted(&settings, &lit, &[]);
        assert_eq!([0, 8, 54, 62].map(|pixel| colours[pixel][0]), [0.5, 1.0, 2.5, 3.0]);
        // A quarter of those above, over which the fire's light is a quarter of theirs, too.
        let higher = Settings { tones_above, ..settings };
        let colours = canvas.painted(&higher, &lit, &[0.25; 63]);
        assert_eq!([colours[0], colours[62]], [[0.375, 0.0, 0.125], [0.75 + 1.5, 0.0, 0.125 + 0.125]]);
        assert_eq!(gradient_share(&[0.0, 1.0, 1.5, 9.0], [1.0, 2.0]), [0.0, 0.0, 0.5, 1.0]);
        assert_eq!(gradient_share(&[0.99, 1.0], [1.0; 2]), [0.0, 1.0]);
    }

    #[test]
    fn mattes_add_up_and_a_rim_has_what_it_has_raised() {
        let (smooth, id) = columns();
        let canvas = Canvas { size: SIZE, id: &id, mask: Mask::Groups, softness: 2.0 };
        let tones: Vec<Tone> = (0..5).map(|i| Tone::new(i as f32 / 5.0, [0.0; 3])).collect();
        let mattes = canvas.mattes(&smooth, &tones);
        assert!(mattes.iter().all(|m| (m.iter().sum::<f64>() - 1.0).abs() < 1e-15));
        // The fourth begins at 0.6, where a border of half a unit of luminance ends at 0.85.
        assert_eq!([mattes[0][1] > 0.0, mattes[0][3] > 0.0, mattes[8][3] > 0.999_999], [true, false, true]);
        let hard = Canvas { softness: 0.0, ..canvas };
        assert_eq!(hard.mattes(&smooth, &tones)[4], [0.0, 0.0, 1.0, 0.0]);
        let raised: Vec<f64> = smooth.iter().map(|s| (s + 0.125).min(1.0)).collect();
        let rim = hard.rim(&raised, &smooth, &tones[..3]);
        // Steps at 0.2 and 0.4 are passed from columns 1 and 3.
        assert_eq!(rim[..9], [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
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
