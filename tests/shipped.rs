//! What travels in the package: the shaders in `shaders/`, and that a host builds with them alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The version of Debian's `libshaderc-dev` that made the shaders in `shaders/`. Others give other SPIR-V.
const MADE_BY: &str = "2023.2-1";

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Files below a folder, by their path in it.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        let Ok(entries) = fs::read_dir(&next) else { continue };
        for path in entries.map(|entry| entry.expect("an entry").path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("a file below the folder").display().to_string();
                found.insert(name, fs::read(&path).expect("a readable file"));
            }
        }
    }
    found
}

/// The version of the shaderc that this build has used, if it is Debian's.
fn shaderc() -> Option<String> {
    let query = Command::new("dpkg-query").args(["-W", "-f", "${Version}", "libshaderc-dev"]).output().ok()?;
    query.status.success().then(|| String::from_utf8_lossy(&query.stdout).into_owned())
}

/// `CELFX_WRITE_SHADERS=1 cargo test --test shipped` (`make shaders`) writes them anew.
#[test]
fn the_shipped_shaders_are_those_of_glsl() {
    let (shipped, made) = (Path::new(ROOT).join("shaders"), Path::new(env!("OUT_DIR")).join("shaders"));
    let made = files(&made);
    assert!(made.len() > 100, "the build has compiled {} files", made.len());
    if std::env::var_os("CELFX_WRITE_SHADERS").is_some() {
        let _ = fs::remove_dir_all(&shipped);
        for (name, content) in &made {
            let path = shipped.join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder of shaders");
            fs::write(path, content).expect("a file of SPIR-V");
        }
    }
    let shipped = files(&shipped);
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&shipped), names(&made), "make shaders");
    let version = shaderc();
    let same_compiler = version.as_deref() == Some(MADE_BY);
    let stale: Vec<&String> =
        made.iter().filter(|(name, content)| shipped[*name] != **content).map(|(n, _)| n).collect();
    // The table has the hash of all sources, so it shows with any compiler whether shaders have changed since.
    assert!(!stale.iter().any(|name| *name == "table.rs"), "glsl/ has changed since: make shaders");
    if same_compiler {
        assert_eq!(stale, Vec::<&String>::new(), "make shaders");
    } else {
        println!("SKIPPED: {} files of SPIR-V compared: shaderc is {version:?}, not {MADE_BY}", made.len());
    }
}

/// A host in a crate of its own, in another folder, without the features of the program.
struct Outside {
    folder: PathBuf,
}

impl Outside {
    fn new(name: &str, main: &str) -> Outside {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(folder.join("src"));
        fs::create_dir_all(folder.join("src")).expect("a folder for a crate");
        let manifest = format!(
            "[package]\nname = \"outside\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[workspace]\n\n[dependencies]\n\
             celfx = {{ path = {ROOT:?}, default-features = false }}\n"
        );
        fs::write(folder.join("Cargo.toml"), manifest).expect("a manifest");
        // Versions as here, so that nothing is fetched.
        fs::copy(Path::new(ROOT).join("Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
        fs::write(folder.join("src/main.rs"), main).expect("a program");
        Outside { folder }
    }

    fn cargo(&self, arguments: &[&str]) -> std::process::Output {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(arguments).arg("--offline").current_dir(&self.folder);
        cargo.env("CARGO_TARGET_DIR", self.folder.join("target"));
        // No library of shaderc, and no compiler to make one.
        cargo.env_remove("SHADERC_LIB_DIR").env("CXX", "/nonexistent").env("CMAKE", "/nonexistent");
        let output = cargo.output().expect("cargo runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output
    }
}

#[test]
fn a_host_in_a_crate_of_its_own_builds_without_shaderc() {
    let main = "fn main() { println!(\"{:?}\", celfx::host::requirements().api_version); }\n";
    let outside = Outside::new("outside", main);
    let tree = String::from_utf8(outside.cargo(&["tree", "--edges", "all"]).stdout).expect("names of crates");
    for other in ["shaderc", "spirq", "clap", "image", "cmake", "cc v"] {
        assert!(!tree.contains(other), "a host needs {other}:\n{tree}");
    }
    let output = outside.cargo(&["run", "--quiet"]);
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), ash::vk::API_VERSION_1_3.to_string());
}
