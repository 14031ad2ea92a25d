//! Whether pictures are still those of another build, bit for bit: hashes of all that many small shots and the quick
//! benchmarks make, as one text.
//!
//! `CELFX_HASHES` names that text: where there is no such file it is written, otherwise every line that differs fails the
//! test. `CELFX_PROGRAM` names the program that is run, by default that of this build:
//!
//! ```text
//! test="cargo test --locked --test unchanged -- --ignored"
//! CELFX_HASHES=/tmp/hashes.txt CELFX_PROGRAM=before/celfx $test     # writes
//! CELFX_HASHES=/tmp/hashes.txt CELFX_PROGRAM=after/celfx $test      # compares
//! ```
//!
//! Both must have the same driver. Shots are in `unchanged/shots.txt`. A line is shot, layer, frame and hash: of a layer's
//! pixels; of the passes that ran and that were left out, with the reasons; of what the program said. Lines of `passes` say
//! how many frames had each. Times are in none.
#![cfg(feature = "cli")]

#[path = "unchanged/inputs.rs"]
mod inputs;
#[allow(dead_code, reason = "each test file uses its part")]
#[path = "cli/run.rs"]
mod run;

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::{env, fs, iter, thread};

use celfx::io::{image, picture};
use run::Folder;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

const SHOTS: &str = include_str!("unchanged/shots.txt");
/// Frames of a mesh whose light turns, to be blurred as images of others.
const LIT: &str = "size=[96,72] frames=[20,23] blur.scene=builtin:crossing camera.file=builtin:crossing blur.strength=0 \
    light.direction=[[20,[-1,-1,-1]],[23,[1,-1,-1]]] blur.toon.outline.strength=0";
/// Effects, and which rows: each variant of each pass at its smallest workload.
const BENCHMARKS: [(&str, &str); 9] = [
    ("blur", "paper"),
    ("flame", "paper"),
    ("blur", "complete"),
    ("blur", "fox-like"),
    ("blur", "trajectory"),
    ("blur", "extent"),
    ("smoke", "grow"),
    ("smoke", "512x512"),
    ("smoke", "paper"),
];
/// Columns of `bench.json` that depend on time.
const TIMES: [&str; 5] = ["gpu_ms", "gpu_ms_low", "gpu_ms_high", "cpu_ms", "of_limit"];

/// Shot, layer and frame, and the hash.
type Lines = BTreeMap<String, String>;

#[test]
#[ignore = "takes minutes, and CELFX_HASHES=FILE: writes hashes of all pictures, or compares where the file is there"]
fn pictures_are_those_of_the_build_before() {
    let Some(path) = env::var_os("CELFX_HASHES").map(PathBuf::from) else {
        eprintln!("SKIPPED: CELFX_HASHES is not set");
        return;
    };
    let lines = all();
    if !path.exists() {
        let text: String = lines.iter().map(|(key, hash)| format!("{key} {hash}\n")).collect();
        return fs::write(&path, text).expect("CELFX_HASHES names a file that can be written");
    }
    let before = read(&fs::read_to_string(&path).expect("CELFX_HASHES names a text"));
    let differing = differing(&before, &lines);
    let counts = format!("{} of {} lines differ", differing.len(), before.len());
    assert!(differing.is_empty(), "{}: {counts}\n{}", path.display(), differing.join("\n"));
}

fn read(text: &str) -> Lines {
    let line = |line: &str| line.rsplit_once(' ').map(|(key, hash)| (key.to_owned(), hash.to_owned()));
    text.lines().filter_map(line).collect()
}

/// What is missing, added or changed.
fn differing(before: &Lines, after: &Lines) -> Vec<String> {
    let gone = before.iter().map(|(key, hash)| match after.get(key) {
        None => Some(format!("missing: {key} {hash}")),
        Some(new) => (new != hash).then(|| format!("changed: {key} {hash} -> {new}")),
    });
    let added = after.iter().map(|(key, hash)| (!before.contains_key(key)).then(|| format!("added: {key} {hash}")));
    gone.chain(added).flatten().collect()
}

#[test]
fn what_differs_is_named() {
    let (before, after) = (read("a x 1 11\na y 1 22\na z 1 33"), read("a x 1 11\na y 1 20\nb z 1 33"));
    assert_eq!(differing(&before, &before), Vec::<String>::new());
    assert_eq!(differing(&before, &after), ["changed: a y 1 22 -> 20", "missing: a z 1 33", "added: b z 1 33"]);
}

