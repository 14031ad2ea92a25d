//! What documents say of shots.

use std::fs;

use crate::io::shot::Table;
use crate::program;
use crate::settings::{Dial, DialKind};

/// `docs/dials.md`, as the tables of settings have it.
fn documented() -> String {
    let mut text =
        "# Dials\n\nThe settings of each effect: keys of a shot, and fields of `Settings` of the same names. This \
                    file is written from their tables: `CELFX_WRITE_DOCS=1 cargo test --lib dials` writes it.\n"
            .to_owned();
    for Table { name, dials, .. } in program::tables() {
        if *name == "vignette" {
            continue;
        }
        text += &format!("\n## `[{name}]`\n\n| key | default | allowed | what it does |\n|---|---|---|---|\n");
        for Dial { key, about, allowed, default, kind } in dials() {
            if kind != DialKind::Table {
                let default = default.map_or("none".to_owned(), |default| format!("`{default}`"));
                text += &format!("| `{key}` | {default} | {allowed} | {about} |\n");
            }
        }
    }
    text
}

#[test]
fn the_dials_are_documented() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/dials.md");
    if std::env::var_os("CELFX_WRITE_DOCS").is_some() {
        fs::write(path, documented()).expect("the folder of documents");
    }
    let written = fs::read_to_string(path).unwrap_or_default();
    assert!(written == documented(), "{path} is not what the settings say: run this test with CELFX_WRITE_DOCS=1");
}

/// Those that pictures in the documents are made by.
#[test]
fn the_documents_shots_are_shots() {
    let folder = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/shots")).expect("a folder of shots");
    let paths: Vec<_> = folder.map(|entry| entry.expect("a shot").path()).collect();
    assert!(!paths.is_empty());
    for path in paths {
        let name = path.to_str().expect("a name");
        let shot = program::load(name, &[]).expect(name);
        shot.check_effects().expect(name);
    }
}
