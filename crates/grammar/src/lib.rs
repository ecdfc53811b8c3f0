//! The grammar of samplers, integrands and profiles: `name` or `name:item,item`, where an item is
//! `key=value` or, only as the first item, a bare value.
//!
//! A value may be in double quotes, `file="a,b.exr"`; operators and separators in it have no
//! meaning, and `\"`, `\\` and `\xHH` are a quote, a backslash and the byte HH.
//!
//! A type with parameters implements [`Parametric`]: one function declares every parameter with its
//! range and meaning; [`read`], [`text`] and [`describe`] use it to parse, display and list the
//! parameters.
//!
//! ```
//! use sphvar_grammar::{Declaration, Error, Parametric, Range, Spec, read, text};
//!
//! #[derive(Debug, PartialEq)]
//! struct Lobe {
//!     kappa: f64,
//! }
//!
//! impl Default for Lobe {
//!     fn default() -> Self {
//!         Self { kappa: 10.0 }
//!     }
//! }
//!
//! impl Parametric for Lobe {
//!     fn declare(&mut self, d: &mut Declaration<'_>) {
//!         d.number("kappa", Range::AT_LEAST_0, "concentration", &mut self.kappa);
//!     }
//! }
//!
//! let mut lobe = Lobe::default();
//! read(&mut lobe, Spec::parse("lobe:kappa=50")?)?;
//! assert_eq!(lobe, Lobe { kappa: 50.0 });
//! assert_eq!(text("lobe", &mut lobe, &mut Lobe::default()), "lobe:kappa=50");
//! let wrong = read(&mut lobe, Spec::parse("lobe:kappa=-1")?).unwrap_err();
//! assert_eq!(wrong.to_string(), "lobe:kappa=-1: kappa must be finite and at least 0, got -1");
//! # Ok::<(), Error>(())
//! ```

mod declaration;
mod error;
mod parameter;
mod quoted;
mod range;
mod resolve_error;
mod spec;
mod texts;

pub use declaration::{Declaration, Parametric};
pub use error::Error;
pub use parameter::{Choice, DefaultValue, Parameter, ParameterKind, Value};
pub use quoted::{OPERATORS, argument_text, find_outside, quote, split_outside};
pub use range::Range;
pub use resolve_error::ResolveError;
pub use spec::Spec;
pub use texts::{describe, form, read, take, text};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
