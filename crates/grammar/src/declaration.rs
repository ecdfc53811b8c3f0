use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::{Choice, DefaultValue, Error, Parameter, ParameterKind, Range, Spec, Value};

/// A type with one declaration from which its parameters are parsed, displayed and listed.
pub trait Parametric {
    /// Declares every parameter, in the order of the text form.
    ///
    /// Later declarations may depend on earlier parameters, for example if a file replaces numbers.
    /// By default there are no parameters.
    fn declare(&mut self, _declaration: &mut Declaration<'_>) {}
}

/// The operation applied to parameters as they are declared: parsing from a text, or description.
#[derive(Debug)]
pub struct Declaration<'a> {
    /// The source of values; `None` to describe.
    spec: Option<&'a mut Spec>,
    declared: Vec<Declared>,
    /// The first parse error.
    error: Option<Error>,
}

/// A parameter with its current value.
#[derive(Debug)]
pub(crate) struct Declared {
    pub(crate) name: &'static str,
    pub(crate) kind: ParameterKind,
    pub(crate) summary: &'static str,
    /// The meaning of a missing value; `None` if it is required.
    default: Option<&'static str>,
    pub(crate) value: Option<Value>,
}

impl Declared {
    pub(crate) fn is_required(&self) -> bool {
        self.default.is_none()
    }

    pub(crate) fn parameter(self) -> Parameter {
        let default = match (self.default, self.value) {
            (None, _) => DefaultValue::Required,
            (_, Some(value)) => DefaultValue::Value(value),
            (Some(words), None) => DefaultValue::Depends(words),
        };
        Parameter { name: self.name, kind: self.kind, default, summary: self.summary }
    }
}

impl<'a> Declaration<'a> {
    /// Sets the parameters that `spec` gives, and returns all.
    pub(crate) fn read(
        parametric: &mut dyn Parametric,
        spec: &'a mut Spec,
    ) -> Result<Vec<Declared>, Error> {
        let mut declaration = Self { spec: Some(spec), declared: Vec::new(), error: None };
        parametric.declare(&mut declaration);
        match declaration.error {
            Some(error) => Err(error),
            None => Ok(declaration.declared),
        }
    }

    /// Returns all parameters.
    pub(crate) fn describe(parametric: &mut dyn Parametric) -> Vec<Declared> {
        let mut declaration = Self { spec: None, declared: Vec::new(), error: None };
        parametric.declare(&mut declaration);
        declaration.declared
    }

    /// Declares a number that has a default.
    pub fn number(
        &mut self,
        name: &'static str,
        range: Range,
        summary: &'static str,
        value: &mut f64,
    ) {
        self.read_number(name, range, |given| *value = given);
        self.declare_number(name, range, summary, Some(""), Some(*value));
    }

    /// Declares a number whose default depends on something else; `default` describes it, such as
    /// "by N".
    pub fn optional_number(
        &mut self,
        name: &'static str,
        range: Range,
        summary: &'static str,
        default: &'static str,
        value: &mut Option<f64>,
    ) {
        self.read_number(name, range, |given| *value = Some(given));
        self.declare_number(name, range, summary, Some(default), *value);
    }

    /// Declares a required number; its initial value is an example.
    pub fn required_number(
        &mut self,
        name: &'static str,
        range: Range,
        summary: &'static str,
        value: &mut f64,
    ) {
        if !self.read_number(name, range, |given| *value = given) {
            self.require(name);
        }
        self.declare_number(name, range, summary, None, Some(*value));
    }

    /// Declares an integer that has a default, valid from `min` to `max`.
    pub fn integer<T: Copy + TryFrom<i64> + TryInto<i64>>(
        &mut self,
        name: &'static str,
        [min, max]: [i64; 2],
        summary: &'static str,
        value: &mut T,
    ) {
        self.read_integer(name, [min, max], |given| *value = given);
        self.declare_integer(name, [min, max], summary, Some(""), Some(*value));
    }

    /// Declares an integer whose default depends on something else; `default` describes it, such as
    /// "by N".
    pub fn optional_integer<T: Copy + TryFrom<i64> + TryInto<i64>>(
        &mut self,
        name: &'static str,
        [min, max]: [i64; 2],
        summary: &'static str,
        default: &'static str,
        value: &mut Option<T>,
    ) {
        self.read_integer(name, [min, max], |given| *value = Some(given));
        self.declare_integer(name, [min, max], summary, Some(default), *value);
    }

