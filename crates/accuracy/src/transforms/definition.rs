use std::ops::Mul;

use crate::reference::{AcuteAngle, DoubleDouble, LegendreColumn, power};
use glam::DVec3;
use sphvar_sh::Alm;

/// A complex number of twice the working precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Complex {
    pub(crate) re: DoubleDouble,
    pub(crate) im: DoubleDouble,
}

impl Complex {
    pub(crate) const ZERO: Self = Self { re: DoubleDouble::ZERO, im: DoubleDouble::ZERO };
    pub(crate) const ONE: Self = Self { re: DoubleDouble::ONE, im: DoubleDouble::ZERO };

    pub(crate) fn add_product(&mut self, value: Self, factor: DoubleDouble) {
        self.re += value.re * factor;
        self.im += value.im * factor;
    }
}

impl Mul for Complex {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }
}

/// A weighted set of points grouped by common colatitudes.
///
/// It evaluates the definition of the transforms, `a_lm = sum_k w_k conj Y_lm(x_k)`, term by term
/// in twice the working precision. Points are directions: vectors are normalized in that precision.
#[derive(Debug)]
pub(crate) struct Definition {
    rings: Vec<Ring>,
}

/// Points of one colatitude or of its mirror image in the equator.
#[derive(Debug)]
struct Ring {
    angle: AcuteAngle,
    places: Vec<Place>,
}

#[derive(Debug)]
struct Place {
    /// `e^{-i phi}`.
    phase: Complex,
    weight: DoubleDouble,
    south: bool,
}

impl Definition {
    /// Groups the points. Successive points that differ by the signs of coordinates, or by an
    /// exchange of x and y, share a ring. `weights` are 1 if there are none.
    pub(crate) fn new(points: &[DVec3], weights: Option<&[f64]>) -> Self {
        let mut rings: Vec<Ring> = Vec::new();
        let mut last = None;
        for (k, p) in points.iter().enumerate() {
            let weight = DoubleDouble::from(weights.map_or(1.0, |w| w[k]));
            let place = Place { phase: phase(*p), weight, south: p.z < 0.0 };
            let a = p.abs();
            let shape = Some((a.x.min(a.y).to_bits(), a.x.max(a.y).to_bits(), a.z.to_bits()));
            match rings.last_mut() {
                Some(ring) if shape == last => ring.places.push(place),
                _ => {
                    let angle = AcuteAngle::from_direction([p.x, p.y, a.z]);
                    rings.push(Ring { angle, places: vec![place] });
                    last = shape;
                }
            }
        }
        Self { rings }
    }

    /// Returns `a_lm` for l = m ..= lmax. Cost `O((lmax + m) R + N log m)` with R rings.
    pub(crate) fn column(&self, m: usize, lmax: usize) -> Vec<Complex> {
        let mut sums = vec![Complex::ZERO; lmax + 1 - m];
        for ring in &self.rings {
            // By the parity of l - m, which relates the functions of the southern to those of the
            // northern hemisphere.
            let mut terms = [Complex::ZERO; 2];
            for place in &ring.places {
                let phase = power(Complex::ONE, place.phase, m as u64);
                terms[0].add_product(phase, place.weight);
                terms[1].add_product(phase, if place.south { -place.weight } else { place.weight });
            }
            let lambdas = LegendreColumn::new(m as u64, ring.angle);
            for ((sum, lambda), term) in sums.iter_mut().zip(lambdas).zip(terms.iter().cycle()) {
                sum.add_product(*term, lambda.value);
            }
        }
        sums
    }
}

/// Returns the value `sum_lm a_lm Y_lm(p)` of a real function. Cost `O(lmax^2)`.
pub(super) fn value_at(p: DVec3, alm: &Alm) -> DoubleDouble {
    let angle = AcuteAngle::from_direction(p.to_array());
    let phase = phase(p);
    let mut sum = DoubleDouble::ZERO;
    for m in 0..=alm.lmax() {
        let mut of_order = Complex::ZERO;
        for (a, lambda) in alm.column(m).iter().zip(LegendreColumn::new(m as u64, angle)) {
            let a = Complex { re: DoubleDouble::from(a.re), im: DoubleDouble::from(a.im) };
            of_order.add_product(a, lambda.value);
        }
        // Orders m and -m are complex conjugates; the phase is that of the conjugate harmonic.
        let phase = power(Complex::ONE, phase, m as u64);
        let real = of_order.re * phase.re + of_order.im * phase.im;
        sum += if m == 0 { real } else { real + real };
    }
    sum
}

/// Returns `e^{-i phi}`; 1 at a pole.
fn phase(p: DVec3) -> Complex {
    let [x, y] = [p.x, p.y].map(DoubleDouble::from);
    let length = (x * x + y * y).sqrt();
    if length == DoubleDouble::ZERO {
        return Complex::ONE;
    }
    Complex { re: x / length, im: -y / length }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use num_complex::Complex as Rounded;
    use sphvar_sh::{Alm, ylm_at};

    use super::{Definition, value_at};

    /// Comparison with the functions of the `sphvar-sh` crate, to their accuracy.
    #[test]
    fn coefficients_of_single_points_are_spherical_harmonics() {
        let p = DVec3::new(0.36, -0.48, 0.8);
        let points = [p, p * DVec3::new(1.0, -1.0, -1.0), p * -1.0, DVec3::NEG_Z, DVec3::X];
        let weights = [1.0, 0.5, -0.25, 2.0, 3.0];
        let lmax = 12;
        let definition = Definition::new(&points, Some(&weights));
        assert_eq!(definition.rings.len(), 3, "mirror images share a ring");
        let mut alm = Alm::zeros(lmax).unwrap();
        for m in 0..=lmax {
            for (l, got) in (m..).zip(definition.column(m, lmax)) {
                let order = i64::try_from(m).unwrap();
                let terms = points.iter().zip(weights);
                let expected: Rounded<f64> =
                    terms.map(|(p, w)| ylm_at(l, order, *p).unwrap().conj() * w).sum();
                let got = Rounded::new(got.re.value(), got.im.value());
                alm[(l, m)] = got;
                // Five terms of size 1, each accurate to 4 (l + 1) EPSILON.
                assert!((got - expected).norm() < 1e-13, "l = {l}, m = {m}: {got} {expected}");
            }
        }
        // <A w, A w> = <w, A* A w>
        let by_points: f64 =
            points.iter().zip(weights).map(|(p, w)| w * value_at(*p, &alm).value()).sum();
        let by_degrees: f64 = alm.energy_per_degree().iter().sum();
        assert!((by_points / by_degrees - 1.0).abs() < 1e-13, "{by_points} and {by_degrees}");
    }
}
