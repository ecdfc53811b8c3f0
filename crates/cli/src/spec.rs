//! The one grammar for samplers, integrands and profiles: `name` or `name:item,item`, where an item
//! is `key=value` or, first of all, a bare value.

use crate::error::CliError;

/// A name with its parameters, as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Spec {
    /// The whole text, for messages and tables.
    pub(crate) text: String,
    /// What is in front of the colon.
    pub(crate) name: String,
    /// Parameters that have not been taken yet; a bare value has the key "".
    items: Vec<(String, String)>,
}

impl Spec {
    /// Reads one specification.
    pub(crate) fn parse(text: &str) -> Result<Self, CliError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        if name.is_empty() {
            return Err(CliError::Usage(format!("\"{text}\" has no name in front of the colon")));
        }
        let mut items: Vec<(String, String)> = Vec::new();
        for (i, item) in rest.split(',').filter(|item| !item.is_empty()).enumerate() {
            let is_key = |key: &str| key.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
            // A path may contain an equals sign; a key contains neither slashes nor dots.
            let (key, value) = match item.split_once('=').filter(|(key, _)| is_key(key)) {
                Some((key, value)) => (key, value),
                None if i == 0 => ("", item),
                None => {
                    return Err(CliError::Usage(format!("{text}: \"{item}\" is not key=value")));
                }
            };
            if items.iter().any(|(k, _)| k == key) {
                return Err(CliError::Usage(format!("{text}: {key} is given twice")));
            }
            items.push((key.to_owned(), value.to_owned()));
        }
        Ok(Self { text: text.to_owned(), name: name.to_owned(), items })
    }

    /// Reads a list of specifications separated by commas. A piece that is `key=value` belongs to the
    /// specification before it, as in `poisson-disk:radius=2,mode=exact,jittered`.
    pub(crate) fn parse_list(text: &str) -> Result<Vec<Self>, CliError> {
        let mut specs: Vec<String> = Vec::new();
        for piece in text.split(',').map(str::trim) {
            match specs.last_mut() {
                Some(last) if piece.contains('=') && !piece.contains(':') => {
                    last.push(',');
                    last.push_str(piece);
                }
                _ => specs.push(piece.to_owned()),
            }
        }
        specs.iter().map(|s| Self::parse(s)).collect()
    }

    /// Takes the text of a parameter, or the bare value with the key "".
    pub(crate) fn take(&mut self, key: &str) -> Option<String> {
        let at = self.items.iter().position(|(k, _)| k == key)?;
        Some(self.items.remove(at).1)
    }

    /// Takes a parameter as a number.
    pub(crate) fn take_number<T: std::str::FromStr>(
        &mut self,
        key: &str,
    ) -> Result<Option<T>, CliError> {
        let Some(value) = self.take(key) else {
            return Ok(None);
        };
        value.parse().map(Some).map_err(|_| {
            CliError::Usage(format!("{}: {key} must be a number, got \"{value}\"", self.text))
        })
    }

    /// Takes a parameter as a number in place of `value`, if it is there.
    pub(crate) fn replace_number<T: std::str::FromStr>(
        &mut self,
        key: &str,
        value: &mut T,
    ) -> Result<(), CliError> {
        if let Some(given) = self.take_number(key)? {
            *value = given;
        }
        Ok(())
    }

    /// Takes a parameter as one of some names in place of `value`, if it is there.
    pub(crate) fn replace_choice<T: Copy>(
        &mut self,
        key: &str,
        choices: &[(&str, T)],
        value: &mut T,
    ) -> Result<(), CliError> {
        if let Some(given) = self.take(key) {
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            let found = choices.iter().find(|(name, _)| *name == given);
            let what = format!("{key} of {}", self.name);
            *value = found.ok_or_else(|| unknown_name(&what, &given, &names))?.1;
        }
        Ok(())
    }

    /// Takes a parameter that must be there.
    pub(crate) fn require_number<T: std::str::FromStr>(
        &mut self,
        key: &str,
    ) -> Result<T, CliError> {
        let text = self.text.clone();
        self.take_number(key)?
            .ok_or_else(|| CliError::Usage(format!("{text}: the parameter {key} is missing")))
    }

    /// Refuses what no one has taken. `known` are the keys that there are.
    pub(crate) fn finish(self, known: &[&str]) -> Result<(), CliError> {
        let Some((key, value)) = self.items.into_iter().next() else {
            return Ok(());
        };
        let what =
            if key.is_empty() { format!("the value \"{value}\"") } else { format!("\"{key}\"") };
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Err(CliError::Usage(format!(
            "{}: {what} is no parameter here; there is: {known}",
            self.text
        )))
    }
}

/// `unknown WHAT "name"`, with the nearest of the `known` names if one is near, and all of them.
pub(crate) fn unknown_name(what: &str, name: &str, known: &[&str]) -> CliError {
    let nearest = known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(name, k), *k))
        .min()
        // Half of the letters wrong is no typing error.
        .filter(|(distance, k)| 2 * distance <= k.len().max(name.len()))
        .map_or(String::new(), |(_, k)| format!("did you mean \"{k}\"? "));
    CliError::Usage(format!("unknown {what} \"{name}\"; {nearest}There is: {}", known.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::{Spec, unknown_name};

    #[test]
    fn names_and_parameters_are_told_apart() {
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
    fn lists_keep_parameters_with_their_name() {
        let specs = Spec::parse_list("a,b:x=1,y=2,c,d:q").unwrap();
        let texts: Vec<_> = specs.iter().map(|s| s.text.as_str()).collect();
        assert_eq!(texts, ["a", "b:x=1,y=2", "c", "d:q"]);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, part) in
            [(":l=4", "no name"), ("a:b,c", "not key=value"), ("a:x=1,x=2", "twice")]
        {
            let message = Spec::parse(text).unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
        let left = Spec::parse("a:x=1").unwrap().finish(&["y"]).unwrap_err().to_string();
        assert!(left.contains("\"x\"") && left.contains('y'), "{left}");
        let near = unknown_name("sampler", "jitered", &["jittered", "healpix"]).to_string();
        assert!(near.contains("did you mean \"jittered\""), "{near}");
        let far = unknown_name("sampler", "zzz", &["jittered", "healpix"]).to_string();
        assert!(!far.contains("did you mean"), "{far}");
    }
}
