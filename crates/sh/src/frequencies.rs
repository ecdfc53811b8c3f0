use std::fmt;
use std::sync::Arc;

use crate::{Bands, ByAxis, Error};

/// The bands of the unit square: pairs {k, -k} of frequencies, all with |k| <= kmax and beyond it
/// those on the axes up to a larger limit.
///
/// Points [u, v] in [0, 1)^2 have the coefficients `S_k = sum_j w_j exp(-2 pi i (k1 u_j + k2 v_j))`
/// and the power `P(k) = |S_k|^2 / sum_j w_j^2`, which is the same for k and -k. Under random
/// toroidal shifts (Cranley and Patterson 1976) every pair is a band of its own:
///
/// ```text
/// Var = (1/N) sum over bands b >= 1 of E(b) <P(b)>,   E(b) = |G_k|^2 + |G_-k|^2
/// ```
///
/// Bands are sorted by the Euclidean norm of k; those of equal norm by k2, then k1. Band 0 is (0,
/// 0). For the other bands, the representative k has k2 > 0, or k2 = 0 and k1 > 0. Integrands that
/// are not periodic have most of their energy at high frequencies on the axes, hence the separate
/// limit there.
///
/// A clone shares the table of frequencies, of 8 bytes for each band: `pi kmax^2/2 + 2 axis_max`.
///
/// # Examples
///
/// ```
/// use sphvar_sh::{Bands, Frequencies};
///
/// let bands = Frequencies::new(2)?.with_axes(5)?;
/// let all: Vec<[i32; 2]> = (0..bands.len()).map(|band| bands.frequency(band)).collect();
/// let within = [[0, 0], [1, 0], [0, 1], [-1, 1], [1, 1], [2, 0], [0, 2]];
/// let on_axes = [[3, 0], [0, 3], [4, 0], [0, 4], [5, 0], [0, 5]];
/// assert_eq!(all, [&within[..], &on_axes[..]].concat());
/// assert_eq!(bands.band_of([1, -1]), Some(3));
/// assert_eq!(bands.radius(3), 2f64.sqrt());
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
///
/// # References
///
/// Cranley and Patterson 1976, doi:10.1137/0713071: random shifts.
#[derive(Clone)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(into = "Limits", try_from = "Limits")
)]
pub struct Frequencies {
    limits: Limits,
    sorted: Arc<Vec<[i32; 2]>>,
}

/// The maximum norm of frequencies, and the maximum of those on the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Limits {
    kmax: usize,
    axis_max: usize,
}

impl Frequencies {
    /// The maximum of kmax, with 1.6e8 bands.
    pub const MAX_KMAX: usize = 10_000;

    /// The maximum frequency on the axes.
    pub const MAX_AXIS: usize = 1 << 20;

    /// Returns all pairs of frequencies with `|k| <= kmax` in the Euclidean norm.
    ///
    /// # Errors
    ///
    /// [`Error::Frequency`] if `kmax` exceeds [`Self::MAX_KMAX`]; [`Error::OutOfMemory`] if
    /// allocation of the table fails.
    pub fn new(kmax: usize) -> Result<Self, Error> {
        Limits { kmax, axis_max: kmax }.try_into()
    }

    /// Returns the same frequencies and beyond them those on the axes up to `axis_max`, inclusive.
    ///
    /// # Errors
    ///
    /// [`Error::Frequency`] if `axis_max` is not from kmax to [`Self::MAX_AXIS`];
    /// [`Error::OutOfMemory`] if allocation of the table fails.
    pub fn with_axes(self, axis_max: usize) -> Result<Self, Error> {
        let limits = Limits { axis_max, ..self.limits };
        let beyond = limits.axes_beyond()?;
        let within = &self.sorted[..self.len() - self.limits.n_beyond()];
        let mut sorted = reserve(within.len() + limits.n_beyond())?;
        sorted.extend_from_slice(within);
        sorted.extend(beyond);
        Ok(Self { limits, sorted: sorted.into() })
    }

    /// Returns the maximum Euclidean norm of frequencies off the axes, inclusive.
    #[must_use]
    pub fn kmax(&self) -> usize {
        self.limits.kmax
    }

    /// Returns the maximum frequency on the axes, inclusive; at least kmax.
    #[must_use]
    pub fn axis_max(&self) -> usize {
        self.limits.axis_max
    }

    /// Returns the number of bands, including band 0.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "band 0 is always present")]
    pub fn len(&self) -> usize {
        self.sorted.len()
    }

    /// Returns the representative frequency of a band, with k2 > 0, or k2 = 0 and k1 >= 0.
    ///
    /// # Panics
    ///
    /// Panics if `band` is not below [`len`](Self::len).
    #[must_use]
    pub fn frequency(&self, band: usize) -> [i32; 2] {
        self.sorted[band]
    }

