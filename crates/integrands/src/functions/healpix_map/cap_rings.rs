use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

use num_complex::Complex;
use rayon::prelude::*;
use sphvar_nufft::parts::{Design, Fft, FftDirection, Real, WindowTable};
use sphvar_sht::{DenseRingTransform, RingSums};

use super::height_rule::{HeightNode, HeightRule};

/// The number of cells of the window.
const WIDTH: usize = 16;
/// Number of frequencies stored before 0.
const MARGIN: usize = WIDTH / 2;
/// A grid serves rings down to this part of the number of pixels of the largest one.
const SHARED_GRID: f64 = 0.87;

/// The sums `sum_k v_k exp(-2 pi i x k/M)` over the pixels of the rings of both caps as functions of
/// a real frequency x.
///
/// On a circle at the distance s from the pole, in units of rings, a quarter turn of ring i has i
/// pixels of the width `pi/(2 s)`, and the order m has the frequency `x = m M/(4 s)`. The sums are
/// known on a grid of integers x, for which the pixels have been divided by the transform of a
/// window, and are interpolated by this window.
pub(super) struct CapRings {
    table: WindowTable<f64>,
    rings: Vec<CapRing>,
}

/// The rings at one distance from both poles.
struct CapRing {
    /// The size M of the grid.
    cells: usize,
    /// The pixel in the middle of a quarter, from which pixels are counted.
    middle: usize,
    /// The number of frequencies of each class.
    stored: usize,
    /// Real and imaginary part of the northern ring, then of the southern one, of frequencies from
    /// `-MARGIN` on, for each class of orders modulo 4.
    sums: Vec<[f64; 4]>,
}

/// A grid for the rings of similar size.
struct Grid {
    cells: usize,
    /// The reciprocal of the window's transform by distance from the middle pixel.
    correction: Vec<f64>,
    fft: Arc<dyn Fft<f64>>,
}

impl CapRings {
    /// Transforms the rings 1 to n of the caps. `rings` returns the northern and the southern ring at
    /// a distance from the poles, the latter only if it counts.
    pub(super) fn new<'a>(
        rule: &HeightRule,
        transform: &DenseRingTransform,
        rings: impl Fn(usize) -> [Option<&'a [f64]>; 2] + Sync,
    ) -> Self {
        let design = Design::finest();
        let n = rule.nside();
        let mut grids: Vec<Grid> = Vec::new();
        let mut grid_of = vec![0; n];
        let mut smallest = n + 1;
        for ring in (1..=n).rev() {
            if ring < smallest {
                let half = ring / 2 + 1;
                let cells = design.cells(half);
                let transform = design.window.transform(cells, half);
                let correction = transform.into_iter().map(f64::recip).collect();
                let fft = f64::fourier_plan(cells, FftDirection::Forward);
                grids.push(Grid { cells, correction, fft });
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a part of a positive number"
                )]
                let min = (SHARED_GRID * ring as f64) as usize;
                smallest = min.max(1);
            }
            grid_of[ring - 1] = grids.len() - 1;
        }
        // The largest order over 4 s at the nodes of a panel.
        let frequency = |panel: usize| {
            let (first, nodes) = rule.panel(panel);
            let orders = (first..).zip(nodes).map(|(pair, node)| {
                // Orders are evaluated in blocks.
                let last = transform.last_order(pair).min(transform.lmax() as f64);
                let blocks = (last / RingSums::ORDERS as f64).floor() + 1.0;
                0.25 * blocks * RingSums::ORDERS as f64 / (panel as f64 + node.share)
            });
            orders.fold(0.0, f64::max)
        };
        let frequencies: Vec<f64> = (0..n).map(frequency).collect();
        let ring = |ring: usize, scratch: &mut Scratch| {
            let panels = &frequencies[ring - 1..n.min(ring + 1)];
            let frequency = panels.iter().copied().fold(0.0, f64::max);
            CapRing::new(ring, &grids[grid_of[ring - 1]], frequency, rings(ring), scratch)
        };
        let rings = (1..n + 1).into_par_iter();
        let rings = rings.map_init(Scratch::default, |scratch, i| ring(i, scratch)).collect();
        Self { table: design.window.table(), rings }
    }
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    /// Orders that are 0 and 2 modulo 4, the latter times i, and 1 modulo 4.
    classes: [Vec<Complex<f64>>; 2],
    fft: Vec<Complex<f64>>,
}

