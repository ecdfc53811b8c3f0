use crate::reference::DoubleDouble;
use sphvar_samplers::{Domain, EqualArea, Placement};

use super::pair_sums::legendre;

/// A zone of the sphere that meridians divide into equal regions.
struct Zone {
    /// The heights of the upper and the lower parallel.
    z: [DoubleDouble; 2],
    regions: DoubleDouble,
}

/// Returns the power of one uniform point in each of n zonal regions of equal area, by closed forms
/// in twice the working precision, for degrees 0 ..= lmax; the value of degree 0 is 0.
///
/// ```text
/// P(l) = 1 - (1/n) sum_k E P_l(x.y),   x and y independent and uniform in region k
/// a full turn:   E P_l(x.y) = (E P_l(z))^2,   (2l+1) int P_l = P_{l+1} - P_{l-1}
/// any region:    E x.y = |E x|^2,   E (x.y)^2 = |E x x'|^2 (Frobenius)
/// ```
///
/// `lmax` is at most 2 unless every region is a full turn, which is so for n of 2 and 3.
pub(super) fn power(n: usize, lmax: usize) -> Vec<DoubleDouble> {
    let number = |n: u32| DoubleDouble::from(f64::from(n));
    let strata = EqualArea::new(n, Domain::Sphere, Placement::Jittered);
    let strata = strata.expect("any number of regions exists");
    let all = DoubleDouble::from(n as f64);
    let height = |above: u32| DoubleDouble::ONE - number(2 * above) / all;
    let mut above = 0;
    let mut sums = vec![DoubleDouble::ZERO; lmax + 1];
    for regions in strata.zones() {
        let z = [height(above), height(above + regions)];
        above += regions;
        let zone = Zone { z, regions: number(regions) };
        let means = if regions == 1 { zone.of_full_turn(lmax) } else { zone.of_region() };
        for (sum, mean) in sums.iter_mut().zip(means) {
            *sum += zone.regions * mean;
        }
    }
    sums.into_iter().map(|sum| DoubleDouble::ONE - sum / all).collect()
}

impl Zone {
    /// Returns `E P_l(x.y)` of the whole zone.
    fn of_full_turn(&self, lmax: usize) -> Vec<DoubleDouble> {
        let [high, low] = self.z;
        let values = self.z.map(|z| legendre(z).take(lmax + 2).collect::<Vec<_>>());
        let mean = |l: usize| {
            let [high_step, low_step] = [0, 1].map(|i: usize| values[i][l + 1] - values[i][l - 1]);
            let odd = DoubleDouble::from((2 * l + 1) as f64);
            let mean = (high_step - low_step) / (odd * (high - low));
            mean * mean
        };
        std::iter::once(DoubleDouble::ONE).chain((1..=lmax).map(mean)).collect()
    }

    /// Returns `E P_l(x.y)` of one region for l = 0, 1, 2, from the moments of its coordinates.
    fn of_region(&self) -> Vec<DoubleDouble> {
        let number = |x: f64| DoubleDouble::from(x);
        let one = DoubleDouble::ONE;
        let [a, b] = self.z;
        let height = a - b;
        let [sin_a, sin_b] = self.z.map(|z| (one - z * z).sqrt());
        // Means of z, z^2, s = sqrt(1 - z^2), z s and s^2 over the heights.
        let primitive = |z: DoubleDouble, s: DoubleDouble| z * s + DoubleDouble::atan2(z, s);
        let z = (a + b) / number(2.0);
        let zz = (a * a + a * b + b * b) / number(3.0);
        let s = (primitive(a, sin_a) - primitive(b, sin_b)) / (number(2.0) * height);
        let cube = |x: DoubleDouble| x * x * x;
        let zs = (cube(sin_b) - cube(sin_a)) / (number(3.0) * height);
        let ss = one - zz;
        // Means of cos phi and cos 2 phi over the longitudes, phi from the middle.
        let half_width = DoubleDouble::pi() / self.regions;
        let sinc = |angle: DoubleDouble| angle.sin_cos().0 / angle;
        let (once, twice) = (sinc(half_width), sinc(number(2.0) * half_width));
        let first = z * z + s * s * once * once;
        // E x x' of x = (s cos phi, s sin phi, z).
        let [xx, yy] = [one + twice, one - twice].map(|f| ss * f / number(2.0));
        let xz = zs * once;
        let square = xx * xx + yy * yy + zz * zz + number(2.0) * xz * xz;
        vec![one, first, (number(3.0) * square - one) / number(2.0)]
    }
}

#[cfg(test)]
mod tests {
    use crate::reference::DoubleDouble;

    use super::{Zone, power};

    /// Two hemispheres: `1 - (int_0^1 P_l)^2`, 3/4 for l = 1, 1 for l = 2 and 1 - 1/64 for l = 3.
    #[test]
    fn hemispheres_are_known() {
        let expected = [0.0, 0.75, 1.0, 63.0 / 64.0];
        for (l, (got, expected)) in power(2, 3).into_iter().zip(expected).enumerate() {
            assert!((got.value() - expected).abs() < 1e-30, "l = {l}: {}", got.value());
        }
    }

    /// Both forms for a zone that is one region.
    #[test]
    fn moments_are_those_of_full_turns() {
        for z in [[1.0, 0.25], [0.5, -0.125], [-0.75, -1.0]] {
            let zone = Zone { z: z.map(DoubleDouble::from), regions: DoubleDouble::ONE };
            for (l, (a, b)) in zone.of_full_turn(2).into_iter().zip(zone.of_region()).enumerate() {
                assert!((a - b).value().abs() < 1e-29, "{z:?}, l = {l}: {}", (a - b).value());
            }
        }
    }
}
