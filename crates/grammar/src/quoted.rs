//! Values in double quotes: location, decoding and encoding.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The operators of expressions.
pub const OPERATORS: [&str; 4] = [" + ", " - ", " * ", " @ "];

/// A syntax error in a quoted value.
pub(crate) struct Mistake {
    /// Byte offset within the value.
    pub(crate) at: usize,
    /// The error and the valid form.
    pub(crate) what: String,
}

/// Returns the first occurrence of any of `patterns` outside quotes: its position and the pattern.
#[must_use]
pub fn find_outside<'p>(text: &str, patterns: &[&'p str]) -> Option<(usize, &'p str)> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        if let Some(found) = patterns.iter().find(|p| bytes[at..].starts_with(p.as_bytes())) {
            return Some((at, found));
        }
        // A quote opens a value only at its start.
        let opens = bytes[at] == b'"' && at > 0 && matches!(bytes[at - 1], b':' | b'=');
        at = if opens { quote_end(bytes, at) } else { at + 1 };
    }
    None
}

/// Returns the pieces between separators outside quotes.
#[must_use]
pub fn split_outside<'t>(text: &'t str, separator: &str) -> Vec<&'t str> {
    split_ranges(text, &[separator]).into_iter().map(|range| &text[range]).collect()
}

/// Returns the ranges between separators outside quotes.
fn split_ranges(text: &str, separators: &[&str]) -> Vec<Range<usize>> {
    let (mut ranges, mut start) = (Vec::new(), 0);
    while let Some((at, separator)) = find_outside(&text[start..], separators) {
        ranges.push(start..start + at);
        start += at + separator.len();
    }
    ranges.push(start..text.len());
    ranges
}

/// Returns the end of a quoted value that starts at `start`: after its closing quote, or at the end
/// of the text.
fn quote_end(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return at + 1,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    bytes.len()
}

/// Returns the nonempty items of a specification.
pub(crate) fn items(text: &str) -> Vec<Range<usize>> {
    // The colon is kept, because a quote after it opens a value.
    let Some(colon) = text.find(':') else {
        return Vec::new();
    };
    let mut ranges = split_ranges(&text[colon..], &[","]);
    ranges[0].start += 1;
    let ranges = ranges.into_iter().filter(|range| !range.is_empty());
    ranges.map(|range| colon + range.start..colon + range.end).collect()
}

/// Returns key and value of an item; `None` for a bare value.
pub(crate) fn split_key(item: &str) -> Option<(&str, &str)> {
    // A path may contain an equals sign; a key contains neither slashes nor dots.
    let is_key = |key: &str| key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
    item.split_once('=').filter(|(key, _)| is_key(key))
}

/// Returns the bytes that a value represents.
pub(crate) fn unquote(value: &str) -> Result<Vec<u8>, Mistake> {
    let Some(inner) = value.strip_prefix('"') else {
        return Ok(value.as_bytes().to_vec());
    };
    let (mut bytes, mut rest) = (Vec::new(), inner);
    while let Some(at) = rest.find(['"', '\\']) {
        bytes.extend_from_slice(&rest.as_bytes()[..at]);
        let place = value.len() - rest.len() + at;
        let tail = &rest[at + 1..];
        if rest.as_bytes()[at] == b'"' {
            return if tail.is_empty() {
                Ok(bytes)
            } else {
                let what = "expected a comma or the end behind the closing quote".to_owned();
                Err(Mistake { at: place + 1, what })
            };
        }
        let escape = match tail.as_bytes() {
            [byte @ (b'"' | b'\\'), ..] => Some((*byte, 1)),
            [b'x', ..] => hexadecimal(tail).map(|byte| (byte, 3)),
            _ => None,
        };
        let Some((byte, length)) = escape else {
            let escape: String = tail.chars().take(1).collect();
            let what = format!(
                "unknown escape \"\\{escape}\"; valid in quotes: \\\" \\\\ and \\xHH for a byte"
            );
            return Err(Mistake { at: place, what });
        };
        bytes.push(byte);
        rest = &tail[length..];
    }
    Err(Mistake { at: 0, what: "the quote is not closed".to_owned() })
}

/// Returns the byte of `xHH`.
fn hexadecimal(text: &str) -> Option<u8> {
    let digits = text.get(1..3)?;
    let valid = digits.bytes().all(|b| b.is_ascii_hexdigit());
    u8::from_str_radix(digits, 16).ok().filter(|_| valid)
}

