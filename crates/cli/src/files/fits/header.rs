//! Headers of FITS files: cards of 80 bytes with a keyword and a value.

use std::collections::HashMap;

/// Bytes of a card.
pub(super) const CARD: usize = 80;

/// The value of a keyword.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Logical(bool),
    Integer(i64),
    Real(f64),
    /// A text without its padding.
    Text(String),
}

/// The keywords of one header with their values.
///
/// Of repeated keywords, the last one counts. Commentary and cards of unknown form are omitted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Header {
    values: HashMap<String, Value>,
    /// The keyword whose text continues in the next card.
    continued: Option<String>,
}

impl Header {
    /// Adds a card; returns whether it is the last one of the header.
    pub(super) fn push(&mut self, card: &[u8]) -> bool {
        let text = String::from_utf8_lossy(card);
        let keyword: String = text.chars().take(8).collect();
        let rest: String = text.chars().skip(8).collect();
        let keyword = keyword.trim_end();
        if keyword == "CONTINUE" {
            self.continue_text(&rest);
            return false;
        }
        self.continued = None;
        if keyword == "END" {
            return rest.trim().is_empty();
        }
        if let Some(value) = rest.strip_prefix("= ").and_then(parse) {
            if matches!(&value, Value::Text(text) if text.ends_with('&')) {
                self.continued = Some(keyword.to_owned());
            }
            self.values.insert(keyword.to_owned(), value);
        }
        false
    }

    /// Appends the text of a card CONTINUE.
    fn continue_text(&mut self, rest: &str) {
        let Some(keyword) = self.continued.take() else { return };
        if let (Some(Value::Text(text)), Some(Value::Text(more))) =
            (self.values.get_mut(&keyword), parse(rest))
        {
            text.pop();
            text.push_str(&more);
            if text.ends_with('&') {
                self.continued = Some(keyword);
            }
        }
    }

    /// Returns the value of a keyword.
    pub(crate) fn get(&self, keyword: &str) -> Option<&Value> {
        self.values.get(keyword)
    }

    /// Returns the text of a keyword, or `None` if its value has another type.
    pub(crate) fn text(&self, keyword: &str) -> Option<&str> {
        match self.get(keyword) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// Returns the integer of a keyword, or `None` if its value has another type.
    pub(crate) fn integer(&self, keyword: &str) -> Option<i64> {
        match self.get(keyword) {
            Some(&Value::Integer(value)) => Some(value),
            // Some programs write counts as 3.0.
            #[expect(clippy::cast_possible_truncation, reason = "a whole number below 2^53")]
            Some(&Value::Real(x)) if x.fract() == 0.0 && x.abs() < 9e15 => Some(x as i64),
            _ => None,
        }
    }

    /// Returns the number of a keyword, or `None` if its value has another type.
    pub(crate) fn number(&self, keyword: &str) -> Option<f64> {
        match self.get(keyword) {
            Some(&Value::Integer(value)) => Some(value as f64),
            Some(&Value::Real(value)) => Some(value),
            _ => None,
        }
    }

    /// Returns the logical value of a keyword, or `None` if its value has another type.
    pub(crate) fn logical(&self, keyword: &str) -> Option<bool> {
        match self.get(keyword) {
            Some(&Value::Logical(value)) => Some(value),
            _ => None,
        }
    }
}

/// Returns the value at the start of a text, before its comment.
fn parse(text: &str) -> Option<Value> {
    let text = text.trim_start();
    if let Some(quoted) = text.strip_prefix('\'') {
        let mut value = String::new();
        let mut characters = quoted.chars().peekable();
        while let Some(c) = characters.next() {
            if c == '\'' && characters.next_if_eq(&'\'').is_none() {
                return Some(Value::Text(value.trim_end().to_owned()));
            }
            value.push(c);
        }
        return None;
    }
    match text.split('/').next().unwrap_or_default().trim() {
        "T" => Some(Value::Logical(true)),
        "F" => Some(Value::Logical(false)),
        number => match number.parse() {
            Ok(integer) => Some(Value::Integer(integer)),
            // Fortran writes 1.5D3.
            Err(_) => number.replace(['D', 'd'], "E").parse().ok().map(Value::Real),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::{Header, Value};

    fn header(cards: &[&str]) -> Header {
        let mut header = Header::default();
        for card in cards {
            assert_eq!(header.push(format!("{card:<80}").as_bytes()), *card == "END", "{card}");
        }
        header
    }

    #[test]
    fn values_of_every_form() {
        let header = header(&[
            "SIMPLE  =                    T / conforms",
            "NAXIS   =                   -2",
            "TZERO1  =        9.2233720D+18 / with a D",
            "TTYPE1  = 'RA''s   '           / it''s quoted",
            "EMPTY   = '        '",
            "COMMENT = 'no value'",
            "LONG    = 'one &'",
            "CONTINUE  'two &'",
            "CONTINUE  'three' / with a comment",
            "OPEN    = 'no end",
            "BLANK   =",
            "ROUND   =                  3.0",
            "TWICE   = 1",
            "TWICE   = 2",
            "ENDING  = F",
            "END",
        ]);
        assert_eq!(header.logical("SIMPLE"), Some(true));
        assert_eq!(header.logical("ENDING"), Some(false));
        assert_eq!(header.integer("NAXIS"), Some(-2));
        assert_eq!(header.get("TZERO1"), Some(&Value::Real(9.2233720e18)));
        assert_eq!(header.text("TTYPE1"), Some("RA's"));
        assert_eq!(header.text("EMPTY"), Some(""));
        assert_eq!(header.text("LONG"), Some("one two three"));
        assert_eq!((header.get("OPEN"), header.get("BLANK")), (None, None));
        assert_eq!((header.integer("ROUND"), header.integer("TWICE")), (Some(3), Some(2)));
        assert_eq!((header.number("NAXIS"), header.number("TTYPE1")), (Some(-2.0), None));
    }
}
