//! Products of a function with the real spherical harmonics of low degree, by their coefficients.
//!
//! The harmonics are polynomials in x, y and z, and the products with these coordinates are sums of
//! two or four coefficients of neighbouring degrees and orders (Varshalovich, Moskalev and
//! Khersonskii 1988, section 5.8). The recurrences of the harmonics
//!
//! ```text
//! Y_{l+1,m} A_{l+1,m} = z Y_lm - A_lm Y_{l-1,m},   A_lm^2 = (l^2 - m^2)/(4 l^2 - 1)
//! Y_{m,+-m} ~ Re, Im (x + i y)^m
//! ```
//!
//! therefore hold for the products with a function, coefficient by coefficient: no grid is needed,
//! and each product costs one pass over the coefficients.

use std::f64::consts::{PI, SQRT_2};

use num_complex::Complex;
use sphvar_sh::{Alm, Error};

/// Calls `visit` with l, m and the coefficients of `f Y_lm` for every real harmonic of degree
/// l <= `degree` (m < 0: the sine), which reach the degree `f.lmax() - l`.
pub(super) fn for_each_product(
    f: &Alm,
    degree: usize,
    mut visit: impl FnMut(usize, i64, &Alm),
) -> Result<(), Error> {
    let degree = degree.min(f.lmax());
    let roots = Roots::new(f.lmax());
    // f Re (x + i y)^m and f Im (x + i y)^m.
    let (mut cosine, mut sine): (Alm, Option<Alm>) = (f.clone(), None);
    let mut norm = 1.0 / (4.0 * PI).sqrt();
    for (m, order) in (0..=degree).zip(0_i64..) {
        if m > 0 {
            let (x, y) = (Complex::new(0.5, 0.0), Complex::new(0.0, -0.5));
            let mut next = [cosine.lmax(); 2].map(|lmax| Alm::zeros(lmax - 1));
            if let [Ok(cosines), Ok(sines)] = &mut next {
                roots.add_product(&cosine, x, cosines);
                roots.add_product(&cosine, y, sines);
                if let Some(sine) = &sine {
                    roots.add_product(sine, -y, cosines);
                    roots.add_product(sine, x, sines);
                }
            }
            let [cosines, sines] = next;
            (cosine, sine) = (cosines?, Some(sines?));
            norm *= -((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
        }
        let size = if m == 0 { norm } else { norm * SQRT_2 };
        roots.column(scaled(&cosine, size), m, degree, |l, product| visit(l, order, product))?;
        if let Some(sine) = &sine {
            roots.column(scaled(sine, size), m, degree, |l, product| visit(l, -order, product))?;
        }
    }
    Ok(())
}

fn scaled(f: &Alm, factor: f64) -> Alm {
    let mut scaled = f.clone();
    scaled.values_mut().iter_mut().for_each(|a| *a *= factor);
    scaled
}

/// Square roots from which the factors of the recurrences are products.
struct Roots {
    /// `sqrt(k)`.
    root: Vec<f64>,
    /// `1/sqrt((2l - 1)(2l + 1))`, 0 for l = 0.
    inverse: Vec<f64>,
}

impl Roots {
    fn new(lmax: usize) -> Self {
        let odd = |l: usize| (2 * l) as f64;
        Self {
            root: (0..=2 * lmax + 2).map(|k| (k as f64).sqrt()).collect(),
            inverse: std::iter::once(0.0)
                .chain((1..=lmax + 1).map(|l| 1.0 / ((odd(l) - 1.0) * (odd(l) + 1.0)).sqrt()))
                .collect(),
        }
    }

    /// Returns `A_lm` of the recurrence in z.
    fn a(&self, l: usize, m: usize) -> f64 {
        self.root[l - m] * self.root[l + m] * self.inverse[l]
    }

    /// Calls `visit` with the products of degree m to `degree` at one order, from that of degree m.
    fn column(
        &self,
        first: Alm,
        m: usize,
        degree: usize,
        mut visit: impl FnMut(usize, &Alm),
    ) -> Result<(), Error> {
        let (mut before, mut product): (Option<Alm>, Alm) = (None, first);
        visit(m, &product);
        for l in m..degree {
            let mut next = Alm::zeros(product.lmax() - 1)?;
            let (subtracted, factor) = (self.a(l, m), 1.0 / self.a(l + 1, m));
            for order in 0..=next.lmax() {
                let column = product.column(order);
                for (i, value) in next.column_mut(order).iter_mut().enumerate() {
                    let degree = order + i;
                    *value = column[i + 1] * self.a(degree + 1, order);
                    if i > 0 {
                        *value += column[i - 1] * self.a(degree, order);
                    }
                }
                if let Some(before) = &before {
                    for (value, b) in next.column_mut(order).iter_mut().zip(before.column(order)) {
                        *value -= b * subtracted;
                    }
                }
            }
            next.values_mut().iter_mut().for_each(|value| *value *= factor);
            visit(l + 1, &next);
            before = Some(std::mem::replace(&mut product, next));
        }
        Ok(())
    }

    /// Adds the coefficients of `(w u + conj(w) conj(u)) f` with u = x + i y to `sum`, whose degree
    /// is that of f minus 1: w = 1/2 is the product with x, w = -i/2 that with y.
    fn add_product(&self, f: &Alm, w: Complex<f64>, sum: &mut Alm) {
        let r = &self.root;
        for m in 0..=sum.lmax() {
            for l in m..=sum.lmax() {
                let (above, below) = (self.inverse[l + 1], self.inverse[l]);
                // The coefficient of order m - 1.
                let lower = |l: usize| match m {
                    0 => -f[(l, 1)].conj(),
                    _ => f[(l, m - 1)],
                };
                let mut raised = lower(l + 1) * (r[l - m + 1] * r[l - m + 2] * above);
                if l + m > 1 {
                    raised -= lower(l - 1) * (r[l + m] * r[l + m - 1] * below);
                }
                let mut lowered = f[(l + 1, m + 1)] * (-r[l + m + 1] * r[l + m + 2] * above);
                if l > m + 1 {
                    lowered += f[(l - 1, m + 1)] * (r[l - m] * r[l - m - 1] * below);
                }
                sum[(l, m)] += w * raised + w.conj() * lowered;
            }
        }
    }
}
