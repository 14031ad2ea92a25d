//! Tables of settings. A setting stands once: its field, default, unit, range and text are a line of `settings!`. The
//! structure, its checks and the [`Dial`] that shots, messages and documents show follow from that.

use std::fmt::Display;
use std::ops::RangeInclusive;

use crate::error::{Error, Result};

/// A key of a table of settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Dial {
    /// Its name, with a dot behind each table that it is in.
    pub key: String,
    /// Description of its effect.
    pub about: String,
    /// Its allowed values, with unit.
    pub allowed: String,
    /// Its default as TOML; none where there is none.
    pub default: Option<String>,
    /// Its kind.
    pub kind: DialKind,
}

/// The kind of a [`Dial`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DialKind {
    /// One value.
    Value,
    /// A table, each key of which has a default.
    Table,
    /// A table that is given as a whole.
    Group,
}

/// A type of settings that can stand in a table.
pub(crate) trait Setting {
    /// A table's rule for a value: a [`Rule`], or nothing where the type says it all.
    type Rule;
    /// Refuses what is not allowed, by the name of the key.
    fn check(&self, key: &str, rule: &Self::Rule) -> Result<()>;
    /// The allowed values, with unit.
    fn allowed(rule: &Self::Rule) -> String;
    /// As TOML; none if there is no value.
    fn shown(&self) -> Option<String>;
    /// The kind of the dial.
    const KIND: DialKind = DialKind::Value;
    /// The keys in it, if it is a table.
    fn dials(&self) -> Vec<Dial> {
        Vec::new()
    }
}

/// The dials of a field: its own, and those in it.
pub(crate) fn dials_of<S: Setting>(key: &str, about: &str, value: &S, rule: &S::Rule) -> Vec<Dial> {
    let allowed = S::allowed(rule);
    let own =
        Dial { key: key.to_owned(), about: about.trim().to_owned(), allowed, default: value.shown(), kind: S::KIND };
    let inside = value.dials().into_iter().map(|dial| Dial { key: format!("{key}.{}", dial.key), ..dial });
    [own].into_iter().chain(inside).collect()
}

/// Unit and range of a number.
#[derive(Clone, Debug)]
pub(crate) struct Rule<T> {
    unit: &'static str,
    among: Among<T>,
    /// The meaning of 0, which is allowed whatever the range.
    zero: Option<&'static str>,
}

/// Which numbers.
#[derive(Clone, Debug)]
pub(crate) enum Among<T> {
    Range(T, T),
    List(Vec<T>),
}

impl<T: Copy> From<RangeInclusive<T>> for Among<T> {
    fn from(range: RangeInclusive<T>) -> Self {
        Among::Range(*range.start(), *range.end())
    }
}

impl<T, const N: usize> From<[T; N]> for Among<T> {
    fn from(list: [T; N]) -> Self {
        Among::List(list.into())
    }
}

