//! What the lists of patterns of the sphere and of the square share.

use sphvar_grammar::{Parameter, Spec, describe, read, text};

use crate::definition::Definition;
use crate::hash::fnv1a;
use crate::space::internal::Space as _;
use crate::{Error, FileResolver, PatternFacts, Space, ValidCounts};

/// The patterns of a space by name. `pattern_list!` implements the required items.
pub(crate) trait PatternList: Clone + Sized {
    type Space: Space;

    /// Every pattern that can be parsed, with its default parameters; with empty parameters those
    /// that need a file.
    fn list() -> impl Iterator<Item = Self>;

    /// Returns the name of the pattern.
    fn name_in_list(&self) -> &'static str;

    /// Calls a function with the definition of the pattern.
    fn with_definition<T>(
        &mut self,
        action: impl FnOnce(&mut dyn Definition<Self::Space>) -> T,
    ) -> T;

    /// Reads `name` or `name:key=value,key=value`.
    fn read(text: &str, files: &dyn FileResolver) -> Result<Self, Error> {
        let spec = Spec::parse(text)?;
        let named = Self::list().find(|pattern| pattern.name_in_list() == spec.name);
        let mut pattern = named.ok_or_else(|| {
            let names: Vec<&str> = Self::list().map(|pattern| pattern.name_in_list()).collect();
            sphvar_grammar::Error::unknown_name("sampler", &spec.name, &names)
        })?;
        pattern.with_definition(|definition| {
            read(definition, spec)?;
            definition.resolve(files)
        })?;
        Ok(pattern)
    }

    /// Returns the name and, after a colon, the parameters that differ from the defaults.
    fn text(&self) -> String {
        let mut default = self.default_of_name();
        self.clone().with_definition(|definition| {
            default.with_definition(|default| text(self.name_in_list(), definition, default))
        })
    }

    /// Returns the parameters in the order of the text form.
    fn described(&self) -> Vec<Parameter> {
        self.default_of_name().with_definition(|definition| describe(definition))
    }

    /// Returns the known properties of the pattern with its parameters.
    fn known_facts(&self) -> PatternFacts {
        self.clone().with_definition(|definition| definition.facts())
    }

    /// Returns the number of the random streams.
    fn group(&self, n_points: usize) -> usize {
        let own = self.clone().with_definition(|definition| definition.stream_group(n_points));
        own.unwrap_or_else(|| fnv1a(self.text().as_bytes()) as usize ^ n_points)
    }

    /// Returns the number of the random streams of all prefixes, for patterns whose prefixes are sets
    /// of the pattern: that of no points.
    fn group_of_prefixes(&self) -> Option<usize> {
        self.known_facts().is_extensible.then(|| self.group(0))
    }

    /// Returns the valid numbers of points.
    fn counts_in(&self, space: Self::Space) -> ValidCounts {
        self.clone().with_definition(|definition| definition.valid_counts(space))
    }

    /// Returns the sampler of exactly `n_points` points.
    fn build_in(&self, n_points: usize, space: Self::Space) -> Result<Box<SamplerOf<Self>>, Error> {
        let pattern = self.text();
        if n_points == 0 {
            return Err(Error::NoPoints { pattern });
        }
        let rule = self.counts_in(space);
        let nearest = rule.nearest(n_points);
        if nearest != n_points {
            let (space, requested) = (space.to_string(), n_points);
            return Err(Error::InvalidCount { pattern, space, requested, nearest, rule });
        }
        let sampler =
            self.clone().with_definition(|definition| definition.build(n_points, space))?;
        Ok(Self::Space::with_groups(sampler, self.group(n_points), self.group_of_prefixes()))
    }

    /// Returns the pattern of the same name with its default parameters.
    fn default_of_name(&self) -> Self {
        let name = self.name_in_list();
        Self::list().find(|pattern| pattern.name_in_list() == name).unwrap_or_else(|| self.clone())
    }
}

/// The samplers of the patterns of a list.
type SamplerOf<L> = <<L as PatternList>::Space as crate::space::internal::Space>::Sampler;

