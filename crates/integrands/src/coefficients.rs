use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};
use num_complex::Complex;
use sphvar_sh::{Alm, Colatitude, GaussLegendre, LegendrePlan, ylm_at};
use sphvar_sht::{ExactTransform, ExactWorkspace, FastTransform, FastWorkspace};

use crate::Error;
use crate::shape::{coaxial, colatitude_between};

/// The harmonic coefficients of a function, `F_lm = int F conj Y_lm`, to some degree.
///
/// The sum of zonal parts, each about its own axis and with one coefficient per degree,
///
/// ```text
/// F(x) = sum_l c_l Y_l0(angle between x and axis) + ...,   Y_l0 = sqrt((2l+1)/(4 pi)) P_l
/// ```
///
/// of parts that have a few orders in a frame of their own, and of a general part with all orders. Zonal parts take memory and time proportional to the
/// degree, which makes degrees of 100000 practical; inner products between them need only `P_l` of
/// the angle between their axes.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_integrands::Coefficients;
///
/// // Y_10 about z and about x, which are orthogonal.
/// let z = Coefficients::zonal(DVec3::Z, vec![0.0, 1.0])?;
/// let x = Coefficients::zonal(DVec3::X, vec![0.0, 1.0])?;
/// assert!((z.inner_per_degree(&z)?[1] - 1.0).abs() < 1e-15);
/// assert!(z.inner_per_degree(&x)?[1].abs() < 1e-16);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Coefficients {
    lmax: usize,
    zonals: Vec<Zonal>,
    /// In different frames.
    framed: Vec<Framed>,
    general: Option<Alm>,
}

/// Coefficients of a function of the angle from an axis.
#[derive(Clone, Debug)]
struct Zonal {
    axis: DVec3,
    per_degree: Vec<f64>,
}

/// Coefficients of some orders in another frame.
#[derive(Clone, Debug)]
struct Framed {
    /// From that frame to the frame of the function.
    frame: DMat3,
    /// Ascending orders m, each with the degrees from m to lmax.
    columns: Vec<(usize, Vec<Complex<f64>>)>,
}

impl Coefficients {
    /// Returns the function with coefficients `per_degree` (l = 0 ..= lmax, at least one) of `Y_l0`
    /// about `axis`.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if `axis` is not a unit vector.
    ///
    /// # Panics
    ///
    /// Panics if `per_degree` is empty.
    pub fn zonal(axis: DVec3, per_degree: Vec<f64>) -> Result<Self, Error> {
        assert!(!per_degree.is_empty(), "the coefficient of degree 0 is always there");
        // The evaluation checks the axis.
        ylm_at(0, 0, axis)?;
        let lmax = per_degree.len() - 1;
        Ok(Self { lmax, zonals: vec![Zonal { axis, per_degree }], framed: vec![], general: None })
    }

    /// Returns the coefficients of all orders.
    #[must_use]
    pub fn general(alm: Alm) -> Self {
        Self { lmax: alm.lmax(), zonals: vec![], framed: vec![], general: Some(alm) }
    }

    /// Returns the function whose coefficients in another frame, from which `frame` leads to that of
    /// the function, are `columns`: ascending orders, each with its degrees up to `lmax`.
    pub(crate) fn in_frame(
        frame: DMat3,
        lmax: usize,
        columns: Vec<(usize, Vec<Complex<f64>>)>,
    ) -> Self {
        Self { lmax, zonals: vec![], framed: vec![Framed { frame, columns }], general: None }
    }

