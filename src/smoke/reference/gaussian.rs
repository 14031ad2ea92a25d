//! The Gaussian under the ID mask (section 3.3 of the paper): every pixel averages over pixels of its own ID.
//!
//! Images are `width` x `height`, row by row. ID 0 is empty: it takes no part and stays 0. Weights are
//! `exp(-d^2 / 2 sigma^2)`, the window ends at [`window`] pixels to each side and at the border of the image.

/// Pixels to each side that take part, `ceil(cutoff sigma)`, the product in f32 as in `Settings::window`.
pub fn window(sigma: f32, cutoff: f32) -> usize {
    (cutoff * sigma).ceil() as usize
}

/// Weights at distances 0, 1, ... pixels; the centre has 1.
fn weights(sigma: f32, cutoff: f32) -> Vec<f64> {
    let r = window(sigma, cutoff);
    let sigma = f64::from(sigma);
    let weight = |d: usize| if d == 0 { 1.0 } else { (-((d * d) as f64) / (2.0 * sigma * sigma)).exp() };
    (0..=r).map(weight).collect()
}

/// The places within `r` of `centre` on an axis of `n` pixels, each with its distance.
fn near(centre: usize, r: usize, n: usize) -> impl Iterator<Item = (usize, usize)> {
    (centre.saturating_sub(r)..(centre + r + 1).min(n)).map(move |place| (place, place.abs_diff(centre)))
}

/// The definition: the normalised sum over the two-dimensional window.
pub fn masked_direct(width: usize, height: usize, luminance: &[f64], id: &[u32], sigma: f32, cutoff: f32) -> Vec<f64> {
    let weights = weights(sigma, cutoff);
    let r = weights.len() - 1;
    let mut image = vec![0.0; width * height];
    for (pixel, smooth) in image.iter_mut().enumerate().filter(|(pixel, _)| id[*pixel] != 0) {
        let (mut sum, mut total) = (0.0, 0.0);
        for (y, dy) in near(pixel / width, r, height) {
            for (x, dx) in near(pixel % width, r, width) {
                if id[y * width + x] == id[pixel] {
                    let weight = weights[dx] * weights[dy];
                    sum += weight * luminance[y * width + x];
                    total += weight;
                }
            }
        }
        *smooth = sum / total;
    }
    image
}

/// The same sums in two passes, one ID at a time (normalised convolution, Knutsson and Westin 1993): rows spread
/// numerator and denominator of that ID to every column, its own or not; columns collect them for its pixels.
pub fn masked_separable(
    width: usize,
    height: usize,
    luminance: &[f64],
    id: &[u32],
    sigma: f32,
    cutoff: f32,
) -> Vec<f64> {
    let weights = weights(sigma, cutoff);
    let r = weights.len() - 1;
    let mut members = std::collections::BTreeMap::<u32, Vec<usize>>::new();
    for (pixel, id) in id.iter().enumerate().filter(|(_, id)| **id != 0) {
        members.entry(*id).or_default().push(pixel);
    }
    let mut image = vec![0.0; width * height];
    let mut rows = vec![[0.0; 2]; width * height];
    for pixels in members.values() {
        rows.fill([0.0; 2]);
        for &pixel in pixels {
            for (x, dx) in near(pixel % width, r, width) {
                let [sum, total] = &mut rows[pixel / width * width + x];
                *sum += weights[dx] * luminance[pixel];
                *total += weights[dx];
            }
        }
        for &pixel in pixels {
            let (mut sum, mut total) = (0.0, 0.0);
            for (y, dy) in near(pixel / width, r, height) {
                let row = rows[y * width + pixel % width];
                sum += weights[dy] * row[0];
                total += weights[dy] * row[1];
            }
            image[pixel] = sum / total;
        }
    }
    image
}