/// Declares the module, the variant, the name and the summary of every pattern of a space. A variant
/// with parameters names their type; otherwise the definition is the type `Parameters` of its
/// module. Patterns without a default are not in `ALL`.
///
/// The list declares the modules, so `cargo fmt` does not find their files; `.ci/run` checks them
/// by name.
macro_rules! pattern_list {
    (
        $(#[$attribute:meta])*
        pub enum $Pattern:ident of $Space:ty;

        $($name:literal = $module:ident::$Variant:ident $(($parameters:ident: $Parameters:ident))?: $summary:literal;)*

        without default:
        $($file_name:literal = $file_module:ident::$FileVariant:ident ($FileParameters:ident): $file_summary:literal;)*
    ) => {
        $(
            pub(crate) mod $module;
            #[allow(
                unused_imports,
                unreachable_pub,
                reason = "some modules have nothing but a definition"
            )]
            pub use $module::*;
        )*
        $(
            pub(crate) mod $file_module;
            pub use $file_module::*;
        )*

        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum $Pattern {
            $(
                #[doc = concat!("`", $name, "`: ", $summary, ".")]
                $Variant $(($Parameters))?,
            )*
            $(
                #[doc = concat!("`", $file_name, "`: ", $file_summary, ".")]
                $FileVariant($FileParameters),
            )*
        }

        impl $Pattern {
            /// All patterns with their default parameters, in the order of tables.
            pub const ALL: [Self; [$($name),*].len()] =
                [$(Self::$Variant $(($Parameters::DEFAULT))?),*];

            /// The patterns that have no default, since they need a file, with empty parameters.
            const WITHOUT_DEFAULT: [Self; <[&str]>::len(&[$($file_name),*])] =
                [$(Self::$FileVariant($FileParameters::DEFAULT)),*];

            /// Returns every pattern that can be parsed: [`Self::ALL`], and with empty parameters
            /// those that need a file.
            pub fn known() -> impl Iterator<Item = Self> {
                Self::ALL.into_iter().chain(Self::WITHOUT_DEFAULT)
            }

            /// Returns the name of the pattern in commands and files.
            #[must_use]
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $name,)*
                    $(Self::$FileVariant(_) => $file_name,)*
                }
            }

            /// Returns a one-line description of the pattern.
            #[must_use]
            pub const fn summary(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $summary,)*
                    $(Self::$FileVariant(_) => $file_summary,)*
                }
            }

            /// Returns the parameters with their ranges, meanings and defaults, in the order of the
            /// text form.
            #[must_use]
            pub fn parameters(&self) -> Vec<sphvar_grammar::Parameter> {
                self.described()
            }

            /// Returns the known properties of the pattern with its parameters.
            #[must_use]
            pub fn facts(&self) -> $crate::PatternFacts {
                self.known_facts()
            }

            /// Returns a number for [`Streams::new`](crate::Streams::new) that distinguishes the
            /// ensembles of one run: the number of points combined with a hash of the pattern's text
            /// (32-bit FNV-1a), or for a point file a hash of its content.
            #[must_use]
            pub fn stream_group(&self, n_points: usize) -> usize {
                self.group(n_points)
            }

            /// Returns the number of the random streams that the sets of every number of points
            /// share, so that smaller sets are prefixes of larger ones; `None` for patterns whose
            /// prefixes are not sets of the pattern ([`PatternFacts`](crate::PatternFacts)).
            #[must_use]
            pub fn sequence_group(&self) -> Option<usize> {
                self.group_of_prefixes()
            }
        }

        impl PatternList for $Pattern {
            type Space = $Space;

            fn list() -> impl Iterator<Item = Self> {
                Self::known()
            }

            fn name_in_list(&self) -> &'static str {
                self.name()
            }

            fn with_definition<T>(
                &mut self,
                action: impl FnOnce(&mut dyn Definition<$Space>) -> T,
            ) -> T {
                match self {
                    $(Self::$Variant $(($parameters))? => {
                        action(definition!($module $($parameters)?))
                    })*
                    $(Self::$FileVariant(parameters) => action(parameters),)*
                }
            }
        }

        /// Reads `name` or `name:key=value,key=value`; texts that name files need
        #[doc = concat!("[`", stringify!($Pattern), "::parse`].")]
        impl std::str::FromStr for $Pattern {
            type Err = $crate::Error;

            fn from_str(text: &str) -> Result<Self, $crate::Error> {
                Self::parse(text, &$crate::definition::WithoutFiles)
            }
        }

        /// Writes the name and, after a colon, the parameters that differ from the defaults.
        impl std::fmt::Display for $Pattern {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(&self.text())
            }
        }
    };
}

macro_rules! definition {
    ($module:ident) => {
        &mut $module::Parameters
    };
    ($module:ident $parameters:ident) => {
        $parameters
    };
}

pub(crate) use {definition, pattern_list};