    /// Returns the largest degree, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.lmax
    }

    /// Returns the axis and the coefficients of `Y_l0` about it, if the function is zonal.
    #[must_use]
    pub fn as_zonal(&self) -> Option<(DVec3, &[f64])> {
        match (&self.general, self.zonals.as_slice()) {
            (None, [zonal]) if self.framed.is_empty() => Some((zonal.axis, &zonal.per_degree)),
            _ => None,
        }
    }

    /// Returns `F_00`; the integral is `sqrt(4 pi)` times that.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let zonals: f64 = self.zonals.iter().map(|z| z.per_degree[0]).sum();
        let framed: f64 = self.framed.iter().map(Framed::mean).sum();
        zonals + framed + self.general.as_ref().map_or(0.0, |alm| alm[(0, 0)].re)
    }

    /// `E(l) = sum_m |F_lm|^2` for l = 0 ..= lmax.
    ///
    /// The cost is O(lmax^2) with a general part, otherwise O(lmax) per pair of axes and per order
    /// of a frame, or O(lmax^2) per axis if there are more than lmax axes. Parts of different frames
    /// are rotated.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if lmax exceeds the supported degrees.
    pub fn energy_per_degree(&self) -> Result<Vec<f64>, Error> {
        if self.has_many_axes() || self.has_frames_beside(None) {
            return Ok(self.to_alm()?.energy_per_degree());
        }
        let mut energy = match &self.general {
            Some(alm) => alm.energy_per_degree(),
            None => vec![0.0; self.lmax + 1],
        };
        for framed in &self.framed {
            framed.add_inner(1.0, framed, &mut energy);
        }
        for (i, zonal) in self.zonals.iter().enumerate() {
            for (e, c) in energy.iter_mut().zip(&zonal.per_degree) {
                *e += c * c;
            }
            for other in &self.zonals[..i] {
                add(&mut energy, 2.0, &zonal.inner(other)?);
            }
            for framed in &self.framed {
                add(&mut energy, 2.0, &zonal.inner_framed(framed, self.lmax)?);
            }
            if let Some(alm) = &self.general {
                add(&mut energy, 2.0, &zonal.inner_general(alm)?);
            }
        }
        // Cancellation leaves rounding errors of either sign.
        Ok(energy.into_iter().map(|e| e.max(0.0)).collect())
    }

    /// Returns `sum_m F_lm conj G_lm` for every degree of both functions.
    ///
    /// # Errors
    ///
    /// Those of [`energy_per_degree`](Self::energy_per_degree).
    pub fn inner_per_degree(&self, other: &Self) -> Result<Vec<f64>, Error> {
        for (many, few) in [(self, other), (other, self)] {
            if many.has_many_axes() {
                return Self::general(many.to_alm()?).inner_per_degree(few);
            }
            if !many.framed.is_empty() && many.has_frames_beside(Some(few)) {
                return Self::general(many.to_alm()?).inner_per_degree(few);
            }
        }
        let mut sum = vec![0.0; self.lmax.min(other.lmax) + 1];
        for a in &self.zonals {
            for b in &other.zonals {
                add(&mut sum, 1.0, &a.inner(b)?);
            }
            for b in &other.framed {
                add(&mut sum, 1.0, &a.inner_framed(b, other.lmax)?);
            }
            if let Some(alm) = &other.general {
                add(&mut sum, 1.0, &a.inner_general(alm)?);
            }
        }
        for a in &self.framed {
            for b in &other.zonals {
                add(&mut sum, 1.0, &b.inner_framed(a, self.lmax)?);
            }
            for b in &other.framed {
                a.add_inner(1.0, b, &mut sum);
            }
        }
        if let Some(a) = &self.general {
            for b in &other.zonals {
                add(&mut sum, 1.0, &b.inner_general(a)?);
            }
            if let Some(b) = &other.general {
                for m in 0..sum.len() {
                    let weight = if m == 0 { 1.0 } else { 2.0 };
                    let products = a.column(m).iter().zip(b.column(m));
                    for (s, (x, y)) in sum[m..].iter_mut().zip(products) {
                        *s += weight * (x * y.conj()).re;
                    }
                }
            }
        }
        Ok(sum)
    }

    /// Returns the degree-l part of the function at a direction, `sum_m F_lm Y_lm(dir)`, for l = 0
    /// ..= lmax.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if `dir` is not a unit vector.
    pub fn values_per_degree(&self, dir: DVec3) -> Result<Vec<f64>, Error> {
        let at = Self::zonal(dir, delta(self.lmax))?;
        self.inner_per_degree(&at)
    }

    /// Returns these coefficients plus `weight` times `other`, up to the smaller of the two
    /// degrees.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is out.
    pub fn plus(mut self, weight: f64, other: &Self) -> Result<Self, Error> {
        self.truncate(other.lmax)?;
        for zonal in &other.zonals {
            self.add_zonal(weight, zonal);
        }
        for framed in &other.framed {
            self.add_framed(weight, framed);
        }
        if let Some(alm) = &other.general {
            let mut sum = match self.general.take() {
                Some(own) => own,
                None => Alm::zeros(self.lmax)?,
            };
            for m in 0..=self.lmax {
                for (s, a) in sum.column_mut(m).iter_mut().zip(alm.column(m)) {
                    *s += a * weight;
                }
            }
            self.general = Some(sum);
        }
        Ok(self)
    }

    /// Returns these coefficients times `weight`.
    #[must_use]
    pub fn scaled(mut self, weight: f64) -> Self {
        for zonal in &mut self.zonals {
            zonal.per_degree.iter_mut().for_each(|c| *c *= weight);
        }
        for (_, column) in self.framed.iter_mut().flat_map(|framed| &mut framed.columns) {
            column.iter_mut().for_each(|a| *a *= weight);
        }
        if let Some(alm) = &mut self.general {
            alm.values_mut().iter_mut().for_each(|a| *a *= weight);
        }
        self
    }

    /// Returns the coefficients of `F(x) + F(-x)`: twice the even degrees, 0 in odd ones.
    #[must_use]
    pub fn even_extension(self) -> Self {
        self.even_part().scaled(2.0)
    }

    /// Returns the coefficients of `(F(x) + F(-x))/2`: the even degrees.
    #[must_use]
    pub fn even_part(mut self) -> Self {
        for zonal in &mut self.zonals {
            zonal.per_degree.iter_mut().skip(1).step_by(2).for_each(|c| *c = 0.0);
        }
        for (m, column) in self.framed.iter_mut().flat_map(|framed| &mut framed.columns) {
            let odd = column.iter_mut().skip((*m + 1) % 2).step_by(2);
            odd.for_each(|a| *a = Complex::ZERO);
        }
        if let Some(alm) = &mut self.general {
            for m in 0..=self.lmax {
                let odd = alm.column_mut(m).iter_mut().skip((m + 1) % 2).step_by(2);
                odd.for_each(|a| *a = Complex::ZERO);
            }
        }
        self
    }

    /// Returns the coefficients of the function after a rotation, `F(R^-1 x)`.
    ///
    /// Zonal parts and those of other frames are exact. The general part is evaluated on a Gauss-Legendre grid, which is exact for band-limited
    /// functions; the result is accurate to rounding up to degree 64 and to a relative 1e-12
    /// beyond.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is out.
    pub fn rotated(mut self, rotation: DMat3) -> Result<Self, Error> {
        for zonal in &mut self.zonals {
            zonal.axis = (rotation * zonal.axis).normalize();
        }
        for framed in &mut self.framed {
            framed.frame = rotation * framed.frame;
        }
        self.general = self.general.map(|alm| rotate(&alm, rotation)).transpose()?;
        Ok(self)
    }

    /// Returns the coefficients of all orders.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if memory is out.
    pub fn to_alm(&self) -> Result<Alm, Error> {
        let mut alm = match &self.general {
            Some(alm) => alm.clone(),
            None => Alm::zeros(self.lmax)?,
        };
        for framed in &self.framed {
            let own = framed.to_alm(self.lmax)?;
            alm.values_mut().iter_mut().zip(own.values()).for_each(|(sum, a)| *sum += a);
        }
        let plan = LegendrePlan::new(self.lmax)?;
        for zonal in &self.zonals {
            let colatitude = Colatitude::from_direction(zonal.axis);
            let phi = zonal.axis.y.atan2(zonal.axis.x);
            for m in 0..=self.lmax {
                let mut column = vec![0.0; self.lmax + 1 - m];
                plan.column_into(m, colatitude, &mut column);
                let phase = Complex::cis(-(m as f64) * phi);
                let terms = column.iter().zip(&zonal.per_degree[m..]).enumerate();
                for (a, (n, (lambda, c))) in alm.column_mut(m).iter_mut().zip(terms) {
                    *a += phase * (c * lambda / peak(m + n));
                }
            }
        }
        Ok(alm)
    }

    /// Returns whether coefficients of all orders take less time than pairs of axes.
    fn has_many_axes(&self) -> bool {
        self.zonals.len() > self.lmax.max(8)
    }

    /// Returns whether there are parts in frames that have no inner products with other parts, or
    /// with those of another function, without a rotation.
    fn has_frames_beside(&self, other: Option<&Self>) -> bool {
        let other = other.unwrap_or(self);
        let is_own = |a: &Framed| other.framed.iter().all(|b| a.frame == b.frame);
        !self.framed.is_empty() && other.general.is_some() || !self.framed.iter().all(is_own)
    }

    fn add_framed(&mut self, weight: f64, framed: &Framed) {
        let mut added = Self::in_frame(framed.frame, self.lmax, framed.columns.clone());
        added.cut_columns();
        let added = added.scaled(weight).framed.remove(0);
        match self.framed.iter_mut().find(|own| own.frame == framed.frame) {
            Some(own) => own.join(added),
            None => self.framed.push(added),
        }
    }

    /// Removes the degrees beyond lmax from the columns of frames.
    fn cut_columns(&mut self) {
        for framed in &mut self.framed {
            framed.columns.retain(|(m, _)| *m <= self.lmax);
            for (m, column) in &mut framed.columns {
                column.truncate(self.lmax + 1 - *m);
            }
        }
    }

    fn add_zonal(&mut self, weight: f64, zonal: &Zonal) {
        let own = self.zonals.iter_mut().find_map(|z| Some((coaxial(z.axis, zonal.axis)?, z)));
        if let Some((sign, own)) = own {
            let mut parity = weight;
            for (s, c) in own.per_degree.iter_mut().zip(&zonal.per_degree) {
                *s += parity * c;
                parity *= sign;
            }
        } else {
            let per_degree = zonal.per_degree[..=self.lmax].iter().map(|c| weight * c).collect();
            self.zonals.push(Zonal { axis: zonal.axis, per_degree });
        }
    }

    pub(crate) fn truncate(&mut self, lmax: usize) -> Result<(), Error> {
        if lmax >= self.lmax {
            return Ok(());
        }
        self.lmax = lmax;
        for zonal in &mut self.zonals {
            zonal.per_degree.truncate(lmax + 1);
        }
        self.cut_columns();
        if let Some(long) = self.general.take() {
            let mut short = Alm::zeros(lmax)?;
            for m in 0..=lmax {
                short.column_mut(m).copy_from_slice(&long.column(m)[..=lmax - m]);
            }
            self.general = Some(short);
        }
        Ok(())
    }
}

