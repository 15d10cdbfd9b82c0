//! What a URI of a glTF file stands for: a data URI, or a file beside it.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use crate::error::{Error, Result};

/// A URI, taken apart.
#[derive(Debug, PartialEq)]
pub enum Uri {
    /// Decoded `data:` URI.
    Data(Vec<u8>),
    /// Relative path, percent-decoded.
    File(PathBuf),
}

/// Takes a URI apart. The error says what is wrong with it.
pub fn parse(uri: &str) -> Result<Uri, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, payload) = data.split_once(',').ok_or("a data URI without a comma")?;
        let payload = percent_decoded(payload)?;
        return if kind.ends_with(";base64") {
            base64_decoded(&payload).map(Uri::Data)
        } else {
            Ok(Uri::Data(payload))
        };
    }
    let scheme = uri.split(['/', '?', '#']).next().unwrap_or_default();
    if scheme.contains(':') || uri.starts_with('/') {
        return Err(format!("the URI {:?} is neither a data URI nor a path relative to the file", short(uri)));
    }
    let path = String::from_utf8(percent_decoded(uri)?)
        .map_err(|_| format!("the URI {:?} is not UTF-8 when decoded", short(uri)))?;
    if path.is_empty() || path.contains('\0') || Path::new(&path).is_absolute() {
        return Err(format!("the URI {:?} names no file", short(uri)));
    }
    Ok(Uri::File(path.into()))
}

/// All of a plain file, which may have `limit` bytes at most.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let fail = |source| Error::io("read", path, source);
    // Opening a pipe would wait for its writer.
    let kind = std::fs::metadata(path).map_err(fail)?;
    if !kind.is_file() {
        return Err(fail(std::io::Error::new(std::io::ErrorKind::InvalidInput, "not a plain file")));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(fail)?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > limit {
        let what = format!("longer than the {limit} bytes that are read at most");
        return Err(fail(std::io::Error::new(std::io::ErrorKind::InvalidData, what)));
    }
    Ok(bytes)
}

/// The start of a text that may be long.
pub fn short(text: &str) -> String {
    if text.chars().count() <= 80 { text.to_owned() } else { text.chars().take(77).chain("...".chars()).collect() }
}

fn percent_decoded(text: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let mut digit = || char::from(rest.next()?).to_digit(16);
        let (Some(high), Some(low)) = (digit(), digit()) else {
            return Err(format!("the URI {:?} has a % without two hexadecimal digits", short(text)));
        };
        bytes.push((high * 16 + low) as u8);
    }
    Ok(bytes)
}

/// RFC 4648, section 4; missing padding is forgiven.
fn base64_decoded(text: &[u8]) -> Result<Vec<u8>, String> {
    let text = text.trim_ascii_end();
    let end = text.iter().rposition(|&c| c != b'=').map_or(0, |last| last + 1);
    let mut bytes = Vec::with_capacity(end / 4 * 3 + 2);
    let mut bits = 0u32;
    let mut count = 0;
    for &c in &text[..end] {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return Err(format!("base64 data with the character {:?}", char::from(c))),
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    if count == 6 { Err("base64 data that ends within a byte".into()) } else { Ok(bytes) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn data_uris_are_decoded() {
        for (uri, bytes) in [
            ("data:application/octet-stream;base64,AAEC/w==", &[0u8, 1, 2, 255][..]),
            ("data:;base64,AAEC/w", &[0, 1, 2, 255]),
            ("data:;base64,", &[]),
            ("data:,a%20b", b"a b"),
        ] {
            assert_eq!(parse(uri), Ok(Uri::Data(bytes.to_vec())), "{uri}");
        }
    }

    #[test]
    fn paths_are_percent_decoded() {
        assert_eq!(parse("Normal%20Map.png"), Ok(Uri::File("Normal Map.png".into())));
        assert_eq!(parse("a/b%C3%A4.bin"), Ok(Uri::File("a/bä.bin".into())));
    }

    #[test]
    fn what_is_neither_is_refused() {
        for (uri, what) in [
            ("http://example.org/a.bin", "neither a data URI nor a path"),
            ("file:///etc/passwd", "neither a data URI nor a path"),
            ("/etc/passwd", "neither a data URI nor a path"),
            ("%2Fetc/passwd", "names no file"),
            ("a%0", "hexadecimal"),
            ("a%zz", "hexadecimal"),
            ("%ff%fe", "not UTF-8"),
            ("", "names no file"),
            ("a%00b", "names no file"),
            ("data:text", "without a comma"),
            ("data:;base64,A", "ends within a byte"),
            ("data:;base64,AA*A", "'*'"),
        ] {
            let error = parse(uri).unwrap_err();
            assert!(error.contains(what), "{uri}: {error}");
        }
    }
}
