//! Files that a file may read beside itself.

use std::fs;

use super::*;

/// Reads a file whose buffer is at a URI, beside which `make` has made things.
fn error_of(uri: &str, make: impl FnOnce(&Path)) -> String {
    let folder = Folder::new();
    make(&folder.0);
    let path = folder.0.join("mesh.gltf");
    one_node(json!({})).write_beside(&path, uri, "unused.bin");
    let error =
        AnimatedMesh::read(&path, &Choice::default(), SECONDS).map(|mesh| mesh.vertices()).unwrap_err().to_string();
    assert!(error.contains("mesh.gltf: buffer 0: "), "{error}");
    error
}

#[test]
fn only_regular_files_near_by_are_read() {
    for uri in ["/dev/zero", "/etc/passwd", "file:///etc/passwd", "../../../../../../etc/passwd", "%2fdev/zero"] {
        let error = error_of(uri, |_| ());
        assert!(error.contains(&format!("is at `{uri}`")) && error.contains("expected a relative path"), "{error}");
    }
    let error = error_of("sub", |folder| fs::create_dir(folder.join("sub")).unwrap());
    assert!(error.contains("sub: is a folder, not a file"), "{error}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        let error = error_of("link.bin", |folder| symlink("/dev/zero", folder.join("link.bin")).unwrap());
        assert!(error.contains("is at `link.bin`, which leads to /dev/zero"), "{error}");
    }
}

#[test]
fn no_more_is_read_than_a_buffer_has() {
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    one_node(json!({})).write_beside(&path, "a.bin", "a.bin");
    // Far more than memory has; nothing is there but the start.
    fs::OpenOptions::new().write(true).open(folder.0.join("a.bin")).unwrap().set_len(1 << 40).unwrap();
    assert_eq!(AnimatedMesh::read(&path, &Choice::default(), SECONDS).unwrap().vertices(), 3);
}

#[test]
fn a_glb_that_says_more_than_it_has_is_refused() {
    let file = one_node(json!({}));
    let mut bytes = file.glb();
    let there = bytes.len();
    bytes[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    let says = |bytes: &[u8], what: &str| {
        let error = gltf::parse(Path::new("a.glb"), bytes, &Choice::default())
            .map(|scene| scene.contents.animations)
            .unwrap_err()
            .to_string();
        assert!(error.contains("a.glb: byte ") && error.contains(what), "{error}");
    };
    says(&bytes, &format!("byte 8: a length of 4294967295 bytes, of which {there} are there"));
    let mut bytes = file.glb();
    bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    says(&bytes, &format!("byte 12: a chunk of 4294967295 bytes, of which {} are there", there - 20));
}
