use std::path::PathBuf;
use std::str::FromStr;

use crate::Error;
use crate::quoted::{self, OPERATORS, find_outside, split_outside};

/// A parsed name with its parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spec {
    /// The whole text, for messages and tables.
    pub text: String,
    /// The name before the colon.
    pub name: String,
    /// Parameters that have not been taken yet; a bare value has the key "". Values are bytes,
    /// since names of files need not be UTF-8.
    items: Vec<(String, Vec<u8>)>,
}

impl Spec {
    /// Parses one specification.
    ///
    /// # Errors
    ///
    /// [`Error`] for a missing name, items after the first that are not `key=value`, duplicate keys
    /// and malformed quotes.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let name = text.split(':').next().unwrap_or_default();
        if name.is_empty() {
            return Err(Error::NoName { text: text.to_owned() });
        }
        let mut items: Vec<(String, Vec<u8>)> = Vec::new();
        for (i, range) in quoted::items(text).into_iter().enumerate() {
            let item = &text[range.clone()];
            let (key, value) = match quoted::split_key(item) {
                Some((key, value)) => (key, value),
                None if i == 0 => ("", item),
                None => {
                    let (text, item) = (text.to_owned(), item.to_owned());
                    return Err(Error::NotKeyValue { text, item });
                }
            };
            if items.iter().any(|(k, _)| k == key) {
                return Err(Error::Repeated { text: text.to_owned(), key: key.to_owned() });
            }
            let start = range.end - value.len();
            let value = quoted::unquote(value).map_err(|wrong| {
                let character = text[..start + wrong.at].chars().count() + 1;
                Error::Quoting { text: text.to_owned(), character, reason: wrong.what }
            })?;
            items.push((key.to_owned(), value));
        }
        Ok(Self { text: text.to_owned(), name: name.to_owned(), items })
    }

    /// Parses a list of specifications separated by commas. A piece of the form `key=value` belongs
    /// to the preceding specification, as in `poisson-disk:radius=2,mode=exact,jittered`.
    ///
    /// # Errors
    ///
    /// Those of [`Self::parse`].
    pub fn parse_list(text: &str) -> Result<Vec<Self>, Error> {
        let mut specs: Vec<String> = Vec::new();
        for piece in split_outside(text, ",").into_iter().map(str::trim) {
            match specs.last_mut() {
                Some(last) if quoted::split_key(piece).is_some() => {
                    last.push(',');
                    last.push_str(piece);
                }
                _ => specs.push(piece.to_owned()),
            }
        }
        specs.iter().map(|s| Self::parse(s)).collect()
    }

    /// Takes the text of a parameter, or the bare value with the key "".
    pub fn take(&mut self, key: &str) -> Option<String> {
        Some(String::from_utf8_lossy(&self.take_bytes(key)?).into_owned())
    }

    /// Returns whether a parameter that has not been taken contains an operator of expressions.
    pub fn has_operator_left(&self) -> bool {
        self.items
            .iter()
            .any(|(_, value)| find_outside(&String::from_utf8_lossy(value), &OPERATORS).is_some())
    }

    fn take_bytes(&mut self, key: &str) -> Option<Vec<u8>> {
        let at = self.items.iter().position(|(k, _)| k == key)?;
        Some(self.items.remove(at).1)
    }

    /// Takes the path of a parameter, or of the bare value with the key "".
    pub fn take_path(&mut self, key: &str) -> Option<PathBuf> {
        self.take_bytes(key).map(quoted::path)
    }

    /// Takes a parameter as a number.
    ///
    /// # Errors
    ///
    /// [`Error::NotANumber`].
    pub fn take_number<T: FromStr>(&mut self, key: &str) -> Result<Option<T>, Error> {
        let Some(value) = self.take(key) else {
            return Ok(None);
        };
        value.parse().map(Some).map_err(|_| self.not_a_number(key, value))
    }

    /// Takes a parameter as a number and assigns it to `value`, if it is present.
    ///
    /// # Errors
    ///
    /// [`Error::NotANumber`].
    pub fn replace_number<T: FromStr>(&mut self, key: &str, value: &mut T) -> Result<(), Error> {
        if let Some(given) = self.take_number(key)? {
            *value = given;
        }
        Ok(())
    }

    /// Takes a parameter as one of a list of names and assigns its value to `value`, if it is
    /// present.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownName`].
    pub fn replace_choice<T: Copy>(
        &mut self,
        key: &str,
        choices: &[(&str, T)],
        value: &mut T,
    ) -> Result<(), Error> {
        if let Some(given) = self.take(key) {
            let found = choices.iter().find(|(name, _)| *name == given);
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            let what = || format!("{key} of {}", self.name);
            *value = found.ok_or_else(|| Error::unknown_name(what(), &given, &names))?.1;
        }
        Ok(())
    }

    /// Takes a required parameter.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`] or [`Error::NotANumber`].
    pub fn require_number<T: FromStr>(&mut self, key: &str) -> Result<T, Error> {
        let text = self.text.clone();
        self.take_number(key)?.ok_or_else(|| Error::Missing { text, key: key.to_owned() })
    }

    /// Rejects a parameter that has not been taken; `known` are the valid keys, for the message.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownParameter`] or [`Error::UnexpectedValue`].
    pub fn finish(self, known: &[&str]) -> Result<(), Error> {
        let Some((key, value)) = self.items.into_iter().next() else {
            return Ok(());
        };
        let (text, valid) = (self.text, known.iter().map(|&known| known.to_owned()).collect());
        Err(if key.is_empty() {
            let value = String::from_utf8_lossy(&value).into_owned();
            Error::UnexpectedValue { text, value, valid }
        } else {
            Error::UnknownParameter { text, key, valid }
        })
    }

    pub(crate) fn not_a_number(&self, key: &str, got: String) -> Error {
        Error::NotANumber { text: self.text.clone(), key: key.to_owned(), got }
    }
}