impl CapRing {
    fn new(
        ring: usize,
        grid: &Grid,
        frequency: f64,
        values: [Option<&[f64]>; 2],
        scratch: &mut Scratch,
    ) -> Self {
        let Grid { cells, correction, fft } = grid;
        let (cells, middle) = (*cells, ring / 2);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
        let needed = (frequency * cells as f64).min(cells as f64) as usize + 1;
        let stored = needed + 2 * MARGIN + 1;
        let mut sums = vec![[0.0; 4]; 4 * stored];
        scratch.fft.resize(fft.get_inplace_scratch_len(), Complex::ZERO);
        for (part, values) in values.into_iter().enumerate() {
            let Some(values) = values else { continue };
            let quarters = values.len() / 4;
            let quarter = |q: usize| &values[q * quarters..][..quarters];
            for class in &mut scratch.classes {
                class.clear();
                class.resize(cells, Complex::ZERO);
            }
            let [even, odd] = &mut scratch.classes;
            for k in 0..quarters {
                let [a, b, c, d] = [0, 1, 2, 3].map(|q| quarter(q)[k]);
                // Counted from the middle, the pixels before it are at the end of the grid.
                let (place, distance) = if k >= middle {
                    (k - middle, k - middle)
                } else {
                    (cells + k - middle, middle - k)
                };
                let factor = correction[distance];
                even[place] = Complex::new((a + c) + (b + d), (a + c) - (b + d)) * factor;
                odd[place] = Complex::new(a - c, d - b) * factor;
            }
            for class in [&mut *even, odd] {
                fft.process_with_scratch(class, &mut scratch.fft);
            }
            for (i, at) in (0..stored).map(|i| (i, (cells + i - MARGIN) % cells)) {
                let opposite = (cells - at) % cells;
                let (here, there) = (even[at], even[opposite].conj());
                let (sum, difference) = (0.5 * (here + there), 0.5 * (here - there));
                let by_class = [
                    sum,
                    odd[at],
                    Complex::new(difference.im, -difference.re),
                    odd[opposite].conj(),
                ];
                for (class, value) in by_class.into_iter().enumerate() {
                    let place = &mut sums[class * stored + i];
                    [place[2 * part], place[2 * part + 1]] = [value.re, value.im];
                }
            }
        }
        Self { cells, middle, stored, sums }
    }
}

/// A node of a cap, prepared for all orders.
pub(super) struct CapNode {
    /// The distance from the pole in rings.
    distance: f64,
    weight: f64,
    /// The ring at or before the distance, if any, and the next one.
    bands: [Option<Band>; 2],
}

/// The intervals of longitude of a ring at a node.
struct Band {
    /// The ring, counted from 0.
    ring: usize,
    /// The longitude of the middle of the middle interval of the first quarter.
    middle: f64,
    /// Half of the width of an interval.
    half: f64,
    /// `exp(-i middle)` and `exp(i half)`.
    turns: [Complex<f64>; 2],
}

impl CapRings {
    /// Prepares a node of the panel from ring `panel`, or the pole, to the next one.
    pub(super) fn node(&self, panel: usize, node: &HeightNode) -> CapNode {
        let share = node.share;
        let distance = panel as f64 + share;
        // The edges of a pixel meet where the next rings begin.
        let band = |ring: usize, from: f64, width: f64| {
            let half = FRAC_PI_4 * width / distance;
            let pixels = self.rings[ring].middle as f64 + from;
            let middle = pixels * (FRAC_PI_2 / distance) + half;
            Band { ring, middle, half, turns: [Complex::cis(-middle), Complex::cis(half)] }
        };
        let before = panel.checked_sub(1).map(|ring| band(ring, share, 1.0 - share));
        let bands = [before, Some(band(panel, 0.0, share))];
        CapNode { distance, weight: node.weight, bands }
    }

