use std::fmt;
use std::str::FromStr;

use sphvar_grammar::{Parameter, Spec, describe, form, read, text};

use crate::{Error, Expression, Integrand, IntegrandResolver, Term};

impl Term {
    /// Returns the parameters with their ranges, meanings and defaults, in the order of texts.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.default_of_name().with_definition(|definition| describe(definition))
    }

    /// Returns the form of texts, such as `ylm:l=4[,m=0]`, with examples of what must be given.
    #[must_use]
    pub fn form(&self) -> String {
        let name = self.name();
        self.default_of_name().with_definition(|definition| form(name, definition))
    }

    /// Returns the function; files that the parameters name are read by `files`.
    ///
    /// # Errors
    ///
    /// [`Error::OfTerm`] with the reason if there is none with these parameters; [`Error::File`] if
    /// `files` cannot read a file.
    pub fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        let built = self.clone().with_definition(|definition| definition.build(files));
        built.map_err(|error| match error {
            Error::File(error) => Error::File(error),
            reason => Error::OfTerm { text: self.to_string(), reason: Box::new(reason) },
        })
    }

    /// Returns the integrand to which a filter is applied.
    pub(crate) fn filtered(&self) -> Option<&Expression> {
        match self {
            Self::Filtered(filtered) => Some(&filtered.of),
            _ => None,
        }
    }

    /// Returns the integrand of the same name with its default parameters.
    fn default_of_name(&self) -> Self {
        let same = Self::all().into_iter().find(|term| term.name() == self.name());
        same.unwrap_or_else(|| self.clone())
    }
}

/// Reads `name` or `name:key=value,key=value`.
impl FromStr for Term {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let spec = Spec::parse(text)?;
        let all = Self::all();
        let names: Vec<&str> = all.iter().map(Self::name).collect();
        let unknown = || sphvar_grammar::Error::unknown_name("integrand", &spec.name, &names);
        let known = all.iter().find(|term| term.name() == spec.name);
        let mut term = known.ok_or_else(unknown)?.clone();
        term.with_definition(|definition| read(definition, spec))?;
        Ok(term)
    }
}

/// The name, and after a colon the parameters that must be given or are not the default ones.
impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut default = self.default_of_name();
        let text = self.clone().with_definition(|definition| {
            default.with_definition(|default| text(self.name(), definition, default))
        });
        f.pad(&text)
    }
}
