use num_complex::Complex;
use rayon::prelude::*;
use sphvar_nufft::parts::{FftDirection, Real};
use sphvar_sht::RingSums;

/// The discrete Fourier transforms of rings of `4 nside` pixels.
pub(super) struct BeltRings {
    n: usize,
    /// The number of stored frequencies of a ring.
    stored: usize,
    spectra: Vec<Complex<f64>>,
}

/// Where the orders of a block are among the stored frequencies, which are those of real values.
pub(super) struct BeltOrders {
    /// The index and the sign of the imaginary part.
    places: [(usize, f64); RingSums::ORDERS],
    /// `exp(-i m phi)` at half a pixel.
    half_pixel: [Complex<f64>; RingSums::ORDERS],
}

impl BeltRings {
    /// Transforms `rings` of a map, each of `4 n` pixels, for orders up to `lmax`.
    pub(super) fn new(n: usize, lmax: usize, rings: &[f64]) -> Self {
        let len = 4 * n;
        let stored = lmax.min(2 * n) + 1;
        let mut spectra = vec![Complex::ZERO; rings.len() / len * stored];
        let fft = f64::fourier_plan(len, FftDirection::Forward);
        let workspace = || {
            let scratch = vec![Complex::ZERO; fft.get_inplace_scratch_len()];
            (vec![Complex::ZERO; len + 1], scratch)
        };
        // Two real rings share a complex transform.
        let pairs = spectra.par_chunks_mut(2 * stored).zip(rings.par_chunks(2 * len));
        pairs.for_each_init(workspace, |(values, scratch), (spectra, rings)| {
            let (first, second) = rings.split_at(len);
            for (i, (value, &re)) in values.iter_mut().zip(first).enumerate() {
                *value = Complex::new(re, second.get(i).copied().unwrap_or(0.0));
            }
            fft.process_with_scratch(&mut values[..len], scratch);
            values[len] = values[0];
            let (first, second) = spectra.split_at_mut(stored);
            let halves = values.iter().zip(values.iter().rev());
            for (i, (here, there)) in halves.take(stored).enumerate() {
                let (sum, difference) = (here + there.conj(), here - there.conj());
                first[i] = 0.5 * sum;
                if let Some(second) = second.get_mut(i) {
                    *second = 0.5 * Complex::new(difference.im, -difference.re);
                }
            }
        });
        Self { n, stored, spectra }
    }

    /// Returns the number of rings.
    pub(super) fn len(&self) -> usize {
        self.spectra.len() / self.stored
    }

    /// Returns the places of the orders from `first` on.
    pub(super) fn orders(&self, first: usize) -> BeltOrders {
        let (n, len) = (self.n as f64, 4 * self.n);
        let place = |m: usize| {
            let here = m % len;
            let there = len - here;
            let (k, sign) = if here <= there { (here, 1.0) } else { (there, -1.0) };
            // Orders beyond lmax may have no place.
            (k.min(self.stored - 1), sign)
        };
        let turn = |m: usize| Complex::cis(-std::f64::consts::FRAC_PI_4 * m as f64 / n);
        BeltOrders {
            places: std::array::from_fn(|i| place(first + i)),
            half_pixel: std::array::from_fn(|i| turn(first + i)),
        }
    }

    /// Returns `sum_k v_k exp(-i m phi_k)` over the pixel centres of a ring, counted from the first
    /// ring of the belt, whose pixels are shifted by half a pixel if the number is even.
    #[inline(always)]
    pub(super) fn get(&self, ring: usize, orders: &BeltOrders) -> [Complex<f64>; RingSums::ORDERS] {
        let spectrum = &self.spectra[ring * self.stored..][..self.stored];
        std::array::from_fn(|i| {
            let (place, sign) = orders.places[i];
            let value = Complex::new(spectrum[place].re, sign * spectrum[place].im);
            if ring.is_multiple_of(2) { value * orders.half_pixel[i] } else { value }
        })
    }
}
