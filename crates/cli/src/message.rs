//! Messages on standard error: short and without control characters, whatever files and arguments
//! they quote.

use std::borrow::Cow;
use std::io::Write;

/// The maximum length of a word, in characters; of longer ones the two ends are shown.
const MAX_WORD: usize = 200;
/// The maximum length of a message, likewise.
const MAX_MESSAGE: usize = 1500;
/// A number with more digits than this was written out: `f64` has 17, a `u64` at most 20.
const MAX_DIGITS: usize = 24;

/// Writes a message as one line.
pub(crate) fn write(text: &str) {
    // If standard error is closed, the failure cannot be reported.
    let _ = writeln!(std::io::stderr(), "{}", clean(text));
}

/// Returns a text as one line of limited length: control characters are escaped, numbers of many
/// digits are written with an exponent, and the middle of long words and texts is omitted.
pub(crate) fn clean(text: &str) -> String {
    // Escapes lengthen a text by up to a factor of ten, so very long text is cut first.
    let bounded = without_codes(&shorten(text, 16 * MAX_MESSAGE));
    let escaped = escape(&bounded);
    let words: Vec<Cow<'_, str>> = escaped.split(' ').map(word).collect();
    shorten(&words.join(" "), MAX_MESSAGE).into_owned()
}

/// Returns a text without the numeric codes that the standard library appends to system messages.
fn without_codes(text: &str) -> String {
    const START: &str = " (os error ";
    let mut pieces = text.split(START);
    let mut short = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        match piece.split_once(')') {
            Some((code, rest)) if code.bytes().all(|b| b.is_ascii_digit()) => short += rest,
            _ => short.extend([START, piece]),
        }
    }
    short
}

/// Returns a text with control characters escaped in the notation of Rust, including those that
/// reorder a line or are not characters.
pub(crate) fn escape(text: &str) -> Cow<'_, str> {
    let is_plain = |c: char| !c.is_control() && !is_invisible(c);
    if text.chars().all(is_plain) {
        return text.into();
    }
    let mut escaped = String::new();
    for c in text.chars() {
        if is_plain(c) {
            escaped.push(c);
        } else {
            escaped.extend(c.escape_default());
        }
    }
    escaped.into()
}

/// Returns whether a character changes how others are shown: directions of writing, line
/// separators, zero widths.
fn is_invisible(c: char) -> bool {
    matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// Returns a word with its numbers shortened, and then the word itself shortened.
fn word(word: &str) -> Cow<'_, str> {
    if word.len() <= MAX_DIGITS {
        return word.into();
    }
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let mut rest = word;
    let mut short = String::new();
    while let Some(start) = rest.find(is_number) {
        short += &rest[..start];
        let number = &rest[start..];
        let end = number.find(|c| !is_number(c)).unwrap_or(number.len());
        let (digits, after) = number.split_at(end);
        match digits.parse::<f64>() {
            Ok(x) if digits.len() > MAX_DIGITS && x.is_finite() => short += &format!("{x:e}"),
            _ => short += digits,
        }
        rest = after;
    }
    short += rest;
    shorten(&short, MAX_WORD).into_owned().into()
}

/// Returns the two ends of a text of more than `max` characters.
fn shorten(text: &str, max: usize) -> Cow<'_, str> {
    let n = text.chars().count();
    if n <= max {
        return text.into();
    }
    let at = |i: usize| text.char_indices().nth(i).map_or(text.len(), |(at, _)| at);
    let (head, tail) = (max * 2 / 3, max / 3);
    format!(
        "{}[... {} characters ...]{}",
        &text[..at(head)],
        n - head - tail,
        &text[at(n - tail)..]
    )
    .into()
}

#[cfg(test)]
mod tests {
    use super::{MAX_MESSAGE, clean, escape, shorten};

    #[test]
    fn ordinary_messages_stay() {
        for text in [
            "cannot open a.csv: No such file or directory",
            "line 3: expected 3 fields, got \"1 2\"",
            "N = 18446744073709551615, 0.12345678901234567, -1.2345678901234567e-300",
            "größer als 10°, √N",
            "",
        ] {
            assert_eq!(clean(text), text);
        }
        let missing = std::io::Error::from_raw_os_error(2);
        let both = format!("a: {missing}; b: {missing}: x (os error y), z (os error");
        let clear = "a: No such file or directory; b: No such file or directory: x (os error y), z (os error";
        assert_eq!(clean(&both), clear);
    }

    #[test]
    fn no_control_character_passes() {
        let every: String = (0..0x2100).filter_map(char::from_u32).collect();
        let cleaned = clean(&every);
        assert!(!cleaned.chars().any(char::is_control), "{cleaned}");
        assert_eq!(escape("a\x1b[31m\r\n\u{202e}b"), "a\\u{1b}[31m\\r\\n\\u{202e}b");
        assert_eq!(escape("\u{9b}31m"), "\\u{9b}31m", "the control sequence introducer of 8 bits");
    }

    #[test]
    fn numbers_that_are_written_out_get_an_exponent() {
        assert_eq!(clean(&format!("got {}", 1e300)), "got 1e300");
        assert_eq!(
            clean(&format!("[{}, {}]", f64::MIN_POSITIVE, 1.0)),
            "[2.2250738585072014e-308, 1]"
        );
        assert_eq!(clean(&format!("r={}mm", -1e30)), "r=-1e30mm");
        let beyond = "9".repeat(400);
        assert!(clean(&beyond).len() < 250, "{}", clean(&beyond));
    }

    #[test]
    fn messages_are_short_whatever_they_quote() {
        for text in ["x".repeat(50_000_000), "a b ".repeat(10_000_000), "\x07".repeat(1 << 20)] {
            let cleaned =
                clean(&format!("bad.csv:1: expected 3 fields, got {text}; write numbers"));
            assert!(cleaned.chars().count() < MAX_MESSAGE + 100, "{}", cleaned.len());
            assert!(cleaned.starts_with("bad.csv:1: expected 3 fields, got "), "{cleaned}");
            assert!(cleaned.ends_with("; write numbers"), "{cleaned}");
        }
        assert_eq!(shorten("äöü", 2), "ä[... 2 characters ...]");
    }
}