/// The wrong separable form, to show its error: rows, then columns, each with the mask of its own centre, numerator
/// and denominator carried. It loses every row whose pixel straight above or below has another ID.
pub fn masked_naive(width: usize, height: usize, luminance: &[f64], id: &[u32], sigma: f32, cutoff: f32) -> Vec<f64> {
    let weights = weights(sigma, cutoff);
    let r = weights.len() - 1;
    let mut rows = vec![[0.0; 2]; width * height];
    for (pixel, [sum, total]) in rows.iter_mut().enumerate() {
        for (x, dx) in near(pixel % width, r, width) {
            let other = pixel / width * width + x;
            if id[other] == id[pixel] {
                *sum += weights[dx] * luminance[other];
                *total += weights[dx];
            }
        }
    }
    let mut image = vec![0.0; width * height];
    for (pixel, smooth) in image.iter_mut().enumerate().filter(|(pixel, _)| id[*pixel] != 0) {
        let (mut sum, mut total) = (0.0, 0.0);
        for (y, dy) in near(pixel / width, r, height) {
            let other = y * width + pixel % width;
            if id[other] == id[pixel] {
                sum += weights[dy] * rows[other][0];
                total += weights[dy] * rows[other][1];
            }
        }
        *smooth = sum / total;
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{hash, unit};

    const W: usize = 37;
    const H: usize = 29;

    fn random(pixel: usize, dimension: u32) -> f64 {
        unit(hash(4, pixel as u32, 0, dimension)).into()
    }

    fn image<T>(value: impl Fn(usize, usize) -> T) -> Vec<T> {
        (0..W * H).map(|pixel| value(pixel % W, pixel / W)).collect()
    }

    fn noise() -> Vec<f64> {
        (0..W * H).map(|pixel| random(pixel, 0)).collect()
    }

    fn greatest_difference(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// Masks that are hard on separable forms.
    fn masks() -> [Vec<u32>; 6] {
        [
            image(|_, _| 3),
            image(|x, y| if 3 * x > 4 * y { 1 } else { 2 }),
            image(|x, y| 1 + ((x + y) % 2) as u32),
            image(|x, y| if x.abs_diff(y) == 1 { 7 } else { 0 }),
            image(|x, y| 1 + (y * W + x) as u32),
            image(|x, y| (random(y * W + x, 1) * 5.0) as u32),
        ]
    }

    #[test]
    fn separable_equals_direct() {
        for (place, id) in masks().iter().enumerate() {
            for (sigma, cutoff) in [(0.1, 3.0), (1.3, 3.0), (4.0, 4.0), (20.0, 3.0)] {
                let direct = masked_direct(W, H, &noise(), id, sigma, cutoff);
                let separable = masked_separable(W, H, &noise(), id, sigma, cutoff);
                // Rounding of a thousand f64 additions of terms up to 1.
                let difference = greatest_difference(&direct, &separable);
                assert!(difference < 1e-12, "mask {place}, sigma {sigma}: {difference:e}");
                let empty = (0..W * H).filter(|pixel| id[*pixel] == 0);
                assert!(empty.clone().all(|pixel| direct[pixel] == 0.0 && separable[pixel] == 0.0));
            }
        }
    }

    #[test]
    fn a_constant_stays_and_does_not_cross_the_mask() {
        let id = image(|x, y| if 3 * x > 4 * y { 1 } else { 2 });
        let two = image(|x, y| if 3 * x > 4 * y { 0.75 } else { 0.25 });
        for filter in [masked_direct, masked_separable, masked_naive] {
            assert!(greatest_difference(&filter(W, H, &two, &id, 3.0, 3.0), &two) < 1e-14);
        }
    }

    #[test]
    fn an_impulse_becomes_the_weights_over_their_sum() {
        let impulse = image(|x, y| if (x, y) == (18, 14) { 1.0 } else { 0.0 });
        let id = image(|_, _| 1);
        let g = |d: usize| if d <= 6 { (-((d * d) as f64) / 8.0).exp() } else { 0.0 };
        // Far from the image's borders the weights factor.
        let total = (1..=6).map(g).sum::<f64>() * 2.0 + 1.0;
        let smooth = masked_direct(W, H, &impulse, &id, 2.0, 3.0);
        for (x, y) in [(18, 14), (19, 14), (18, 11), (24, 8), (25, 14), (12, 20), (16, 21)] {
            let expected = g(18_usize.abs_diff(x)) * g(14_usize.abs_diff(y)) / total / total;
            assert!((smooth[y * W + x] - expected).abs() < 1e-15, "at {x}, {y}");
        }
    }

    #[test]
    fn the_window_is_clipped_at_the_image_and_normalised() {
        // One row: the first pixel sees itself and three to the right.
        let smooth = masked_direct(5, 1, &[1.0, 0.0, 0.0, 0.0, 0.0], &[1; 5], 1.0, 3.0);
        let g = |d: f64| (-d * d / 2.0).exp();
        assert!((smooth[0] - 1.0 / (1.0 + g(1.0) + g(2.0) + g(3.0))).abs() < 1e-15);
        assert_eq!(smooth[4], 0.0);
        assert_eq!(window(4.0, 3.0), 12);
        assert_eq!(window(0.1, 3.0), 1);
        assert_eq!(masked_direct(2, 1, &[0.3, 0.6], &[1; 2], 0.0, 3.0), [0.3, 0.6]);
    }

    #[test]
    fn naive_is_wrong_at_slanted_borders_alone() {
        let ramp = image(|x, y| (x + 2 * y) as f64 / 100.0);
        let error = |id: &[u32]| {
            let direct = masked_direct(W, H, &ramp, id, 4.0, 3.0);
            greatest_difference(&direct, &masked_naive(W, H, &ramp, id, 4.0, 3.0))
        };
        assert!(error(&image(|_, _| 1)) < 1e-12);
        assert!(error(&image(|x, _| 1 + (x > 18) as u32)) < 1e-12);
        assert!(error(&image(|_, y| 1 + (y > 14) as u32)) < 1e-12);
        // Measured 0.037 on this ramp; 1e-2 is far from rounding.
        assert!(error(&image(|x, y| 1 + (3 * x > 4 * y) as u32)) > 1e-2);
    }
}
