use std::f64::consts::PI;

use crate::{Domain, Error};

/// The equations of a spherical design: all coefficients `sum_k Y_lm(s_k)` of degrees
/// `1 <= l <= t` vanish; for symmetric sets, given by one point of each pair of antipodes, those of
/// the even degrees only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DesignEquations {
    /// The degree t.
    pub(crate) degree: usize,
    /// Whether the points stand for pairs of antipodes.
    pub(crate) is_symmetric: bool,
}

/// The result of a solver that converged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Solved {
    /// The largest power of a degree, as [`DesignEquations::residual`] returns it.
    pub(crate) residual: f64,
    /// The number of steps.
    pub(crate) iterations: u32,
}

impl DesignEquations {
    /// Returns the domain whose degrees have equations: the hemisphere for symmetric sets.
    pub(crate) fn domain(self) -> Domain {
        if self.is_symmetric { Domain::Hemisphere } else { Domain::Sphere }
    }

    /// Returns the degrees that have equations.
    pub(crate) fn degrees(self) -> impl Iterator<Item = usize> {
        (1..=self.degree).filter(move |&l| self.domain().has_degree(l))
    }

    /// Returns the number of equations, `2l + 1` for each degree: `t (t + 2)`, or
    /// `t (t + 3)/2` with the even degrees up to an even t.
    pub(crate) fn count(self) -> usize {
        let last = self.degree - self.degree % self.domain().degree_step();
        if self.is_symmetric { last * (last + 3) / 2 } else { last * (last + 2) }
    }

    /// Returns the largest power `P(l) = (4 pi/N)/(2l + 1) sum_m |sum_k Y_lm(s_k)|^2` of the
    /// degrees that have equations, 1 on average for N independent uniform points; `squares` are
    /// the inner sums by degree from 0.
    pub(crate) fn residual(self, squares: &[f64], n_points: usize) -> f64 {
        let power = |l: usize| 4.0 * PI / n_points as f64 / (2 * l + 1) as f64 * squares[l];
        self.degrees().map(power).fold(0.0, f64::max)
    }

    /// Returns the error of a search that ended with this power.
    pub(crate) fn stalled(self, n_points: usize, iterations: u32, power: f64) -> Error {
        let reason = format!(
            "after {iterations} steps the power of degrees up to {} is {power:.1e} and decreases no \
             further: {} coefficients cannot vanish there with {} degrees of freedom. Use more \
             points or a smaller degree",
            self.degree,
            self.count(),
            2 * n_points
        );
        Error::Infeasible { pattern: "design", n_points, reason }
    }
}
