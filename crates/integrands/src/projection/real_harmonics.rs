use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;

/// The values of all real spherical harmonics to a degree, as polynomials in x, y and z.
#[derive(Clone, Debug)]
pub(super) struct RealHarmonics {
    degree: usize,
    /// `lambda_mm/sin^m theta`, times sqrt(2) for m > 0.
    sectoral: Vec<f64>,
    /// `A_lm` of the recurrence over l, at the index of (l, m).
    ratios: Vec<f64>,
}

impl RealHarmonics {
    pub(super) fn new(degree: usize) -> Self {
        let mut sectoral = vec![1.0 / (4.0 * PI).sqrt()];
        for m in 1..=degree {
            let factor = -((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
            sectoral.push(sectoral[m - 1] * factor);
        }
        sectoral[1..].iter_mut().for_each(|value| *value *= SQRT_2);
        let ratio = |(l, m): (i64, i64)| {
            let (l, m) = (l as f64, m as f64);
            ((l * l - m * m) / (4.0 * l * l - 1.0)).abs().sqrt()
        };
        Self { degree, sectoral, ratios: orders(degree).map(ratio).collect() }
    }

    /// Writes the harmonic of degree l and order m to `values[l (l + 1) + m]`.
    pub(super) fn values_into(&self, dir: DVec3, values: &mut [f64]) {
        // Real and imaginary part of (x + i y)^m.
        let (mut re, mut im) = (1.0, 0.0);
        for m in 0..=self.degree {
            let at = |l: usize| l * (l + 1);
            let mut column = |place: &dyn Fn(usize) -> usize, first: f64| {
                values[place(m)] = first;
                for l in m..self.degree {
                    let below =
                        if l > m { self.ratios[at(l) + m] * values[place(l - 1)] } else { 0.0 };
                    values[place(l + 1)] =
                        (dir.z * values[place(l)] - below) / self.ratios[at(l + 1) + m];
                }
            };
            column(&|l| at(l) + m, self.sectoral[m] * re);
            if m > 0 {
                column(&|l| at(l) - m, self.sectoral[m] * im);
            }
            (re, im) = (re * dir.x - im * dir.y, re * dir.y + im * dir.x);
        }
    }
}

/// Returns degree and order of all harmonics to a degree: l = 0, 1, ... and m = -l ..= l.
pub(super) fn orders(degree: usize) -> impl Iterator<Item = (i64, i64)> {
    let degree = i64::try_from(degree).unwrap_or(i64::MAX);
    (0..=degree).flat_map(|l| (-l..=l).map(move |m| (l, m)))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_sh::real_ylm_at;

    use super::{RealHarmonics, orders};

    #[test]
    fn values_are_those_of_the_definition() {
        let z = 1e-9;
        let dirs = [
            DVec3::Z,
            DVec3::NEG_Z,
            DVec3::X,
            DVec3::NEG_Y,
            DVec3::new(0.48, -0.6, 0.64),
            DVec3::new(z, -2.0 * z, 1.0).normalize(),
        ];
        for degree in [0, 1, 4, 10] {
            let harmonics = RealHarmonics::new(degree);
            let mut values = vec![f64::NAN; (degree + 1).pow(2)];
            for dir in dirs {
                harmonics.values_into(dir, &mut values);
                for ((l, m), value) in orders(degree).zip(&values) {
                    let expected = real_ylm_at(usize::try_from(l).unwrap(), m, dir).unwrap();
                    assert!((value - expected).abs() < 1e-14, "{l} {m} {dir}: {value} {expected}");
                }
            }
        }
    }
}
