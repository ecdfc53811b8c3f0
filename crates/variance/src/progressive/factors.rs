/// The standard errors of a sequence relative to those of a reference at the same numbers of points.
///
/// # Examples
///
/// ```
/// use sphvar_variance::Factors;
///
/// let sequence = [(10, 4.0), (20, 9.0), (30, 1.0)];
/// let reference = [(10, 1.0), (20, 1.0), (40, 1.0)];
/// let factors = Factors::of(sequence, reference, 10).unwrap();
/// assert_eq!((factors.worst, factors.worst_at, factors.count), (3.0, 20, 2));
/// assert!((factors.mean - 6f64.sqrt()).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// The largest ratio of standard errors.
    pub worst: f64,
    /// The number of points with the largest ratio, the smallest of several.
    pub worst_at: usize,
    /// The geometric mean of the ratios.
    pub mean: f64,
    /// The number of ratios.
    pub count: usize,
}

impl Factors {
    /// Returns the factors over the common numbers of points from `from` on, given pairs of the
    /// number of points and the variance, each in increasing order. Returns `None` if no common
    /// number has positive variances of both.
    #[must_use]
    pub fn of(
        sequence: impl IntoIterator<Item = (usize, f64)>,
        reference: impl IntoIterator<Item = (usize, f64)>,
        from: usize,
    ) -> Option<Self> {
        let mut reference = reference.into_iter().peekable();
        let (mut worst, mut worst_at, mut logarithms, mut count) = (0.0, 0, 0.0, 0);
        for (n, variance) in sequence {
            while reference.next_if(|(m, _)| *m < n).is_some() {}
            let Some(&(_, of_reference)) = reference.peek().filter(|(m, _)| *m == n) else {
                continue;
            };
            let factor = (variance / of_reference).sqrt();
            if n < from || !(factor > 0.0 && factor.is_finite()) {
                continue;
            }
            if factor > worst {
                (worst, worst_at) = (factor, n);
            }
            logarithms += factor.ln();
            count += 1;
        }
        let mean = f64::exp(logarithms / count as f64);
        (count > 0).then_some(Self { worst, worst_at, mean, count })
    }
}
