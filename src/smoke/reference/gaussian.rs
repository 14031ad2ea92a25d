//! The Gaussian under a mask: every pixel averages over pixels of its own ID (section 3.3 of the paper), or of about its own
//! depth.
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

/// What a pixel belongs to, and by which share: its ID, or two planes of depth.
type Shares = [(u32, f64); 2];

/// All of it to its ID; nothing where that is 0.
fn of_id(id: &u32) -> Shares {
    [(*id, if *id == 0 { 0.0 } else { 1.0 }), (0, 0.0)]
}

/// To the two nearest planes: plane k has the share `max(0, 1 - |u - k|)` at coordinate u; nothing where it is infinite.
fn of_coordinate(u: &f64) -> Shares {
    let first = if u.is_finite() { u.floor() as u32 } else { 0 };
    [first, first + 1].map(|k| (k, (1.0 - (u - f64::from(k)).abs()).max(0.0)))
}

/// The definition: the normalised sum over the two-dimensional window, of pixels of the same ID.
pub fn masked_direct(width: usize, height: usize, luminance: &[f64], id: &[u32], sigma: f32, cutoff: f32) -> Vec<f64> {
    direct([width, height], luminance, id.iter().map(of_id).collect(), &weights(sigma, cutoff))
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
    separable([width, height], luminance, id.iter().map(of_id).collect(), &weights(sigma, cutoff))
}

/// The soft mask (a bilateral grid, Paris and Durand 2006) by its definition: pixels belong to planes of depth by shares,
/// and one counts for another by the sum over planes of the products of their shares. `coordinate` is depth in ranges,
/// from plane 0, infinite where there is nothing.
pub fn soft_direct(
    width: usize,
    height: usize,
    luminance: &[f64],
    coordinate: &[f64],
    sigma: f32,
    cutoff: f32,
) -> Vec<f64> {
    direct([width, height], luminance, coordinate.iter().map(of_coordinate).collect(), &weights(sigma, cutoff))
}

/// The same in two passes, one plane at a time.
pub fn soft_separable(
    width: usize,
    height: usize,
    luminance: &[f64],
    coordinate: &[f64],
    sigma: f32,
    cutoff: f32,
) -> Vec<f64> {
    separable([width, height], luminance, coordinate.iter().map(of_coordinate).collect(), &weights(sigma, cutoff))
}

fn direct([width, height]: [usize; 2], luminance: &[f64], shares: Vec<Shares>, weights: &[f64]) -> Vec<f64> {
    let r = weights.len() - 1;
    let in_common = |a: &Shares, b: &Shares| {
        let product = |(i, a): &(u32, f64)| b.iter().map(|(j, b)| if i == j { a * b } else { 0.0 }).sum::<f64>();
        a.iter().map(product).sum::<f64>()
    };
    let smooth = |(pixel, own): (usize, &Shares)| {
        let (mut sum, mut total) = (0.0, 0.0);
        for (y, dy) in near(pixel / width, r, height) {
            for (x, dx) in near(pixel % width, r, width) {
                let weight = weights[dx] * weights[dy] * in_common(own, &shares[y * width + x]);
                sum += weight * luminance[y * width + x];
                total += weight;
            }
        }
        if total > 0.0 { sum / total } else { 0.0 }
    };
    shares.iter().enumerate().map(smooth).collect()
}

fn separable([width, height]: [usize; 2], luminance: &[f64], shares: Vec<Shares>, weights: &[f64]) -> Vec<f64> {
    let r = weights.len() - 1;
    let mut members = std::collections::BTreeMap::<u32, Vec<(usize, f64)>>::new();
    for (pixel, shares) in shares.iter().enumerate() {
        for (of, share) in shares.iter().filter(|(_, share)| *share > 0.0) {
            members.entry(*of).or_default().push((pixel, *share));
        }
    }
    let mut sums = vec![[0.0; 2]; width * height];
    let mut rows = vec![[0.0; 2]; width * height];
    for pixels in members.values() {
        rows.fill([0.0; 2]);
        for &(pixel, share) in pixels {
            for (x, dx) in near(pixel % width, r, width) {
                let [sum, total] = &mut rows[pixel / width * width + x];
                *sum += share * weights[dx] * luminance[pixel];
                *total += share * weights[dx];
            }
        }
        for &(pixel, share) in pixels {
            for (y, dy) in near(pixel / width, r, height) {
                let row = rows[y * width + pixel % width];
                (0..2).for_each(|i| sums[pixel][i] += share * weights[dy] * row[i]);
            }
        }
    }
    sums.into_iter().map(|[sum, total]| if total > 0.0 { sum / total } else { 0.0 }).collect()
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

    /// Coordinates that are hard on separable forms.
    fn coordinates() -> [Vec<f64>; 5] {
        [
            image(|x, y| (x + 2 * y) as f64 / 13.0),
            image(|x, y| ((x + y) % 4) as f64),
            image(|x, y| 9.0 * random(y * W + x, 2)),
            image(|x, y| if x.abs_diff(y) == 1 { 2.75 } else { f64::INFINITY }),
            image(|_, _| 0.5),
        ]
    }

    #[test]
    fn soft_separable_equals_direct() {
        for (place, u) in coordinates().iter().enumerate() {
            for (sigma, cutoff) in [(0.1, 3.0), (1.3, 3.0), (4.0, 4.0), (20.0, 3.0)] {
                let direct = soft_direct(W, H, &noise(), u, sigma, cutoff);
                let separable = soft_separable(W, H, &noise(), u, sigma, cutoff);
                // As above.
                let difference = greatest_difference(&direct, &separable);
                assert!(difference < 1e-12, "coordinates {place}, sigma {sigma}: {difference:e}");
                let empty = (0..W * H).filter(|pixel| u[*pixel].is_infinite());
                assert!(empty.clone().all(|pixel| direct[pixel] == 0.0 && separable[pixel] == 0.0));
            }
        }
    }

    #[test]
    fn whole_coordinates_are_ids_and_neighbours_count_by_their_products() {
        let id = image(|x, y| 1 + ((x + y) % 4) as u32);
        let u: Vec<f64> = id.iter().map(|id| f64::from(*id)).collect();
        let masked = masked_direct(W, H, &noise(), &id, 3.0, 3.0);
        assert!(greatest_difference(&masked, &soft_direct(W, H, &noise(), &u, 3.0, 3.0)) < 1e-14);
        // Two pixels at 1.25 and 1.75: in common 2 * 0.25 * 0.75, by themselves 0.25^2 + 0.75^2.
        let g = (-0.5_f64).exp();
        let (own, common) = (0.625, 0.375 * g);
        let smooth = soft_direct(2, 1, &[1.0, 0.0], &[1.25, 1.75], 1.0, 3.0);
        assert!((smooth[0] - own / (own + common)).abs() < 1e-15);
        // Two ranges apart and more nothing is in common.
        assert_eq!(soft_direct(2, 1, &[1.0, 0.0], &[1.25, 3.25], 1.0, 3.0), [1.0, 0.0]);
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
