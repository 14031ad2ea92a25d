//! Black-body colour: Planck's law over the CIE 1931 observer, adapted to the hottest fire, in linear sRGB; and the
//! tables that shaders look it up in.
//!
//! Everything is f64 on the CPU, once. Temperatures are in kelvin; below [`COLDEST`] nothing glows.

use glam::{DMat3, DVec3, Vec3, Vec4};

use super::cie::{FIRST_NM, MATCHING};
use crate::shaders::flame::constants::COLDEST;

/// Entries of a black-body table.
pub const ENTRIES: usize = 256;

/// The smallest component whose logarithm is taken.
const DARKEST: f64 = 1e-12;

/// Hotter is as this: no number overflows.
const HOTTEST: f64 = 1e9;

/// Second radiation constant hc / k in metre kelvin (CODATA 2018, exact).
const C2: f64 = 1.438_776_877_503_933_4e-2;

/// CIE XYZ of `kelvin` up to a factor that is the same for all temperatures.
///
/// `exp(-x) / (1 - exp(-x))` neither overflows where x is large nor cancels where it is small.
fn black_body(kelvin: f64) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (row, matching) in MATCHING.iter().enumerate() {
        let metres = f64::from(FIRST_NM + row as u32) * 1e-9;
        let x = C2 / (metres * kelvin);
        let micrometres = metres * 1e6;
        let radiance = (-x).exp() / -(-x).exp_m1() / micrometres.powi(5);
        sum += radiance * DVec3::from_array(*matching);
    }
    sum
}

/// XYZ to the cone responses of Hunt, Pointer and Estevez.
fn cones_from_xyz() -> DMat3 {
    DMat3::from_cols_array(&[0.40024, -0.2263, 0.0, 0.7076, 1.16532, 0.0, -0.08081, 0.0457, 0.91822])
}

/// Linear sRGB to XYZ, from the chromaticities of its primaries and of its white D65, which becomes Y = 1 (IEC 61966-2-1).
fn xyz_from_rgb() -> DMat3 {
    let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
    let shares = primaries.inverse() * xyz(0.3127, 0.3290);
    primaries * DMat3::from_diagonal(shares)
}

/// Black bodies as seen by an eye that has adapted to one of them.
struct Eye {
    /// XYZ to linear sRGB, adapted and scaled.
    rgb_from_xyz: DMat3,
}

impl Eye {
    /// `hottest` in kelvin; `adaptation` from 0 (none; `hottest` has luminance 1) to 1 (`hottest` is white), linear in
    /// von Kries' gains.
    fn new(hottest: f64, adaptation: f64) -> Eye {
        let (cones, rgb) = (cones_from_xyz(), xyz_from_rgb().inverse());
        let white = black_body(hottest);
        let full = cones * (xyz_from_rgb() * DVec3::ONE) / (cones * white);
        let gains = DVec3::splat(1.0 / white.y).lerp(full, adaptation);
        Eye { rgb_from_xyz: rgb * cones.inverse() * DMat3::from_diagonal(gains) * cones }
    }

    /// Linear sRGB, with components below 0 where it cannot hold the colour.
    fn unclamped(&self, kelvin: f64) -> DVec3 {
        self.rgb_from_xyz * black_body(kelvin.clamp(COLDEST.into(), HOTTEST))
    }

    /// The same with 1 as its largest component.
    fn chromaticity(&self, kelvin: f64) -> DVec3 {
        let colour = self.unclamped(kelvin);
        colour / colour.max_element()
    }
}

/// Whether a body at `kelvin` glows at all; not if that is NaN.
fn glows(kelvin: f64) -> bool {
    kelvin >= f64::from(COLDEST)
}

/// Radiance as linear sRGB, relative to that of `hottest`; 0 or above, without an upper bound for what is hotter.
///
/// `hottest`: kelvin, 700 to 1e6. `adaptation` 1: `hottest` is (1, 1, 1); 0: it has its own chromaticity and luminance
/// 1; between: linear in von Kries' gains. Colours outside of the gamut are clamped. 0 below 700 K and for NaN.
pub fn physical(kelvin: f64, hottest: f64, adaptation: f64) -> [f64; 3] {
    if !glows(kelvin) {
        return [0.0; 3];
    }
    Eye::new(hottest, adaptation).unclamped(kelvin).max(DVec3::ZERO).to_array()
}

