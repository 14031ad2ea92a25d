//! How strength depends on speed.

use crate::error::{Error, Result};
use crate::settings::{Number, Rule, Setting, listed_in_brackets};
use crate::shaders::blur::constants::CURVE_KEYS;

/// Fastest speed of a key.
const FASTEST: f32 = 1e5;

/// A share of strength for each speed: keys of speed, in pixels per frame at 1080 lines, ascending, and share, 0 to 1; linear
/// between them, constant outside. Without keys it is 1.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(transparent))]
pub struct Curve {
    /// Speed and share of each key, at most 8.
    pub keys: Vec<[f32; 2]>,
}

impl Setting for Curve {
    type Rule = ();

    fn check(&self, key: &str, (): &()) -> Result<()> {
        let refuse = |value: String, allowed: &str| Err(Error::setting(key.to_owned(), value, allowed));
        if self.keys.len() > CURVE_KEYS as usize {
            return refuse(format!("{} keys", self.keys.len()), &format!("at most {CURVE_KEYS}"));
        }
        for [speed, share] in &self.keys {
            Rule::new("pixels per frame at 1080 lines", 0.0..=FASTEST).check(key, *speed)?;
            Rule::new("share of strength", 0.0..=1.0).check(key, *share)?;
        }
        match self.keys.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
            Some(pair) => refuse(pair[1][0].to_string(), "speeds, ascending"),
            None => Ok(()),
        }
    }

    fn allowed((): &()) -> String {
        format!(
            "[[speed, share], ...], at most {CURVE_KEYS}, pixels per frame at 1080 lines, 0 to {}, ascending, and share \
             of strength, 0 to 1; linear between, constant outside; [] for 1 at all speeds",
            Number::shown(FASTEST)
        )
    }

    fn shown(&self) -> Option<String> {
        Some(format!("[{}]", self.keys.iter().map(|key| listed_in_brackets(*key)).collect::<Vec<_>>().join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_curve_is_refused() {
        let check = |keys: &[[f32; 2]]| Curve { keys: keys.to_vec() }.check("blur.curve", &());
        assert!(check(&[]).is_ok() && check(&[[0.0, 0.0], [40.0, 1.0]]).is_ok());
        for (keys, why) in [
            (&[[10.0, 0.5], [10.0, 1.0]][..], "ascending"),
            (&[[10.0, 1.5]], "0 to 1"),
            (&[[-1.0, 1.0]], "0 to 100000"),
            (&[[f32::NAN, 1.0]], "0 to 100000"),
            (&[[0.0, 1.0]; 9], "at most 8"),
        ] {
            let error = check(keys).unwrap_err().to_string();
            assert!(error.starts_with("blur.curve") && error.contains(why), "{error}");
        }
    }
}
