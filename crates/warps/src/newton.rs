/// Limit of the number of steps; bisection alone reaches the last digit of a fraction of `end` in
/// 64.
const MAX_STEPS: usize = 128;

/// Rounding errors of value and target, relative, at which the iteration ends.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Returns the x in [0, end] with value(x) = target, for a function that increases from 0, to a few
/// roundings: Newton's iteration from `start`, with bisection where it leaves the bracket.
///
/// `f` returns value and derivative.
pub(crate) fn increasing_root(
    end: f64,
    target: f64,
    start: f64,
    f: impl Fn(f64) -> (f64, f64),
) -> f64 {
    if target <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, end);
    let mut x = start.clamp(low, high);
    for _ in 0..MAX_STEPS {
        let (value, slope) = f(x);
        let residual = value - target;
        let next = x - residual / slope;
        // Where the slope vanishes, a step from rounding errors leads anywhere.
        if residual.abs() <= ROUNDING * target {
            return x;
        }
        if (next - x).abs() <= ROUNDING * x {
            return next.clamp(low, high);
        }
        if residual > 0.0 {
            high = x;
        } else {
            low = x;
        }
        // A NaN is in no bracket.
        x = if next >= low && next <= high { next } else { 0.5 * (low + high) };
    }
    x
}

#[cfg(test)]
mod tests {
    use super::increasing_root;

    #[test]
    fn a_root_where_the_slope_vanishes_is_kept() {
        for target in [1.0, 1.0 - 1e-16, 1.0 - 1e-12] {
            let f = |x: f64| (x * (2.0 - x), 2.0 * (1.0 - x) + 1e-17);
            let x = increasing_root(1.0, target, 1.0, f);
            assert!((x - 1.0).abs() < 2e-6, "{target}: {x}");
        }
    }

    #[test]
    fn roots_are_found_where_the_slope_vanishes_or_the_target_is_not_reached() {
        for (end, target, root) in [
            (1.0, 0.125, 0.5),
            (1.0, 1e-30, 1e-10),
            (1.0, 0.0, 0.0),
            (1.0, 1.0, 1.0),
            (1.0, 1.0 + 1e-15, 1.0),
        ] {
            for start in [0.0, 0.3, 1.0] {
                let x = increasing_root(end, target, start, |x| (x * x * x, 3.0 * x * x));
                assert!(
                    (x - root).abs() <= 4.0 * f64::EPSILON * root,
                    "{target} from {start}: {x}"
                );
            }
        }
    }
}
