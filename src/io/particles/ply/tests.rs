use super::*;

const FACES: &str = "element face 1\nproperty list uchar int vertex_index\n";

/// A file whose vertices have `properties`, after an element of lists.
fn file(format: &str, properties: &[&str], count: usize, body: &[u8]) -> Vec<u8> {
    let lines: String = properties.iter().map(|property| format!("property {property}\n")).collect();
    let header =
        format!("ply\nformat {format} 1.0\ncomment made by hand\n{FACES}element vertex {count}\n{lines}end_header\n");
    [header.as_bytes(), body].concat()
}

const PROPERTIES: [&str; 8] = [
    "double x",
    "short y",
    "uchar red",
    "float z",
    "list uint8 int16 neighbours",
    "uint id",
    "float vy",
    "int32 temperature",
];

fn properties() -> Vec<&'static str> {
    [&PROPERTIES[..], &["float vx", "float vz"]].concat()
}

fn expected() -> Particles {
    Particles {
        position: vec![[0.25, -2.0, 1.5], [1e-3, 300.0, -4.0]],
        temperature: vec![900.0, 3000.0],
        id: Some(vec![7, u32::MAX]),
        velocity: Some(vec![[1.0, 0.5, -1.0], [2.0, 0.0, 3.0]]),
    }
}

/// The rows in bytes: a face of three corners, then two vertices.
fn bytes(is_big: bool) -> Vec<u8> {
    let mut out = vec![3];
    let mut put = |bytes: &[u8]| match is_big {
        true => out.extend(bytes.iter().rev()),
        false => out.extend(bytes),
    };
    [0, 1, 1].iter().for_each(|corner: &i32| put(&corner.to_le_bytes()));
    let rows = [
        (0.25_f64, -2_i16, 1.5_f32, 2_u8, 7_u32, 0.5_f32, 900_i32, [1.0_f32, -1.0]),
        (1e-3, 300, -4.0, 0, u32::MAX, 0.0, 3000, [2.0, 3.0]),
    ];
    for (x, y, z, count, id, vy, temperature, others) in rows {
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
        put(&[200]);
        put(&z.to_le_bytes());
        put(&[count]);
        (0..count).for_each(|_| put(&(-1_i16).to_le_bytes()));
        put(&id.to_le_bytes());
        put(&vy.to_le_bytes());
        put(&temperature.to_le_bytes());
        others.iter().for_each(|value| put(&value.to_le_bytes()));
    }
    out
}

const TEXT: &str = "3 0 1 1\n0.25 -2 200 1.5 2 -1 -1 7 0.5 900 1 -1\n\n1e-3 300 200 -4 0 4294967295 0 3000 2 3\n";

fn parsed(file: &[u8]) -> Result<Particles, String> {
    parse(Path::new("p.ply"), file).map_err(|error| error.to_string())
}

#[test]
fn every_format_is_read() {
    let files = [
        file("ascii", &properties(), 2, TEXT.as_bytes()),
        file("ascii", &properties(), 2, TEXT.replace('\n', "\r\n").as_bytes()),
        file("binary_little_endian", &properties(), 2, &bytes(false)),
        file("binary_big_endian", &properties(), 2, &bytes(true)),
    ];
    for file in files {
        assert_eq!(parsed(&file), Ok(expected()));
    }
    let none = file("ascii", &["float x", "float y", "float z", "float t"], 0, b"3 0 0 0\n");
    assert_eq!(parsed(&none), Ok(Particles::default()));
}

#[test]
fn faults_name_their_place() {
    let says = |file: &[u8], words: &[&str]| {
        let error = parsed(file).unwrap_err();
        assert!(error.starts_with("p.ply: ") && words.iter().all(|word| error.contains(word)), "{error}");
    };
    says(b"plyx\n", &["is no PLY file"]);
    says(b"ply\nformat ascii 1.0\n", &["ends within its header"]);
    says(&file("utf8", &properties(), 2, b""), &["line 2: is `format utf8 1.0`", "binary_big_endian"]);
    says(&file("ascii", &["real x"], 2, b""), &["line 7: is `property real x`", "float64"]);
    says(&file("ascii", &["float x", "float y", "float z"], 2, b""), &["[\"x\", \"y\", \"z\"]", "no temperature"]);
    let list = ["float x", "float y", "float z", "list uchar float t"];
    says(&file("ascii", &list, 2, b""), &["property `t` is a list; expected a number"]);
    let four = ["float x", "float y", "float z", "float t"];
    says(&file("ascii", &four, 2, b"3 0 0 0\n1 2 3 4\n"), &["ends after 1 of 2 vertices"]);
    says(&file("ascii", &four, 1, b"3 0 0 0\n1 two 3 4\n"), &["line 13, property `y`: is `two`"]);
    says(&file("ascii", &four, 1, b"3 0 0 0\n1 2 3\n"), &["line 13, property `t`: is missing"]);
    let huge = file("binary_little_endian", &four, 1 << 27, &bytes(false));
    says(&huge, &["2147483648 bytes", "cut off, or damaged"]);
    says(&file("binary_little_endian", &four, 1 << 30, b""), &["has 1073741824 particles; expected 268435456 at most"]);
    let negative = file("ascii", &four, 1, b"3 0 0 0\n1 2 3 -4\n");
    says(&negative, &["`temperature`, row 0: is -4 as f32"]);
    says(b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", &["[\"face\"]", "an element `vertex`"]);
}

/// Whatever bytes are missing or wrong, there is an error or other values.
#[test]
fn damage_ends_in_an_error() {
    for (number, file) in (0..).zip([
        file("ascii", &properties(), 2, TEXT.as_bytes()),
        file("binary_little_endian", &properties(), 2, &bytes(false)),
        file("binary_big_endian", &properties(), 2, &bytes(true)),
    ]) {
        for size in 0..file.len() {
            let cut = parsed(&file[..size]);
            // Of text the end of a number may be cut off.
            assert!(cut.is_err() || number == 0 && size > file.len() - 8, "{number}: {size}");
        }
        for i in 0..4000 {
            let mut damaged = file.clone();
            let random = |k: u32, of: usize| crate::random::hash(number, i, k, 0) as usize % of;
            let at = random(0, file.len());
            damaged[at] = match i % 3 {
                0 => b'9',
                1 => damaged[at] ^ 1 << random(1, 8),
                _ => random(1, 256) as u8,
            };
            let _ = parsed(&damaged);
        }
    }
}