/// Returns a value in the form that the grammar parses: in quotes if it is empty or contains a
/// delimiter such as a comma.
#[must_use]
pub fn quote(value: &str) -> String {
    let is_plain = !value.is_empty()
        && !value.starts_with('"')
        && !value.contains(',')
        && value.trim() == value
        && !OPERATORS.iter().any(|operator| value.contains(operator))
        && split_key(value).is_none();
    if is_plain { value.to_owned() } else { quoted(value.as_bytes()) }
}

/// Returns a value of any bytes in quotes.
fn quoted(bytes: &[u8]) -> String {
    let mut text = "\"".to_owned();
    for chunk in bytes.utf8_chunks() {
        for character in chunk.valid().chars() {
            if matches!(character, '"' | '\\') {
                text.push('\\');
            }
            text.push(character);
        }
        chunk.invalid().iter().for_each(|byte| text.push_str(&format!("\\x{byte:02x}")));
    }
    text + "\""
}

/// Returns a file name in the form that the grammar parses.
pub(crate) fn path_text(path: &Path) -> String {
    match path.to_str() {
        Some(text) => quote(text),
        None => quoted(path.as_os_str().as_encoded_bytes()),
    }
}

/// Returns a path of any bytes.
#[cfg(unix)]
pub(crate) fn path(bytes: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    std::ffi::OsString::from_vec(bytes).into()
}

/// Returns a path; on other platforms paths are Unicode.
#[cfg(not(unix))]
pub(crate) fn path(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// Returns an argument as text of the grammar. Values that are not UTF-8 are quoted with their
/// bytes as `\xHH`, so that the text can be parsed again.
#[must_use]
pub fn argument_text(argument: &OsStr) -> String {
    if let Some(text) = argument.to_str() {
        return text.to_owned();
    }
    // A placeholder character for each invalid byte lets the grammar locate the values.
    let (mut marked, mut foreign) = (String::new(), BTreeMap::new());
    for chunk in argument.as_encoded_bytes().utf8_chunks() {
        marked.push_str(chunk.valid());
        for &byte in chunk.invalid() {
            foreign.insert(marked.len(), byte);
            marked.push(char::REPLACEMENT_CHARACTER);
        }
    }
    let (mut text, mut done) = (String::new(), 0);
    for term in split_ranges(&marked, &OPERATORS) {
        for item in items(&marked[term.clone()]) {
            let item = term.start + item.start..term.start + item.end;
            let value =
                split_key(&marked[item.clone()]).map_or(item.len(), |(_, value)| value.len());
            let value = item.end - value..item.end;
            if foreign.range(value.clone()).next().is_none() {
                continue;
            }
            text.push_str(&marked[done..value.start]);
            let quoted = marked[value.clone()].starts_with('"');
            text.push_str(if quoted { "" } else { "\"" });
            for (at, character) in marked[value.clone()].char_indices() {
                match (foreign.get(&(value.start + at)), character) {
                    (Some(byte), _) => text.push_str(&format!("\\x{byte:02x}")),
                    (None, '"' | '\\') if !quoted => text.extend(['\\', character]),
                    (None, _) => text.push(character),
                }
            }
            text.push_str(if quoted { "" } else { "\"" });
            done = value.end;
        }
    }
    text + &marked[done..]
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::ffi::OsStrExt;

    use super::{OsStr, Path, argument_text, path, path_text, unquote};

    #[test]
    fn arguments_of_any_bytes_become_text() {
        for (argument, text) in [
            (&b"cap:degrees=60"[..], "cap:degrees=60"),
            (b"env:caf\xe9.exr,channel=r", r#"env:"caf\xe9.exr",channel=r"#),
            (b"2 * env:file=\xff\"\\.exr @ 1/2", r#"2 * env:file="\xff\"\\.exr" @ 1/2"#),
            (b"env:\"a,\xe9\\\"b\" + cosine", r#"env:"a,\xe9\"b" + cosine"#),
            // Valid characters are kept.
            (b"env:\xc3\xa9\xe9", "env:\"\u{e9}\\xe9\""),
        ] {
            assert_eq!(argument_text(OsStr::from_bytes(argument)), text);
        }
    }

    #[test]
    fn file_names_survive_a_round_trip() {
        for name in [
            &b"a.csv"[..],
            b"",
            b"a,b.csv",
            b"a=b.csv",
            b"dir/a=b.csv",
            b"\"a\\.csv",
            b"a + b",
            b" a",
            b"caf\xe9.csv",
            b"\xe9,\"\\",
        ] {
            let file = Path::new(OsStr::from_bytes(name));
            let text = path_text(file);
            let read = path(unquote(&text).unwrap_or_else(|wrong| panic!("{}", wrong.what)));
            assert_eq!(read, file, "{text}");
            assert_eq!(text.starts_with('"'), !matches!(name, b"a.csv" | b"dir/a=b.csv"), "{text}");
        }
    }
}
