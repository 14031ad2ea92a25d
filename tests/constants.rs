//! Constants stand once: the text of the shaders and of the library is searched for a second place.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of shaders that every effect includes from.
const COMMON: &str = "common";

/// A source file.
struct Source {
    path: String,
    text: String,
}

/// A top-level constant of a source file.
struct Constant<'a> {
    name: &'a str,
    path: &'a str,
}

/// Every file below `folder` with one of these endings.
fn sources(folder: &str, endings: &[&str]) -> Vec<Source> {
    let mut folders = vec![PathBuf::from(folder)];
    let mut sources = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if endings.contains(&ending.as_str()) {
                let text = fs::read_to_string(&path).expect("a source file");
                sources.push(Source { path: path.to_string_lossy().replace('\\', "/"), text });
            }
        }
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    sources
}

/// `const TYPE NAME` and `const TYPE NAME[LENGTH]` outside of all braces. Those that are specialised are not meant: their
/// values are the pipeline's.
fn shader_constants(source: &Source) -> impl Iterator<Item = Constant<'_>> {
    source.text.lines().filter_map(|line| {
        let (_, name) = line.strip_prefix("const ")?.split_once(' ')?;
        let name = name.split(|c: char| !is_word(c)).next()?;
        Some(Constant { name, path: &source.path })
    })
}

/// `const NAME: TYPE` of a number, also inside of functions.
fn library_constants(source: &Source) -> impl Iterator<Item = Constant<'_>> {
    source.text.lines().filter_map(|line| {
        let line = line.trim_start();
        let line = ["pub(crate) ", "pub(super) ", "pub "].iter().find_map(|p| line.strip_prefix(p)).unwrap_or(line);
        let (name, rest) = line.strip_prefix("const ")?.split_once(": ")?;
        let kind = rest.split(|c: char| !is_word(c)).next()?;
        let is_number = matches!(
            kind,
            "u8" | "u16" | "u32" | "u64" | "usize" | "i8" | "i16" | "i32" | "i64" | "isize" | "f32" | "f64"
        );
        is_number.then_some(Constant { name, path: &source.path })
    })
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// The effect that a file belongs to: a folder of its path that has the name of a folder of shaders.
fn effect_of<'a>(path: &str, folders: &'a [String]) -> Option<&'a str> {
    let parts = || path.split(['/', '.']);
    folders.iter().find(|folder| parts().any(|part| part == folder.as_str())).map(String::as_str)
}

/// Names that two shader files of one effect declare, or one of an effect and one of those that all share.
fn twice_in_shaders(shaders: &[Source], folders: &[String]) -> Vec<String> {
    let mut twice = Vec::new();
    for effect in folders {
        let mut places = BTreeMap::<&str, Vec<&str>>::new();
        let within = |source: &&Source| {
            let of = effect_of(&source.path, folders);
            of == Some(effect.as_str()) || of == Some(COMMON)
        };
        for constant in shaders.iter().filter(within).flat_map(shader_constants) {
            places.entry(constant.name).or_default().push(constant.path);
        }
        let doubled = places.into_iter().filter(|(_, paths)| paths.len() > 1);
        twice.extend(doubled.map(|(name, paths)| format!("{name}: {}", paths.join(", "))));
    }
    twice.sort();
    twice.dedup();
    twice
}

/// Names of the library's numbers that a shader of the same effect declares, or one that all share.
fn twice_in_library(shaders: &[Source], library: &[Source], folders: &[String]) -> Vec<String> {
    let mut twice = Vec::new();
    for own in library.iter().flat_map(library_constants) {
        let effect = effect_of(own.path, folders);
        let shared = |source: &&Source| {
            let of = effect_of(&source.path, folders);
            of == Some(COMMON) || effect.is_some() && of == effect
        };
        let others = shaders.iter().filter(shared).flat_map(shader_constants).filter(|other| other.name == own.name);
        twice.extend(others.map(|other| format!("{}: {}, {}", own.name, own.path, other.path)));
    }
    twice
}

fn folders() -> Vec<String> {
    let entries = fs::read_dir(Path::new("glsl")).expect("the shaders");
    let paths = entries.map(|entry| entry.expect("an entry").path()).filter(|path| path.is_dir());
    paths.map(|path| path.file_name().expect("a name").to_string_lossy().into_owned()).collect()
}

#[test]
fn constants_stand_once() {
    let (shaders, library) = (sources("glsl", &["glsl", "comp", "vert", "frag"]), sources("src", &["rs"]));
    let folders = folders();
    assert!(folders.iter().any(|folder| folder == COMMON), "{folders:?}");
    assert!(shaders.iter().flat_map(shader_constants).count() > 50, "constants of shaders are not found");
    assert!(library.iter().flat_map(library_constants).count() > 50, "constants of the library are not found");
    let mut twice = twice_in_shaders(&shaders, &folders);
    twice.extend(twice_in_library(&shaders, &library, &folders));
    assert!(twice.is_empty(), "constants that stand twice:\n{}", twice.join("\n"));
}

