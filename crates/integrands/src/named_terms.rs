//! Lists of named functions with parameters: integrands of the sphere and of the square, and warps.

use crate::Error;

/// Declares a list of named functions: what they are in words, the type of its entries, the name that
/// tables omit, if there is one, and the module, the variant, the name and the summary of every
/// function. A variant with parameters
/// names their type; otherwise the definition is the type `Parameters` of its module. Functions
/// that depend on more than their parameters name the further arguments of `build`.
macro_rules! named_terms {
    (
        $(#[$meta:meta])*
        $what:literal $Term:ident: $Definition:ident $(($argument:ident: $Argument:ident))? -> $Function:ident
        $(, unlisted $unlisted:literal)?;
        $($name:literal = $module:ident::$Variant:ident $(($parameters:ident: $Parameters:ident))?: $summary:literal;)*
    ) => {
        $(
            pub(crate) mod $module;
            #[allow(unused_imports, unreachable_pub, reason = "modules may have no public items")]
            pub use $module::*;
        )*

        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum $Term {
            $(
                #[doc = concat!("`", $name, "`: ", $summary, ".")]
                $Variant $(($Parameters))?,
            )*
        }

        impl $Term {
            #[doc = concat!(
                "Returns every named ", $what,
                " with its default parameters, and examples of required ones, in the order of tables."
            )]
            $(#[doc = concat!("`", $unlisted, "` is not among them: texts alone do not give one.")])?
            #[must_use]
            pub fn all() -> Vec<Self> {
                let every = Self::every().into_iter();
                $(let every = every.filter(|term| term.name() != $unlisted);)?
                every.collect()
            }

            #[doc = concat!("Returns [`all`](Self::all) with each ", $what, " that tables omit.")]
            fn every() -> Vec<Self> {
                vec![$(Self::$Variant $(($Parameters::default()))?),*]
            }

            /// Returns the name.
            #[must_use]
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $name,)*
                }
            }

            #[doc = concat!("Returns a one-line description of the ", $what, ".")]
            #[must_use]
            pub const fn summary(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $summary,)*
                }
            }

            /// Returns the parameters with their ranges, meanings and defaults, in the order of
            /// texts.
            #[must_use]
            pub fn parameters(&self) -> Vec<sphvar_grammar::Parameter> {
                self.default_of_name()
                    .with_definition(|definition| sphvar_grammar::describe(definition))
            }

            /// Returns the form of texts, such as `ylm:l=4[,m=0]`, with examples of what must be
            /// given.
            #[must_use]
            pub fn form(&self) -> String {
                let name = self.name();
                self.default_of_name()
                    .with_definition(|definition| sphvar_grammar::form(name, definition))
            }

            #[doc = concat!("Returns the ", $what, "; files that the parameters name are read by `files`.")]
            ///
            /// # Errors
            ///
            /// [`Error::OfTerm`](crate::Error::OfTerm) with the reason if there is none with these
            /// parameters; [`Error::File`](crate::Error::File) if `files` cannot read a file.
            pub fn build(
                &self,
                $($argument: $Argument,)?
                files: &dyn crate::IntegrandResolver,
            ) -> Result<Box<dyn $Function>, crate::Error> {
                let build = |definition: &mut dyn $Definition| definition.build($($argument,)? files);
                let built = self.clone().with_definition(build);
                built.map_err(|error| crate::named_terms::of_term(self, error))
            }

            #[doc = concat!("Returns the ", $what, " of the same name with its default parameters.")]
            fn default_of_name(&self) -> Self {
                let same = Self::every().into_iter().find(|term| term.name() == self.name());
                same.unwrap_or_else(|| self.clone())
            }

            #[doc = concat!("Calls a function with the definition of the ", $what, ".")]
            fn with_definition<T>(&mut self, action: impl FnOnce(&mut dyn $Definition) -> T) -> T {
                match self {
                    $(Self::$Variant $(($parameters))? => {
                        action(crate::named_terms::definition!($module $($parameters)?))
                    })*
                }
            }
        }

        /// Reads `name` or `name:key=value,key=value`.
        impl std::str::FromStr for $Term {
            type Err = crate::Error;

            fn from_str(text: &str) -> Result<Self, crate::Error> {
                let spec = sphvar_grammar::Spec::parse(text)?;
                let unknown = || {
                    let names: Vec<&str> = Self::all().iter().map(Self::name).collect();
                    sphvar_grammar::Error::unknown_name($what, &spec.name, &names)
                };
                let known = Self::every().into_iter().find(|term| term.name() == spec.name);
                let mut term = known.ok_or_else(unknown)?;
                term.with_definition(|definition| sphvar_grammar::read(definition, spec))?;
                Ok(term)
            }
        }

        /// The name, and after a colon the parameters that must be given or are not the default
        /// ones.
        impl std::fmt::Display for $Term {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let mut default = self.default_of_name();
                let text = self.clone().with_definition(|definition| {
                    default.with_definition(|default| {
                        sphvar_grammar::text(self.name(), definition, default)
                    })
                });
                f.pad(&text)
            }
        }
    };
}

/// Returns the definition of a function without or with parameters.
macro_rules! definition {
    ($module:ident) => {
        &mut $module::Parameters
    };
    ($module:ident $parameters:ident) => {
        $parameters
    };
}

/// Returns an error with the term that it is about, which errors of files name themselves.
pub(crate) fn of_term(term: &impl ToString, error: Error) -> Error {
    match error {
        Error::File(error) => Error::File(error),
        reason => Error::OfTerm { text: term.to_string(), reason: Box::new(reason) },
    }
}

pub(crate) use {definition, named_terms};