impl<T: Number> Rule<T> {
    pub(crate) fn new<R>(unit: &'static str, among: R) -> Rule<T>
    where
        Among<T>: From<R>,
    {
        Rule { unit, among: among.into(), zero: None }
    }

    /// 0 is allowed, and means this.
    pub(crate) fn or_zero(self, meaning: &'static str) -> Rule<T> {
        Rule { zero: Some(meaning), ..self }
    }

    /// Refuses a number that is not allowed, or none at all.
    pub(crate) fn check(&self, key: &str, value: T) -> Result<()> {
        let is_within = match &self.among {
            Among::Range(low, high) => (low..=high).contains(&&value),
            Among::List(list) => list.contains(&value),
        };
        match is_within || (self.zero.is_some() && value == T::default()) {
            true => Ok(()),
            false => Err(Error::setting(key.to_owned(), value, self.allowed())),
        }
    }

    /// The allowed values, with unit.
    pub(crate) fn allowed(&self) -> String {
        let range = match (&self.among, self.zero) {
            (Among::List(list), _) => listed(list.iter().map(|n| n.shown())),
            (Among::Range(low, high), _) if T::ENDS == Some((*low, *high)) => "a finite number".to_owned(),
            (Among::Range(low, high), _) if T::LEAST == Some(*low) => format!("above 0, at most {}", high.shown()),
            (Among::Range(low, high), None) => format!("{} to {}", low.shown(), high.shown()),
            (Among::Range(low, high), Some(zero)) if *low == T::default() => format!("0 ({zero}) to {}", high.shown()),
            (Among::Range(low, high), Some(zero)) => format!("0 ({zero}) or {} to {}", low.shown(), high.shown()),
        };
        match if self.unit.is_empty() { T::UNIT } else { self.unit } {
            "" => range,
            unit => format!("{unit}, {range}"),
        }
    }
}

/// `a, b or c`.
pub(crate) fn listed(words: impl ExactSizeIterator<Item = String>) -> String {
    let last = words.len().saturating_sub(1);
    let joined = |(i, word): (usize, String)| match i {
        0 => word,
        i if i == last => format!(" or {word}"),
        _ => format!(", {word}"),
    };
    words.enumerate().map(joined).collect()
}

/// A type of numbers.
pub(crate) trait Number: Copy + PartialOrd + Default + Display {
    /// The unit shown for types that have none.
    const UNIT: &'static str = "";
    /// The smallest above 0, and the ends of all finite ones, where they are worth a word.
    const LEAST: Option<Self> = None;
    const ENDS: Option<(Self, Self)> = None;
    fn shown(self) -> String;
}

impl Number for u32 {
    const UNIT: &'static str = "a whole number";
    fn shown(self) -> String {
        self.to_string()
    }
}

macro_rules! floats {
    ($($float:ty)*) => { $(impl Number for $float {
        const LEAST: Option<Self> = Some(<$float>::MIN_POSITIVE);
        const ENDS: Option<(Self, Self)> = Some((<$float>::MIN, <$float>::MAX));
        fn shown(self) -> String {
            match self.abs() {
                usual if usual == 0.0 || (1e-3..1e6).contains(&usual) => self.to_string(),
                _ => format!("{self:e}"),
            }
        }
    })* };
}
floats!(f32 f64);

macro_rules! numbers {
    ($($number:ty)*) => { $(impl Setting for $number {
        type Rule = Rule<$number>;
        fn check(&self, key: &str, rule: &Self::Rule) -> Result<()> {
            rule.check(key, *self)
        }
        fn allowed(rule: &Self::Rule) -> String {
            rule.allowed()
        }
        fn shown(&self) -> Option<String> {
            Some(Number::shown(*self))
        }
    })* };
}
numbers!(f32 u32);

impl<S: Setting + Default> Setting for Option<S> {
    type Rule = S::Rule;
    const KIND: DialKind = S::KIND;
    fn check(&self, key: &str, rule: &Self::Rule) -> Result<()> {
        self.as_ref().map_or(Ok(()), |value| value.check(key, rule))
    }
    fn allowed(rule: &Self::Rule) -> String {
        S::allowed(rule)
    }
    fn shown(&self) -> Option<String> {
        self.as_ref().and_then(S::shown)
    }
    fn dials(&self) -> Vec<Dial> {
        // Those of a value that is not there have no defaults either.
        S::default().dials().into_iter().map(|dial| Dial { default: None, ..dial }).collect()
    }
}

/// Numbers in brackets.
pub(crate) fn listed_in_brackets<const N: usize>(values: [f32; N]) -> String {
    format!("[{}]", values.map(Number::shown).join(", "))
}

impl<const N: usize> Setting for [f32; N] {
    type Rule = Rule<f32>;
    fn check(&self, key: &str, rule: &Self::Rule) -> Result<()> {
        self.iter().try_for_each(|value| rule.check(key, *value))
    }
    fn allowed(rule: &Self::Rule) -> String {
        rule.allowed()
    }
    fn shown(&self) -> Option<String> {
        Some(listed_in_brackets(*self))
    }
}

/// The rule that a line of a table says.
macro_rules! rule {
    () => {
        ()
    };
    ($unit:literal, $range:expr) => {
        $crate::settings::Rule::new($unit, $range)
    };
    ($unit:literal, $range:expr, $zero:literal) => {
        $crate::settings::Rule::new($unit, $range).or_zero($zero)
    };
}
pub(crate) use rule;

/// A structure of settings: `key: type = default, "unit", range, "what 0 means";` with its text above. Range and what
/// follows may be left out.
macro_rules! settings {
    (
        $(#[doc = $about:literal])+
        $(#[derive($($derive:ident),+)])?
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])+
                $field:ident: $type:ty = $default:expr $(, $unit:literal, $range:expr $(, $zero:literal)?)?;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq $($(, $derive)+)?)]
        #[cfg_attr(feature = "cli", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                #[doc = concat!(
                    "\n\n",
                    $($unit, " `", stringify!($range), "`", $(", 0: ", $zero,)? "; ",)?
                    "default `", stringify!($default), "`."
                )]
                pub $field: $type,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                $name { $($field: $default),+ }
            }
        }

        impl $crate::settings::Setting for $name {
            type Rule = ();
            const KIND: $crate::settings::DialKind = $crate::settings::DialKind::Table;
            fn check(&self, key: &str, (): &()) -> $crate::error::Result<()> {
                $({
                    let key = format!("{key}.{}", stringify!($field));
                    let rule = $crate::settings::rule!($($unit, $range $(, $zero)?)?);
                    $crate::settings::Setting::check(&self.$field, &key, &rule)?;
                })+
                Ok(())
            }
            fn allowed((): &()) -> String {
                format!("a table {{ {} }}", [$(stringify!($field)),+].join(", "))
            }
            fn shown(&self) -> Option<String> {
                None
            }
            fn dials(&self) -> Vec<$crate::settings::Dial> {
                let mut dials = Vec::new();
                $({
                    let rule = $crate::settings::rule!($($unit, $range $(, $zero)?)?);
                    let about = concat!($($doc),+);
                    dials.extend($crate::settings::dials_of(stringify!($field), about, &self.$field, &rule));
                })+
                dials
            }
        }
    };
}
pub(crate) use settings;

/// A setting that is one of some words.
macro_rules! words {
    (
        $(#[doc = $about:literal])+
        pub enum $name:ident {
            $($(#[$attribute:meta])+ $variant:ident = $word:literal,)+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "cli", derive(serde::Deserialize))]
        pub enum $name {
            $(
                $(#[$attribute])+
                #[cfg_attr(feature = "cli", serde(rename = $word))]
                $variant,
            )+
        }

        impl $crate::settings::Setting for $name {
            type Rule = ();
            fn check(&self, _: &str, (): &()) -> $crate::error::Result<()> {
                Ok(())
            }
            fn allowed((): &()) -> String {
                $crate::settings::listed([$(format!("{:?}", $word)),+].into_iter())
            }
            fn shown(&self) -> Option<String> {
                Some(match self { $($name::$variant => format!("{:?}", $word)),+ })
            }
        }
    };
}
pub(crate) use words;
