//! URIs that hold data (RFC 2397).

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::general_purpose::{GeneralPurpose, NO_PAD};
use percent_encoding::percent_decode_str;

/// The data of a `data:` URI, base64 or percent-encoded; `None` if that cannot be decoded.
pub(super) fn decoded(uri: &str) -> Option<Vec<u8>> {
    let (kind, data) = uri.strip_prefix("data:")?.split_once(',')?;
    let bytes = Cow::from(percent_decode_str(data)).into_owned();
    match kind.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64")) {
        true => base64(bytes),
        false => Some(bytes),
    }
}

/// Decodes base64 (RFC 4648), padded or not, in one line or several; `None` if it is none.
fn base64(mut text: Vec<u8>) -> Option<Vec<u8>> {
    const LENIENT: GeneralPurpose = GeneralPurpose::new(&STANDARD, NO_PAD.with_decode_allow_trailing_bits(true));
    text.retain(|c| !c.is_ascii_whitespace());
    let end = text.iter().rposition(|&c| c != b'=').map_or(0, |last| last + 1);
    LENIENT.decode(&text[..end]).ok()
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
            ("Zm9=\n==", b"fo"),
        ] {
            assert_eq!(base64(text.into()).as_deref(), Some(bytes), "{text}");
        }
        for text in ["Z", "Zm9*", "Zm=v"] {
            assert_eq!(base64(text.into()), None, "{text}");
        }
    }

    #[test]
    fn data_are_base64_or_percent_encoded() {
        for (uri, bytes) in [
            ("data:application/octet-stream;base64,Zm8=", &b"fo"[..]),
            ("data:;BASE64,Zm8%3D", b"fo"),
            ("data:text/plain;charset=utf-8;base64,Zm8", b"fo"),
            ("data:application/octet-stream,a%00%fFb", b"a\0\xffb"),
            ("data:,%C3%A4%zz%4", b"\xc3\xa4%zz%4"),
            ("data:,", b""),
            ("data:text/plain;base65,Zm8", b"Zm8"),
        ] {
            assert_eq!(decoded(uri).as_deref(), Some(bytes), "{uri}");
        }
        assert_eq!([decoded("data:text/plain"), decoded("data:;base64,*"), decoded("a.bin")], [None, None, None]);
    }
}
