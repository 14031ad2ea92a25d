//! Every key of a shot, with what it takes: what error messages say is allowed, and what the nearest key is found in.

/// Keys, those of an effect in the order of its settings, each with what is allowed. A name that others begin with is a table.
pub(super) const KEYS: &[(&str, &str)] = &[
    ("size", "[width, height], whole numbers of pixels, 1 to 16384 each"),
    ("frames", "[first, last], whole numbers, 0 to 999999, first not above last"),
    ("fps", "frames per second, 0.001 to 1000000"),
    ("seed", "a whole number, 0 to 4294967295"),
    ("background", "linear [red, green, blue], 0 to 1e6, or \"file.png\", or \"none\""),
    ("camera", "a table"),
    ("camera.eye", "[x, y, z], in metres, none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("camera.target", "[x, y, z], in metres, none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("camera.up", "[x, y, z], none beyond 1e12, or keyframes [[frame, [x, y, z]], ...], ascending"),
    ("camera.vertical_fov", "degrees, 1e-9 to 179.999999999, or keyframes [[frame, degrees], ...], ascending"),
    ("camera.near", "metres, above 0, or keyframes [[frame, metres], ...], ascending"),
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
    ("light.ambient", "0 to 1, or keyframes [[frame, ambient], ...], ascending"),
    ("smoke", "a table"),
    ("smoke.volume", "\"builtin:plume\", \"builtin:cloud\", or a file or pattern (\"smoke.####.npz\")"),
    ("smoke.density_grid", "the name of an array in the file"),
    ("smoke.velocity_grid", "the name of an array in the file"),
    ("smoke.hold", "true or false"),
    ("smoke.threshold", "a finite density"),
    ("smoke.particles", "a whole number, 0 to 1000000"),
    ("smoke.placement", "\"random\""),
    ("smoke.emitter", "{ min = [x, y, z], max = [x, y, z] }, in metres, none beyond 1e12, min not above max"),
    ("smoke.emitter.min", "[x, y, z], in metres, none beyond 1e12, not above max"),
    ("smoke.emitter.max", "[x, y, z], in metres, none beyond 1e12, not below min"),
    ("smoke.integrator", "\"euler\" or \"rk2\""),
    ("smoke.still", "voxels per frame, 0 to 1e6"),
    ("smoke.lifetime", "frames, 1 to 16777216"),
    ("smoke.fade", "frames, 0 to 64"),
    ("smoke.radius", "\"box\" or \"ball\""),
    ("smoke.scale", "above 0, at most 1e6"),
    ("smoke.grow", "\"chosen\", \"growth\", \"field\" or \"pyramid\""),
    ("smoke.shadow", "\"exact\", \"map\" or \"none\""),
    ("smoke.softness", "tangent of the light's half angle, 0 to 1"),
    ("smoke.shadow_map", "texels a side, 16 to 8192"),
    ("smoke.shadow_filter", "taps a side: 1, 3 or 5"),
    ("smoke.groups", "a whole number, 1 to 254"),
    ("smoke.group_depth", "metres, above 0, at most 1e12"),
    ("smoke.range_smoothing", "share of the last frame's range, 0 to 0.999"),
    ("smoke.hysteresis", "share of a range, 0 to 1"),
    ("smoke.sigma", "pixels, 0 (off) or 0.1 to 64"),
    ("smoke.cutoff", "multiples of sigma, 1 to 4"),
    (
        "smoke.tones",
        "[[from, [red, green, blue]], ...], 1 to 256 tones, from 0 to 1 ascending, linear colours 0 to 1e6, or an image file",
    ),
    ("smoke.tone_softness", "pixels, 0 to 16"),
    ("smoke.outline", "a table { strength, width, colour, operator }"),
    ("smoke.outline.strength", "0 (off) to 1e6"),
    ("smoke.outline.width", "pixels, 1 to 16"),
    ("smoke.outline.colour", "linear [red, green, blue], 0 to 1e6"),
    ("smoke.outline.operator", "\"roberts\" or \"second\""),
    ("flame", "a table"),
    ("flame.particles", "\"builtin:random\", or a file or pattern (\"fire.####.npz\")"),
    ("flame.hold", "true or false"),
    ("flame.mode", "\"stochastic\" or \"expected\""),
    ("flame.method", "\"tiles\" or \"raster\""),
    ("flame.repetitions", "a whole number, 1 to 1048576"),
    ("flame.count", "sprites of a particle, 0 to 32768"),
    ("flame.spread", "metres, 0 to 1e6"),
    ("flame.shape", "\"ball\" or \"cube\""),
    ("flame.size", "metres, 0 to 1e6"),
    ("flame.size_pixels", "pixels, 0 to 16384, not together with flame.size or mode = \"expected\""),
    ("flame.alpha_scale", "0 to 1e6"),
    ("flame.threshold", "a finite number"),
    ("flame.variants", "a whole number, 1 to 64"),
    ("flame.hottest", "kelvin, 700 to 1e6"),
    ("flame.colour", "\"physical\", \"displayable\", or an image file (.png, .exr)"),
    ("flame.falloff", "0 to 16"),
    ("flame.adaptation", "0 to 1"),
    ("flame.intensity", "0 to 1e6"),
    ("flame.sampling", "\"independent\" or \"shuffled_sobol\""),
    ("flame.bins", "a whole number, 1 to 1024"),
    ("flame.adaptive", "0 (off) to 1"),
    ("flame.flicker", "0 to 1"),
    ("flame.light", "0 (off) to 1e6"),
    ("blur", "a table"),
    ("blur.scene", "\"builtin:run\", \"builtin:spin\" or \"builtin:crossing\", or a file (.glb, .gltf, .npz)"),
    (
        "blur.animation",
        "the name of an animation of the glTF file, its number, from 0, a list of names and numbers, or \"*\" for all",
    ),
    ("blur.images", "a pattern of image files, one a frame (\"frames/####.png\", .exr, .jpg)"),
    ("blur.strength", "frames, 0 (off) to 4"),
    ("blur.teeth", "a whole number, 1 to 4096, not together with blur.tooth_width"),
    ("blur.tooth_width", "pixels at 1080 lines, 0.1 to 10000"),
    ("blur.hold", "frames, 1 to 1000000"),
    ("blur.trajectory", "\"spline\" or \"exact\""),
    ("blur.space", "\"homogeneous\" or \"screen\""),
    ("blur.reference_time", "frames after the earlier one, 0 to 1"),
    ("blur.jump", "picture heights, 0 (never) to 1000"),
    ("blur.clusters", "\"direction\" or \"ldf\""),
    ("blur.angle", "degrees, 0 to 180"),
    ("blur.seam_smoothing", "rounds, 0 (off) to 64"),
    ("blur.refine", "\"error\" or \"length\""),
    ("blur.tolerance", "pixels at 1080 lines, 0 to 10000"),
    ("blur.edge", "pixels at 1080 lines, 0 to 10000"),
    ("blur.completion", "\"surface\", \"gradient\" or \"none\""),
    ("blur.skirt", "pixels, 0 to 16"),
    ("blur.lines", "a table { count, length, width, opacity, colour }"),
    ("blur.lines.count", "0 (off) to 1024"),
    ("blur.lines.length", "frames, 0 to 8"),
    ("blur.lines.width", "pixels at 1080 lines, 0 to 64"),
    ("blur.lines.opacity", "0 to 1"),
    ("blur.lines.colour", "linear [red, green, blue], 0 to 1e6"),
    ("blur.ghosts", "a table { count, step, opacity }"),
    ("blur.ghosts.count", "0 (off) to 16"),
    ("blur.ghosts.step", "frames, 0.01 to 1"),
    ("blur.ghosts.opacity", "0 to 1"),
    ("blur.toon", "a table { tones, outline }"),
    (
        "blur.toon.tones",
        "[[from, [red, green, blue]], ...], 1 to 256 tones, from 0 to 1 ascending, linear colours 0 to 1e6, or an image file",
    ),
    ("blur.toon.outline", "a table { strength, width, colour, operator }"),
    ("blur.toon.outline.strength", "0 (off) to 1e6"),
    ("blur.toon.outline.width", "pixels, 1 to 16"),
    ("blur.toon.outline.colour", "linear [red, green, blue], 0 to 1e6"),
    ("blur.toon.outline.operator", "\"roberts\" or \"second\""),
];

/// What key `name` takes; `None` if there is no such key.
pub(super) fn allowed(name: &str) -> Option<&'static str> {
    KEYS.iter().find(|(key, _)| *key == name).map(|(_, allowed)| *allowed)
}

/// Whether `name` holds other keys.
pub(super) fn is_table(name: &str) -> bool {
    KEYS.iter().any(|(key, _)| parent(key) == Some(name))
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
    KEYS.iter().map(|(key, _)| *key).min_by_key(|key| distance(key)).unwrap_or("size")
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
