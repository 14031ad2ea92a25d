//! Every key of a shot, with what it takes: what error messages say is allowed, and what the nearest key is found in. Those
//! of an effect's settings are of the settings' own table.

use super::Table;
use crate::settings::{Dial, DialKind};
use crate::view;

/// The shot's own keys. A name that others begin with is a table.
const SHOT: &[(&str, &str)] = &[
    ("size", "[width, height], whole numbers of pixels, 1 to 16384 each"),
    ("frames", "[first, last], whole numbers, 0 to 999999, first not above last"),
    ("fps", "frames per second, 0.001 to 1000000"),
    ("on", "1, 2 or 3 frames"),
    ("seed", "a whole number, 0 to 4294967295"),
    ("background", "linear [red, green, blue], 0 to 1e6, \"#rrggbb\", \"file.png\", or \"none\""),
    ("output", "a table"),
    ("output.view", "\"sRGB\", \"Rec.709\", \"ACES 2.0 SDR\", or \"DISPLAY / VIEW\" of an OCIO config"),
    ("output.config", "an OCIO config's file (.ocio, .ocioz), or \"ocio://NAME\""),
    ("output.space", "the name of the config's colour space of linear Rec. 709"),
    ("camera", "a table"),
    ("camera.eye", "[x, y, z], in metres, none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("camera.target", "[x, y, z], in metres, none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("camera.up", "[x, y, z], none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("camera.far", "metres, above camera.near, may be inf, or keyframes [[frame, metres], ...], ascending"),
    (
        "camera.file",
        "a glTF file with a camera, \"builtin:run\", \"builtin:spin\" or \"builtin:crossing\", or an .npz file with \
         view_projection [frames, 4, 4]",
    ),
    ("camera.name", "the name of a camera of the glTF file, or its number in the file's scene, from 0"),
    (
        "camera.animation",
        "the name of an animation of the glTF file, its number, from 0, a list of names and numbers, or \"*\" for all",
    ),
    ("light", "a table"),
    ("light.direction", "[x, y, z], none beyond 1e12, not all 0, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("light.position", "[x, y, z], in metres, none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("light.second", "a table"),
    (
        "light.second.direction",
        "[x, y, z], none beyond 1e12, not all 0, or keyframes [[frame, [x, y, z]], ...], ascending",
    ),
    (
        "light.second.position",
        "[x, y, z], in metres, none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending",
    ),
];

/// Keys that `camera.file` takes the place of.
pub(super) const INSTEAD_OF_FILE: [&str; 5] =
    ["camera.eye", "camera.target", "camera.up", "camera.vertical_fov", "camera.orthographic"];

/// The keys of a shot that may have some tables. Of those that are no settings, what they do and their defaults stand in the
/// built-in shots.
#[derive(Clone, Debug)]
pub(super) struct Keys(Vec<Dial>);

impl Keys {
    pub(super) fn new(tables: &[&'static Table]) -> Keys {
        let own = |(key, allowed): &(&str, &str)| given(key, (*allowed).to_owned());
        let keyframes = |key: &str, allowed: String, what: &str| {
            given(key, format!("{allowed}, or keyframes [[frame, {what}], ...], ascending"))
        };
        let mut keys: Vec<Dial> = SHOT.iter().map(own).collect();
        keys.push(keyframes("camera.vertical_fov", view::vertical_fov().allowed(), "degrees"));
        keys.push(keyframes("camera.shift", view::shift_allowed(), "[right, up]"));
        keys.push(keyframes("camera.orthographic", view::orthographic().allowed(), "metres"));
        keys.push(given("camera.pixel_aspect", view::pixel_aspect().allowed()));
        keys.push(keyframes("camera.near", view::near().allowed(), "metres"));
        keys.push(keyframes("light.ambient", view::ambient().allowed(), "ambient"));
        keys.push(keyframes("light.fill", view::fill().allowed(), "fill"));
        keys.push(keyframes("light.rim", view::rim().allowed(), "rim"));
        keys.push(keyframes("light.second.strength", view::strength().allowed(), "strength"));
        for Table { name, inputs, dials, .. } in tables {
            keys.push(given(name, "a table".to_owned()));
            keys.extend(inputs.iter().map(own));
            keys.extend(dials().into_iter().map(|dial| Dial { key: format!("{name}.{}", dial.key), ..dial }));
        }
        Keys(keys)
    }

    /// All of them.
    #[cfg(test)]
    pub(super) fn all(&self) -> &[Dial] {
        &self.0
    }

    /// The key `name`; `None` if there is no such key.
    pub(super) fn find(&self, name: &str) -> Option<&Dial> {
        self.0.iter().find(|dial| dial.key == name)
    }

    /// The allowed values of key `name`; `None` if there is no such key.
    pub(super) fn allowed(&self, name: &str) -> Option<&str> {
        self.find(name).map(|dial| dial.allowed.as_str())
    }

    /// Whether `name` holds other keys.
    pub(super) fn is_table(&self, name: &str) -> bool {
        self.0.iter().any(|dial| parent(&dial.key) == Some(name))
    }

    /// The known key that `name` most likely meant: the nearest spelling of the whole, or of its last part in case the
    /// table is wrong. Where no spelling is near, one of its own table.
    pub(super) fn nearest(&self, name: &str) -> &str {
        let distance = |key: &str| {
            let elsewhere = usize::from(parent(key) != parent(name));
            let moved = strsim::damerau_levenshtein(leaf(name), leaf(key));
            let whole = strsim::damerau_levenshtein(name, key);
            let is_near = elsewhere == 0 || 3 * moved <= leaf(name).len();
            elsewhere + if is_near { moved.min(whole) } else { whole }
        };
        self.0.iter().map(|dial| dial.key.as_str()).min_by_key(|key| distance(key)).unwrap_or("size")
    }
}

fn given(key: &str, allowed: String) -> Dial {
    Dial { key: key.to_owned(), about: String::new(), allowed, default: None, kind: DialKind::Value }
}

/// The entry of `names` that is spelled most like `name`.
pub(super) fn nearest_of<'a>(name: &str, names: &[&'a str]) -> &'a str {
    names.iter().copied().min_by_key(|n| strsim::damerau_levenshtein(name, n)).unwrap_or("")
}

/// The table that holds `name`.
pub(super) fn parent(name: &str) -> Option<&str> {
    name.rsplit_once('.').map(|(parent, _)| parent)
}

fn leaf(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(_, leaf)| leaf)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_key_is_the_intended_one() {
        let keys = Keys::new(&crate::program::tables());
        for (typed, meant) in [
            ("sise", "size"),
            ("smok", "smoke"),
            ("smoke.sigmaa", "smoke.sigma"),
            ("smoke.partikels", "smoke.particles"),
            ("smoke.outlin", "smoke.outline"),
            ("smoke.outline.color", "smoke.outline.colour"),
            ("camera.fov", "camera.far"),
            ("camera.vertical_fow", "camera.vertical_fov"),
            ("sigma", "smoke.sigma"),
            ("smoke.eye", "camera.eye"),
            ("flam", "flame"),
            ("flame.repetition", "flame.repetitions"),
            ("flame.color", "flame.colour"),
            ("fall_off", "flame.falloff"),
            ("blur.lines.cnt", "blur.lines.count"),
            ("blur.tolerence", "blur.tolerance"),
        ] {
            assert_eq!(keys.nearest(typed), meant, "{typed}");
        }
        // Like nothing that there is: a key of the table, not a short one from somewhere else.
        for typed in ["blur.lines.foo", "blur.ghosts.foo", "blur.toon.foo"] {
            assert_eq!(parent(keys.nearest(typed)), parent(typed), "{typed}: {}", keys.nearest(typed));
        }
    }
}
