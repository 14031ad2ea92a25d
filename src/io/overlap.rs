//! Outputs that are an input, or another output: writing one would destroy the other.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::file::{Identity, resolved};
use super::pattern::Pattern;

/// A file that a run reads or writes, or one a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Files {
    /// Where it was named, as the user wrote it: `-o out/####.png`.
    pub what: String,
    /// The file, or those of the frames.
    pub pattern: Pattern,
}

impl Files {
    /// Names files.
    pub fn new(what: impl Into<String>, pattern: Pattern) -> Files {
        Files { what: what.into(), pattern }
    }
}

/// Two that are the same file (exit code 2).
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{output} would overwrite {other}: {}; expected {expected}", same.display())]
pub struct Overlap {
    /// The output.
    pub output: String,
    /// Its other use: an input or another output.
    pub other: String,
    /// The file that both are.
    pub same: PathBuf,
    expected: &'static str,
}

const OF_ITS_OWN: &str = "an output of another name or in another folder";

/// Refuses outputs that are an input or another output, of whatever frame: a pattern is refused for what it can name.
/// Files that are there are also compared by what they are, since links lead to others than their names say: the outputs
/// of the frames `written` with the inputs of the frames `read`, both first to last.
pub fn check(inputs: &[Files], outputs: &[Files], read: [u32; 2], written: [u32; 2]) -> Result<(), Overlap> {
    let found = |output: &Files, other: &Files, same: PathBuf| {
        Err(Overlap { output: output.what.clone(), other: other.what.clone(), same, expected: OF_ITS_OWN })
    };
    let names = |files: &Files| files.pattern.with_folder(resolved);
    let output_names: Vec<Pattern> = outputs.iter().map(names).collect();
    for (i, (output, name)) in outputs.iter().zip(&output_names).enumerate() {
        for input in inputs {
            // What a link leads to is an input, and so is the link.
            let target = (!input.pattern.has_number()).then(|| fs::canonicalize(input.pattern.path(0)).ok()).flatten();
            let targets = target.map(Pattern::single).into_iter().chain([names(input)]);
            if let Some(same) = targets.into_iter().find_map(|target| name.common(&target)) {
                return found(output, input, same);
            }
        }
        for (other, other_name) in outputs.iter().zip(&output_names).take(i) {
            if let Some(same) = name.common(other_name).or_else(|| folder_of(name, other_name)) {
                return found(output, other, same);
            }
        }
    }
    let mut there: HashMap<Identity, usize> = HashMap::new();
    for (i, output) in outputs.iter().enumerate() {
        for (path, file) in existing(&output.pattern, written) {
            match there.insert(file, i) {
                Some(other) if other != i => return found(output, &outputs[other], path),
                _ => {}
            }
        }
    }
    if there.is_empty() {
        return Ok(());
    }
    for input in inputs {
        for (path, file) in existing(&input.pattern, read) {
            if let Some(output) = there.get(&file) {
                return found(&outputs[*output], input, path);
            }
        }
    }
    Ok(())
}

/// A file that the other needs as a folder.
fn folder_of(a: &Pattern, b: &Pattern) -> Option<PathBuf> {
    let [one, other] = [a, b].map(|pattern| pattern.path(0));
    let is_within = |path: &Path, folder: &Path| path != folder && path.starts_with(folder);
    if is_within(&one, &other) { Some(other) } else { is_within(&other, &one).then_some(one) }
}

/// The files of these frames that are there.
fn existing(pattern: &Pattern, [first, last]: [u32; 2]) -> impl Iterator<Item = (PathBuf, Identity)> {
    let last = if pattern.has_number() { last } else { first };
    (first..=last).filter_map(|frame| {
        let path = pattern.path(frame);
        Identity::of(&path).map(|file| (path, file))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;

    /// The first two that are the same, of files in a folder; frames 1 to 3 are read, 2 to 3 written.
    fn overlap(folder: &Folder, inputs: &[&str], outputs: &[&str]) -> Option<[String; 2]> {
        let files = |names: &[&str]| -> Vec<Files> {
            let file = |name: &&str| Files::new(*name, Pattern::parse(folder.0.join(name)).unwrap());
            names.iter().map(file).collect()
        };
        let overlap = check(&files(inputs), &files(outputs), [1, 3], [2, 3]).err()?;
        assert!(overlap.to_string().contains("would overwrite"), "{overlap}");
        Some([overlap.output, overlap.other])
    }

    #[test]
    fn names_that_meet_are_refused_whatever_their_spelling_and_frame() {
        let folder = Folder::new();
        for (input, output) in [
            ("im/####.png", "im/####.png"),
            ("im/####.png", "./im/../im/%04d.png"),
            ("im/####.png", "new/../im/##.png"),
            ("sky.png", "sky.png"),
            // Neither rendered nor there.
            ("out/0040.png", "out/####.png"),
            ("v.##/a.png", "v.07/a.png"),
        ] {
            assert_eq!(overlap(&folder, &["x", input], &[output]), Some([output, input].map(str::to_owned)));
            assert_eq!(overlap(&folder, &["x"], &[input, output]), Some([output, input].map(str::to_owned)));
        }
        for (input, output) in [("im/####.png", "out/####.png"), ("sky.png", "####.png"), ("a.npz", "a.exr")] {
            assert_eq!(overlap(&folder, &[input], &[output, "s.png"]), None, "{input} {output}");
        }
        // Inputs may be the same as often as they like.
        assert_eq!(overlap(&folder, &["a.glb", "a.glb"], &["o.png"]), None);
        let nested = ["a.gif", "a.gif/####.png"];
        assert_eq!(overlap(&folder, &[], &nested), Some([nested[1], nested[0]].map(str::to_owned)));
        assert_eq!(folder.names(), Vec::<String>::new());
    }

    #[cfg(unix)]
    #[test]
    fn files_are_the_same_through_links() {
        use std::os::unix::fs::symlink;
        let folder = Folder::new();
        let path = |name: &str| folder.0.join(name);
        for name in ["im", "out"] {
            fs::create_dir(path(name)).unwrap();
        }
        (1..=3).for_each(|frame| fs::write(path(&format!("im/{frame}.png")), "x").unwrap());
        symlink("im", path("linked")).unwrap();
        let refused = |output: &str| Some([output, "im/#.png"].map(str::to_owned));
        assert_eq!(overlap(&folder, &["im/#.png"], &["linked/#.png"]), refused("linked/#.png"));
        assert_eq!(overlap(&folder, &["im/#.png"], &["out/#.png"]), None);
        // Frames that are written over, and one that is not.
        symlink("../im/1.png", path("out/1.png")).unwrap();
        assert_eq!(overlap(&folder, &["im/#.png"], &["out/#.png"]), None);
        symlink("../im/1.png", path("out/2.png")).unwrap();
        assert_eq!(overlap(&folder, &["im/#.png"], &["out/#.png"]), refused("out/#.png"));
        fs::remove_file(path("out/2.png")).unwrap();
        fs::hard_link(path("im/2.png"), path("out/3.png")).unwrap();
        assert_eq!(overlap(&folder, &["im/#.png"], &["out/#.png"]), refused("out/#.png"));
        // A background that is a link into the output's folder.
        symlink("out/0040.png", path("sky.png")).unwrap();
        fs::write(path("out/0040.png"), "x").unwrap();
        assert_eq!(
            overlap(&folder, &["sky.png"], &["out/####.png"]),
            Some(["out/####.png", "sky.png"].map(str::to_owned))
        );
    }
}