impl Zonal {
    /// Returns the inner products with another zonal function, by the addition theorem.
    fn inner(&self, other: &Self) -> Result<Vec<f64>, Error> {
        let lmax = self.per_degree.len().min(other.per_degree.len()) - 1;
        let mut column = vec![0.0; lmax + 1];
        let between = colatitude_between(self.axis, other.axis);
        LegendrePlan::new(lmax)?.column_into(0, between, &mut column);
        for (l, x) in column.iter_mut().enumerate() {
            *x *= self.per_degree[l] * other.per_degree[l] / peak(l);
        }
        Ok(column)
    }

    /// Returns the inner products with a general function.
    fn inner_general(&self, alm: &Alm) -> Result<Vec<f64>, Error> {
        let columns = (0..=alm.lmax()).map(|m| (m, alm.column(m)));
        self.inner_columns(self.axis, columns, alm.lmax())
    }

    /// Returns the inner products with a part in another frame, of degrees to `lmax`.
    fn inner_framed(&self, framed: &Framed, lmax: usize) -> Result<Vec<f64>, Error> {
        let axis = (framed.frame.transpose() * self.axis).normalize();
        let columns = framed.columns.iter().map(|(m, column)| (*m, &column[..]));
        self.inner_columns(axis, columns, lmax)
    }

