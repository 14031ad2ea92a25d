//! Tones from smoothed luminance and lines from depth (sections 3.4 and 3.5 of the paper), and both together.
//!
//! Images have `size` = [width, height] pixels, row by row from the top.

use crate::toon::{Operator, Outline, Tone};
use crate::view::{Projection, View};

/// Tone colour of every pixel, linear RGB; black where `id` is 0.
///
/// `smooth` is the smoothed luminance, `softness` the width in pixels over which tones mix. Tone after tone is
/// composited over the first with the share `clamp(0.5 + (S - from) / (2 softness |grad S|), 0, 1)`: a step, open at
/// `from`, where the product is 0.
pub fn tones(size: [u32; 2], smooth: &[f64], id: &[u32], tones: &[Tone], softness: f64) -> Vec<[f64; 3]> {
    let colour = |pixel: usize| {
        if id[pixel] == 0 {
            return [0.0; 3];
        }
        let slope = 2.0 * softness * gradient(size, smooth, id, pixel);
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
/// has it (the image's border included), 0 where none has.
fn gradient(size: [u32; 2], smooth: &[f64], id: &[u32], pixel: usize) -> f64 {
    let [x, y] = place(size, pixel);
    let along = |dx: i64, dy: i64| {
        let value = |side: i64| {
            let other = inside(size, x + side * dx, y + side * dy)?;
            (id[other] == id[pixel]).then(|| smooth[other])
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

/// Opacity of the line in every pixel, 0 to 1; 0 where nothing is seen.
///
/// `depth` is linear view depth in metres, infinite where nothing is seen; `voxel` is the smallest side of a voxel in
/// metres. Width spreads the line: the greatest `(1 - l) clamp(width - distance, 0, 1)` of all pixels.
pub fn outline(size: [u32; 2], depth: &[f64], view: &View, voxel: f64, settings: &Outline) -> Vec<f64> {
    let projection = Projection::of_valid(view, size);
    let line: Vec<f64> =
        (0..depth.len()).map(|pixel| stencil(size, depth, &projection, voxel, settings, pixel)).collect();
    let width = f64::from(settings.width);
    let reach = width.ceil() as i64;
    let mut offsets = Vec::new();
    for (dy, dx) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dy, dx))) {
        let share = (width - (dx as f64).hypot(dy as f64)).clamp(0.0, 1.0);
        if share > 0.0 {
            offsets.push((dx, dy, share));
        }
    }
    let opacity = |pixel: usize| {
        if !depth[pixel].is_finite() {
            return 0.0;
        }
        let [x, y] = place(size, pixel);
        let near = offsets.iter().filter_map(|(dx, dy, share)| Some(line[inside(size, x + dx, y + dy)?] * share));
        near.fold(0.0, f64::max)
    };
    (0..depth.len()).map(opacity).collect()
}

/// 1 - l of one pixel: the squared diagonal differences of depth in units of `max(voxel, 8 pixels)`.
fn stencil(
    size: [u32; 2],
    depth: &[f64],
    projection: &Projection,
    voxel: f64,
    settings: &Outline,
    pixel: usize,
) -> f64 {
    let centre = depth[pixel];
    if !centre.is_finite() || !settings.is_on() {
        return 0.0;
    }
    let [x, y] = place(size, pixel);
    let [last_x, last_y] = size.map(|n| i64::from(n) - 1);
    let at = |dx: i64, dy: i64| {
        let [x, y] = [(x + dx).clamp(0, last_x), (y + dy).clamp(0, last_y)];
        depth[y as usize * size[0] as usize + x as usize]
    };
    let [a, b, c, d] = [at(-1, 1), at(1, -1), at(-1, -1), at(1, 1)];
    if [a, b, c, d].iter().any(|z| !z.is_finite()) {
        return 1.0;
    }
    let unit = voxel.max(8.0 * projection.widening(centre) / projection.focal.y);
    let [first, second] = match settings.operator {
        Operator::Roberts => [a - b, c - d],
        Operator::Second => [a + b - 2.0 * centre, c + d - 2.0 * centre],
    };
    let squared = (first / unit).powi(2) + (second / unit).powi(2);
    1.0 - (1.0 - f64::from(settings.strength) * squared).max(0.0)
}

/// The effect's image, linear RGBA: the line over the tone, alpha 1 on smoke; all 0 where `id` is 0.
pub fn composite(tone: &[[f64; 3]], opacity: &[f64], id: &[u32], colour: [f32; 3]) -> Vec<[f64; 4]> {
    let pixel = |((tone, opacity), id): ((&[f64; 3], &f64), &u32)| {
        let [r, g, b] = mix(*tone, colour, *opacity);
        if *id == 0 { [0.0; 4] } else { [r, g, b, 1.0] }
    };
    tone.iter().zip(opacity).zip(id).map(pixel).collect()
}

/// The share `share` of `b` composited over `a`.
fn mix(a: [f64; 3], b: [f32; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|c| a[c] * (1.0 - share) + f64::from(b[c]) * share)
}

/// Column and row of a pixel.
fn place(size: [u32; 2], pixel: usize) -> [i64; 2] {
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
    use crate::view::Camera;

    const SIZE: [u32; 2] = [9, 7];

    fn image<T>(value: impl Fn(i64, i64) -> T) -> Vec<T> {
        (0..63).map(|pixel| value(pixel % 9, pixel / 9)).collect()
    }

    fn two_tones(from: f32) -> [Tone; 2] {
        [Tone { from: 0.0, colour: [0.0, 0.5, 1.0] }, Tone { from, colour: [1.0, 0.5, 0.0] }]
    }

    /// 90 degrees: at depth 1 the seven rows are 2 m high.
    fn camera() -> Camera {
        Camera { vertical_fov: 90.0, ..Camera::default() }
    }

    fn line(depth: &[f64], voxel: f64, settings: Outline) -> Vec<f64> {
        outline(SIZE, depth, &camera().view(SIZE), voxel, &settings)
    }

    fn thin(strength: f32, operator: Operator) -> Outline {
        Outline { strength, width: 1.0, operator, ..Outline::default() }
    }

    #[test]
    fn hard_tones_step_at_their_threshold() {
        let smooth = image(|x, _| x as f64 / 8.0);
        let colours = tones(SIZE, &smooth, &image(|_, _| 1), &two_tones(0.5), 0.0);
        let red: Vec<f64> = colours[..9].iter().map(|c| c[0]).collect();
        assert_eq!(red, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        assert_eq!(colours[0], [0.0, 0.5, 1.0]);
        assert_eq!(tones(SIZE, &smooth, &image(|_, _| 0), &two_tones(0.5), 0.0), [[0.0; 3]; 63]);
    }

    #[test]
    fn soft_tones_mix_by_the_distance_in_pixels() {
        // Slope 1/8 per pixel; softness 2: the border is 4 pixels wide, and the share 1/2 lies at x = 4.
        let smooth = image(|x, _| x as f64 / 8.0);
        let colours = tones(SIZE, &smooth, &image(|_, _| 1), &two_tones(0.5), 2.0);
        let red: Vec<f64> = colours[9..18].iter().map(|c| c[0]).collect();
        assert_eq!(red, [0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0]);
        // Three tones are composited over each other in order.
        let three = [two_tones(0.5)[0], two_tones(0.5)[1], Tone { from: 0.625, colour: [0.0, 0.0, 0.0] }];
        let colour = tones(SIZE, &smooth, &image(|_, _| 1), &three, 2.0)[4];
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
                assert!((gradient(SIZE, &smooth, &id, y * 9 + x) - expected).abs() < 1e-14, "at {x}, {y}");
            }
        }
        // An ID of its own everywhere: no gradient, hence a step.
        let alone = image(|x, y| 1 + (y * 9 + x) as u32);
        assert_eq!(gradient(SIZE, &smooth, &alone, 30), 0.0);
    }

    #[test]
    fn a_step_of_one_voxel_is_black_and_half_a_voxel_half_grey() {
        // One degree: at depth 1, 8 pixels are 0.02 m, below a voxel of 0.125. A step between columns 3 and 4 is crossed
        // by both diagonals of columns 3 and 4: l' = 2 (step / voxel)^2.
        let row = |step: f64, strength: f32| {
            let depth = image(|x, _| if x < 4 { 1.0 } else { 1.0 + step });
            let camera = Camera { vertical_fov: 1.0, ..camera() };
            outline(SIZE, &depth, &camera.view(SIZE), 0.125, &thin(strength, Operator::Roberts))[27..36].to_vec()
        };
        assert_eq!(row(0.125, 1.0), [0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(row(0.0625, 1.0), [0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(row(0.0625, 0.5), [0.0, 0.0, 0.0, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn far_away_the_unit_is_eight_pixels_of_the_centre() {
        // Depth 7: a pixel is 2 m high, the unit 16 m. The step of 8 m is seen from 7 (l' = 2 / 4) and from 15, where
        // the unit is 240 / 7 m.
        let depth = image(|x, _| if x < 4 { 7.0 } else { 15.0 });
        let opacity = line(&depth, 0.125, thin(1.0, Operator::Roberts));
        assert!((opacity[30] - 0.5).abs() < 1e-14);
        assert!((opacity[31] - 2.0 * (56.0_f64 / 240.0).powi(2)).abs() < 1e-14);
    }

    #[test]
    fn second_differences_ignore_slopes() {
        let slope = image(|x, y| 0.01 + 0.05 * x as f64 + 0.02 * y as f64);
        let roberts = line(&slope, 1.0, thin(1.0, Operator::Roberts));
        let second = line(&slope, 1.0, thin(1.0, Operator::Second));
        // Diagonals (2, -2) and (2, 2): 0.06^2 + 0.14^2. The unit is 1 m, as 8 pixels are 0.66 m there.
        assert!((roberts[2 * 9 + 2] - (0.06_f64.powi(2) + 0.14_f64.powi(2))).abs() < 1e-14);
        assert!(second[2 * 9 + 2] < 1e-14);
        let crease = image(|x, _| 0.01 + 0.1 * x.abs_diff(4) as f64);
        assert!((line(&crease, 1.0, thin(1.0, Operator::Second))[31] - 2.0 * 0.2_f64.powi(2)).abs() < 1e-14);
    }

    #[test]
    fn borders_of_the_smoke_are_silhouette_and_borders_of_the_image_are_not() {
        let depth = image(|x, y| if (x, y) == (4, 3) { f64::INFINITY } else { 0.01 });
        let opacity = line(&depth, 1.0, thin(1.0, Operator::Roberts));
        let black: Vec<usize> = (0..63).filter(|pixel| opacity[*pixel] == 1.0).collect();
        // The four diagonal neighbours see the hole; the hole itself carries no line.
        assert_eq!(black, [2 * 9 + 3, 2 * 9 + 5, 4 * 9 + 3, 4 * 9 + 5]);
        assert_eq!(opacity.iter().sum::<f64>(), 4.0);
        assert_eq!(line(&depth, 1.0, thin(0.0, Operator::Roberts)), [0.0; 63]);
        assert_eq!(line(&[f64::INFINITY; 63], 1.0, thin(1.0, Operator::Roberts)), [0.0; 63]);
    }

    #[test]
    fn width_spreads_the_line_over_smoke() {
        let depth = image(|x, y| if (x, y) == (4, 3) { f64::INFINITY } else { 0.01 });
        let opacity = line(&depth, 1.0, Outline { width: 2.25, ..thin(1.0, Operator::Roberts) });
        let at = |x: usize, y: usize| opacity[y * 9 + x];
        assert_eq!(at(4, 3), 0.0, "the hole");
        assert_eq!(at(4, 2), 1.0, "beside two black pixels");
        assert_eq!(at(2, 1), 2.25 - 2.0_f64.sqrt(), "a diagonal away");
        assert_eq!(at(1, 2), 0.25, "two away");
        assert_eq!(at(0, 2), 0.0, "three away");
    }

    #[test]
    fn the_line_lies_over_the_tone() {
        let image = composite(&[[0.5, 0.25, 1.0]; 3], &[0.0, 0.5, 1.0], &[1, 2, 0], [0.5, 1.0, 0.0]);
        assert_eq!(image, [[0.5, 0.25, 1.0, 1.0], [0.5, 0.625, 0.5, 1.0], [0.0; 4]]);
    }
}
