//! `--tuning`: which ways kernels take is nobody's affair but the clock's.

use super::run::{Folder, celfx, has_device, shown};
use super::succeeds;

const SHOT: [&str; 7] = ["render", "builtin:flame", "--frames", "20-20", "--set", "size=[40,30]", "--quiet"];

#[test]
fn pictures_do_not_depend_on_the_ways_that_kernels_take() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let table = "tile_invocations = 64\nmask_kernels = 1\n[grow]\ngrowth_base = 1e6\ngrowth_particle = 0.0\n\
        field_base = 1.0\nfield_voxel = 0.0\nfield_particle = 0.0\npyramid_base = 2.0\npyramid_level = 0.0\n\
        pyramid_side = 0.0\npyramid_particle = 0.0\npyramid_visit = 0.0\n";
    folder.write("mine.toml", table);
    let pictures = ["cpu", "gpu", "mine.toml"].map(|tuning| {
        let name = format!("{}.png", tuning.replace('.', "-"));
        succeeds(&folder, &[&SHOT[..], &["--tuning", tuning, "-o", &name]].concat());
        let picture = shown(&folder.0.join(&name));
        assert!(picture.chunks(16).any(|pixel| *pixel != picture[..16]), "{tuning}: no fire");
        picture
    });
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
}

#[test]
fn a_tuning_that_cannot_be_is_refused_by_name() {
    let folder = Folder::new();
    folder.write("half.toml", "tile_invocations = 64\n");
    for (tuning, code, text) in
        [("fast", 3, "--tuning fast"), ("half.toml", 3, "mask_kernels"), ("none.toml", 3, "\"cpu\" or \"gpu\"")]
    {
        let output = celfx(&folder, &[&SHOT[..], &["--tuning", tuning, "-o", "x.png"]].concat()).output();
        let output = output.expect("the program runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(code) && said.contains(text), "{tuning}: {:?} {said}", output.status);
    }
}

/// What is printed is taken.
#[test]
#[ignore = "compiles the fire's kernels in every shape: a minute"]
fn what_is_calibrated_is_taken() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let table = succeeds(&folder, &["bench", "calibrate", "--quick", "--quiet"]);
    folder.write("mine.toml", &table);
    assert!(table.contains("tile_invocations = ") && table.contains("pyramid_visit = "), "{table}");
    succeeds(&folder, &[&SHOT[..], &["--tuning", "mine.toml", "-o", "x.png"]].concat());
}
