//! The look "cel": heat, smoothed, becomes tones with a line along the silhouette.
//!
//! Images have `size` = [width, height] pixels, row by row from the top.

use crate::flame::settings::{Glow, Settings};

/// What a fire's heat looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Linear RGBA, premultiplied: tones alone.
    pub tone: Vec<[f64; 4]>,
    /// Opacity of the line.
    pub outline: Vec<f64>,
    /// Linear RGBA, premultiplied.
    pub picture: Vec<[f64; 4]>,
}

/// The definition: heat averaged over the window around a pixel by weights `exp(-d^2 / 2 sigma^2)`, of what lies in the
/// picture and is not hidden. Heat is 0 where there is no fire.
pub fn smooth(size: [u32; 2], heat: &[f64], hidden: &[bool], settings: &Settings) -> Vec<f64> {
    let window = i64::from((3.0 * settings.sigma).ceil() as u32);
    let sigma = f64::from(settings.sigma);
    let weight = |d: i64| if d == 0 { 1.0 } else { (-((d * d) as f64) / (2.0 * sigma * sigma)).exp() };
    let pixel = |place: usize| {
        let [x, y] = at(size, place);
        let (mut sum, mut weights) = (0.0, 0.0);
        for dy in -window..=window {
            for dx in -window..=window {
                if let Some(other) = inside(size, x + dx, y + dy).filter(|other| !hidden[*other]) {
                    let weight = weight(dx) * weight(dy);
                    sum += weight * heat[other];
                    weights += weight;
                }
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    };
    (0..heat.len()).map(pixel).collect()
}

/// Tones of smoothed heat, each composited over the ones before with the share
/// `clamp(0.5 + (S - from) / (2 softness |grad S|), 0, 1)`: a step, open at `from`, where the product is 0. The first is as
/// opaque as its share. The line's middle is the silhouette, of which pixels are `(S - from) / |grad S|` away, and it fades
/// over its last pixel.
pub fn draw(size: [u32; 2], smooth: &[f64], hidden: &[bool], settings: &Settings) -> Drawn {
    let tones: Vec<_> = settings.tones.shares(settings.hottest).collect();
    let mut drawn = Drawn { tone: Vec::new(), outline: Vec::new(), picture: Vec::new() };
    for (place, &heat) in smooth.iter().enumerate() {
        let slope = gradient(size, smooth, place);
        let width = 2.0 * f64::from(settings.tone_softness) * slope;
        let share = |from: f32| match heat - f64::from(from) {
            above if width > 0.0 => (0.5 + above / width).clamp(0.0, 1.0),
            above => f64::from(u8::from(above >= 0.0)),
        };
        let colour = |c: usize| f64::from(settings.intensity) * f64::from(tones[0].colour[c]);
        let mut tone: [f64; 3] = std::array::from_fn(colour);
        for above in &tones[1..] {
            let share = share(above.from);
            let over = |c: usize| f64::from(settings.intensity) * f64::from(above.colour[c]);
            tone = std::array::from_fn(|c| tone[c] * (1.0 - share) + over(c) * share);
        }
        let alpha = if hidden[place] { 0.0 } else { share(tones[0].from) };
        let line = &settings.outline;
        let way = (heat - f64::from(tones[0].from)).max(0.0) / slope;
        let reaches = if way.is_nan() { 1.0 } else { (f64::from(line.width) - way).clamp(0.0, 1.0) };
        let ink = f64::from(line.strength) * reaches;
        let [r, g, b] = std::array::from_fn(|c| (tone[c] * (1.0 - ink) + f64::from(line.colour[c]) * ink) * alpha);
        drawn.tone.push([tone[0] * alpha, tone[1] * alpha, tone[2] * alpha, alpha]);
        drawn.outline.push(ink * alpha);
        drawn.picture.push([r, g, b, alpha]);
    }
    drawn
}

/// Adds light to a picture around what is brighter than 1: a Gaussian of as much as that is above 1, of which what lies
/// beyond the picture is lost.
pub fn glow(size: [u32; 2], picture: &[[f64; 4]], glow: &Glow) -> Vec<[f64; 4]> {
    let window = i64::from(glow.window());
    let sigma = f64::from(glow.sigma);
    let weight = |d: i64| (-((d * d) as f64) / (2.0 * sigma * sigma)).exp();
    let all = (-window..=window).map(weight).sum::<f64>().powi(2);
    let mut sum = picture.to_vec();
    for (place, pixel) in picture.iter().enumerate() {
        let light: [f64; 3] = std::array::from_fn(|c| (pixel[c] - 1.0).max(0.0));
        if light == [0.0; 3] {
            continue;
        }
        let [x, y] = at(size, place);
        for dy in -window..=window {
            for dx in -window..=window {
                if let Some(other) = inside(size, x + dx, y + dy) {
                    let share = f64::from(glow.strength) * weight(dx) * weight(dy) / all;
                    (0..3).for_each(|c| sum[other][c] += share * light[c]);
                }
            }
        }
    }
    sum
}

/// Length of the gradient a pixel: central differences, one-sided at the border of the picture.
fn gradient(size: [u32; 2], smooth: &[f64], place: usize) -> f64 {
    let [x, y] = at(size, place);
    let along = |dx: i64, dy: i64| {
        let value = |side: i64| inside(size, x + side * dx, y + side * dy).map(|other| smooth[other]);
        match (value(-1), value(1)) {
            (Some(before), Some(after)) => (after - before) / 2.0,
            (before, after) => after.unwrap_or(smooth[place]) - before.unwrap_or(smooth[place]),
        }
    };
    along(1, 0).hypot(along(0, 1))
}

/// Column and row of a pixel.
fn at(size: [u32; 2], pixel: usize) -> [i64; 2] {
    let width = size[0] as usize;
    [(pixel % width) as i64, (pixel / width) as i64]
}

/// The pixel in column `x` and row `y`, if there is one.
fn inside(size: [u32; 2], x: i64, y: i64) -> Option<usize> {
    let [width, height] = size.map(i64::from);
    ((0..width).contains(&x) && (0..height).contains(&y)).then_some((y * width + x) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::settings::Tones;
    use crate::toon::{Line, Tone};

    const SIZE: [u32; 2] = [11, 5];

    /// Two tones, at a quarter and at a half, without a line.
    fn settings() -> Settings {
        let tones = Tones(vec![Tone::new(0.25, [1.0, 0.0, 0.0]), Tone::new(0.5, [0.0, 1.0, 0.0])]);
        let outline = Line { strength: 0.0, ..Line::default() };
        Settings { tones, outline, tone_softness: 0.0, ..Settings::default() }
    }

    #[test]
    fn what_is_even_stays_and_hidden_pixels_count_for_nothing() {
        let hidden: Vec<bool> = (0..55).map(|place| place % 3 == 0).collect();
        let heat: Vec<f64> = hidden.iter().map(|hidden| if *hidden { 9.0 } else { 0.75 }).collect();
        let smooth = smooth(SIZE, &heat, &hidden, &Settings { sigma: 2.0, ..settings() });
        assert!(smooth.iter().all(|heat| (heat - 0.75).abs() < 1e-14), "{smooth:?}");
        assert_eq!(super::smooth(SIZE, &heat, &[false; 55], &Settings { sigma: 0.0, ..settings() }), heat);
    }

    #[test]
    fn all_light_that_glows_is_given_back() {
        let mut picture = vec![[0.5, 1.0, 0.0, 1.0]; 21 * 21];
        picture[10 * 21 + 10] = [3.0, 1.5, 0.0, 1.0];
        let glowing = glow([21, 21], &picture, &Glow { strength: 2.0, sigma: 2.0 });
        let sums = [0, 1, 2].map(|c| glowing.iter().zip(&picture).map(|(a, b)| a[c] - b[c]).sum::<f64>());
        assert!((sums[0] - 4.0).abs() < 1e-12 && (sums[1] - 1.0).abs() < 1e-12 && sums[2] == 0.0, "{sums:?}");
        assert!(glowing[10 * 21 + 11][0] > glowing[10 * 21 + 12][0] && glowing[0] == picture[0]);
    }

    #[test]
    fn shapes_begin_at_the_first_tone_and_a_line_runs_within() {
        // A slope of 1 / 10 a pixel along rows.
        let heat: Vec<f64> = (0..55).map(|place| f64::from(place % 11) / 10.0).collect();
        let row = |drawn: &Drawn| drawn.picture[11..22].to_vec();
        let hard = draw(SIZE, &heat, &[false; 55], &settings());
        let (none, red, green) = ([0.0; 4], [1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(row(&hard), [[none; 3].as_slice(), &[red; 2], &[green; 6]].concat());
        assert_eq!(draw(SIZE, &heat, &[true; 55], &settings()).picture, [none; 55]);
        // A border of one pixel: the silhouette runs between columns 2 and 3, the next tone begins in the middle of 5.
        let soft = draw(SIZE, &heat, &[false; 55], &Settings { tone_softness: 0.5, ..settings() });
        let alpha: Vec<f64> = row(&soft)[..6].iter().map(|pixel| pixel[3]).collect();
        let near = |found: &[f64], expected: &[f64]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}")
        };
        near(&alpha, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        near(&row(&soft)[5], &[0.5, 0.5, 0.0, 1.0]);
        // Column 3 is half a pixel within, 4 one and a half.
        let outline = Line { strength: 0.5, width: 2.0, colour: [0.0; 3] };
        let lined = draw(SIZE, &heat, &[false; 55], &Settings { outline, ..settings() });
        near(&lined.outline[11..22], &[0.0, 0.0, 0.0, 0.5, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        near(&row(&lined)[3], &[0.5, 0.0, 0.0, 1.0]);
        // Where nothing changes, there is no silhouette near.
        assert_eq!(draw(SIZE, &[0.75; 55], &[false; 55], &Settings { outline, ..settings() }).outline, [0.0; 55]);
    }
}
