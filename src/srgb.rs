//! What sRGB codes.

/// The sRGB transfer function (IEC 61966-2-1) from the coded value to linear light; both 0 to 1.
pub fn linear_from_srgb(coded: f64) -> f64 {
    match coded <= 0.040_45 {
        true => coded / 12.92,
        false => ((coded + 0.055) / 1.055).powf(2.4),
    }
}
