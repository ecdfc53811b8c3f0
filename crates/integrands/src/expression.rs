use std::fmt;
use std::str::FromStr;

use sphvar_grammar::{find_outside, split_outside};

use crate::{Cap, Error, Integrand, IntegrandResolver, Product, Rotated, Sum, Term};

/// A sum of products of named integrands with rotations, such as
/// `cap:degrees=30 @ 40/10 + 0.5 * vmf:kappa=10`; of integrands on the square, without rotations,
/// with [`SquareTerm`](crate::SquareTerm) as the type of factors. A
/// [`WarpExpression`](crate::WarpExpression) has the same grammar.
///
/// `@` has the highest precedence, then `*`, then `+` and `-`. Each operator needs blanks around
/// it, which keeps numbers and file names intact. Quoted names of files may contain operators.
/// `f @ THETA/PHI/PSI` rotates f by PSI about +z and then rotates +z to colatitude THETA and
/// longitude PHI, in degrees.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Domain, Expression, NoFiles};
///
/// let expression: Expression = "2 * cosine - cap:degrees=60 @ 90/0".parse()?;
/// assert_eq!(expression.to_string(), "2 * cosine - cap:degrees=60 @ 90/0");
/// let integrand = expression.build(&NoFiles)?;
/// assert!((integrand.exact(Domain::Sphere).unwrap() - std::f64::consts::PI).abs() < 1e-14);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Expression<F = Factor> {
    /// The terms of the sum; at least one.
    pub summands: Vec<Summand<F>>,
}

/// A product of a number and functions.
#[derive(Clone, Debug, PartialEq)]
pub struct Summand<F = Factor> {
    /// The number.
    pub weight: f64,
    /// The functions; none for a constant.
    pub factors: Vec<F>,
}

/// A named integrand after some rotations; a warp with [`WarpTerm`](crate::WarpTerm) as the type of
/// the term.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor<T = Term> {
    /// The integrand.
    pub term: T,
    /// Colatitude, longitude and rotation about +z of each rotation, in degrees.
    pub rotations: Vec<[f64; 3]>,
}

/// Whether filters of an expression are part of the function.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Filters {
    Applied,
    Removed,
}

impl Expression {
    /// The maximum number of functions in a product: the functions are nested, and quadratures over
    /// more factors take too long.
    pub const MAX_FACTORS: usize = 64;

    /// Returns the function; `files` reads the files that it names.
    ///
    /// # Errors
    ///
    /// [`Error::OfTerm`] with the text of the term and the reason, [`Error::Weight`] for weights
    /// out of range, [`Error::File`] if `files` cannot read a file.
    pub fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        self.function(Filters::Applied, files)
    }

    /// Returns the function without its filters, `filtered:of=f` being f, if it has any: the
    /// function of which the filtered one is an approximation.
    ///
    /// # Errors
    ///
    /// Those of [`build`](Self::build).
    pub fn build_unfiltered(
        &self,
        files: &dyn IntegrandResolver,
    ) -> Result<Option<Box<dyn Integrand>>, Error> {
        let has_filters = self.terms().any(|term| term.filtered().is_some());
        has_filters.then(|| self.function(Filters::Removed, files)).transpose()
    }

    fn function(
        &self,
        filters: Filters,
        files: &dyn IntegrandResolver,
    ) -> Result<Box<dyn Integrand>, Error> {
        // A single integrand without a weight is returned unchanged.
        if let [single] = &*self.summands
            && single.weight.to_bits() == 1f64.to_bits()
        {
            return single.function(filters, files);
        }
        let mut sum = Sum::default();
        for summand in &self.summands {
            let function = summand.function(filters, files)?;
            sum = sum.plus(summand.weight, function).map_err(|error| Error::OfTerm {
                text: self.to_string(),
                reason: Box::new(error),
            })?;
        }
        Ok(Box::new(sum))
    }

    /// Returns all named integrands, including those within filters.
    pub fn terms(&self) -> impl Iterator<Item = &Term> {
        let mut terms = Vec::new();
        let mut pending = vec![self];
        while let Some(expression) = pending.pop() {
            for factor in expression.summands.iter().flat_map(|summand| &summand.factors) {
                terms.push(&factor.term);
                pending.extend(factor.term.filtered());
            }
        }
        terms.into_iter()
    }
}

impl From<Term> for Expression {
    fn from(term: Term) -> Self {
        let factors = vec![Factor { term, rotations: Vec::new() }];
        Self { summands: vec![Summand { weight: 1.0, factors }] }
    }
}