    /// Returns the inner products with a function of some orders in the frame in which this one has
    /// an axis: its value on the axis, degree by degree.
    fn inner_columns<'c>(
        &self,
        axis: DVec3,
        columns: impl Iterator<Item = (usize, &'c [Complex<f64>])>,
        lmax: usize,
    ) -> Result<Vec<f64>, Error> {
        let lmax = lmax.min(self.per_degree.len() - 1);
        let plan = LegendrePlan::new(lmax)?;
        let colatitude = Colatitude::from_direction(axis);
        let phi = axis.y.atan2(axis.x);
        let mut values = vec![0.0; lmax + 1];
        let mut scratch = vec![0.0; lmax + 1];
        for (m, column) in columns.take_while(|(m, _)| *m <= lmax) {
            let lambda = &mut scratch[..=lmax - m];
            plan.column_into(m, colatitude, lambda);
            let phase = Complex::cis(m as f64 * phi) * if m == 0 { 1.0 } else { 2.0 };
            for ((v, a), lambda) in values[m..].iter_mut().zip(column).zip(&*lambda) {
                *v += lambda * (a * phase).re;
            }
        }
        for (l, v) in values.iter_mut().enumerate() {
            *v *= self.per_degree[l] / peak(l);
        }
        Ok(values)
    }
}

