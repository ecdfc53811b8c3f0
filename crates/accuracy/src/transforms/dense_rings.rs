use std::sync::Arc;

use num_complex::Complex;
use sphvar_sh::{Alm, Colatitude};
use sphvar_sht::{DenseRingTransform, MirroredRings, RingSums};

use super::input::Input;
use crate::{Errors, Subject};

/// The transform of rings in pairs, with one point on each ring: neighbouring points of the input
/// are reflections of each other at the equator.
#[derive(Debug)]
pub(super) struct DenseRings {
    input: Arc<Input>,
    state: Option<(DenseRingTransform, Alm)>,
}

impl DenseRings {
    pub(super) fn new(input: Arc<Input>) -> Self {
        Self { input, state: None }
    }
}

impl Subject for DenseRings {
    fn run(&mut self) {
        let input = &self.input;
        let (transform, alm) = self.state.get_or_insert_with(|| {
            let pairs = input.points().as_chunks::<2>().0;
            let colatitudes = pairs.iter().map(|[north, _]| Colatitude::from_direction(*north));
            let transform = DenseRingTransform::new(input.lmax(), colatitudes);
            let alm = Alm::zeros(input.lmax());
            (
                transform.expect("a degree of some thousands"),
                alm.expect("a degree of some thousands"),
            )
        });
        *alm = transform.adjoint(&Points(input)).expect("memory for the coefficients");
    }

    fn errors(&mut self) -> Errors {
        self.state.as_ref().map_or_else(Errors::default, |(_, alm)| self.input.error_of(alm))
    }
}

/// The values `w e^{-i m phi}` of points on rings of their own.
struct Points<'a>(&'a Input);

impl MirroredRings for Points<'_> {
    fn add<const FUSED: bool>(&self, first: usize, sums: &mut RingSums<'_>) {
        let points = self.0.points().as_chunks::<2>().0;
        let weight = |k: usize| self.0.weights().map_or(1.0, |w| w[k]);
        for (ring, pair) in points.iter().enumerate() {
            if sums.is_negligible(ring) {
                continue;
            }
            let mut values = [[Complex::ZERO; RingSums::ORDERS]; 2];
            for (k, (values, p)) in values.iter_mut().zip(pair).enumerate() {
                let phase = Complex::new(p.x, -p.y) / p.x.hypot(p.y);
                let mut value =
                    phase.powu(u32::try_from(first).unwrap_or(0)) * weight(2 * ring + k);
                for to in values {
                    *to = value;
                    value *= phase;
                }
            }
            sums.add::<FUSED>(ring, &values);
        }
    }
}
