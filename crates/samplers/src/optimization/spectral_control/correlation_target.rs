use std::f64::consts::{FRAC_PI_2, PI};

use sphvar_sh::{GaussLegendre, legendre_p_into};

use super::target::SpectralTarget;
use crate::{Domain, Error};

/// Powers that are negative by less than this are 0: targets are met to this accuracy.
const NEGLIGIBLE: f64 = 1e-6;

/// Nodes of the quadrature beyond half of those that oscillations need.
const EXTRA_NODES: usize = 12;

/// Returns the target to degree `last` with the pair correlation `g(gamma)`, a table of angles in
/// radians and values that is interpolated linearly, constant before its first angle, and 1 beyond
/// its last. Repeated angles are jumps.
///
/// The expected number of ordered pairs of distinct points at angles in `d gamma` is
/// `N^2/2 g sin(gamma) d gamma`, so that the addition theorem `P(l) = 1 + (1/N) sum_(k != j)
/// P_l(x_k.x_j)` becomes
///
/// ```text
/// P(l) = 1 + N/2 int_0^pi (g(gamma) - 1) P_l(cos gamma) sin(gamma) d gamma,   l >= 1.
/// ```
///
/// The 1 subtracted from g does not change the integral, and makes it converge where g is 1. On the
/// hemisphere the angle is that between lines, to pi/2, and the factor N.
///
/// # Errors
///
/// [`Error::Infeasible`] if the table is invalid or requires a negative power.
pub(super) fn target(
    table: &[[f64; 2]],
    n_points: usize,
    last: usize,
    domain: Domain,
) -> Result<SpectralTarget, Error> {
    let infeasible = |reason| Error::Infeasible { pattern: "profile", n_points, reason };
    let (end, factor) = match domain {
        Domain::Sphere => (PI, 0.5),
        Domain::Hemisphere => (FRAC_PI_2, 1.0),
    };
    check(table, end).map_err(infeasible)?;
    let mut power = transform(table, factor * n_points as f64, last)?;
    for (l, power) in power.iter_mut().enumerate().skip(1) {
        if *power < -NEGLIGIBLE && domain.has_degree(l) {
            return Err(infeasible(format!(
                "its pair correlation requires the power {power:.3} at degree {l}, and no set has a \
                 negative power. Use fewer points, or pairs that are less rare"
            )));
        }
        *power = power.max(0.0);
    }
    SpectralTarget::new(power)
}

/// Returns the reason why a table is no pair correlation up to the angle `end`.
fn check(table: &[[f64; 2]], end: f64) -> Result<(), String> {
    if table.is_empty() {
        return Err("its pair correlation has no values".to_owned());
    }
    // Angles of files may be rounded.
    let is_angle = |gamma: f64| (0.0..=end + 1e-6).contains(&gamma);
    for [gamma, g] in table {
        if !is_angle(*gamma) {
            return Err(format!(
                "an angle of its pair correlation must be from 0 to {end:.6}, got {gamma}"
            ));
        }
        if !(g.is_finite() && *g >= 0.0) {
            return Err(format!("a pair correlation must be finite and at least 0, got {g}"));
        }
    }
    match table.windows(2).find(|pair| pair[1][0] < pair[0][0]) {
        Some(pair) => Err(format!(
            "the angles of its pair correlation must increase, got {} after {}",
            pair[1][0], pair[0][0]
        )),
        None => Ok(()),
    }
}