/// [`physical`] colour with `(kelvin / hottest)^falloff` as its largest component, 0 to 1. Hotter is as `hottest`.
pub fn displayable(kelvin: f64, hottest: f64, falloff: f64, adaptation: f64) -> [f64; 3] {
    if !glows(kelvin) {
        return [0.0; 3];
    }
    let kelvin = kelvin.min(hottest);
    let chromaticity = Eye::new(hottest, adaptation).chromaticity(kelvin).max(DVec3::ZERO);
    (chromaticity * (kelvin / hottest).powf(falloff)).to_array()
}

/// Linear RGB over kelvin / hottest from 0 to 1, linear between the centres of `colours`, constant outside of them.
/// 0 below 700 K, for NaN and without colours.
pub fn ramp(kelvin: f64, hottest: f64, colours: &[[f32; 3]]) -> [f64; 3] {
    if colours.is_empty() || !glows(kelvin) {
        return [0.0; 3];
    }
    let last = colours.len() - 1;
    let place = (kelvin / hottest * colours.len() as f64 - 0.5).clamp(0.0, last as f64);
    let below = (place as usize).min(last.saturating_sub(1));
    let [low, high] = [below, (below + 1).min(last)].map(|i| DVec3::from_array(colours[i].map(f64::from)));
    low.lerp(high, place - below as f64).to_array()
}

/// Heat, as grey: kelvin / hottest, at most 1. 0 below 700 K and for NaN.
pub fn heat(kelvin: f64, hottest: f64) -> [f64; 3] {
    [if glows(kelvin) { (kelvin / hottest).min(1.0) } else { 0.0 }; 3]
}

/// The kind of a [`Table`]'s entries, and their axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Logarithms of [`physical`] colours over 1 / T.
    Radiance,
    /// Logarithms of chromaticities over 1 / T, for [`displayable`] colours.
    Chromaticity,
    /// Colours over T.
    Ramp,
}

/// Colours as shaders look them up.
///
/// At temperature T in kelvin: 0 where T < 700 or T is NaN. Otherwise t = T for a ramp and 1 / T for black bodies, and
/// `c` is linear between the two entries next to `place = clamp(scale * t + offset, 0, entries - 1)`. For black bodies
/// then `c = max(exp(c) - shift, 0)`; for chromaticities then
/// `c = c / largest component of c * (min(T, hottest) / hottest)^falloff`.
///
/// ln B is nearly linear in 1 / T (Wien). The shift keeps the logarithms smooth where a component leaves the gamut,
/// and the fall-off is left out of the table because it is not: both together are ten times closer than a table without.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// ln(max(component + shift, 1e-12)), or linear RGB; the fourth component is unused. At least 2.
    pub entries: Vec<[f32; 4]>,
    /// The kind of the entries.
    pub form: Form,
    /// Places per unit of t.
    pub scale: f32,
    /// Place at t = 0.
    pub offset: f32,
    /// Added to each component before its logarithm: 0, or more than it lacks to 0 anywhere up to `hottest`.
    pub shift: [f32; 3],
    /// Kelvin.
    pub hottest: f32,
    /// Exponent of T / hottest; 0 but for chromaticities.
    pub falloff: f32,
}

impl Table {
    /// [`physical`] colours up to `upper` kelvin, above which the table is constant. Entries are few where 1 / T hardly
    /// changes: close to the formula only to some 5000 K.
    pub fn physical(hottest: f64, adaptation: f64, upper: f64) -> Table {
        let eye = Eye::new(hottest, adaptation);
        Table::black_body(Form::Radiance, hottest, upper.max(hottest), |kelvin| eye.unclamped(kelvin))
    }

    /// [`displayable`] colours.
    pub fn displayable(hottest: f64, falloff: f64, adaptation: f64) -> Table {
        let eye = Eye::new(hottest, adaptation);
        let table = Table::black_body(Form::Chromaticity, hottest, hottest, |kelvin| eye.chromaticity(kelvin));
        Table { falloff: falloff as f32, ..table }
    }