    /// Returns the band of a frequency or of its opposite; `None` if it is beyond the limits. The
    /// cost is that of a binary search.
    #[must_use]
    pub fn band_of(&self, k: [i32; 2]) -> Option<usize> {
        let is_representative = k[1] > 0 || (k[1] == 0 && k[0] >= 0);
        let k = if is_representative { k } else { [k[0].checked_neg()?, k[1].checked_neg()?] };
        self.sorted.binary_search_by_key(&key(k), |k| key(*k)).ok()
    }
}

/// Returns the sort key of a frequency.
fn key(k: [i32; 2]) -> (u64, [i32; 2]) {
    let square = |x: i32| u64::from(x.unsigned_abs()).pow(2);
    (square(k[0]) + square(k[1]), [k[1], k[0]])
}

impl Limits {
    /// Returns the number of bands on the axes beyond kmax.
    fn n_beyond(self) -> usize {
        2 * (self.axis_max - self.kmax)
    }

    /// Returns the bands on the axes beyond kmax, in their order.
    fn axes_beyond(self) -> Result<impl Iterator<Item = [i32; 2]>, Error> {
        let Self { kmax, axis_max } = self;
        if kmax > Frequencies::MAX_KMAX {
            return Err(Error::Frequency { kmax, min: 0, max: Frequencies::MAX_KMAX });
        }
        if !(kmax..=Frequencies::MAX_AXIS).contains(&axis_max) {
            let max = Frequencies::MAX_AXIS;
            return Err(Error::Frequency { kmax: axis_max, min: kmax, max });
        }
        // Both fit: the limits are far below the range of i32.
        let [inner, outer] = [kmax, axis_max].map(|k| i32::try_from(k).unwrap_or(i32::MAX));
        Ok((inner + 1..=outer).flat_map(|k| [[k, 0], [0, k]]))
    }

    /// Returns the representatives within kmax, ordered by k2, then k1.
    fn within(self) -> impl Iterator<Item = [i32; 2]> {
        let inner = i32::try_from(self.kmax).unwrap_or(i32::MAX);
        (0..=inner).flat_map(move |k2| {
            let half_width = (i64::from(inner).pow(2) - i64::from(k2).pow(2)).isqrt();
            let half_width = i32::try_from(half_width).unwrap_or(i32::MAX);
            let first = if k2 == 0 { 0 } else { -half_width };
            (first..=half_width).map(move |k1| [k1, k2])
        })
    }
}

/// Returns an empty vector in which `len` items fit.
fn reserve<T>(len: usize) -> Result<Vec<T>, Error> {
    let mut empty = Vec::new();
    let failed = |_| Error::OutOfMemory { len, bytes_each: size_of::<T>() };
    empty.try_reserve_exact(len).map_err(failed)?;
    Ok(empty)
}

impl TryFrom<Limits> for Frequencies {
    type Error = Error;

    /// Sorts by counting, since the squares of the norms are integers up to kmax^2.
    fn try_from(limits: Limits) -> Result<Self, Error> {
        let beyond = limits.axes_beyond()?;
        // At most 1e8, and the numbers of bands at most 1.6e8.
        let square = |k: [i32; 2]| usize::try_from(key(k).0).unwrap_or(usize::MAX);
        let norms = limits.kmax * limits.kmax + 1;
        let mut starts: Vec<u32> = reserve(norms)?;
        starts.resize(norms, 0);
        limits.within().for_each(|k| starts[square(k)] += 1);
        let mut len = 0;
        for start in &mut starts {
            len += std::mem::replace(start, len);
        }
        let len = len as usize;
        let mut sorted = reserve(len + limits.n_beyond())?;
        sorted.resize(len, [0; 2]);
        // The order among equal norms is that of `within`.
        for k in limits.within() {
            let next = &mut starts[square(k)];
            sorted[*next as usize] = k;
            *next += 1;
        }
        sorted.extend(beyond);
        Ok(Self { limits, sorted: sorted.into() })
    }
}

impl From<Frequencies> for Limits {
    fn from(frequencies: Frequencies) -> Self {
        frequencies.limits
    }
}

/// The limits determine the frequencies.
impl PartialEq for Frequencies {
    fn eq(&self, other: &Self) -> bool {
        self.limits == other.limits
    }
}

impl fmt::Debug for Frequencies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Limits { kmax, axis_max } = self.limits;
        f.debug_struct("Frequencies").field("kmax", &kmax).field("axis_max", &axis_max).finish()
    }
}

/// Bands beyond the table do not exist; their radius is infinite.
impl Bands for Frequencies {
    type Tail = ByAxis;

