//! Every key of a shot, with what it takes: what error messages say is allowed, and what the nearest key is found in. Those
//! of an effect's settings are of the settings' own table.

use std::sync::LazyLock;

use crate::settings::{Dial, DialKind};
use crate::{blur, flame, smoke, view};

/// An effect's table: its name, the keys of its inputs, each with what is allowed, and those of its settings.
pub(super) struct EffectKeys {
    pub(super) name: &'static str,
    inputs: &'static [(&'static str, &'static str)],
    pub(super) dials: fn() -> Vec<Dial>,
}

/// Every effect.
pub(super) const EFFECTS: [EffectKeys; 3] = [
    EffectKeys { name: "smoke", inputs: SMOKE, dials: smoke::Settings::dials },
    EffectKeys { name: "flame", inputs: FLAME, dials: flame::Settings::dials },
    EffectKeys { name: "blur", inputs: BLUR, dials: blur::Settings::dials },
];

/// The shot's own keys. A name that others begin with is a table.
const SHOT: &[(&str, &str)] = &[
    ("size", "[width, height], whole numbers of pixels, 1 to 16384 each"),
    ("frames", "[first, last], whole numbers, 0 to 999999, first not above last"),
    ("fps", "frames per second, 0.001 to 1000000"),
    ("seed", "a whole number, 0 to 4294967295"),
    ("background", "linear [red, green, blue], 0 to 1e6, or \"file.png\", or \"none\""),
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
];

const SMOKE: &[(&str, &str)] = &[
    ("smoke.volume", "\"builtin:plume\", \"builtin:cloud\", or a file or pattern (\"smoke.####.npz\")"),
    ("smoke.density_grid", "the name of an array in the file"),
    ("smoke.velocity_grid", "the name of an array in the file"),
    ("smoke.hold", "true or false"),
];

const FLAME: &[(&str, &str)] = &[
    ("flame.particles", "\"builtin:random\", or a file or pattern (\"fire.####.npz\")"),
    ("flame.hold", "true or false"),
];

const BLUR: &[(&str, &str)] = &[
    ("blur.scene", "\"builtin:run\", \"builtin:spin\" or \"builtin:crossing\", or a file (.glb, .gltf, .npz)"),
    (
        "blur.animation",
        "the name of an animation of the glTF file, its number, from 0, a list of names and numbers, or \"*\" for all",
    ),
    ("blur.images", "a pattern of image files, one a frame (\"frames/####.png\", .exr, .jpg)"),
];

/// A key. Of those that are no settings, what they do and their defaults stand in the built-in shots.
pub(super) static KEYS: LazyLock<Vec<Dial>> = LazyLock::new(|| {
    let own = |(key, allowed): &(&str, &str)| given(key, (*allowed).to_owned());
    let keyframes = |key: &str, allowed: String, what: &str| {
        given(key, format!("{allowed}, or keyframes [[frame, {what}], ...], ascending"))
    };
    let mut keys: Vec<Dial> = SHOT.iter().map(own).collect();
    keys.push(keyframes("camera.vertical_fov", view::vertical_fov().allowed(), "degrees"));
    keys.push(keyframes("camera.near", view::near().allowed(), "metres"));
    keys.push(keyframes("light.ambient", view::ambient().allowed(), "ambient"));
    for EffectKeys { name, inputs, dials } in &EFFECTS {
        keys.push(given(name, "a table".to_owned()));
        keys.extend(inputs.iter().map(own));
        keys.extend(dials().into_iter().map(|dial| Dial { key: format!("{name}.{}", dial.key), ..dial }));
    }
    keys
});

fn given(key: &str, allowed: String) -> Dial {
    Dial { key: key.to_owned(), about: String::new(), allowed, default: None, kind: DialKind::Value }
}

/// The key `name`; `None` if there is no such key.
pub(super) fn find(name: &str) -> Option<&'static Dial> {
    KEYS.iter().find(|dial| dial.key == name)
}

/// What key `name` takes; `None` if there is no such key.
pub(super) fn allowed(name: &str) -> Option<&'static str> {
    find(name).map(|dial| dial.allowed.as_str())
}

/// Whether `name` holds other keys.
pub(super) fn is_table(name: &str) -> bool {
    KEYS.iter().any(|dial| parent(&dial.key) == Some(name))
}

/// The known key that `name` most likely meant: the nearest spelling of the whole, or of its last part in case the table
/// is wrong. Where no spelling is near, one of its own table.
pub(super) fn nearest(name: &str) -> &'static str {
    let distance = |key: &str| {
        let elsewhere = usize::from(parent(key) != parent(name));
        let moved = strsim::damerau_levenshtein(leaf(name), leaf(key));
        let whole = strsim::damerau_levenshtein(name, key);
        let is_near = elsewhere == 0 || 3 * moved <= leaf(name).len();
        elsewhere + if is_near { moved.min(whole) } else { whole }
    };
    KEYS.iter().map(|dial| dial.key.as_str()).min_by_key(|key| distance(key)).unwrap_or("size")
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
            assert_eq!(nearest(typed), meant, "{typed}");
        }
        // Like nothing that there is: a key of the table, not a short one from somewhere else.
        for typed in ["blur.lines.foo", "blur.ghosts.foo", "blur.toon.foo"] {
            assert_eq!(parent(nearest(typed)), parent(typed), "{typed}: {}", nearest(typed));
        }
    }
}
