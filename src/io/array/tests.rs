use super::*;
use crate::io::tests::Folder;
use std::fs;
use std::io::Write;

/// The bytes of a `.npy` file.
pub(crate) fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let fortran = if fortran { "True" } else { "False" };
    with_header(&format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n"), data)
}

fn with_header(text: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

/// Writes an `.npz` of such arrays.
pub(crate) fn write_archive(path: &Path, arrays: &[(&str, Vec<u8>)]) {
    let mut npz = ZipWriter::new(File::create(path).unwrap());
    for (name, bytes) in arrays {
        npz.start_file(format!("{name}.npy"), SimpleFileOptions::DEFAULT).unwrap();
        npz.write_all(bytes).unwrap();
    }
    npz.finish().unwrap();
}

fn read_one(bytes: Vec<u8>) -> Result<Array<f64>, ReadError> {
    let folder = Folder::new();
    let path = folder.0.join("one.npz");
    write_archive(&path, &[("a", bytes)]);
    Archive::open(&path)?.read("a", 1 << 20).map(Option::unwrap)
}

#[test]
fn every_number_type_in_both_byte_orders() {
    let values = [1.5f64, -2.0, 0.25, 65504.0];
    let check = |descr: &str, bytes: Vec<u8>, expected: &[f64]| {
        let array = read_one(npy(descr, false, "(4,)", &bytes)).unwrap();
        assert_eq!((array.values.as_slice(), &array.shape[..]), (expected, &[4][..]), "{descr}");
    };
    check("'<f8'", values.iter().flat_map(|v| v.to_le_bytes()).collect(), &values);
    check("'>f8'", values.iter().flat_map(|v| v.to_be_bytes()).collect(), &values);
    check("'<f4'", values.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect(), &values);
    check("'>f4'", values.iter().flat_map(|v| (*v as f32).to_be_bytes()).collect(), &values);
    check("'<f2'", values.iter().flat_map(|v| f16::from_f64(*v).to_le_bytes()).collect(), &values);
    check("'>f2'", values.iter().flat_map(|v| f16::from_f64(*v).to_be_bytes()).collect(), &values);
    let whole = [1i16, -2, 300, -32768];
    check("'<i2'", whole.iter().flat_map(|v| v.to_le_bytes()).collect(), &[1.0, -2.0, 300.0, -32768.0]);
    check("'>i2'", whole.iter().flat_map(|v| v.to_be_bytes()).collect(), &[1.0, -2.0, 300.0, -32768.0]);
    check("'|i1'", vec![255, 1, 128, 0], &[-1.0, 1.0, -128.0, 0.0]);
    check("\"|u1\"", vec![255, 1, 128, 0], &[255.0, 1.0, 128.0, 0.0]);
    let longest = [u64::MAX, 0, 1, 7].iter().flat_map(|v| v.to_le_bytes()).collect();
    check("'<u8'", longest, &[u64::MAX as f64, 0.0, 1.0, 7.0]);
}

#[test]
fn shapes_and_headers_as_numpy_writes_them() {
    let data: Vec<u8> = (0..24u8).collect();
    let c = read_one(npy("'|u1'", false, "(2, 3, 4)", &data)).unwrap();
    assert_eq!(c.values, (0..24).map(f64::from).collect::<Vec<_>>());
    let fortran = read_one(npy("'|u1'", true, "(2, 3, 4)", &data)).unwrap();
    let at = |i: usize, j: usize, k: usize| fortran.values[(i * 3 + j) * 4 + k];
    assert_eq!([at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1), at(1, 2, 3)], [0.0, 1.0, 2.0, 6.0, 23.0]);
    assert_eq!(read_one(npy("'|u1'", true, "()", &[9])).unwrap().values, [9.0]);
    assert_eq!(read_one(npy("'|u1'", true, "(24L,)", &data)).unwrap().shape, [24]);
    assert_eq!(read_one(npy("'<f4'", false, "(0, 5)", &[])).unwrap().shape, [0, 5]);
    let compact = with_header("{\"shape\":(2,),\"fortran_order\":False,\"descr\":\"|u1\"}", &[1, 2]);
    assert_eq!(read_one(compact).unwrap().values, [1.0, 2.0]);
    let mut version_2 = b"\x93NUMPY\x02\x00".to_vec();
    let text = b"{'descr': '|u1', 'fortran_order': False, 'shape': (1,), }";
    version_2.extend((text.len() as u32).to_le_bytes());
    version_2.extend(text);
    version_2.push(5);
    assert_eq!(read_one(version_2).unwrap().values, [5.0]);
}