    /// Declares a required integer; its initial value is an example.
    pub fn required_integer<T: Copy + TryFrom<i64> + TryInto<i64>>(
        &mut self,
        name: &'static str,
        [min, max]: [i64; 2],
        summary: &'static str,
        value: &mut T,
    ) {
        if !self.read_integer(name, [min, max], |given| *value = given) {
            self.require(name);
        }
        self.declare_integer(name, [min, max], summary, None, Some(*value));
    }

    /// Declares a choice among names.
    pub fn choice<T: Choice>(&mut self, name: &'static str, summary: &'static str, value: &mut T) {
        if let Some(spec) = &mut self.spec
            && let Err(error) = spec.replace_choice(name, T::CHOICES, value)
        {
            self.error.get_or_insert(error);
        }
        self.declare_choice(name, summary, "", Some(*value));
    }

    /// Declares an optional choice among names; `default` describes the meaning of its absence.
    pub fn optional_choice<T: Choice>(
        &mut self,
        name: &'static str,
        summary: &'static str,
        default: &'static str,
        value: &mut Option<T>,
    ) {
        if let Some(spec) = &mut self.spec {
            let mut given = None;
            let choices: Vec<_> =
                T::CHOICES.iter().map(|&(name, choice)| (name, Some(choice))).collect();
            match spec.replace_choice(name, &choices, &mut given) {
                Ok(()) => *value = given.or(*value),
                Err(error) => _ = self.error.get_or_insert(error),
            }
        }
        self.declare_choice(name, summary, default, *value);
    }

    /// Declares an arbitrary text; `default` describes the meaning of its absence.
    pub fn word(
        &mut self,
        name: &'static str,
        summary: &'static str,
        default: &'static str,
        value: &mut Option<String>,
    ) {
        if let Some(given) = self.spec.as_mut().and_then(|spec| spec.take(name)) {
            *value = Some(given);
        }
        let value = value.clone().map(Value::Word);
        self.push(name, ParameterKind::Word, summary, Some(default), value);
    }

    /// Declares a required text of another grammar, in quotes where it contains commas or operators;
    /// `what` names what it must be, such as "an integrand". Its initial value is an example.
    pub fn required_text<T: FromStr<Err: fmt::Display> + fmt::Display>(
        &mut self,
        name: &'static str,
        what: &'static str,
        summary: &'static str,
        value: &mut T,
    ) {
        if let Some(spec) = &mut self.spec {
            match spec.take(name).map(|given| given.parse()) {
                Some(Ok(given)) => *value = given,
                Some(Err(reason)) => {
                    let (text, key, reason) = (spec.text.clone(), name, reason.to_string());
                    self.error.get_or_insert(Error::OfText { text, key, reason });
                }
                None => self.require(name),
            }
        }
        let value = Some(Value::Word(value.to_string()));
        self.push(name, ParameterKind::Text(what), summary, None, value);
    }

    /// Declares a file, given by the first bare value or by its key; `default` describes the
    /// meaning of its absence.
    pub fn file(
        &mut self,
        name: &'static str,
        summary: &'static str,
        default: &'static str,
        value: &mut Option<PathBuf>,
    ) {
        if let Some(given) = self.read_file(name) {
            *value = Some(given);
        }
        let value = value.clone().map(Value::File);
        self.push(name, ParameterKind::File, summary, Some(default), value);
    }

    /// Declares a required file.
    pub fn required_file(
        &mut self,
        name: &'static str,
        summary: &'static str,
        value: &mut PathBuf,
    ) {
        match (self.read_file(name), &self.spec) {
            (Some(given), _) => *value = given,
            (None, Some(spec)) => {
                let (text, name) = (spec.text.clone(), spec.name.clone());
                self.error.get_or_insert(Error::NoFile { text, name });
            }
            (None, None) => (),
        }
        let value = Some(Value::File(value.clone()));
        self.push(name, ParameterKind::File, summary, None, value);
    }

    /// Declares the required name of something that the program has, given by the first bare value or
    /// by its key. Its initial value is an example.
    pub fn required_name(&mut self, name: &'static str, summary: &'static str, value: &mut String) {
        if let Some(spec) = &mut self.spec {
            match spec.take("").or_else(|| spec.take(name)) {
                Some(given) => *value = given,
                None => self.require(name),
            }
        }
        self.push(name, ParameterKind::Name, summary, None, Some(Value::Word(value.clone())));
    }

    fn read_file(&mut self, name: &str) -> Option<PathBuf> {
        let spec = self.spec.as_mut()?;
        spec.take_path("").or_else(|| spec.take_path(name))
    }