/// Returns `1 + factor int (g - 1) P_l(cos gamma) sin(gamma) d gamma` for the degrees 0 to `last`.
/// The cost is `(last + 1)` times the number of nodes, about `last` and 12 for each line of the
/// table.
fn transform(table: &[[f64; 2]], factor: f64, last: usize) -> Result<Vec<f64>, Error> {
    let mut sums = vec![0.0; last + 1];
    let mut polynomials = vec![0.0; last + 1];
    let first = [[0.0, table[0][1]]];
    let mut rule: Option<GaussLegendre> = None;
    for (a, b) in first.iter().chain(table).zip(table) {
        let ([from, g_from], [to, g_to]) = (*a, *b);
        if to <= from {
            continue;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let nodes = (0.5 * (to - from) * (last + 1) as f64) as usize + EXTRA_NODES;
        let rule = match rule.take().filter(|rule| rule.nodes().len() == nodes) {
            Some(known) => rule.insert(known),
            None => rule.insert(GaussLegendre::new(nodes).map_err(of_degree(last))?),
        };
        for (x, w) in rule.nodes().iter().zip(rule.weights()) {
            let share = 0.5 * (1.0 + x);
            let gamma = from + share * (to - from);
            let excess = g_from + share * (g_to - g_from) - 1.0;
            let weight = 0.5 * (to - from) * w * gamma.sin() * excess;
            legendre_p_into(gamma.cos(), &mut polynomials).map_err(of_degree(last))?;
            sums.iter_mut().zip(&polynomials).for_each(|(sum, p)| *sum += weight * p);
        }
    }
    Ok(sums.into_iter().map(|sum| 1.0 + factor * sum).collect())
}

/// Returns the error of a transform to degree `last`.
fn of_degree(last: usize) -> impl Fn(sphvar_sh::Error) -> Error {
    move |error| Error::Degree { last, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use sphvar_sh::legendre_p;

    use super::{Domain, PI, target};

    fn p(l: usize, x: f64) -> f64 {
        legendre_p(l, x).unwrap()
    }

    /// g = 0 up to an angle c and 1 beyond: the integral of `P_l` over a cap has a closed form,
    /// `P(l) = 1 - N/2 (P_(l-1)(cos c) - P_(l+1)(cos c))/(2l + 1)`.
    #[test]
    fn a_hard_core_has_its_closed_form() {
        let (n, core, last) = (100, 0.17_f64, 80);
        let table = [[core, 0.0], [core, 1.0]];
        let sphere = target(&table, n, last, Domain::Sphere).unwrap();
        let lines = target(&table, n / 2, last, Domain::Hemisphere).unwrap();
        let x = core.cos();
        for l in 1..=last {
            let cap = (p(l - 1, x) - p(l + 1, x)) / (2 * l + 1) as f64;
            let expected = 1.0 - 0.5 * n as f64 * cap;
            assert!((sphere.at(l, Domain::Sphere).unwrap() - expected).abs() < 1e-12, "{l}");
            if let Some(power) = lines.at(l, Domain::Hemisphere) {
                assert!((power - expected).abs() < 1e-12, "{l}");
            }
        }
        // Larger cores exclude more pairs than there are.
        let excluded = [[0.3, 0.0], [0.3, 1.0]];
        let error = target(&excluded, n, last, Domain::Sphere).unwrap_err().to_string();
        assert!(error.contains("at degree 1, and no set has a negative power"), "{error}");
    }

    /// The pair correlation of a spectrum, `1 - 1/N + (1/N) sum_l (2l+1) (P(l) - 1) P_l`, gives the
    /// spectrum.
    #[test]
    fn pair_correlations_of_spectra_give_the_spectra() {
        let (n, last) = (40, 12);
        let power: Vec<f64> = (0..=last).map(|l| 0.5 + 0.04 * l as f64).collect();
        const STEPS: u32 = 20_000;
        let table: Vec<[f64; 2]> = (0..=STEPS)
            .map(|i| {
                let gamma = PI * f64::from(i) / f64::from(STEPS);
                let terms =
                    (1..=last).map(|l| (2 * l + 1) as f64 * (power[l] - 1.0) * p(l, gamma.cos()));
                [gamma, 1.0 + (terms.sum::<f64>() - 1.0) / n as f64]
            })
            .collect();
        let got = target(&table, n, 20, Domain::Sphere).unwrap();
        for l in 1..=20 {
            let expected = power.get(l).copied().unwrap_or(1.0);
            // Linear interpolation: 1e-4^2/8 times the second derivative, below 100.
            let got = got.at(l, Domain::Sphere).unwrap();
            assert!((got - expected).abs() < 1e-5, "{l}: {got}, not {expected}");
        }
    }

    #[test]
    fn invalid_tables_are_rejected() {
        for table in [
            vec![],
            vec![[-0.1, 1.0]],
            vec![[3.2, 1.0]],
            vec![[f64::NAN, 1.0]],
            vec![[0.1, -1e-9]],
            vec![[0.1, f64::INFINITY]],
            vec![[0.2, 1.0], [0.1, 1.0]],
        ] {
            assert!(target(&table, 10, 5, Domain::Sphere).is_err(), "{table:?}");
        }
        assert!(target(&[[2.0, 1.0]], 10, 5, Domain::Hemisphere).is_err());
        // White noise.
        let white = target(&[[1.0, 1.0]], 10, 5, Domain::Sphere).unwrap();
        assert!((1..=5).all(|l| white.at(l, Domain::Sphere) == Some(1.0)));
    }
}