#[test]
fn faulty_arrays_are_named() {
    let says = |bytes: Vec<u8>, words: &[&str]| {
        let error = read_one(bytes).unwrap_err().to_string();
        assert!(words.iter().all(|w| error.contains(w)) && error.contains("one.npz: array `a`"), "{error}");
    };
    says(npy("'<f4'", false, "(4,)", &[0; 15]), &["15 bytes", "[4]", "expected 16 bytes"]);
    says(npy("'<f4'", false, "(4,)", &[0; 17]), &["17 bytes", "expected 16 bytes"]);
    says(npy("'<f4'", false, "(99999, 99999)", &[0; 16]), &["too large"]);
    says(npy("'<f4'", false, "(4294967296, 4294967296, 0)", &[0; 16]), &["too large"]);
    says(npy("'<f4'", false, "(99999999999999999999999,)", &[0; 16]), &["shape"]);
    says(npy("'<f4'", false, "(-4,)", &[0; 16]), &["shape"]);
    says(npy("'|O'", false, "(4,)", &[0; 16]), &["`|O`", "f16, f32 or f64"]);
    says(npy("'<c8'", false, "(2,)", &[0; 16]), &["`<c8`"]);
    says(npy("'<f16'", false, "(1,)", &[0; 16]), &["`<f16`"]);
    says(npy("[('x', '<f4')]", false, "(4,)", &[0; 16]), &["several fields", "f16, f32 or f64"]);
    says(npy("'ä'", false, "(4,)", &[0; 16]), &["`ä`"]);
    says(with_header("{'descr': '<f4'}", &[]), &["lacks"]);
    says(with_header("[[[[[[[[[[", &[]), &["no dictionary"]);
    says(with_header("{'descr': '<f4' 'shape': (1,)}", &[]), &["comma"]);
    says(with_header("{'other': 3}", &[]), &["unknown key"]);
    says(b"\x93NUMPY\x01\x00\xff\xff{'descr'".to_vec(), &["byte 0", "ends within the header"]);
    says(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{".to_vec(), &["header of 4294967295 bytes"]);
    says(b"\x93NUMPY\x09\x00\xff\xff".to_vec(), &["known version"]);
    says(b"no".to_vec(), &["byte 0"]);
    says(vec![], &["byte 0"]);
}

#[test]
fn no_damage_to_an_archive_panics() {
    let folder = Folder::new();
    let path = folder.0.join("damaged.npz");
    write_archive(&path, &[("a", npy("'<f4'", true, "(2, 2)", &[1; 16])), ("b", npy("'<i8'", false, "()", &[2; 8]))]);
    let whole = fs::read(&path).unwrap();
    let read = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let mut archive = Archive::open(&path)?;
        for name in archive.names() {
            archive.header(&name)?;
            archive.read::<f32>(&name, 1 << 20)?;
        }
        Ok::<(), ReadError>(())
    };
    read(&whole).unwrap();
    for cut in 0..whole.len() {
        assert!(read(&whole[..cut]).is_err(), "cut at {cut}");
    }
    // The packed data of the first array follow a local header of 30 bytes and the name: the checksum tells.
    for at in 35..75 {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x10;
        assert!(read(&damaged).is_err(), "byte {at}");
    }
    for at in 0..whole.len() {
        for value in [0, 0xff, whole[at] ^ 0x10] {
            let mut damaged = whole.clone();
            damaged[at] = value;
            // Not every byte of an archive matters (dates, for one); what counts is that it returns.
            let _ = read(&damaged);
        }
    }
}

/// An archive of one array, with the two-byte words of its entry in the list of the archive changed.
fn with_entry(array: Vec<u8>, words: &[(usize, u16)]) -> Result<Array<f64>, ReadError> {
    let folder = Folder::new();
    let path = folder.0.join("lying.npz");
    write_archive(&path, &[("a", array)]);
    let mut bytes = fs::read(&path).unwrap();
    let entry = bytes.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
    words.iter().for_each(|(at, word)| bytes[entry + at..][..2].copy_from_slice(&word.to_le_bytes()));
    fs::write(&path, bytes).unwrap();
    Archive::open(&path)?.read("a", 1 << 31).map(Option::unwrap)
}

#[test]
fn an_entry_holds_no_more_than_its_packing_can() {
    let array = || npy("'|u1'", false, "(2147418112,)", &[7; 5000]);
    // The size once unpacked, of which the header has 128 bytes or less.
    let error = with_entry(array(), &[(24, 0), (26, 0x7fff)]).unwrap_err().to_string();
    assert!(error.contains("lying.npz: array `a`") && error.contains("claim to unpack to 2147418112"), "{error}");
    // A packed size that the whole file does not have makes it no more likely.
    let error = with_entry(array(), &[(20, 0xffff), (22, 0x7fff), (26, 0x7fff)]).unwrap_err().to_string();
    assert!(error.contains("lying.npz: array `a`") && error.contains("claim to unpack to"), "{error}");
    // Way of packing 12 is bzip2.
    let error = with_entry(npy("'|u1'", false, "(3,)", &[7; 3]), &[(10, 12)]).unwrap_err().to_string();
    assert!(error.contains("array `a`: is packed as Bzip2; expected a stored or deflated"), "{error}");
    // As far as deflate goes.
    let zeros = npy("'|u1'", false, "(1000000,)", &vec![0; 1_000_000]);
    assert_eq!(with_entry(zeros, &[]).unwrap().values.len(), 1_000_000);
}

#[test]
fn numbers_come_one_by_one_without_being_kept() {
    let folder = Folder::new();
    let path = folder.0.join("a.npz");
    write_archive(&path, &[("a", npy("'>i2'", true, "(2, 2)", &[0, 1, 0, 2, 0, 3, 0, 4]))]);
    let mut archive = Archive::open(&path).unwrap();
    let mut values = Vec::new();
    let header = archive.each("a", |value: f64| values.push(value)).unwrap().unwrap();
    assert_eq!((values, header.shape, header.fortran_order), (vec![1.0, 2.0, 3.0, 4.0], vec![2, 2], true));
    assert_eq!(archive.each("b", |_: f64| unreachable!()).unwrap(), None);
    assert_eq!(archive.shape("a", 1, Kind::Whole, "").unwrap(), Some(vec![2, 2]));
    assert!(archive.shape("a", 2, Kind::Float, "floats").unwrap_err().to_string().contains("are integers"));
}

#[test]
fn npy_files_hold_what_was_written() {
    let folder = Folder::new();
    let path = folder.0.join("deep/a.npy");
    let values = [1.0f32, f32::NEG_INFINITY, 1e-45, -0.0, 3.5, 7.25];
    write_npy(&path, &[2, 3], &values).unwrap();
    let bytes = fs::read(&path).unwrap();
    let (header, start) = read_header(&mut &bytes[..], &Fault { path: &path, name: "" }).unwrap();
    assert_eq!((header.element, &header.shape[..], header.fortran_order), (Element::F32, &[2, 3][..], false));
    let stored: Vec<u32> =
        bytes[start as usize..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(stored, values.map(f32::to_bits));
    // NumPy maps files whose data begin at a multiple of 64.
    assert_eq!(start % 16, 0);
    write_npy(&path, &[0, 5], &[]).unwrap();
    write_npy(&path, &[], &[1.0]).unwrap();
    let error = write_npy(&path, &[4, 2], &values).unwrap_err().to_string();
    assert!(error.contains("a.npy") && error.contains("6 values") && error.contains("[4, 2]"), "{error}");
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
}