impl<F: FromStr<Err = Error>> Summand<F> {
    /// Parses a product; `whole` is the expression, for messages.
    fn parse(sign: f64, text: &str, whole: &str) -> Result<Self, Error> {
        let mut summand = Self { weight: sign, factors: Vec::new() };
        for factor in split_outside(text, " * ").into_iter().map(str::trim) {
            if factor.is_empty() {
                return Err(Error::NoOperand { text: whole.to_owned() });
            }
            if let Ok(number) = factor.parse::<f64>() {
                summand.weight *= number;
            } else if summand.factors.len() == Expression::MAX_FACTORS {
                return Err(Error::TooManyFactors { max: Expression::MAX_FACTORS });
            } else {
                summand.factors.push(factor.parse()?);
            }
        }
        Ok(summand)
    }
}

impl Summand {
    /// Returns the product of the functions, without the weight.
    fn function(
        &self,
        filters: Filters,
        files: &dyn IntegrandResolver,
    ) -> Result<Box<dyn Integrand>, Error> {
        let mut product: Option<Box<dyn Integrand>> = None;
        for factor in &self.factors {
            let function = factor.function(filters, files)?;
            product = Some(match product {
                Some(before) => Box::new(Product::new(before, function)),
                None => function,
            });
        }
        match product {
            Some(product) => Ok(product),
            // A product of numbers alone is a constant function, the cap of the whole sphere.
            None => Ok(Box::new(Cap::from_degrees(180.0)?)),
        }
    }
}

impl Factor {
    fn function(
        &self,
        filters: Filters,
        files: &dyn IntegrandResolver,
    ) -> Result<Box<dyn Integrand>, Error> {
        let function = match (filters, self.term.filtered()) {
            (Filters::Removed, Some(expression)) => expression.function(filters, files)?,
            _ => self.term.build(files)?,
        };
        let mut rotations = self.rotations.iter().map(|angles| angles.map(f64::to_radians));
        let Some([theta, phi, psi]) = rotations.next() else {
            return Ok(function);
        };
        // Chained rotations are combined.
        let mut rotated = Rotated::to_angles(function, theta, phi, psi);
        for [theta, phi, psi] in rotations {
            rotated = rotated.and_then(|rotated| rotated.then_to_angles(theta, phi, psi));
        }
        let of_term = |reason| Error::OfTerm { text: self.to_string(), reason: Box::new(reason) };
        Ok(Box::new(rotated.map_err(of_term)?))
    }
}

impl<F: FromStr<Err = Error>> FromStr for Expression<F> {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let mut summands = Vec::new();
        let (mut sign, mut rest) = (1.0, text);
        while let Some((at, operator)) = find_outside(rest, &[" + ", " - "]) {
            summands.push(Summand::parse(sign, &rest[..at], text)?);
            sign = if operator == " + " { 1.0 } else { -1.0 };
            rest = &rest[at + operator.len()..];
        }
        summands.push(Summand::parse(sign, rest, text)?);
        Ok(Self { summands })
    }
}

impl<T: FromStr<Err = Error>> FromStr for Factor<T> {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let mut pieces = split_outside(text, " @ ").into_iter().map(str::trim);
        let term = pieces.next().unwrap_or_default().parse()?;
        let rotations = pieces
            .map(|piece| angles(piece).ok_or_else(|| Error::Angles { text: piece.to_owned() }));
        Ok(Self { term, rotations: rotations.collect::<Result<_, _>>()? })
    }
}

/// Returns colatitude, longitude and rotation about +z in degrees.
fn angles(text: &str) -> Option<[f64; 3]> {
    let degrees: Option<Vec<f64>> = text.split('/').map(|a| a.trim().parse().ok()).collect();
    let degrees = degrees?;
    let known = degrees.iter().all(|a| a.is_finite()) && (0.0..=180.0).contains(degrees.first()?);
    match *degrees.as_slice() {
        _ if !known => None,
        [theta, phi] => Some([theta, phi, 0.0]),
        [theta, phi, psi] => Some([theta, phi, psi]),
        _ => None,
    }
}

impl<F: fmt::Display> fmt::Display for Expression<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, summand) in self.summands.iter().enumerate() {
            let (mut weight, factors) = (summand.weight, &summand.factors);
            if i > 0 {
                f.write_str(if weight.is_sign_negative() { " - " } else { " + " })?;
                weight = weight.abs();
            }
            let mut separator = "";
            if weight.to_bits() != 1f64.to_bits() || factors.is_empty() {
                write!(f, "{weight}")?;
                separator = " * ";
            }
            for factor in factors {
                write!(f, "{separator}{factor}")?;
                separator = " * ";
            }
        }
        Ok(())
    }
}

impl<T: fmt::Display> fmt::Display for Factor<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.term.fmt(f)?;
        for [theta, phi, psi] in &self.rotations {
            write!(f, " @ {theta}/{phi}")?;
            if *psi != 0.0 {
                write!(f, "/{psi}")?;
            }
        }
        Ok(())
    }
}
