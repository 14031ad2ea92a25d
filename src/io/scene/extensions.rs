//! Extensions that a glTF file names, and what becomes of it without them.

use std::path::Path;

use super::Note;
use super::json::Head;
use crate::io::ReadError;

/// A reader's handling of an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// It is obeyed, or changes neither where anything is nor how it looks.
    Obeyed,
    /// It changes looks alone, and is not obeyed.
    Looks,
    /// Nobody knows what it changes.
    Unknown,
}

/// Those that are obeyed, and those that only describe.
const OBEYED: [&str; 14] = [
    "AGI_articulations",
    "AGI_stk_metadata",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Those that change looks alone and whose names do not say so.
const LOOKS: [&str; 7] = [
    "CESIUM_primitive_outline",
    "KHR_blend",
    "KHR_environment_map",
    "KHR_techniques_webgl",
    "MOZ_lightmap",
    "VRM",
    "VRMC_vrm",
];

/// The parts of glTF, second in the names of extensions (`KHR_materials_sheen`), that change looks alone.
const PARTS_OF_LOOKS: [&str; 5] = ["lights", "material", "materials", "texture", "textures"];

fn kind(name: &str) -> Kind {
    let part = name.split('_').nth(1).unwrap_or_default();
    match () {
        () if OBEYED.contains(&name) => Kind::Obeyed,
        () if LOOKS.contains(&name) || PARTS_OF_LOOKS.contains(&part) => Kind::Looks,
        () => Kind::Unknown,
    }
}

/// Refuses a file that requires what is not known, for vertices may be elsewhere without it.
pub(super) fn check(path: &Path, head: &Head) -> Result<(), ReadError> {
    match head.extensions_required.iter().find(|name| kind(name) == Kind::Unknown) {
        None => Ok(()),
        Some(name) => {
            let compressed = name.contains("compression").then_some(", uncompressed");
            let expected = format!("a file that does without it{}", compressed.unwrap_or_default());
            Err(ReadError::at(path, "extensionsRequired", format!("{name} is not supported"), expected))
        }
    }
}

/// Extensions that the file wants and does not get, but for looks that it can do without.
pub(super) fn notes(head: &Head) -> Vec<Note> {
    let looks = head.extensions_required.iter().filter(|name| kind(name) == Kind::Looks);
    let looks = looks.map(|name| Note::of_looks(format!("requires {name}: it is drawn without")));
    // What channels point at with it is told channel by channel.
    let is_unknown = |name: &&String| kind(name) == Kind::Unknown && *name != "KHR_animation_pointer";
    let unknown = head.extensions_used.iter().filter(is_unknown);
    looks.chain(unknown.map(|name| Note::new(format!("uses {name}: what that adds is left out")))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_what_concerns_looks() {
        for name in [
            "KHR_materials_sheen",
            "KHR_materials_pbrSpecularGlossiness",
            "KHR_materials_of_tomorrow",
            "VRMC_materials_mtoon",
            "ADOBE_materials_thin_transparency",
            "KHR_texture_basisu",
            "EXT_texture_webp",
            "EXT_texture_avif",
            "MSFT_texture_dds",
            "KHR_lights_punctual",
            "EXT_lights_image_based",
            "VRM",
        ] {
            assert_eq!(kind(name), Kind::Looks, "{name}");
        }
        for name in [
            "KHR_draco_mesh_compression",
            "KHR_animation_pointer",
            "KHR_node_visibility",
            "VRMC_springBone",
            "VRMC_node_constraint",
            "CESIUM_RTC",
            "materials",
            "",
        ] {
            assert_eq!(kind(name), Kind::Unknown, "{name}");
        }
        assert_eq!(kind("KHR_texture_transform"), Kind::Obeyed);
    }
}
