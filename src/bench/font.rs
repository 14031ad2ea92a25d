//! A stroke font of the plots' own: the same lines in SVG and PNG, and no font file to find or to ship. Capitals are
//! drawn as small letters.

/// Distance from one letter to the next, in the font's units.
const ADVANCE: f64 = 5.0;
/// Height of the letters above the baseline, in the font's units.
const HEIGHT: f64 = 6.0;
/// The baseline, in the font's units.
const BASELINE: f64 = 2.0;

/// Strokes of a letter on a grid of 5 x 9: points as two digits, x and y (up), strokes parted by bars.
fn strokes(letter: char) -> &'static str {
    match letter {
        'a' => "35 26 16 05 03 12 22 33|36 32",
        'b' => "08 02|03 12 22 33 35 26 16 05",
        'c' => "35 26 16 05 03 12 22 33",
        'd' => "38 32|33 22 12 03 05 16 26 35",
        'e' => "04 34 35 26 16 05 03 12 22 33",
        'f' => "38 28 17 12|06 26",
        'g' => "36 31 20 10 01|35 26 16 05 03 12 22 33",
        'h' => "08 02|05 16 26 35 32",
        'i' => "16 12|18 17",
        'j' => "26 21 10 00|28 27",
        'k' => "08 02|36 04 32",
        'l' => "18 13 22",
        'm' => "02 06|05 16 25 22|25 36 45 42",
        'n' => "06 02|05 16 26 35 32",
        'o' => "16 05 03 12 22 33 35 26 16",
        'p' => "06 00|03 12 22 33 35 26 16 05",
        'q' => "36 30|33 22 12 03 05 16 26 35",
        'r' => "06 02|04 15 26 36",
        's' => "35 26 16 05 14 24 33 22 12 03",
        't' => "18 13 22 32|06 36",
        'u' => "06 03 12 22 33|36 32",
        'v' => "06 12 22 36",
        'w' => "06 12 24 32 46",
        'x' => "06 32|02 36",
        'y' => "06 03 12 22 33|36 31 20 10 01",
        'z' => "06 36 02 32",
        '0' => "18 07 03 12 22 33 37 28 18",
        '1' => "07 18 12|02 22",
        '2' => "07 18 28 37 36 02 32",
        '3' => "08 38 15 25 34 33 22 12 03",
        '4' => "22 28 04 34",
        '5' => "38 08 05 25 34 33 22 12 03",
        '6' => "37 28 18 07 03 12 22 33 34 25 15 04",
        '7' => "08 38 12",
        '8' => "18 07 06 15 25 34 33 22 12 03 04 15|25 36 37 28 18",
        '9' => "03 12 22 33 37 28 18 07 06 15 25 36",
        '.' => "12 13",
        ',' => "13 12 01",
        ':' => "12 13|15 16",
        '-' => "04 34",
        '+' => "04 44|22 26",
        '=' => "03 33|05 35",
        '/' => "02 38",
        '^' => "06 18 26",
        '(' => "28 17 13 22",
        ')' => "18 27 23 12",
        '%' => "02 38|07 08|32 33",
        '_' => "01 31",
        '|' => "10 18",
        ' ' => "",
        _ => "02 08 38 32 02",
    }
}

/// Polylines of a text whose baseline begins at `at`, in pixels, y down. `height` is that of its tall letters.
pub(super) fn lines(text: &str, at: [f64; 2], height: f64) -> Vec<Vec<(i32, i32)>> {
    let unit = height / HEIGHT;
    let mut lines = Vec::new();
    for (place, letter) in text.chars().flat_map(char::to_lowercase).enumerate() {
        let left = at[0] + place as f64 * ADVANCE * unit;
        for stroke in strokes(letter).split('|').filter(|stroke| !stroke.is_empty()) {
            let point = |point: &str| {
                let mut digits = point.chars().filter_map(|digit| digit.to_digit(10)).map(f64::from);
                let (x, y) = (digits.next()?, digits.next()?);
                Some(((left + x * unit).round() as i32, (at[1] - (y - BASELINE) * unit).round() as i32))
            };
            lines.push(stroke.split(' ').filter_map(point).collect());
        }
    }
    lines
}

/// Width of a text in pixels.
pub(super) fn width(text: &str, height: f64) -> f64 {
    text.chars().count() as f64 * ADVANCE * height / HEIGHT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stroke_is_well_formed() {
        for letter in "abcdefghijklmnopqrstuvwxyz0123456789.,:-+=/^()%_| ?".chars() {
            for stroke in strokes(letter).split('|').filter(|stroke| !stroke.is_empty()) {
                assert!(stroke.split(' ').count() > 1, "{letter}: a stroke has two ends");
                for point in stroke.split(' ') {
                    let digits: Vec<u32> = point.chars().filter_map(|digit| digit.to_digit(10)).collect();
                    assert!(matches!(digits[..], [0..=4, 0..=8]), "{letter}: {point}");
                }
            }
        }
    }

    #[test]
    fn letters_stand_on_the_baseline_side_by_side() {
        let text = lines("Lh", [10.0, 100.0], 12.0);
        assert_eq!(text[0], [(12, 88), (12, 98), (14, 100)]);
        assert_eq!(text[1], [(20, 88), (20, 100)]);
        assert_eq!(width("Lh", 12.0), 20.0);
    }
}