    /// Replaces `out` by the values of the node and its reflection for the orders from `first` to
    /// lmax.
    #[inline(always)]
    pub(super) fn evaluate<const FUSED: bool>(
        &self,
        node: &CapNode,
        first: usize,
        lmax: usize,
        out: &mut [[Complex<f64>; RingSums::ORDERS]; 2],
    ) {
        *out = [[Complex::ZERO; RingSums::ORDERS]; 2];
        let mut frequencies = Frequencies::default();
        for band in node.bands.iter().flatten() {
            let ring = &self.rings[band.ring];
            if ring.cells != frequencies.cells {
                frequencies.fill::<FUSED>(&self.table, ring.cells, node.distance, first);
            }
            let factors = band.factors(first, lmax, node.weight);
            for i in 0..RingSums::ORDERS {
                let class = (first + i) % 4 * ring.stored;
                let sums = &ring.sums[class + frequencies.places[i]..][..WIDTH];
                let [a, b, c, d] = dot::<FUSED>(&frequencies.windows[i], sums);
                out[0][i] += Complex::new(a, b) * factors[i];
                out[1][i] += Complex::new(c, d) * factors[i];
            }
        }
    }
}

/// The windows at the frequencies of a block of orders.
#[derive(Default)]
struct Frequencies {
    /// The size of the grid, 0 before the first.
    cells: usize,
    places: [usize; RingSums::ORDERS],
    windows: [[f64; WIDTH]; RingSums::ORDERS],
}

impl Frequencies {
    #[inline(always)]
    fn fill<const FUSED: bool>(
        &mut self,
        table: &WindowTable<f64>,
        cells: usize,
        distance: f64,
        first: usize,
    ) {
        self.cells = cells;
        let cells = cells as f64;
        let per_order = 0.25 * cells / distance;
        let mut t = [0.0; RingSums::ORDERS];
        for (i, (t, cell)) in t.iter_mut().zip(&mut self.places).enumerate() {
            let x = (first + i) as f64 * per_order;
            let x = if x < cells { x } else { x - cells * (x / cells).floor() };
            let place = (x - MARGIN as f64).ceil();
            *t = 2.0 * (x - place - MARGIN as f64) + 1.0;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0")]
            let place = (place + MARGIN as f64) as usize;
            *cell = place;
        }
        let pairs = self.windows.as_chunks_mut::<2>().0.iter_mut().zip(t.as_chunks::<2>().0);
        for (windows, &t) in pairs {
            *windows = table.evaluate::<WIDTH, MARGIN, FUSED>(t);
        }
    }
}

impl Band {
    /// Returns `int e^{-i m phi}` over the middle interval times the weight, 0 beyond lmax.
    #[inline(always)]
    fn factors(&self, first: usize, lmax: usize, weight: f64) -> [Complex<f64>; RingSums::ORDERS] {
        let order = first as f64;
        let [middle, half] = self.turns;
        let turn = powers(Complex::cis(-order * self.middle), middle);
        let open = powers(Complex::cis(order * self.half), half);
        let count = (lmax + 1 - first).min(RingSums::ORDERS);
        let mut factors = [Complex::ZERO; RingSums::ORDERS];
        for i in 0..count {
            let width = if first + i == 0 { self.half } else { open[i].im / (first + i) as f64 };
            factors[i] = turn[i] * (2.0 * width * weight);
        }
        factors
    }
}

/// Returns `start z^i`.
#[inline(always)]
fn powers(start: Complex<f64>, z: Complex<f64>) -> [Complex<f64>; RingSums::ORDERS] {
    let mut powers = [start; RingSums::ORDERS];
    let (mut factor, mut step) = (z, 1);
    while step < RingSums::ORDERS {
        for i in step..2 * step {
            powers[i] = powers[i - step] * factor;
        }
        factor = factor * factor;
        step *= 2;
    }
    powers
}

#[inline(always)]
fn dot<const FUSED: bool>(window: &[f64; WIDTH], sums: &[[f64; 4]]) -> [f64; 4] {
    let mut parts = [[0.0; 4]; 2];
    for (window, sums) in window.as_chunks::<2>().0.iter().zip(sums.as_chunks::<2>().0) {
        for p in 0..2 {
            for i in 0..4 {
                parts[p][i] = sums[p][i].times_plus::<FUSED>(window[p], parts[p][i]);
            }
        }
    }
    std::array::from_fn(|i| parts[0][i] + parts[1][i])
}
