//! Files that a glTF file may name beside it.

use std::path::{Component, Path, PathBuf};

use percent_encoding::percent_decode_str;

/// The allowed URIs.
pub(super) const REACH: &str = "a relative path of a file in this one's folder, in the one above, or below these";

/// The file that a URI names, without links; or why it may not. A file that was sent by somebody else must not reach
/// whatever its user can read.
pub(super) fn beside(gltf: &Path, uri: &str) -> Result<PathBuf, String> {
    let start = uri.split(['/', '?', '#']).next().unwrap_or_default();
    if start.contains(':') {
        return Err(format!("is at `{uri}`"));
    }
    let name = percent_decode_str(uri).decode_utf8_lossy();
    if name.contains(['\\', '\0']) {
        return Err(format!("is at `{uri}`, which has a backslash or a zero"));
    }
    let name = Path::new(&*name);
    let Some(above) = levels_above(name).filter(|above| *above <= 1) else {
        return Err(format!("is at `{uri}`, which is absolute or leads out of the folder above"));
    };
    let folder = gltf.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let named = folder.join(name);
    let fault = |error| format!("{}: {error}", named.display());
    let folder = folder.canonicalize().map_err(fault)?;
    // All files are below the root.
    let base = folder.ancestors().nth(above).filter(|base| above == 0 || base.parent().is_some());
    let file = named.canonicalize().map_err(fault)?;
    match base.is_some_and(|base| file.starts_with(base)) {
        true => Ok(file),
        false => Err(format!("is at `{uri}`, which leads to {}", file.display())),
    }
}

/// How many folders up a relative path goes at its highest; none if it is not relative.
fn levels_above(path: &Path) -> Option<usize> {
    let (mut depth, mut highest) = (0isize, 0isize);
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => return None,
        }
        highest = highest.min(depth);
    }
    Some(highest.unsigned_abs())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::io::tests::Folder;

    /// `scene/mesh.gltf` and files around it.
    fn folder() -> (Folder, PathBuf) {
        let folder = Folder::new();
        fs::create_dir_all(folder.0.join("top/scene/parts")).unwrap();
        for name in ["far.bin", "top/near.bin", "top/scene/a b.bin", "top/scene/parts/c.bin"] {
            fs::write(folder.0.join(name), b"x").unwrap();
        }
        let gltf = folder.0.join("top/scene/mesh.gltf");
        (folder, gltf)
    }

    #[test]
    fn files_beside_and_in_the_folder_above_are_found() {
        let (_folder, gltf) = folder();
        for uri in ["a%20b.bin", "./a b.bin", "parts/c.bin", "parts/../a b.bin", "../near.bin", "../scene/a b.bin"] {
            assert!(beside(&gltf, uri).unwrap().is_file(), "{uri}");
        }
    }

    #[test]
    fn nothing_else_is_reached() {
        let (_folder, gltf) = folder();
        let refused = [
            "/etc/passwd",
            "//etc/passwd",
            "%2Fetc%2Fpasswd",
            "file:///etc/passwd",
            "FILE:/etc/passwd",
            "https://example.org/a.bin",
            "C:/a.bin",
            "..\\near.bin",
            "..%5Cnear.bin",
            "a%00.bin",
            "../../far.bin",
            "%2e%2e/%2e%2e/far.bin",
            "parts/../../../far.bin",
            "../../../../../../../../../../etc/passwd",
        ];
        for uri in refused {
            let why = beside(&gltf, uri).unwrap_err();
            assert!(why.contains(&format!("is at `{uri}`")), "{uri}: {why}");
        }
        let why = beside(&gltf, "none.bin").unwrap_err();
        assert!(why.contains("scene/none.bin: ") && !why.contains("is at"), "{why}");
    }

    #[test]
    #[cfg(unix)]
    fn links_do_not_lead_out() {
        use std::os::unix::fs::symlink;
        let (folder, gltf) = folder();
        let link = |to: &Path, name: &str| symlink(to, gltf.with_file_name(name)).unwrap();
        link(Path::new("parts/c.bin"), "inside.bin");
        link(&folder.0.join("top/near.bin"), "outside.bin");
        link(&folder.0, "folder");
        assert!(beside(&gltf, "inside.bin").is_ok());
        for uri in ["outside.bin", "folder/far.bin"] {
            assert!(beside(&gltf, uri).unwrap_err().contains("leads to"), "{uri}");
        }
        // The root is above everything.
        let why = beside(Path::new("/etc/mesh.gltf"), "../dev/zero").unwrap_err();
        assert!(why.contains("leads to /dev/zero"), "{why}");
    }
}