#[test]
fn a_second_place_is_found() {
    let source = |path: &str, text: &str| Source { path: path.to_owned(), text: text.to_owned() };
    let folders = ["common", "fog", "rain"].map(str::to_owned);
    let shaders = [
        source("glsl/common/bits.glsl", "const uint SIGN = 1u << 31u;  // the sign\n"),
        source("glsl/fog/a.comp", "const int SIDE = 8;\nlayout(constant_id = 0) const bool ON = true;\n"),
        source("glsl/fog/b.glsl", "const uint SIDE = 8u;\nvoid main() {\n    const float LOCAL = 1.0;\n}\n"),
        source("glsl/fog/c.vert", "layout(constant_id = 3) const bool ON = false;\nconst float LOCAL = 1.0;\n"),
        source("glsl/rain/d.frag", "const uint SIGN = 1u;\nconst vec2 SIDE[2] = vec2[](vec2(0.0), vec2(1.0));\n"),
    ];
    let found = twice_in_shaders(&shaders, &folders);
    let expected = ["SIDE: glsl/fog/a.comp, glsl/fog/b.glsl", "SIGN: glsl/common/bits.glsl, glsl/rain/d.frag"];
    assert_eq!(found, expected);
    let library = [
        source("src/fog/layout.rs", "pub(crate) const SIDE: usize = 8;\nconst SIDES: [u32; 2] = [8, 8];\n"),
        source("src/bench/rain/mod.rs", "    const SIDE: u64 = 2;\nconst NAME: &str = \"rain\";\n"),
        source("src/view.rs", "const SIGN: u32 = 1 << 31;\npub const SIDE: f64 = 8.0;\n"),
        source("src/cli/layers/rain.rs", "pub const ON: u32 = 1;\n"),
    ];
    let found = twice_in_library(&shaders, &library, &folders);
    let expected = [
        "SIDE: src/fog/layout.rs, glsl/fog/a.comp",
        "SIDE: src/fog/layout.rs, glsl/fog/b.glsl",
        "SIDE: src/bench/rain/mod.rs, glsl/rain/d.frag",
        "SIGN: src/view.rs, glsl/common/bits.glsl",
    ];
    assert_eq!(found, expected);
}

/// The references read these from the shaders, and would follow where one is changed by mistake.
#[test]
fn the_numbers_of_the_methods_are_what_was_decided() {
    use celfx::low_level::shaders::{blur::constants as blur, flame::constants as flame, smoke::constants as smoke};
    let whole = [
        // Of the refinement: rounds, and those after which tolerances grow; of the tables: bins along a side.
        [blur::ROUNDS, blur::USUAL_ROUNDS, blur::SIDE, blur::BETWEEN, 16, 11, 32, u32::MAX],
        // Of tones: steps of the cosine, a change that is seen, places.
        [blur::TONE_STEPS, blur::CLEAR, blur::WANTED_SITES, blur::MOST_STRIDE, 48, 77, 8192, 256],
        [blur::MOST_SITES, blur::MOST_FEW, blur::FEW_WEIGHT, blur::WHOLE, 32_768, 8192, 8, 16],
        // Of the search for the light: candidates, and steps of the cosine in its rounds.
        [blur::STARTS, blur::STILL_STARTS, blur::TURNED_STARTS, blur::SEARCHES, 512, 256, 8, 6],
        [blur::FIRST_SEARCHES, blur::BESIDE, blur::STARTS, blur::FIRST_STEPS, 2, 5, 512, 16],
        [blur::SEARCH_STEPS, blur::RESIDUAL, blur::REPEATS, blur::ALLOWED, 32, 13, 5, 4],
        // Of the mask, and the keys of draws.
        [flame::MASK_SIDE, flame::MASK_LEVELS, flame::COUNT_KEY, flame::PHASE_KEY, 64, 7, u32::MAX, u32::MAX],
        [flame::SOBOL_KEY, flame::RENEWAL, smoke::BIRTH_VOXEL, smoke::BIRTH_PLACE, u32::MAX - 1, 0x9E37_79B9, 0, 1],
    ];
    for [a, b, c, d, expected @ ..] in whole {
        assert_eq!([a, b, c, d], expected);
    }
    assert_eq!((blur::MOST_CHANGE, blur::EVEN, smoke::FIRST_AGE), (1024, 128, 4));
    let real = [
        (blur::LEAST_EDGE, 0.25),
        (blur::LEAST_SURFACE, 1.0 / 64.0),
        (blur::LEAST_SPEED_SQUARED, 1e-12),
        (blur::LEAST_EXTENT, 1e-3),
        (blur::UNIT, 262_144.0),
        (blur::UNITS, 65_536.0),
        (blur::LARGEST_SCALE, 16.0),
        (blur::LOGARITHM, 256.0),
        (blur::AROUND, 0.25),
        (flame::LIGHT_STEPS, 65_535.0),
        (flame::MOST_COUNT, 32_768.0),
        (flame::NOISE_CELLS, 4.0),
        (flame::LEAST_LOGARITHM, -24.0),
    ];
    real.into_iter().for_each(|(found, expected)| assert_eq!(found, expected));
}