impl Framed {
    fn mean(&self) -> f64 {
        match self.columns.first() {
            Some((0, column)) => column.first().map_or(0.0, |a| a.re),
            _ => 0.0,
        }
    }

    /// Adds `weight` times the inner products with a function in the same frame.
    fn add_inner(&self, weight: f64, other: &Self, sum: &mut [f64]) {
        let mut others = other.columns.iter().peekable();
        for (m, column) in &self.columns {
            while others.next_if(|(order, _)| order < m).is_some() {}
            let Some((_, of_other)) = others.next_if(|(order, _)| order == m) else { continue };
            let copies = if *m == 0 { weight } else { 2.0 * weight };
            for (s, (x, y)) in sum.iter_mut().skip(*m).zip(column.iter().zip(of_other)) {
                *s += copies * (x * y.conj()).re;
            }
        }
    }

    /// Adds a function in the same frame, of the same degrees.
    fn join(&mut self, other: Self) {
        for (m, column) in other.columns {
            match self.columns.binary_search_by_key(&m, |(order, _)| *order) {
                Ok(at) => {
                    self.columns[at].1.iter_mut().zip(column).for_each(|(sum, a)| *sum += a);
                }
                Err(at) => self.columns.insert(at, (m, column)),
            }
        }
    }

    /// Returns the coefficients of all orders in the frame of the function.
    fn to_alm(&self, lmax: usize) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(lmax)?;
        for (m, column) in &self.columns {
            alm.column_mut(*m).copy_from_slice(column);
        }
        if self.frame == DMat3::IDENTITY { Ok(alm) } else { rotate(&alm, self.frame) }
    }
}

/// `Y_l0` on its axis, `sqrt((2l+1)/(4 pi))`.
fn peak(l: usize) -> f64 {
    ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()
}

/// Returns the coefficients of a Dirac mass on the axis.
fn delta(lmax: usize) -> Vec<f64> {
    (0..=lmax).map(peak).collect()
}

fn add(sum: &mut [f64], weight: f64, terms: &[f64]) {
    for (s, t) in sum.iter_mut().zip(terms) {
        *s += weight * t;
    }
}

/// The largest degree rotated by the exact transform, in O(lmax^4).
const EXACT_ROTATION: usize = 64;
/// The accuracy of the fast transform beyond that degree.
const ROTATION_EPSILON: f64 = 1e-13;

fn rotate(alm: &Alm, rotation: DMat3) -> Result<Alm, Error> {
    let lmax = alm.lmax();
    let rule = GaussLegendre::new(lmax + 1)?;
    let n_phi = 2 * lmax + 2;
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (&z, w) in rule.nodes().iter().zip(rule.weights()) {
        let sin = ((1.0 - z) * (1.0 + z)).sqrt();
        for j in 0..n_phi {
            let (s, c) = (TAU * (j as f64 + 0.5) / n_phi as f64).sin_cos();
            points.push(DVec3::new(sin * c, sin * s, z).normalize());
            weights.push(w * TAU / n_phi as f64);
        }
    }
    let back = rotation.transpose();
    let rotated_points: Vec<DVec3> = points.iter().map(|&p| (back * p).normalize()).collect();
    let mut values = vec![0.0; points.len()];
    let mut out = Alm::zeros(lmax)?;
    if lmax <= EXACT_ROTATION {
        let transform = ExactTransform::new(lmax)?;
        let mut workspace = ExactWorkspace::default();
        transform.synthesis_into(alm, &rotated_points, &mut workspace, &mut values);
        values.iter_mut().zip(weights).for_each(|(v, w)| *v *= w);
        transform.adjoint_into(&points, Some(&values), &mut workspace, &mut out);
    } else {
        let transform = FastTransform::new(lmax, ROTATION_EPSILON)?;
        let mut workspace = FastWorkspace::default();
        transform.synthesis_into(alm, &rotated_points, &mut workspace, &mut values);
        values.iter_mut().zip(weights).for_each(|(v, w)| *v *= w);
        transform.adjoint_into(&points, Some(&values), &mut workspace, &mut out);
    }
    Ok(out)
}