    fn label(&self) -> &'static str {
        "band"
    }

    fn has_band(&self, band: usize) -> bool {
        band < self.len()
    }

    fn multiplicity(&self, band: usize) -> f64 {
        if band == 0 { 1.0 } else { 2.0 }
    }

    fn radius(&self, band: usize) -> f64 {
        let norm = |[k1, k2]: &[i32; 2]| f64::from(*k1).hypot(f64::from(*k2));
        self.sorted.get(band).map_or(f64::INFINITY, norm)
    }

    /// Points with an equal coordinate change the power on one axis.
    fn tail_class(&self, band: usize) -> usize {
        match self.sorted.get(band) {
            Some([_, 0]) => 1,
            Some([0, _]) => 2,
            _ => 0,
        }
    }

    fn area(&self) -> f64 {
        1.0
    }

    fn factor(&self, n_points: usize) -> f64 {
        1.0 / n_points as f64
    }

    /// Projections of N points on an axis have peaks at distances of up to N.
    fn spacing_radius(&self, class: usize, n_points: usize) -> f64 {
        if class == 0 { (n_points as f64).sqrt() } else { n_points as f64 }
    }

    fn extent(&self, class: usize, last: usize) -> f64 {
        let radius = self.radius(last);
        if class == 0 { radius.min(self.kmax() as f64) } else { radius }
    }
}

#[cfg(test)]
mod tests {
    use super::Frequencies;
    use crate::{Bands, Error};

    #[test]
    fn bands_are_all_pairs_of_frequencies() {
        for (kmax, axis_max) in [(0, 0), (0, 4), (1, 1), (5, 5), (12, 40)] {
            let bands = Frequencies::new(kmax).unwrap().with_axes(axis_max).unwrap();
            let limit = i32::try_from(axis_max).unwrap() + 1;
            let mut count = 0;
            for k1 in -limit..=limit {
                for k2 in -limit..=limit {
                    let norm = f64::from(k1).hypot(f64::from(k2));
                    let max = if k1 == 0 || k2 == 0 { axis_max } else { kmax };
                    let Some(band) = bands.band_of([k1, k2]) else {
                        assert!(norm > max as f64, "{k1}, {k2}");
                        continue;
                    };
                    assert!(norm <= max as f64, "{k1}, {k2}");
                    let k = bands.frequency(band);
                    assert!(k == [k1, k2] || k == [-k1, -k2], "{k1}, {k2}: {k:?}");
                    assert!(k[1] > 0 || (k[1] == 0 && k[0] >= 0), "{k:?}");
                    assert!((bands.radius(band) - norm).abs() < 1e-12 && bands.has_band(band));
                    let class = if k[1] == 0 { 1 } else { 2 * usize::from(k[0] == 0) };
                    assert_eq!(bands.tail_class(band), class, "{k:?}");
                    count += 1;
                }
            }
            assert_eq!(count, 2 * bands.len() - 1);
            let radii: Vec<f64> = (0..bands.len()).map(|band| bands.radius(band)).collect();
            assert!(radii.is_sorted() && radii[0] == 0.0);
            assert!(radii[1..].iter().all(|r| *r > 0.0) && !bands.has_band(bands.len()));
        }
    }

    /// The order is that of sorting by the norm, k2 and k1, whichever limits came first.
    #[test]
    fn bands_are_sorted() {
        for kmax in [0_usize, 1, 2, 31, 57] {
            let bands = Frequencies::new(kmax).unwrap();
            let limit = i32::try_from(kmax).unwrap();
            let half = (0..=limit).flat_map(|k2| (-limit..=limit).map(move |k1| [k1, k2]));
            let mut expected: Vec<[i32; 2]> = half
                .filter(|k| k[1] > 0 || k[0] >= 0)
                .filter(|k| k[0].pow(2) + k[1].pow(2) <= limit.pow(2))
                .collect();
            expected.sort_by_key(|k| (k[0].pow(2) + k[1].pow(2), k[1], k[0]));
            assert_eq!(*bands.sorted, expected);
            let again = bands.clone().with_axes(kmax + 9).unwrap().with_axes(kmax + 2).unwrap();
            expected.extend([1, 2].map(|k| limit + k).into_iter().flat_map(|k| [[k, 0], [0, k]]));
            assert_eq!((&*again.sorted, again.axis_max()), (&expected, kmax + 2));
            assert_eq!(*again.with_axes(kmax).unwrap().sorted, *bands.sorted);
        }
    }

    #[test]
    fn limits_are_checked() {
        let error = |kmax, min, max| Error::Frequency { kmax, min, max };
        let (max, max_axis) = (Frequencies::MAX_KMAX, Frequencies::MAX_AXIS);
        for kmax in [max + 1, usize::MAX] {
            assert_eq!(Frequencies::new(kmax), Err(error(kmax, 0, max)));
        }
        for axis_max in [0, 7, max_axis + 1, usize::MAX] {
            let bands = Frequencies::new(8).unwrap();
            assert_eq!(bands.with_axes(axis_max), Err(error(axis_max, 8, max_axis)));
        }
        let bands = Frequencies::new(3).unwrap();
        for k in [[4, 0], [3, 1], [0, i32::MIN], [i32::MIN, 0], [i32::MIN; 2], [i32::MAX; 2]] {
            assert_eq!(bands.band_of(k), None, "{k:?}");
        }
        assert!(Frequencies::new(3).unwrap() != bands.with_axes(4).unwrap());
    }
}
