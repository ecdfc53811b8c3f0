//! Sums, products and rotations of integrands.
//!
//! `+` and `-` bind least, then `*`, then `@`; each has blanks around it, so that neither numbers nor names
//! of files are torn apart. Quoted names of files may contain operators.

use sphvar_integrands::{Cap, Integrand, Product, Rotated, Sum};

use super::term;
use crate::error::CliError;
use crate::spec::{Spec, find_outside, split_outside};

/// The largest number of integrands in a product: each is an object within the next, and quadratures over more
/// factors have no end.
const MAX_FACTORS: usize = 64;

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
///
/// Operators in the other parameters belong to an expression, as in `env:a.exr,up=y * cosine`.
fn names_a_file(text: &str) -> bool {
    let Ok(mut spec) = Spec::parse(text) else { return false };
    if !matches!(spec.name.as_str(), "env" | "map") {
        return false;
    }
    let file = spec.take_path("").or_else(|| spec.take_path("file"));
    file.is_some_and(|file| file.is_file()) && !spec.has_operator_left()
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
    let mut factors = 0;
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
        factors += 1;
        if factors > MAX_FACTORS {
            return Err(CliError::Usage(format!(
                "a product has at most {MAX_FACTORS} integrands; this one has more"
            )));
        }
        let function = rotated(factor, remarks)?;
        product = Some(match product {
            Some(before) => Box::new(Product::new(before, function)),
            None => function,
        });
    }
    if let Some(product) = product {
        return Ok((weight, product));
    }
    // Numbers alone are a constant function, the cap that is the whole sphere.
    let one = Cap::from_degrees(180.0).map_err(|e| CliError::Usage(format!("{text}: {e}")))?;
    Ok((weight, Box::new(one)))
}

/// A term with the rotations behind it.
fn rotated(text: &str, remarks: &mut Vec<String>) -> Result<Box<dyn Integrand>, CliError> {
    let mut pieces = split_outside(text, " @ ").into_iter().map(str::trim);
    let function = term::parse(pieces.next().unwrap_or_default(), remarks)?;
    // Chained rotations are one.
    let mut angles_of = pieces.map(|piece| {
        angles(piece).ok_or_else(|| {
            CliError::Usage(format!(
                "@ wants THETA/PHI or THETA/PHI/PSI in degrees, THETA in [0, 180], got \"{piece}\""
            ))
        })
    });
    let Some(first) = angles_of.next() else {
        return Ok(function);
    };
    let [theta, phi, psi] = first?;
    let mut turned = Rotated::to_angles(function, theta, phi, psi);
    for next in angles_of {
        let [theta, phi, psi] = next?;
        turned = turned.and_then(|turned| turned.then_to_angles(theta, phi, psi));
    }
    Ok(Box::new(turned.map_err(|e| CliError::Usage(format!("{text}: {e}")))?))
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

#[cfg(test)]
mod tests {
    use sphvar_integrands::Integrand;
    use sphvar_samplers::Domain;

    use crate::error::CliError;

    fn parsed(text: &str) -> Result<Box<dyn Integrand>, CliError> {
        super::parse(text, &mut Vec::new())
    }

    #[test]
    fn long_expressions_take_neither_stack_nor_much_time() {
        let chain = format!("cap:degrees=30{}", " @ 40/10/5".repeat(12_000));
        let turned = parsed(&chain).unwrap();
        let exact = parsed("cap:degrees=30").unwrap().exact(Domain::Sphere).unwrap();
        assert!((turned.exact(Domain::Sphere).unwrap() / exact - 1.0).abs() < 1e-15);
        let square = |f: &dyn Integrand| f.square(Domain::Sphere).unwrap();
        for term in ["cosine", "vmf:kappa=5 @ 30/20", "ylm:l=4,m=2", "cap:degrees=60"] {
            let sum = parsed(&vec![term; 1000].join(" + ")).unwrap();
            let ratio = square(&*sum) / square(&*parsed(term).unwrap());
            assert!((ratio / 1e6 - 1.0).abs() < 1e-11, "{term}: {ratio}");
        }
        let product = vec!["cosine"; 100_000].join(" * ");
        assert!(parsed(&product).is_err_and(|e| e.to_string().contains("at most 64")));
        assert!(parsed("1e-200 * cosine").is_err_and(|e| e.to_string().contains("1e-150")));
    }
}
