//! What is measured of fire: how much fine detail there is, however near the camera.

use super::plane::Plane;
use crate::io::image::srgb_from_linear;

/// Standard deviation in pixels of the Gaussian that is taken off: detail is what is finer.
const COARSE: f64 = 3.0;

/// Root mean square of fine detail, in levels of 8 bits (0 to 255): the brightness less its Gaussian of 3 px, over the pixels
/// that are `covered`; none where none is.
pub(super) fn fine_detail(brightness: &Plane<f64>, covered: &Plane<bool>) -> Option<f64> {
    let coarse = brightness.smoothed(COARSE);
    let all = brightness.values.iter().zip(&coarse.values).zip(&covered.values);
    let squares = all.filter(|(_, covered)| **covered).map(|((fine, coarse), _)| (fine - coarse).powi(2));
    let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
    (count > 0.0).then(|| (sum / count).sqrt())
}

/// Brightness of linear premultiplied pixels over black: luminance (Rec. 709), coded as sRGB, in levels of 8 bits.
pub(super) fn brightness(picture: &Plane<[f32; 4]>) -> Plane<f64> {
    picture.map(|[r, g, b, _]| {
        let [r, g, b] = [r, g, b].map(|c| f64::from(*c).clamp(0.0, 1.0));
        255.0 * srgb_from_linear(0.2126 * r + 0.7152 * g + 0.0722 * b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detail_is_what_a_gaussian_takes_off() {
        let wave = |frequency: f64| {
            let values = (0..200 * 60).map(|i| 100.0 + 40.0 * (f64::from(i % 200) * frequency).cos()).collect();
            let inside = (0..200 * 60).map(|i| (20..180).contains(&(i % 200))).collect();
            fine_detail(&Plane::new(200, values), &Plane::new(200, inside)).unwrap_or_default()
        };
        // 40 / sqrt(2), less what is left of the wave; over whole and half periods alike, nearly.
        for frequency in [0.1_f64, 0.3, 1.0] {
            let expected = 40.0 / 2.0_f64.sqrt() * (1.0 - (-0.5 * (COARSE * frequency).powi(2)).exp());
            assert!((wave(frequency) - expected).abs() < 0.03 * expected, "{frequency}: {}", wave(frequency));
        }
        let flat = Plane::new(9, vec![7.0; 81]);
        assert!(fine_detail(&flat, &flat.map(|_| true)).is_some_and(|detail| detail < 1e-9));
        assert_eq!(fine_detail(&flat, &flat.map(|_| false)), None);
    }

    #[test]
    fn brightness_is_coded_and_bounded() {
        let pixels = vec![[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0], [9.0, 9.0, 9.0, 0.0], [0.5, 0.5, 0.5, 0.5]];
        let found = brightness(&Plane::new(4, pixels)).values;
        let expected = [0.0, 255.0, 255.0, 187.5];
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.1), "{found:?}");
    }
}