    /// [`ramp`] colours.
    pub fn ramp(hottest: f64, colours: &[[f32; 3]]) -> Table {
        let mut entries: Vec<[f32; 4]> = colours.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]).collect();
        while entries.len() < 2 {
            entries.push(entries.last().copied().unwrap_or_default());
        }
        let scale = if colours.len() < 2 { 0.0 } else { colours.len() as f64 / hottest };
        Table {
            entries,
            form: Form::Ramp,
            scale: scale as f32,
            offset: -0.5,
            shift: [0.0; 3],
            hottest: hottest as f32,
            falloff: 0.0,
        }
    }

    /// [`heat`].
    pub fn heat(hottest: f64) -> Table {
        let entries = vec![[0.0; 4], [1.0, 1.0, 1.0, 0.0]];
        Table { entries, scale: (1.0 / hottest) as f32, offset: 0.0, ..Table::ramp(hottest, &[]) }
    }

    fn black_body(form: Form, hottest: f64, upper: f64, colour: impl Fn(f64) -> DVec3) -> Table {
        let last = (ENTRIES - 1) as f64;
        let (hot, cold) = (1.0 / upper, 1.0 / f64::from(COLDEST));
        let nodes = (0..ENTRIES).map(|i| 1.0 / (hot + (cold - hot) * i as f64 / last));
        let colours: Vec<(f64, DVec3)> = nodes.map(|kelvin| (kelvin, colour(kelvin))).collect();
        let glowing = colours.iter().filter(|(kelvin, _)| *kelvin <= hottest * (1.0 + 1e-9));
        let least = glowing.fold(DVec3::ZERO, |least, (_, colour)| least.min(*colour));
        // Twice what is missing: the logarithm of what is left stays smooth. Rounded first, then used.
        let shift = (-2.0 * least).as_vec3();
        let entry = |(_, colour): &(f64, DVec3)| {
            let [r, g, b] = (*colour + shift.as_dvec3()).to_array().map(|c| c.max(DARKEST).ln() as f32);
            [r, g, b, 0.0]
        };
        let scale = if cold > hot { last / (cold - hot) } else { 0.0 };
        Table {
            entries: colours.iter().map(entry).collect(),
            form,
            scale: scale as f32,
            offset: (-scale * hot) as f32,
            shift: shift.to_array(),
            hottest: hottest as f32,
            falloff: 0.0,
        }
    }

    /// The colour at `kelvin` as a shader finds it.
    pub fn look_up(&self, kelvin: f32) -> [f32; 3] {
        if kelvin.is_nan() || kelvin < COLDEST {
            return [0.0; 3];
        }
        let t = if self.form == Form::Ramp { kelvin } else { 1.0 / kelvin };
        let place = (self.scale * t + self.offset).clamp(0.0, (self.entries.len() - 1) as f32);
        let below = (place as usize).min(self.entries.len() - 2);
        let [low, high] = [below, below + 1].map(|i| Vec4::from_array(self.entries[i]).truncate());
        let mut colour = low + (high - low) * (place - below as f32);
        if self.form != Form::Ramp {
            colour = (colour.exp() - Vec3::from_array(self.shift)).max(Vec3::ZERO);
        }
        if self.form == Form::Chromaticity {
            colour *= (kelvin.min(self.hottest) / self.hottest).powf(self.falloff) / colour.max_element();
        }
        colour.to_array()
    }

    /// The same in f64: what is left of the difference to the formulas is the table's.
    pub fn look_up_f64(&self, kelvin: f64) -> [f64; 3] {
        if !glows(kelvin) {
            return [0.0; 3];
        }
        let t = if self.form == Form::Ramp { kelvin } else { 1.0 / kelvin };
        let last = (self.entries.len() - 1) as f64;
        let place = (f64::from(self.scale) * t + f64::from(self.offset)).clamp(0.0, last);
        let below = (place as usize).min(self.entries.len() - 2);
        let [low, high] = [below, below + 1].map(|i| Vec4::from_array(self.entries[i]).truncate().as_dvec3());
        let mut colour = low + (high - low) * (place - below as f64);
        if self.form != Form::Ramp {
            colour = (colour.exp() - Vec3::from_array(self.shift).as_dvec3()).max(DVec3::ZERO);
        }
        if self.form == Form::Chromaticity {
            let hottest = f64::from(self.hottest);
            colour *= (kelvin.min(hottest) / hottest).powf(self.falloff.into()) / colour.max_element();
        }
        colour.to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: [f64; 3], b: [f64; 3], relative: f64) -> bool {
        (0..3).all(|c| (a[c] - b[c]).abs() <= relative * b[c].abs())
    }

    fn luminance(c: [f64; 3]) -> f64 {
        0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
    }

    fn temperatures(low: f64, high: f64) -> impl Iterator<Item = f64> {
        (0..=4000).map(move |i| low + (high - low) * f64::from(i) / 4000.0)
    }

    #[test]
    fn the_observer_is_the_published_one() {
        let row = |nm: u32| MATCHING[(nm - FIRST_NM) as usize];
        assert_eq!((row(360), row(555)), ([0.0001299, 0.000003917, 0.0006061], [0.5120501, 1.0, 0.005749999]));
        assert_eq!((row(446), row(830)), ([0.3463733, 0.03131083, 1.7829682], [0.000001251141, 0.00000045181, 0.0]));
        // An equal-energy spectrum is white: the three integrals are equal.
        let sum = MATCHING.iter().fold(DVec3::ZERO, |sum, row| sum + DVec3::from_array(*row));
        assert!((sum - DVec3::splat(106.86)).abs().max_element() < 0.05, "{sum}");
    }

    #[test]
    fn radiance_has_its_known_values() {
        let at = |kelvin| physical(kelvin, 3000.0, 1.0);
        assert!(close(at(3000.0), [1.0; 3], 1e-12));
        assert!(close(at(2500.0), [0.232094, 0.178901, 0.116065], 1e-5));
        assert!(close(at(2000.0), [0.0252540, 0.0133939, 0.00429713], 1e-5));
        assert!(close(at(1500.0), [5.96950e-4, 1.76040e-4, 5.93209e-6], 1e-5));
        assert!(close(at(1200.0), [1.37886e-5, 2.27133e-6, 0.0], 1e-5));
        assert!(close(at(800.0), [1.16771e-9, 1.95113e-11, 0.0], 1e-5));
        assert!(close(physical(3000.0, 3000.0, 0.0), [1.770931, 0.844261, 0.272074], 1e-5));
        assert!((luminance(physical(3000.0, 3000.0, 0.0)) - 1.0).abs() < 1e-4);
        let [none, half, full] = [0.0, 0.5, 1.0].map(|a| DVec3::from_array(physical(2700.0, 3000.0, a)));
        assert!((half - (none + full) / 2.0).abs().max_element() < 1e-15);
    }

    #[test]
    fn a_black_body_of_6504_k_is_nearly_daylight() {
        // D65 lies a little beside the Planckian locus, by 0.003 in u'v'.
        let c = displayable(6504.0, 6504.0, 0.0, 0.0);
        assert!(c[0] == 1.0 && (c[1] - 0.95).abs() < 0.03 && (c[2] - 0.97).abs() < 0.05, "{c:?}");
    }

    #[test]
    fn displayable_colours_keep_the_chromaticity() {
        for kelvin in [700.0, 1000.0, 1700.0, 2999.0] {
            let (radiance, shown) = (physical(kelvin, 3000.0, 0.7), displayable(kelvin, 3000.0, 2.0, 0.7));
            let largest = shown.into_iter().fold(0.0, f64::max);
            assert!((largest - (kelvin / 3000.0).powi(2)).abs() < 1e-15);
            let expected = radiance.map(|c| c / radiance.into_iter().fold(0.0, f64::max) * largest);
            assert!(close(shown, expected, 1e-12));
        }
        assert_eq!(displayable(9000.0, 3000.0, 2.0, 1.0), displayable(3000.0, 3000.0, 2.0, 1.0));
        assert!(physical(9000.0, 3000.0, 1.0)[2] > 100.0);
    }

    #[test]
    fn brightness_rises_with_temperature() {
        for adaptation in [0.0, 0.5, 1.0] {
            let tables = [Table::physical(3000.0, adaptation, 4000.0), Table::displayable(3000.0, 2.0, adaptation)];
            let mut before = [0.0; 4];
            for kelvin in temperatures(700.0, 3000.0) {
                let physical = luminance(physical(kelvin, 3000.0, adaptation));
                let shown = luminance(displayable(kelvin, 3000.0, 2.0, adaptation));
                let [a, b] = [0, 1].map(|i| luminance(tables[i].look_up_f64(kelvin)));
                let now = [physical, shown, a, b];
                assert!((0..4).all(|i| now[i] > before[i]), "{kelvin} K: {now:?} after {before:?}");
                before = now;
            }
        }
    }

    #[test]
    fn extremes_are_dark_or_finite() {
        for kelvin in [0.0, -0.0, -1.0, 1.0, 199.0, 699.999, f64::NAN, f64::NEG_INFINITY] {
            for adaptation in [0.0, 1.0] {
                assert_eq!(physical(kelvin, 3000.0, adaptation), [0.0; 3]);
                assert_eq!(displayable(kelvin, 3000.0, 2.0, adaptation), [0.0; 3]);
                assert_eq!(ramp(kelvin, 3000.0, &[[1.0; 3]]), [0.0; 3]);
                for table in tables(3000.0, adaptation) {
                    assert_eq!(table.look_up(kelvin as f32), [0.0; 3]);
                    assert_eq!(table.look_up_f64(kelvin), [0.0; 3]);
                }
            }
        }
        for hottest in [700.0, 701.0, 3000.0, 1e6] {
            for kelvin in [700.0, 701.0, 3000.0, 1e5, 1e6, 1e30, f64::INFINITY] {
                for adaptation in [0.0, 0.3, 1.0] {
                    let fine = |c: [f64; 3]| c.iter().all(|c| (0.0..f64::from(f32::MAX)).contains(c));
                    assert!(fine(physical(kelvin, hottest, adaptation)));
                    assert!(fine(displayable(kelvin, hottest, 16.0, adaptation)));
                    for table in tables(hottest, adaptation) {
                        assert!(fine(table.look_up_f64(kelvin)));
                        assert!(fine(table.look_up(kelvin as f32).map(f64::from)), "{hottest} {kelvin} {adaptation}");
                    }
                }
            }
        }
    }

    fn tables(hottest: f64, adaptation: f64) -> [Table; 3] {
        let ramp = Table::ramp(hottest, &[[0.0, 0.5, 1.0], [2.0, 0.0, 1.0]]);
        [Table::physical(hottest, adaptation, 1e6), Table::displayable(hottest, 2.0, adaptation), ramp]
    }

    #[test]
    fn tables_agree_with_the_formulas() {
        for adaptation in [0.0, 0.5, 1.0] {
            for (falloff, upper) in [(0.0, 3000.0), (2.0, 3500.0), (16.0, 5000.0)] {
                let physical_table = Table::physical(3000.0, adaptation, upper);
                let displayable_table = Table::displayable(3000.0, falloff, adaptation);
                let eye = Eye::new(3000.0, adaptation);
                let mut worst = [0.0_f64; 4];
                for kelvin in temperatures(800.0, 3000.0) {
                    let radiance = eye.unclamped(kelvin).max(DVec3::ZERO);
                    let shown = DVec3::from_array(displayable(kelvin, 3000.0, falloff, adaptation));
                    let single = |c: [f32; 3]| Vec3::from_array(c).as_dvec3();
                    let differences = [
                        DVec3::from_array(physical_table.look_up_f64(kelvin)) - radiance,
                        single(physical_table.look_up(kelvin as f32)) - radiance,
                        DVec3::from_array(displayable_table.look_up_f64(kelvin)) - shown,
                        single(displayable_table.look_up(kelvin as f32)) - shown,
                    ];
                    worst = std::array::from_fn(|i| worst[i].max(differences[i].abs().max_element()));
                }
                assert!(worst.iter().all(|w| *w < 2e-5), "{adaptation} {falloff} {upper}: {worst:?}");
            }
        }
    }

    #[test]
    fn heat_is_the_share_of_the_hottest() {
        assert_eq!([600.0, 1500.0, 3000.0, 9000.0].map(|kelvin| heat(kelvin, 3000.0)[1]), [0.0, 0.5, 1.0, 1.0]);
        let table = Table::heat(3000.0);
        for kelvin in temperatures(650.0, 4000.0) {
            let exact = heat(kelvin, 3000.0)[0];
            assert!((table.look_up_f64(kelvin)[0] - exact).abs() < 1e-6);
            assert!((f64::from(table.look_up(kelvin as f32)[2]) - exact).abs() < 1e-6);
        }
    }

    #[test]
    fn ramps_are_linear_between_the_centres() {
        let colours = [[0.0, 1.0, 2.0], [1.0, 1.0, 0.0], [5.0, 0.0, 0.0], [5.0, 0.0, 4.0]];
        // The middle of the second and the third: 2 / 4 of 3000 K.
        assert!(close(ramp(1500.0, 3000.0, &colours), [3.0, 0.5, 0.0], 1e-12));
        assert_eq!(ramp(3000.0, 3000.0, &colours), [5.0, 0.0, 4.0]);
        assert_eq!(ramp(9000.0, 3000.0, &colours), [5.0, 0.0, 4.0]);
        assert_eq!(ramp(3000.0, 3000.0, &[]), [0.0; 3]);
        for colours in [&colours[..], &colours[..1], &[]] {
            let table = Table::ramp(3000.0, colours);
            for kelvin in temperatures(700.0, 4000.0) {
                let exact = DVec3::from_array(ramp(kelvin, 3000.0, colours));
                let (single, double) = (table.look_up(kelvin as f32), table.look_up_f64(kelvin));
                assert!((DVec3::from_array(double) - exact).abs().max_element() < 1e-5);
                assert!((Vec3::from_array(single).as_dvec3() - exact).abs().max_element() < 1e-5);
            }
        }
    }
}