/// A run of the program.
enum Job {
    Benchmark { effect: &'static str, only: &'static str },
    Shot { name: String, words: Vec<&'static str> },
}

/// What a run has made.
#[derive(Default)]
struct Made {
    lines: Lines,
    /// What became of a pass in a frame, once for each frame.
    passes: Vec<String>,
}

/// The lines of all jobs, two of which run at a time.
fn all() -> Lines {
    let folder = Folder::new();
    inputs::write(&folder);
    let lit = LIT.split_whitespace().flat_map(|word| ["--set", word]);
    let lit = ["render", "builtin:blur", "-q", "-o", "lit.####.exr"].into_iter().chain(lit).map(OsString::from);
    celfx(&folder, "lit", &lit.collect::<Vec<_>>());
    let benchmarks = BENCHMARKS.into_iter().map(|(effect, only)| Job::Benchmark { effect, only });
    let jobs = Mutex::new(benchmarks.chain(shots()).enumerate());
    let next = || jobs.lock().expect("no job has failed").next();
    let work = || {
        let run = |(index, job): (usize, Job)| {
            let out = folder.0.join(format!("out{index}"));
            let made = match job {
                Job::Benchmark { effect, only } => benchmark(&folder, &out, effect, only),
                Job::Shot { name, words } => shot(&folder, &out, &name, &words),
            };
            fs::remove_dir_all(&out).expect("temporary folder");
            made
        };
        iter::from_fn(next).map(run).collect::<Vec<Made>>()
    };
    let made = thread::scope(|scope| {
        [scope.spawn(work), scope.spawn(work)].map(|worker| worker.join().expect("no job has failed"))
    });
    let mut lines = Lines::new();
    let mut frames: BTreeMap<String, u32> = BTreeMap::new();
    for made in made.into_iter().flatten() {
        for (key, hash) in made.lines {
            assert!(lines.insert(key.clone(), hash).is_none(), "{key} is there twice");
        }
        made.passes.into_iter().for_each(|pass| *frames.entry(pass).or_default() += 1);
    }
    lines.extend(frames.into_iter().map(|(pass, frames)| (format!("passes {pass}"), frames.to_string())));
    lines
}

/// The shots of the list.
fn shots() -> Vec<Job> {
    let mut section = Vec::new();
    let mut jobs = Vec::new();
    for line in SHOTS.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (name, words) = line.split_once(' ').unwrap_or((line, ""));
        let words = words.split_whitespace();
        match name.strip_prefix('[') {
            Some(name) => section = [name.trim_end_matches(']')].into_iter().chain(words).collect(),
            None => {
                let name = format!("{}/{name}", section[0]);
                jobs.push(Job::Shot { name, words: section[1..].iter().copied().chain(words).collect() });
            }
        }
    }
    jobs
}

/// Runs the program in the folder of the inputs; returns what it says on standard error.
fn celfx(folder: &Folder, name: &str, arguments: &[OsString]) -> String {
    let program = env::var_os("CELFX_PROGRAM").unwrap_or_else(|| env!("CARGO_BIN_EXE_celfx").into());
    let program = fs::canonicalize(&program).unwrap_or_else(|error| panic!("{}: {error}", program.display()));
    let mut command = Command::new(program);
    command.args(arguments).args(["--threads", "1"]).current_dir(&folder.0).stdin(Stdio::null());
    if let Ok(device) = env::var("CELFX_DEVICE") {
        command.args(["--device", &device]);
    }
    let output = command.output().expect("the program runs");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.success(), "{name}, {arguments:?}: {}\n{said}", output.status);
    said
}

