//! What the text of shaders says and SPIR-V does not: constants, and comments on members of blocks.

use std::collections::BTreeMap;
use std::path::Path;

/// `const TYPE NAME = VALUE;` of a GLSL file, at the start of a line.
pub struct Constant {
    pub name: String,
    /// Its type in Rust.
    pub rust: &'static str,
    /// Its value as a Rust expression.
    pub value: String,
    pub comment: String,
    /// The feature that its file is for.
    pub feature: Option<&'static str>,
}

/// The scalar constants of a file, in its order. One whose value calls a function, takes several lines, or follows from a
/// specialisation constant of the file or from what is built in, is the shaders' own.
pub fn constants(text: &str) -> impl Iterator<Item = Constant> {
    let specialised: Vec<&str> = text.lines().filter_map(specialised).collect();
    let all = text.lines().filter_map(|line| constant(line.strip_prefix("const ")?));
    all.filter(move |constant| !constant.value.split(' ').any(|word| specialised.contains(&word)))
}

/// `layout(constant_id = 0) const uint NAME = 1;` declares `NAME`.
fn specialised(line: &str) -> Option<&str> {
    line.strip_prefix("layout(constant_id")?.split_once(" const ")?.1.split(' ').nth(1)
}

fn constant(line: &str) -> Option<Constant> {
    let (kind, rest) = line.split_once(' ')?;
    let rust = match kind {
        "uint" => "u32",
        "int" => "i32",
        "float" => "f32",
        _ => return None,
    };
    let (name, rest) = rest.split_once(" = ")?;
    let (value, comment) = rest.split_once(';')?;
    if name.contains('[') || value.contains('(') || value.contains("gl_") {
        return None;
    }
    let comment = comment.trim().trim_start_matches('/').trim().to_owned();
    Some(Constant { name: name.to_owned(), rust, value: rust_value(value), comment, feature: None })
}

/// `1u << 26u` becomes `1 << 26`.
fn rust_value(value: &str) -> String {
    let word = |word: &str| match word.strip_suffix('u') {
        Some(number) if number.starts_with(|c: char| c.is_ascii_digit()) => number.to_owned(),
        _ => word.to_owned(),
    };
    value.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// FNV-1a of the names and the texts of all files in `glsl`: of what a table was made from.
pub fn hash() -> u64 {
    let bytes = super::sorted(Path::new("glsl")).into_iter().filter(|path| path.is_dir()).flat_map(|folder| {
        super::sorted(&folder).into_iter().flat_map(|path| [path.display().to_string(), super::read(&path)])
    });
    let bytes = bytes.flat_map(String::into_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// Comments on the members of blocks: (block, member) -> comment; on a block itself: (block, "").
pub type Comments = BTreeMap<(String, String), String>;

/// Those of a file.
pub fn comments(text: &str, into: &mut Comments) {
    let mut block = None;
    let mut above = String::new();
    for line in text.lines() {
        let (code, comment) = line.split_once("//").map_or((line, ""), |(code, comment)| (code, comment.trim()));
        let code = code.trim();
        if let Some(head) = code.strip_suffix('{') {
            let name = head.split_whitespace().last().unwrap_or_default().to_owned();
            let is_block = head.contains("struct ") || head.contains("uniform ") || head.contains("buffer ");
            block = is_block.then_some(name);
            if let Some(block) = &block {
                into.insert((block.clone(), String::new()), std::mem::take(&mut above));
            }
        } else if code.starts_with('}') {
            block = None;
        } else if let (Some(block), Some(declaration)) = (&block, code.strip_suffix(';')) {
            let name = declaration.split_whitespace().last().unwrap_or_default();
            let name = name.split('[').next().unwrap_or_default();
            into.insert((block.clone(), name.to_owned()), comment.to_owned());
        }
        match code.is_empty() && !comment.is_empty() {
            true => above = format!("{above} {comment}").trim().to_owned(),
            false => above.clear(),
        }
    }
}
