/// Limit of the number of steps; bisection alone reaches the last digit of a fraction of `end` in
/// 64.
const MAX_STEPS: usize = 128;

/// Rounding errors of value and target, relative, at which the iteration ends.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Residuals, relative to the target, that may be noise: a step that does not reduce them ends the
/// iteration, too.
const NOISE: f64 = 64.0 * f64::EPSILON;

/// A last step, relative to x. Each step squares the error, so the next would be about 1e-18.
const LAST_STEP: f64 = 1e-9;

/// Returns the x in [0, end] with value(x) = target, for a function that increases from 0, to a few
/// roundings: Newton's iteration from `start`, with bisection where it leaves the bracket.
///
/// `f` returns value and derivative. The value has an absolute error of about `rounding`, besides a
/// few relative roundings; below it the iteration would follow noise.
pub(crate) fn increasing_root(
    end: f64,
    target: f64,
    rounding: f64,
    start: f64,
    f: impl Fn(f64) -> (f64, f64),
) -> f64 {
    if target <= 0.0 {
        return 0.0;
    }
    let tolerance = rounding.max(ROUNDING * target);
    let (mut low, mut high) = (0.0, end);
    let mut x = start.clamp(low, high);
    let (mut previous, mut previous_residual) = (x, f64::INFINITY);
    for _ in 0..MAX_STEPS {
        let (value, slope) = f(x);
        let residual = value - target;
        let next = x - residual / slope;
        // Where the slope vanishes, a step from rounding errors leads anywhere.
        if residual.abs() <= tolerance {
            return x;
        }
        if (next - x).abs() <= LAST_STEP * x {
            return next.clamp(low, high);
        }
        if residual.abs() >= previous_residual && previous_residual <= NOISE * target {
            return previous;
        }
        (previous, previous_residual) = (x, residual.abs());
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

/// Returns the x in [0, 1] with `int_0^x (l + (r - l) y) dy = mass`, for l and r not negative.
pub(crate) fn linear_root(l: f64, r: f64, mass: f64) -> f64 {
    let root = (l * l + 2.0 * (r - l) * mass).max(0.0).sqrt();
    if mass <= 0.0 { 0.0 } else { (2.0 * mass / (l + root)).min(1.0) }
}

#[cfg(test)]
mod tests {
    use super::{increasing_root, linear_root};

    #[test]
    fn linear_densities_are_inverted() {
        for (l, r) in [(1.0, 1.0), (0.0, 2.0), (2.0, 0.0), (1e-20, 1e20), (1e20, 1e-20)] {
            for share in [0.0, 1e-12, 0.3, 0.999, 1.0] {
                let mass = share * 0.5 * (l + r);
                let x: f64 = linear_root(l, r, mass);
                let found = x * (l + 0.5 * (r - l) * x);
                assert!((found - mass).abs() <= 1e-15 * (l + r), "{l}, {r}, {share}: {x}");
            }
        }
        assert!(linear_root(0.0, 0.0, 0.0).abs() <= 0.0);
    }

    /// Without the tolerance, the noise of 1e-12 leads to bisection to the last digit.
    #[test]
    fn noise_below_the_stated_rounding_is_not_followed() {
        let evaluations = std::cell::Cell::new(0);
        let f = |x: f64| {
            evaluations.set(evaluations.get() + 1);
            (x + 1e-12 * (1e14 * x).sin(), 1.0)
        };
        let x = increasing_root(1.0, 0.3, 1e-12, 0.9, f);
        assert!((x - 0.3).abs() < 3e-12, "{x}");
        assert!(evaluations.get() <= 3, "{} evaluations", evaluations.get());
    }

    #[test]
    fn a_root_where_the_slope_vanishes_is_kept() {
        for target in [1.0, 1.0 - 1e-16, 1.0 - 1e-12] {
            let f = |x: f64| (x * (2.0 - x), 2.0 * (1.0 - x) + 1e-17);
            let x = increasing_root(1.0, target, 0.0, 1.0, f);
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
                let x = increasing_root(end, target, 0.0, start, |x| (x * x * x, 3.0 * x * x));
                assert!(
                    (x - root).abs() <= 4.0 * f64::EPSILON * root,
                    "{target} from {start}: {x}"
                );
            }
        }
    }
}
