use std::f64::consts::PI;

use glam::DVec3;
use sphvar_sh::Alm;
use sphvar_sht::{Method, Transform, TransformWorkspace};

use super::soft_core::SoftCore;
use super::target::SpectralTarget;
use crate::descent::Objective;
use crate::{Domain, Error};

/// The accuracies of the transforms at first and in the end. The residual that a transform can still
/// see is a tenth of its square.
const ACCURACIES: [f64; 2] = [1e-5, 1e-10];

/// The residual from which on the finer transform is used.
const ROUGH: f64 = 1e-9;

/// What counts as having vanished: powers, and overlaps relative to the core.
const VANISHED: f64 = 5e-21;

/// The deviation of a power from a target that is not 0.
const NEAR: f64 = 1e-6;

/// The slope `|grad E|^2/(2E)` of a descent that has come to rest above its aim, for so many steps:
/// it stays above 4e-4 in descents that arrive.
const STALLED: f64 = 1e-5;
const PATIENCE: u32 = 5;

/// How far the amplitudes `|c_l|` of a set of points are from those of a target,
///
/// ```text
/// E = 1/2 (4 pi/N) sum_l (|c_l| - a_l)^2/(l(l+1)) + core,   |c_l|^2 = sum_m |c_lm|^2,
/// a_l^2 = N/(4 pi) (2l+1) P*(l),
/// ```
///
/// weighted as the logarithmic energy is, so that a unit step down the gradient is nearly a Newton step.
pub(crate) struct SpectralEnergy<'a> {
    domain: Domain,
    target: &'a SpectralTarget,
    core: SoftCore,
    n_points: usize,
    /// Those of `ACCURACIES`.
    transforms: [Transform; 2],
    is_fine: bool,
    workspace: TransformWorkspace,
    alms: [Alm; 1],
    /// By degree: `|c_l|^2`.
    squares: Vec<f64>,
    core_energy: f64,
    core_gradient: Vec<DVec3>,
    values: Vec<f64>,
    stalled_for: u32,
}

impl<'a> SpectralEnergy<'a> {
    pub(crate) fn new(
        domain: Domain,
        target: &'a SpectralTarget,
        core: SoftCore,
        n_points: usize,
    ) -> Result<Self, Error> {
        let lmax = target.last_degree();
        let transform = |epsilon| {
            Transform::new(Method::Auto, lmax, n_points, epsilon)
                .map_err(|error| Error::Degree { last: lmax, reason: error.to_string() })
        };
        let alm = Alm::zeros(lmax)
            .map_err(|error| Error::Degree { last: lmax, reason: error.to_string() })?;
        Ok(Self {
            domain,
            target,
            core,
            n_points,
            transforms: [transform(ACCURACIES[0])?, transform(ACCURACIES[1])?],
            is_fine: false,
            workspace: TransformWorkspace::default(),
            alms: [alm],
            squares: vec![0.0; lmax + 1],
            core_energy: 0.0,
            core_gradient: Vec::new(),
            values: vec![0.0; n_points],
            stalled_for: 0,
        })
    }

    /// `4 pi/N`, which makes the mean square of the coefficients of white noise 1.
    fn normalization(&self) -> f64 {
        4.0 * PI / self.n_points as f64
    }

    /// The largest power where the target is 0, and the largest deviation from it elsewhere.
    pub(crate) fn residuals(&self) -> [f64; 2] {
        let mut residuals = [0.0; 2];
        for (l, target) in self.target.degrees(self.domain) {
            let power = self.normalization() * self.squares[l] / (2 * l + 1) as f64;
            let of_kind = &mut residuals[usize::from(target > 0.0)];
            *of_kind = f64::max(*of_kind, (power - target).abs());
        }
        residuals
    }

    /// Whether the points of the last call have the target's spectrum and keep their distance.
    pub(crate) fn has_arrived(&self) -> bool {
        let [vanishing, others] = self.residuals();
        let overlap = self.core.relative(self.core_energy, self.n_points);
        vanishing <= VANISHED && others <= NEAR && overlap <= VANISHED
    }
}

impl Objective for SpectralEnergy<'_> {
    fn energy(&mut self, points: &[DVec3]) -> f64 {
        let transform = &self.transforms[usize::from(self.is_fine)];
        transform.adjoint_batch_into(&[(points, None)], &mut self.workspace, &mut self.alms);
        self.squares = self.alms[0].power_per_degree();
        let normalization = self.normalization();
        let mut sum = 0.0;
        for (l, square) in self.squares.iter_mut().enumerate() {
            *square *= (2 * l + 1) as f64;
        }
        for (l, target) in self.target.degrees(self.domain) {
            let amplitude = ((2 * l + 1) as f64 * target / normalization).sqrt();
            sum += (self.squares[l].sqrt() - amplitude).powi(2) / (l * (l + 1)) as f64;
        }
        self.core_gradient.clear();
        self.core_gradient.resize(points.len(), DVec3::ZERO);
        self.core_energy = self.core.add(points, &mut self.core_gradient);
        0.5 * normalization * sum + self.core_energy
    }

    fn gradient(&mut self, points: &[DVec3], gradient: &mut Vec<DVec3>) {
        // The gradient of E by the points is that of the function with coefficients
        // (4 pi/N) (1 - a_l/|c_l|) c_lm/(l(l+1)).
        let mut factors = vec![0.0; self.squares.len()];
        let normalization = self.normalization();
        for (l, target) in self.target.degrees(self.domain) {
            let amplitude = ((2 * l + 1) as f64 * target / normalization).sqrt();
            let size = self.squares[l].sqrt();
            // Without any amplitude there is no direction in which to grow.
            let ratio = if size > 0.0 { amplitude / size } else { 0.0 };
            factors[l] = normalization * (1.0 - ratio) / (l * (l + 1)) as f64;
        }
        let alm = &mut self.alms[0];
        for m in 0..=alm.lmax() {
            for (a, factor) in alm.column_mut(m).iter_mut().zip(&factors[m..]) {
                *a *= factor;
            }
        }
        gradient.resize(points.len(), DVec3::ZERO);
        let transform = &self.transforms[usize::from(self.is_fine)];
        transform.gradient_into(alm, points, &mut self.workspace, &mut self.values, gradient);
        for (gradient, core) in gradient.iter_mut().zip(&self.core_gradient) {
            *gradient += *core;
        }
    }

    fn is_final(&mut self, energy: f64, squared_slope: f64) -> bool {
        let [vanishing, others] = self.residuals();
        if !self.is_fine && vanishing < ROUGH && others < 100.0 * NEAR {
            self.is_fine = true;
            return false;
        }
        let is_slow = squared_slope < STALLED * 2.0 * energy;
        self.stalled_for = if is_slow { self.stalled_for + 1 } else { 0 };
        self.is_fine && self.has_arrived() || self.stalled_for >= PATIENCE
    }
}