/// One line a row: its name, and the hash of what is not time.
fn benchmark(folder: &Folder, out: &Path, effect: &str, only: &str) -> Made {
    let arguments = ["bench", effect, "--quick", "-q", "--only", only, "-o"].map(OsString::from);
    celfx(folder, effect, &[&arguments[..], &[out.into()]].concat());
    let text = fs::read_to_string(out.join("bench.json")).expect("bench.json");
    let mut report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let device = format!("{} {}", report["device"], report["driver"]);
    let rows = report["rows"].as_array_mut().expect("rows").iter_mut().map(|row| {
        let row = row.as_object_mut().expect("a row");
        row.retain(|column, _| !TIMES.contains(&column.as_str()));
        let [pass, variant, workload] =
            ["pass", "variant", "workload"].map(|key| row[key].as_str().expect("a name").replace(' ', "_"));
        let row = serde_json::to_string(row).expect("JSON");
        (format!("bench/{effect} {pass}/{variant} {workload}"), hash(row.as_bytes()))
    });
    let lines = rows.chain([(format!("bench/{effect} device {only}"), hash(device.as_bytes()))]).collect();
    Made { lines, ..Made::default() }
}

/// One line a file that a shot has made, one for the passes of each frame, and one for what was said.
fn shot(folder: &Folder, out: &Path, name: &str, words: &[&str]) -> Made {
    let within = |file: &str| out.join(file).into_os_string();
    let mut arguments: Vec<OsString> = vec!["render".into(), String::new().into()];
    for word in words {
        match word.split_once("OUT/") {
            _ if word.starts_with("builtin:") || word.ends_with(".toml") => arguments[1] = word.into(),
            _ if *word == "plain" => {}
            Some((option, file)) => arguments.push([option.into(), within(file)].into_iter().collect()),
            None if word.starts_with("--") => arguments.push(word.into()),
            None => arguments.extend(["--set".into(), word.into()]),
        }
    }
    if !words.contains(&"plain") {
        arguments.extend(["--layers".into(), within("")]);
    }
    arguments.extend(["-o".into(), within("picture.####.exr"), "--profile".into(), within("profile.csv")]);
    let said = celfx(folder, name, &arguments);
    let lines = Lines::from([(format!("{name} said all"), hash(said.as_bytes()))]);
    let mut made = Made { lines, ..Made::default() };
    for file in run::names(out) {
        let path = out.join(&file);
        let (stem, kind) = file.rsplit_once('.').expect("a kind");
        let (layer, frame) = stem.rsplit_once('.').unwrap_or((stem, "all"));
        let hash = match kind {
            "csv" => {
                profile(&path, name, &mut made);
                continue;
            }
            "exr" => channels(&path),
            "png" => {
                let picture = picture::read(&path).expect("a picture");
                pixels(picture.size, [("RGBA", picture.pixels.as_flattened())])
            }
            // A shape and numbers; or an animation.
            _ => hash(&fs::read(&path).expect("a file")),
        };
        made.lines.insert(format!("{name} {layer} {frame}"), hash);
    }
    made
}

fn channels(path: &Path) -> String {
    let image = image::read_exr(path).unwrap_or_else(|error| panic!("{error}"));
    pixels(image.size, image.channels.iter().map(|(name, values)| (name.as_str(), &values[..])))
}

/// Of size, channels' names and the values' bits.
fn pixels<'a>(size: [u32; 2], channels: impl IntoIterator<Item = (&'a str, &'a [f32])>) -> String {
    let mut hasher = Xxh3::new();
    hasher.update(format!("{size:?}").as_bytes());
    for (name, values) in channels {
        hasher.update(name.as_bytes());
        hasher.update(&values.iter().flat_map(|value| value.to_bits().to_le_bytes()).collect::<Vec<u8>>());
    }
    format!("{:016x}", hasher.digest())
}

fn hash(bytes: &[u8]) -> String {
    format!("{:016x}", xxh3_64(bytes))
}

/// The passes of each frame in their order, and those left out, with why.
fn profile(path: &Path, name: &str, made: &mut Made) {
    let text = fs::read_to_string(path).expect("a profile");
    let mut frames: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for row in text.lines().skip(1) {
        let [frame, pass, _, _, _, reason] = row.splitn(6, ',').collect::<Vec<_>>().try_into().expect("six columns");
        let how = if reason.is_empty() { "ran".into() } else { reason.replace('"', "").replace(' ', "_") };
        frames.entry(frame).or_default().push(format!("{pass} {how}"));
    }
    for (frame, rows) in frames {
        made.lines.insert(format!("{name} passes {frame:0>4}"), hash(rows.join("\n").as_bytes()));
        made.passes.extend(rows.into_iter().collect::<BTreeSet<String>>());
    }
}
