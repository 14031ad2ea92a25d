//! Tones by heat.

use crate::error::{Error, Result};
use crate::flame::settings::HOTTEST;
use crate::settings::{Number, Rule, Setting, listed_in_brackets};
use crate::shaders::toon::constants::MOST_TONES;
use crate::toon::Tone;
use crate::view::BRIGHTEST;

/// What heat becomes: from `from` upwards the colour is `colour`. Up to 1, `from` is a share of `hottest`; above, kelvin.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(transparent))]
pub struct Tones(pub Vec<Tone>);

impl Default for Tones {
    fn default() -> Self {
        Tones(vec![
            Tone::new(0.22, [0.19, 0.010, 0.012]),
            Tone::new(0.40, [0.72, 0.045, 0.020]),
            Tone::new(0.52, [1.00, 0.300, 0.020]),
            Tone::new(0.66, [1.00, 0.860, 0.330]),
        ])
    }
}

impl Tones {
    /// With each `from` as a share of the hottest, in kelvin.
    pub(crate) fn shares(&self, hottest: f32) -> impl Iterator<Item = Tone> {
        self.0
            .iter()
            .map(move |tone| Tone { from: if tone.from > 1.0 { tone.from / hottest } else { tone.from }, ..*tone })
    }

    /// Refuses tones that do not ascend as shares of the hottest.
    pub(super) fn check_ascending(&self, hottest: f32) -> Result<()> {
        let shares: Vec<f32> = self.shares(hottest).map(|tone| tone.from).collect();
        match shares.windows(2).position(|pair| pair[0] >= pair[1]) {
            Some(at) => Err(Error::setting("flame.tones", self.0[at + 1].from, "hotter than the tone before it")),
            None => Ok(()),
        }
    }
}

impl Setting for Tones {
    type Rule = ();

    fn check(&self, key: &str, (): &()) -> Result<()> {
        let refuse = |value: String, allowed: &str| Err(Error::setting(key.to_owned(), value, allowed));
        if self.0.is_empty() || self.0.len() > MOST_TONES as usize {
            return refuse(format!("{} tones", self.0.len()), &format!("1 to {MOST_TONES} tones"));
        }
        for tone in &self.0 {
            if !(tone.from > 0.0 && tone.from <= HOTTEST) {
                return refuse(tone.from.to_string(), "heats above 0, at most 1e6");
            }
            if tone.shadow.is_some() {
                return refuse("a colour in shadow".to_owned(), "[from, [red, green, blue]]: no shadow falls on fire");
            }
            tone.colour.check(key, &Rule::new("linear RGB", 0.0..=BRIGHTEST))?;
        }
        Ok(())
    }

    fn allowed((): &()) -> String {
        format!(
            "[[from, [red, green, blue]], ...], 1 to {MOST_TONES} tones, from ascending, above 0: up to 1 a share of `hottest`, \
             above that kelvin, linear colours 0 to {}",
            Number::shown(BRIGHTEST)
        )
    }

    fn shown(&self) -> Option<String> {
        let one = |tone: &Tone| format!("[{}, {}]", Number::shown(tone.from), listed_in_brackets(tone.colour));
        Some(format!("[{}]", self.0.iter().map(one).collect::<Vec<_>>().join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flame::Settings;

    fn checked(froms: &[f32]) -> Result<()> {
        let tones = Tones(froms.iter().map(|&from| Tone::new(from, [1.0; 3])).collect());
        Settings { tones, hottest: 2000.0, ..Settings::default() }.validate()
    }

    #[test]
    fn shares_and_kelvin_ascend_as_one() {
        checked(&[0.25, 1000.0, 1900.0]).expect("500, 1000 and 1900 K");
        checked(&[1.0]).expect("all of it");
        for refused in [&[0.0, 0.5][..], &[-0.1], &[f32::NAN], &[0.5, 0.5], &[0.6, 1000.0], &[2e6], &[]] {
            checked(refused).expect_err("refused");
        }
        let tones = Tones(vec![Tone::new(500.0, [0.0; 3])]);
        assert_eq!(tones.shares(2000.0).next().expect("a tone").from, 0.25);
    }
}
