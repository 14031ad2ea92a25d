//! From the tree of keys to typed values.

use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};
use serde::de::DeserializeOwned;
use toml::Value;

use super::track::{Between, Track};
use super::tree::{self, Kind, Node, Tree};
use super::{Background, Exposure, ShotError};
use crate::io::pattern::LAST_FRAME;
use crate::io::scene::Pick;
use crate::settings::{DialKind, Rule};
use crate::view::{BRIGHTEST, FARTHEST};

type Result<T> = std::result::Result<T, ShotError>;

impl Tree {
    /// The value at `path` as `read` understands it, or `default` where the shot does not name it.
    pub(crate) fn read<T>(&self, path: &str, default: T, read: impl Fn(&Value) -> Option<T>) -> Result<T> {
        match self.get(path).map(|node| &node.kind) {
            None => Ok(default),
            Some(Kind::Leaf(value)) => read(value).ok_or_else(|| self.not_allowed(path)),
            Some(Kind::Table(_)) => Err(self.not_allowed(path)),
        }
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> Result<[u32; 2]> {
        let side = |value: &Value| whole(value).filter(|side| (1..=16384).contains(side));
        self.read("size", [512, 512], |value| match value.as_array()?.as_slice() {
            [width, height] => Some([side(width)?, side(height)?]),
            _ => None,
        })
    }

    /// First and last frame.
    pub(super) fn frames(&self) -> Result<[u32; 2]> {
        self.read("frames", [1, 48], |value| match value.as_array()?.as_slice() {
            [first, last] => Some([whole(first)?, whole(last)?]).filter(|[a, b]| a <= b && *b <= LAST_FRAME),
            _ => None,
        })
    }

    /// Frames per second.
    pub(super) fn fps(&self) -> Result<f64> {
        self.read("fps", 24.0, |value| number(value).filter(|fps| (1e-3..=1e6).contains(fps)))
    }

    /// How many frames a drawing lasts.
    pub(super) fn exposure(&self, path: &str, default: u32) -> Result<u32> {
        self.read(path, default, |value| whole(value).filter(|on| (1..=Exposure::MOST).contains(on)))
    }

    /// Seed of everything random.
    pub(super) fn seed(&self) -> Result<u32> {
        self.read("seed", 0, whole)
    }

    /// The background of the effects.
    pub(super) fn background(&self) -> Result<Background> {
        self.read("background", Background::Colour([0.55, 0.70, 0.90]), |value| match value {
            Value::String(text) if text == "none" => Some(Background::None),
            Value::String(text) if !text.is_empty() => Some(Background::Image(text.into())),
            _ => {
                let colour = three(value)?.as_vec3().to_array();
                colour.iter().all(|c| (0.0..=BRIGHTEST).contains(c)).then_some(Background::Colour(colour))
            }
        })
    }

    /// A vector that may have keyframes.
    pub(super) fn vector(&self, path: &str, default: DVec3) -> Result<Track<DVec3>> {
        self.track(path, default, |value| {
            three(value).filter(|v| v.to_array().iter().all(|x| x.abs() <= f64::from(FARTHEST)))
        })
    }

    /// Two numbers that may have keyframes, none beyond `most`.
    pub(super) fn pair(&self, path: &str, default: DVec2, most: f64) -> Result<Track<DVec2>> {
        self.track(path, default, |value| match value.as_array()?.as_slice() {
            [x, y] => Some(DVec2::new(number(x)?, number(y)?)).filter(|v| v.to_array().iter().all(|x| x.abs() <= most)),
            _ => None,
        })
    }

    /// A number that may have keyframes; not NaN.
    pub(super) fn number(&self, path: &str, default: f64) -> Result<Track<f64>> {
        self.track(path, default, number)
    }

    fn track<T: Between>(&self, path: &str, default: T, read: impl Fn(&Value) -> Option<T>) -> Result<Track<T>> {
        let keyframe = |value: &Value| match value.as_array()?.as_slice() {
            [frame, value] => Some((number(frame)?, read(value)?)),
            _ => None,
        };
        self.read(path, Track::constant(default), |value| match value {
            Value::Array(keyframes) if keyframes.iter().all(Value::is_array) => {
                Track::new(keyframes.iter().map(keyframe).collect::<Option<Vec<_>>>()?)
            }
            constant => Some(Track::constant(read(constant)?)),
        })
    }

    /// A string that need not be there.
    pub(crate) fn text(&self, path: &str) -> Result<Option<String>> {
        self.read(path, None, |value| value.as_str().filter(|text| !text.is_empty()).map(|text| Some(text.to_owned())))
    }

    /// The chosen parts of a file, by name or number: one, or a list of some; none where the shot does not say it.
    pub(crate) fn picks(&self, path: &str) -> Result<Vec<Pick>> {
        let pick = |value: &Value| match value {
            Value::String(name) => Some(Pick::Name(name.clone())).filter(|_| !name.is_empty()),
            number => whole(number).map(Pick::Number),
        };
        self.read(path, Vec::new(), |value| match value {
            Value::Array(picks) if picks.is_empty() => None,
            Value::Array(picks) => picks.iter().map(pick).collect(),
            one => Some(vec![pick(one)?]),
        })
    }

    /// Numbers of frames, ascending; none where the shot does not say it.
    pub(crate) fn frame_list(&self, path: &str) -> Result<Option<Vec<u32>>> {
        self.read(path, None, |value| {
            let frames: Vec<u32> = value.as_array()?.iter().map(whole).collect::<Option<_>>()?;
            let is_good = frames.is_sorted_by(|a, b| a < b) && frames.iter().all(|frame| *frame <= LAST_FRAME);
            is_good.then_some(Some(frames))
        })
    }

    /// Names, each with a share of 0 to 1.
    pub(crate) fn shares(&self, path: &str) -> Result<Vec<(String, f32)>> {
        let share = |value: &Value| match value.as_array()?.as_slice() {
            [Value::String(name), share] if !name.is_empty() => {
                let share = number(share).filter(|share| (0.0..=1.0).contains(share))?;
                Some((name.clone(), share as f32))
            }
            _ => None,
        };
        self.read(path, Vec::new(), |value| value.as_array()?.iter().map(share).collect())
    }

    /// A number without keyframes, within a range; `default` where the shot does not name it.
    pub(crate) fn plain_number(&self, path: &str, default: f64, range: RangeInclusive<f64>) -> Result<f64> {
        self.read(path, default, |value| number(value).filter(|number| range.contains(number)))
    }

    /// A number without keyframes, as a rule allows it; `default` where the shot does not name it.
    pub(super) fn ruled(&self, path: &str, default: f64, rule: &Rule<f64>) -> Result<f64> {
        self.read(path, default, |value| number(value).filter(|number| rule.check(path, *number).is_ok()))
    }

    /// True or false; false where it is not named.
    pub(crate) fn flag(&self, path: &str) -> Result<bool> {
        self.read(path, false, Value::as_bool)
    }

    /// The string at `path`, if it is one.
    pub(crate) fn word(&self, path: &str) -> Option<&str> {
        match &self.get(path)?.kind {
            Kind::Leaf(Value::String(word)) => Some(word),
            _ => None,
        }
    }

    /// The settings of the table `effect`, each of its own type; ranges are not checked yet. Those of `elsewhere`, dotted
    /// where they are in a table, are read by who asks and stay at their default.
    pub(crate) fn settings<T: DeserializeOwned + Default>(&self, effect: &str, elsewhere: &[&str]) -> Result<T> {
        let Some(Node { kind: Kind::Table(entries), .. }) = self.get(effect) else { return Ok(T::default()) };
        let table = self.checked::<T>(effect, "", entries, elsewhere)?;
        T::deserialize(table).map_err(|e| self.wrong(effect, e.message().to_owned()))
    }

    /// The entries of an effect's table, or of one within it whose name with a dot is `inside`. Each key has been read on
    /// its own, so that an error names the one that it is in.
    fn checked<T: DeserializeOwned>(
        &self,
        effect: &str,
        inside: &str,
        entries: &[(String, Node)],
        elsewhere: &[&str],
    ) -> Result<toml::Table> {
        let mut table = toml::Table::new();
        for (key, node) in entries {
            let dotted = format!("{inside}{key}");
            let path = format!("{effect}.{dotted}");
            if elsewhere.contains(&dotted.as_str()) {
                continue;
            }
            let value = match &node.kind {
                Kind::Table(entries) if self.keys.find(&path).is_some_and(|key| key.kind == DialKind::Table) => {
                    Value::Table(self.checked::<T>(effect, &format!("{dotted}."), entries, elsewhere)?)
                }
                _ => {
                    let within = |value, name: &str| Value::Table(toml::Table::from_iter([(name.to_owned(), value)]));
                    let alone = dotted.rsplit('.').fold(tree::value(node), within);
                    T::deserialize(alone).map_err(|_| self.not_allowed(&path))?;
                    tree::value(node)
                }
            };
            table.insert(key.clone(), value);
        }
        Ok(table)
    }
}

fn whole(value: &Value) -> Option<u32> {
    value.as_integer().and_then(|n| u32::try_from(n).ok())
}

fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64))?;
    (!number.is_nan()).then_some(number)
}

fn three(value: &Value) -> Option<DVec3> {
    match value.as_array()?.as_slice() {
        [x, y, z] => Some(DVec3::new(number(x)?, number(y)?, number(z)?)),
        _ => None,
    }
}
