//! Runs the program in a folder of the test's own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use celfx::io::array::ArchiveWriter;

/// An empty folder, removed at the test's end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("celfx-cli-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("temporary folder");
        Folder(path)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).expect("temporary folder");
    }

    /// Names of what is in it.
    pub fn names(&self) -> Vec<String> {
        names(&self.0)
    }

    /// Files that were not finished, and frames that were claimed and not let go, anywhere in it.
    pub fn parts(&self) -> Vec<String> {
        let mut found = Vec::new();
        let mut folders = vec![self.0.clone()];
        while let Some(folder) = folders.pop() {
            for name in names(&folder) {
                let path = folder.join(&name);
                if path.is_dir() {
                    folders.push(path);
                } else if name.ends_with(".part") || name.ends_with(".claim") {
                    found.push(name);
                }
            }
        }
        found
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Names of what is in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

/// The program with its arguments, to be run in `folder`. `CELFX_DEVICE` chooses the device where one is used.
pub fn celfx(folder: &Folder, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_celfx"));
    command.args(arguments).current_dir(&folder.0).stdin(Stdio::null());
    if let (Ok(device), Some(&("render" | "info"))) = (std::env::var("CELFX_DEVICE"), arguments.first())
        && !arguments.contains(&"--device")
    {
        command.args(["--device", &device]);
    }
    command
}

fn info() -> &'static Output {
    static INFO: OnceLock<Output> = OnceLock::new();
    INFO.get_or_init(|| {
        let folder = Folder::new();
        celfx(&folder, &["info", "--json"]).output().expect("the program runs")
    })
}

/// Whether there is a device to render on. Without one the test says so and passes, unless `CELFX_REQUIRE_VULKAN=1`.
pub fn has_device() -> bool {
    let found = info().status.success();
    let error = String::from_utf8_lossy(&info().stderr);
    assert!(found || !std::env::var("CELFX_REQUIRE_VULKAN").is_ok_and(|v| v == "1"), "{error}");
    if !found {
        eprintln!("SKIPPED, no device: {error}");
    }
    found
}

/// The option that turns validation on, where its layer is installed; otherwise one that changes nothing.
pub fn validate() -> &'static str {
    let report: serde_json::Value = serde_json::from_slice(&info().stdout).unwrap_or_default();
    if report["validation_layer"].is_string() { "--validate" } else { "--threads=2" }
}

/// What a file shows: the pixels of a picture, without what its file says of where they are from; else its bytes.
pub fn shown(path: &Path) -> Vec<u8> {
    match celfx::io::picture::read(path) {
        Ok(picture) => {
            picture.pixels.as_flattened().iter().flat_map(|channel| channel.to_bits().to_le_bytes()).collect()
        }
        Err(_) => fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())),
    }
}

/// An archive of arrays that is being written; it is whole when it is dropped.
pub type Archive = ArchiveWriter<std::fs::File>;

/// A new archive.
pub fn archive(path: &Path) -> Archive {
    ArchiveWriter::new(std::fs::File::create(path).expect("temporary folder"))
}

/// Adds an array.
pub fn add_array<T: npyz::AutoSerialize>(
    to: &mut Archive,
    name: &str,
    shape: &[u64],
    values: impl IntoIterator<Item = T>,
) {
    to.add(name, shape, values).expect("an array");
}
