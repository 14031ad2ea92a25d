//! URIs that hold data (RFC 2397), and what is encoded in URIs.

/// The data of a `data:` URI, base64 or percent-encoded; `None` if that cannot be decoded.
pub(super) fn decoded(uri: &str) -> Option<Vec<u8>> {
    let (kind, data) = uri.strip_prefix("data:")?.split_once(',')?;
    let bytes = percent_decoded(data);
    match kind.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64")) {
        true => base64(&bytes),
        false => Some(bytes),
    }
}

/// Decodes base64 (RFC 4648), padded or not, in one line or several; `None` if it is none.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let end = text.iter().rposition(|&c| c != b'=' && !c.is_ascii_whitespace()).map_or(0, |last| last + 1);
    let mut bytes = Vec::with_capacity(end / 4 * 3 + 2);
    let (mut bits, mut digits) = (0u32, 0);
    for &c in text[..end].iter().filter(|c| !c.is_ascii_whitespace()) {
        let digit = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        (bits, digits) = (bits << 6 | u32::from(digit), digits + 1);
        if digits == 4 {
            bytes.extend(&bits.to_be_bytes()[1..]);
            (bits, digits) = (0, 0);
        }
    }
    match digits {
        0 => {}
        1 => return None,
        _ => bytes.extend(&(bits << (6 * (4 - digits))).to_be_bytes()[1..digits]),
    }
    Some(bytes)
}

/// The bytes of a URI with its `%XX` decoded.
pub(super) fn percent_decoded(uri: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = |c: &u8| char::from(*c).to_digit(16);
        (rest, _) = match (first, tail) {
            (b'%', [a, b, after @ ..]) if hex(a).is_some() && hex(b).is_some() => {
                let byte = hex(a).zip(hex(b)).map_or(0, |(a, b)| a * 16 + b);
                (after, bytes.push(byte as u8))
            }
            _ => (tail, bytes.push(*first)),
        };
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_decoded() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYg", b"foob"),
            ("Zm9vYmE=", b"fooba"),
            ("Zm9v\r\nYmE=\n", b"fooba"),
            ("+/A9\n", &[0xfb, 0xf0, 0x3d]),
        ] {
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes), "{text}");
        }
        assert_eq!(base64(b"Z"), None);
        assert_eq!(base64(b"Zm9*"), None);
        assert_eq!(base64(b"Zm=v"), None);
    }

    #[test]
    fn data_are_base64_or_percent_encoded() {
        for (uri, bytes) in [
            ("data:application/octet-stream;base64,Zm8=", &b"fo"[..]),
            ("data:;BASE64,Zm8%3D", b"fo"),
            ("data:text/plain;charset=utf-8;base64,Zm8", b"fo"),
            ("data:application/octet-stream,a%00%fFb", b"a\0\xffb"),
            ("data:,", b""),
            ("data:text/plain;base65,Zm8", b"Zm8"),
        ] {
            assert_eq!(decoded(uri).as_deref(), Some(bytes), "{uri}");
        }
        assert_eq!([decoded("data:text/plain"), decoded("data:;base64,*"), decoded("a.bin")], [None, None, None]);
    }

    #[test]
    fn uris_are_decoded() {
        assert_eq!(percent_decoded("a%20b%2Fc%zz%4"), b"a b/c%zz%4");
        assert_eq!(percent_decoded("%C3%A4"), "ä".as_bytes());
    }
}