    /// Sets a number if it is given, and returns whether it is.
    fn read_number(&mut self, name: &'static str, range: Range, set: impl FnOnce(f64)) -> bool {
        let Some(spec) = &mut self.spec else { return true };
        match spec.take_number(name) {
            Ok(None) => return false,
            Ok(Some(given)) if range.contains(given) => set(given),
            Ok(Some(given)) => {
                let (text, got) = (spec.text.clone(), given.to_string());
                let kind = ParameterKind::Number(range);
                self.error.get_or_insert(Error::OutOfRange { text, key: name, kind, got });
            }
            Err(error) => {
                self.error.get_or_insert(error);
            }
        }
        true
    }

    /// Sets an integer if it is given, and returns whether it is.
    fn read_integer<T: TryFrom<i64>>(
        &mut self,
        name: &'static str,
        [min, max]: [i64; 2],
        set: impl FnOnce(T),
    ) -> bool {
        let Some(spec) = &mut self.spec else { return true };
        let Some(given) = spec.take(name) else { return false };
        let valid = given.parse().ok().filter(|given| (min..=max).contains(given));
        match valid.and_then(|given| T::try_from(given).ok()) {
            Some(given) => set(given),
            None if given.parse::<f64>().is_err() => {
                let error = spec.not_a_number(name, given);
                self.error.get_or_insert(error);
            }
            None => {
                let (text, kind) = (spec.text.clone(), ParameterKind::Integer { min, max });
                // The range of a parameter without an upper limit is that of the type.
                let is_beyond = given.parse::<f64>().is_ok_and(|given| given > max as f64);
                let got = match is_beyond && max == i64::MAX {
                    true => format!("{given}, beyond the largest integer, {max}"),
                    false => given,
                };
                self.error.get_or_insert(Error::OutOfRange { text, key: name, kind, got });
            }
        }
        true
    }

    fn require(&mut self, name: &str) {
        if let Some(spec) = &self.spec {
            let (text, key) = (spec.text.clone(), name.to_owned());
            self.error.get_or_insert(Error::Missing { text, key });
        }
    }

    fn declare_choice<T: Choice>(
        &mut self,
        name: &'static str,
        summary: &'static str,
        default: &'static str,
        value: Option<T>,
    ) {
        let kind = ParameterKind::Choice(T::CHOICES.iter().map(|(name, _)| *name).collect());
        let named = T::CHOICES.iter().find(|(_, choice)| Some(*choice) == value);
        let value = named.map(|(name, _)| Value::Choice(name));
        self.push(name, kind, summary, Some(default), value);
    }

    fn declare_number(
        &mut self,
        name: &'static str,
        range: Range,
        summary: &'static str,
        default: Option<&'static str>,
        value: Option<f64>,
    ) {
        let kind = ParameterKind::Number(range);
        self.push(name, kind, summary, default, value.map(Value::Number));
    }

    fn declare_integer<T: TryInto<i64>>(
        &mut self,
        name: &'static str,
        [min, max]: [i64; 2],
        summary: &'static str,
        default: Option<&'static str>,
        value: Option<T>,
    ) {
        let kind = ParameterKind::Integer { min, max };
        let value = value.and_then(|value| value.try_into().ok()).map(Value::Integer);
        self.push(name, kind, summary, default, value);
    }

    fn push(
        &mut self,
        name: &'static str,
        kind: ParameterKind,
        summary: &'static str,
        default: Option<&'static str>,
        value: Option<Value>,
    ) {
        self.declared.push(Declared { name, kind, summary, default, value });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{describe, form, read, text};

    #[derive(Debug, Default, PartialEq)]
    struct Design {
        degree: Option<u32>,
    }

    impl Parametric for Design {
        fn declare(&mut self, d: &mut Declaration<'_>) {
            d.optional_integer("t", [1, 9], "degree", "by N", &mut self.degree);
        }
    }

    #[test]
    fn an_optional_integer_has_a_described_default() {
        let mut design = Design::default();
        assert_eq!(describe(&mut design)[0].default, DefaultValue::Depends("by N"));
        assert_eq!(form("design", &mut design), "design[:t=NUMBER]");
        assert_eq!(text("design", &mut design, &mut Design::default()), "design");
        read(&mut design, Spec::parse("design").unwrap()).unwrap();
        assert_eq!(design.degree, None);
        read(&mut design, Spec::parse("design:t=7").unwrap()).unwrap();
        assert_eq!(design.degree, Some(7));
        assert_eq!(text("design", &mut design, &mut Design::default()), "design:t=7");
        for wrong in ["0", "10", "2.5", "many"] {
            let spec = Spec::parse(&format!("design:t={wrong}")).unwrap();
            assert!(read(&mut design, spec).is_err(), "{wrong}");
        }
        assert_eq!(design.degree, Some(7));
    }
}
