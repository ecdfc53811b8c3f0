//! Sums, products and rotations of integrands.
//!
//! `+` and `-` bind least, then `*`, then `@`; each has blanks around it, so that neither numbers nor names
//! of files are torn apart. Quoted names of files may contain operators.

use glam::DVec3;
use sphvar_variance::{Integrand, Product, Rotated, SampledFunction, Shape, Sum};

use super::term;
use crate::error::CliError;
use crate::spec::{Spec, find_outside, split_outside};

/// The integrand of an expression; what a user should know of its files goes to `remarks`.
pub(super) fn parse(text: &str, remarks: &mut Vec<String>) -> Result<Box<dyn Integrand>, CliError> {
    if names_a_file(text) {
        return term::parse(text, remarks);
    }
    let mut summands = Vec::new();
    let (mut sign, mut rest) = (1.0, text);
    while let Some((at, operator)) = find_outside(rest, &[" + ", " - "]) {
        summands.push(summand(sign, &rest[..at], text, remarks)?);
        sign = if operator == " + " { 1.0 } else { -1.0 };
        rest = &rest[at + operator.len()..];
    }
    summands.push(summand(sign, rest, text, remarks)?);
    // A single integrand without a weight stays itself.
    let plain = summands.len() == 1 && summands[0].0.to_bits() == 1f64.to_bits();
    if let Some((_, single)) = summands.pop_if(|_| plain) {
        return Ok(single);
    }
    let mut sum = Sum::default();
    for (weight, function) in summands {
        sum = sum.plus(weight, function).map_err(|e| CliError::Usage(format!("{text}: {e}")))?;
    }
    Ok(Box::new(sum))
}

/// Whether the text is a single term with a file whose name looks like an expression.
fn names_a_file(text: &str) -> bool {
    let file = Spec::parse(text).ok().and_then(|mut spec| {
        matches!(spec.name.as_str(), "env" | "map")
            .then(|| spec.take_path("").or_else(|| spec.take_path("file")))
    });
    file.flatten().is_some_and(|file| file.is_file())
}

/// The weight and the function of a summand: a product of numbers and rotated terms.
fn summand(
    sign: f64,
    text: &str,
    whole: &str,
    remarks: &mut Vec<String>,
) -> Result<(f64, Box<dyn Integrand>), CliError> {
    let mut weight = sign;
    let mut product: Option<Box<dyn Integrand>> = None;
    for factor in split_outside(text, " * ").into_iter().map(str::trim) {
        if factor.is_empty() {
            return Err(CliError::Usage(format!(
                "\"{whole}\": there is no integrand on one side of an operator"
            )));
        }
        if let Ok(number) = factor.parse::<f64>() {
            weight *= number;
            continue;
        }
        let function = rotated(factor, remarks)?;
        product = Some(match product {
            Some(before) => Box::new(Product::new(before, function)),
            None => function,
        });
    }
    if !weight.is_finite() {
        return Err(CliError::Usage(format!("\"{text}\": a weight must be finite")));
    }
    // Numbers alone are a constant function.
    let one = || {
        let shape = Shape::smooth(0).zonal(DVec3::Z).even();
        Box::new(SampledFunction::with_shape(|_: DVec3| 1.0, shape)) as Box<dyn Integrand>
    };
    Ok((weight, product.unwrap_or_else(one)))
}

/// A term with the rotations behind it.
fn rotated(text: &str, remarks: &mut Vec<String>) -> Result<Box<dyn Integrand>, CliError> {
    let mut pieces = split_outside(text, " @ ").into_iter().map(str::trim);
    let mut function = term::parse(pieces.next().unwrap_or_default(), remarks)?;
    for piece in pieces {
        let [theta, phi, psi] = angles(piece).ok_or_else(|| {
            CliError::Usage(format!(
                "{text}: @ wants THETA/PHI or THETA/PHI/PSI in degrees, THETA in [0, 180], got \"{piece}\""
            ))
        })?;
        let turned = Rotated::to_angles(function, theta, phi, psi);
        function = Box::new(turned.map_err(|e| CliError::Usage(format!("{text}: {e}")))?);
    }
    Ok(function)
}

/// Colatitude, longitude and turn in radians.
fn angles(text: &str) -> Option<[f64; 3]> {
    let degrees: Option<Vec<f64>> = text.split('/').map(|a| a.trim().parse().ok()).collect();
    let degrees = degrees?;
    let known = degrees.iter().all(|a| a.is_finite()) && (0.0..=180.0).contains(degrees.first()?);
    match *degrees.as_slice() {
        _ if !known => None,
        [theta, phi] => Some([theta, phi, 0.0].map(f64::to_radians)),
        [theta, phi, psi] => Some([theta, phi, psi].map(f64::to_radians)),
        _ => None,
    }
}