#[cfg(test)]
mod tests {
    use super::{Error, Spec};

    #[test]
    fn names_and_parameters_are_distinguished() {
        let mut spec = Spec::parse("ylm:l=4,m=-2").unwrap();
        assert_eq!(spec.name, "ylm");
        assert_eq!(spec.require_number::<usize>("l").unwrap(), 4);
        assert_eq!(spec.take_number::<i64>("m").unwrap(), Some(-2));
        spec.finish(&["l", "m"]).unwrap();
        let mut spec = Spec::parse("env:data/a=b.exr,channel=r").unwrap();
        assert_eq!(spec.take("").as_deref(), Some("data/a=b.exr"));
        let mut spec = Spec::parse("env:data/city.exr,channel=r").unwrap();
        assert_eq!(spec.take("").as_deref(), Some("data/city.exr"));
    }

    #[test]
    fn quoted_values_hold_separators_and_bytes() {
        for (text, key, value) in [
            (r#"env:"a,b.exr""#, "", &b"a,b.exr"[..]),
            (r#"env:file="a,b=c + d.exr",channel=r"#, "file", b"a,b=c + d.exr"),
            (r#"map:field=2,file="x=1.fits""#, "file", b"x=1.fits"),
            (r#"env:"a\\\"b\xff\x2c.exr""#, "", b"a\\\"b\xff,.exr"),
            (r#"env:"""#, "", b""),
            // A quote opens a value only at its start.
            (r#"env:a"b.exr"#, "", b"a\"b.exr"),
            (r#"env:C:\x.exr"#, "", b"C:\\x.exr"),
        ] {
            let mut spec = Spec::parse(text).unwrap();
            assert_eq!(spec.take_bytes(key).as_deref(), Some(value), "{text}");
        }
        let specs = Spec::parse_list(r#"a:f="x,y",b=2,c"#).unwrap();
        let texts: Vec<_> = specs.iter().map(|s| s.text.as_str()).collect();
        assert_eq!(texts, [r#"a:f="x,y",b=2"#, "c"]);
    }

    #[test]
    fn errors_in_quotes_are_located() {
        for (text, parts) in [
            (r#"env:"a,b.exr"#, ["character 5", "not closed"]),
            (r#"env:"a"b"#, ["character 8", "expected a comma"]),
            (r#"env:"a\q""#, ["character 7", r#"\q"#]),
            (r#"env:channel=r,file="\x4g""#, ["character 21", r#"\x"#]),
            (r#"env:"\"#, ["character 6", "escape"]),
        ] {
            let message = Spec::parse(text).unwrap_err().to_string();
            for part in parts {
                assert!(message.contains(part), "{text}: {message}");
            }
        }
    }

    #[test]
    fn lists_keep_parameters_with_their_name() {
        let specs = Spec::parse_list("a,b:x=1,y=2,c,d:q").unwrap();
        let texts: Vec<_> = specs.iter().map(|s| s.text.as_str()).collect();
        assert_eq!(texts, ["a", "b:x=1,y=2", "c", "d:q"]);
    }

    #[test]
    fn errors_name_the_text() {
        for (text, part) in
            [(":l=4", "no name"), ("a:b,c", "not key=value"), ("a:x=1,x=2", "twice")]
        {
            let message = Spec::parse(text).unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
        let left = Spec::parse("a:x=1").unwrap().finish(&["y"]).unwrap_err().to_string();
        assert_eq!(left, "a:x=1: unknown parameter \"x\"; valid: y");
        let bare = Spec::parse("a:1").unwrap().finish(&[]).unwrap_err().to_string();
        assert_eq!(bare, "a:1: unexpected value \"1\"; valid parameters: none");
        let near = Error::unknown_name("mode", "rotatd", &["fixed", "rotated"]).to_string();
        let expected = "unknown mode \"rotatd\" (did you mean \"rotated\"?); valid: fixed, rotated";
        assert_eq!(near, expected);
        let far = Error::unknown_name("sampler", "zzz", &["jittered", "healpix"]).to_string();
        assert_eq!(far, "unknown sampler \"zzz\"; valid: jittered, healpix");
    }
}
