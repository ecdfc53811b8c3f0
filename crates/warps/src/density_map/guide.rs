//! Search in cumulative sums, from brackets at equidistant fractions of the total.

use super::sampling::index_of;

/// Writes, for each fraction k/n of the total, the last interval that begins at or before it.
///
/// `sums` are the n + 1 sums before each interval, ascending, and `guide` has n elements.
pub(super) fn write_guide(sums: &[f64], guide: &mut [u32]) {
    let n = guide.len();
    let total = sums[n];
    let mut interval = 0;
    for (k, entry) in guide.iter_mut().enumerate() {
        let target = total * (k as f64 / n as f64);
        while interval + 1 < n && sums[interval + 1] <= target {
            interval += 1;
        }
        *entry = u32::try_from(interval).unwrap_or(u32::MAX);
    }
}

/// Returns the first interval of a fraction v of the total and the one behind its last.
pub(super) fn bracket(guide: &[u32], v: f64) -> [usize; 2] {
    let k = index_of(v * guide.len() as f64, guide.len());
    let last = guide.get(k + 1).map_or(guide.len() - 1, |last| *last as usize);
    [guide[k] as usize, last + 1]
}

/// Returns the last of n intervals that begins at or before a target, for ascending sums `before`
/// intervals and a bracket that rounding may have moved.
pub(super) fn last_interval(
    n: usize,
    [mut low, mut high]: [usize; 2],
    target: f64,
    before: impl Fn(usize) -> f64,
) -> usize {
    while low > 0 && before(low) > target {
        low -= 1;
    }
    while high < n && before(high) <= target {
        high += 1;
    }
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        if before(middle) <= target {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::{bracket, last_interval, write_guide};

    #[test]
    fn guided_search_agrees_with_linear_search() {
        for masses in [vec![1.0], vec![0.0, 0.0, 3.0, 0.0], vec![1e-20, 1e20, 5.0, 0.0, 0.0, 1e19]]
        {
            let mut sums = vec![0.0];
            for mass in &masses {
                sums.push(sums[sums.len() - 1] + mass);
            }
            let n = masses.len();
            let mut guide = vec![0; n];
            write_guide(&sums, &mut guide);
            for k in 0..1000 {
                let v = f64::from(k) / 1000.0;
                let target = v * sums[n];
                let slow = (0..n).rev().find(|i| sums[*i] <= target).unwrap_or(0);
                let fast = last_interval(n, bracket(&guide, v), target, |i| sums[i]);
                assert_eq!(fast, slow, "{masses:?}, {v}");
                // A wrong bracket costs time only.
                for wrong in [[0, 1], [n - 1, n]] {
                    assert_eq!(last_interval(n, wrong, target, |i| sums[i]), slow, "{masses:?}");
                }
            }
        }
    }
}
