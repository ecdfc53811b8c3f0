use std::f64::consts::{FRAC_2_PI, FRAC_PI_4};

/// A longitude as quadrant and position within the quadrant.
///
/// The distances to both ends of the quadrant are stored, because a polar cap needs both with full
/// relative precision, which `1 - since` would lose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Azimuth {
    /// Number of whole quarter turns, 0..4.
    pub(crate) quadrant: u32,
    /// Quarter turns since the start of the quadrant, in `[0, 1]` (1 only by rounding).
    pub(crate) since: f64,
    /// Quarter turns until its end, `1 - since`, in `[0, 1]`.
    pub(crate) until: f64,
}

impl Azimuth {
    /// Returns the longitude of `(x, y)`; `(0, 0)` has longitude 0, as has every signed zero of `y`
    /// with `x > 0`.
    ///
    /// Branch-free: random directions would mispredict every second comparison. Always inlined, so
    /// that loops can be vectorized.
    #[inline(always)]
    pub(crate) fn of_xy(x: f64, y: f64) -> Self {
        // Adding zero maps -0 to 0, so that the sign bits determine the half planes.
        let (x, y) = (x + 0.0, y + 0.0);
        let odd = x.is_sign_negative() ^ y.is_sign_negative();
        let quadrant = 2 * u32::from(y.is_sign_negative()) + u32::from(odd);

        let (abs_x, abs_y) = (x.abs(), y.abs());
        let steep = abs_y > abs_x;
        let short = if steep { abs_x } else { abs_y };
        let long = if steep { abs_y } else { abs_x };
        let near = quarter_turns_of_ratio(short, long);
        // One of the two is `near`, the other `1 - near`; subtracting from 0 or 1 avoids a branch
        // and is exact for 0.
        let from_end = f64::from(u8::from(odd != steep));
        let since = (from_end - near).abs();
        let until = ((1.0 - from_end) - near).abs();
        // An axis belongs to the quadrant that starts on it.
        let inside = until > 0.0;
        Self {
            quadrant: (quadrant + u32::from(!inside)) & 3,
            since: if inside { since } else { 0.0 },
            until: if inside { until } else { 1.0 },
        }
    }

    /// Returns the longitude `phi`, any finite number of radians.
    #[inline(always)]
    pub(crate) fn of_phi(phi: f64) -> Self {
        let turns = quarter_turns(phi);
        Self::of_quarter_turns(phi < 0.0, if turns < NO_FRACTION { turns } else { reduce(turns) })
    }

    /// Returns the longitude of `turns` quarter turns, at least 0 and below [`NO_FRACTION`],
    /// westwards if `negative`.
    #[inline(always)]
    pub(crate) fn of_quarter_turns(negative: bool, turns: f64) -> Self {
        let (whole, bits) = floor(turns);
        let part = turns - whole;
        // A point exactly on an axis belongs to the next quadrant.
        let back = negative & (part > 0.0);
        let quadrant = (bits & 3) as u32;
        let mirrored = 4 - u32::from(back) - quadrant;
        let from_end = if back { 1.0 } else { 0.0 };
        Self {
            quadrant: if negative { mirrored & 3 } else { quadrant },
            since: (from_end - part).abs(),
            until: ((1.0 - from_end) - part).abs(),
        }
    }
}

/// Reduces longitudes of 10^15 turns; not inlined because they are rare.
#[cold]
#[inline(never)]
fn reduce(turns: f64) -> f64 {
    turns % 4.0
}

/// Returns the absolute value of `phi` radians in quarter turns.
#[inline(always)]
pub(crate) fn quarter_turns(phi: f64) -> f64 {
    phi.abs() * FRAC_2_PI
}

/// The smallest number beyond which no `f64` has a fraction, 2^52.
pub(crate) const NO_FRACTION: f64 = (1_u64 << 52) as f64;

/// Returns the integer part of `number`, which is in `[0, NO_FRACTION)`, and bits whose low end is
/// that of the integer part.
///
/// A sum with 2^52 has no bits for a fraction. Instructions that round or convert differ between
/// instruction sets, or are calls.
#[inline(always)]
pub(crate) fn floor(number: f64) -> (f64, u64) {
    let nearest = number + NO_FRACTION;
    let whole = nearest - NO_FRACTION;
    // Rounded upwards as often as downwards, so branch-free.
    let upwards = whole > number;
    (whole - if upwards { 1.0 } else { 0.0 }, nearest.to_bits() - u64::from(upwards))
}

/// tan(pi/8), where `t` and `(1 - t)/(1 + t)` are equal.
const TAN_PI_8: f64 = std::f64::consts::SQRT_2 - 1.0;

/// Interpolant of `(2/pi) atan(sqrt(s))/sqrt(s)` in `s` at the 12 Chebyshev nodes of
/// `[0, tan(pi/8)^2]`, computed with 60 digits. Due to the nearest singularity, `s = -1`, the error
/// decreases by a factor of 25 per term; the measured relative error with these rounded
/// coefficients is below 6.7e-17 on the interval.
const ATAN: [f64; 12] = [
    FRAC_2_PI,
    -0.21220659078919243,
    0.12732395447313996,
    -0.09094568172564597,
    0.0707355279318174,
    -0.057874446572035124,
    0.04896908147600092,
    -0.042417668668887784,
    0.03722238330707732,
    -0.032054457797691296,
    0.024169433558156754,
    -0.011335267915828496,
];

/// Returns `(2/pi) atan(short/long)` for `0 <= short <= long`, and 0 for two zeros.
#[inline(always)]
fn quarter_turns_of_ratio(short: f64, long: f64) -> f64 {
    // Beyond pi/8, atan(a/b) = pi/4 + atan((a - b)/(b + a)). A factor of 0 or 1, which is exact,
    // replaces a branch: both cases are equally frequent, so it would be mispredicted every second
    // time.
    let fold = if short > TAN_PI_8 * long { 1.0 } else { 0.0 };
    let num = short - fold * long;
    let den = long + fold * short;
    let start = 0.5 * fold;
    // The floor only affects 0/0: for components this small the pole is exact to all digits.
    let floor = f64::MIN_POSITIVE;
    let t = num / if den > floor { den } else { floor };
    start + t * atan_series(t * t)
}

/// Evaluates the polynomial [`ATAN`] in a tree: the latency of Horner's chain of 11 dependent steps
/// would be that of a whole pixel lookup.
#[inline(always)]
fn atan_series(s: f64) -> f64 {
    let c = &ATAN;
    let s2 = s * s;
    let s4 = s2 * s2;
    let low = (c[0] + c[1] * s) + (c[2] + c[3] * s) * s2;
    let mid = (c[4] + c[5] * s) + (c[6] + c[7] * s) * s2;
    let high = (c[8] + c[9] * s) + (c[10] + c[11] * s) * s2;
    low + (mid + high * s4) * s4
}

/// Returns the sine of `x` radians within one unit in the last place for `|x| <= pi/4`, and within
/// 5e-14 up to pi/2.
///
/// Taylor series to x^17: the first omitted term is at most (pi/4)^19/19! = 8e-20.
#[inline(always)]
pub(crate) fn sin_series(x: f64) -> f64 {
    let s = x * x;
    let s2 = s * s;
    let s4 = s2 * s2;
    let sin_low =
        (INV_FACTORIAL[3] - INV_FACTORIAL[5] * s) + (INV_FACTORIAL[7] - INV_FACTORIAL[9] * s) * s2;
    let sin_high = (INV_FACTORIAL[11] - INV_FACTORIAL[13] * s)
        + (INV_FACTORIAL[15] - INV_FACTORIAL[17] * s) * s2;
    x - x * s * (sin_low + sin_high * s4)
}

/// Returns `(sin, cos)` of `eighth * pi/4` for `|eighth| <= 1`.
///
/// Uses [`sin_series`] and the Taylor series of the cosine to x^16. The first omitted term is at
/// most (pi/4)^18/18! = 2e-18, so only rounding remains, below one unit in the last place. The
/// standard `sin_cos` is more expensive because it reduces its argument.
#[inline]
pub(crate) fn sin_cos_eighths(eighth: f64) -> (f64, f64) {
    let x = eighth * FRAC_PI_4;
    let sin = sin_series(x);
    let s = x * x;
    let s2 = s * s;
    let s4 = s2 * s2;

    let cos_low =
        (INV_FACTORIAL[4] - INV_FACTORIAL[6] * s) + (INV_FACTORIAL[8] - INV_FACTORIAL[10] * s) * s2;
    let cos_high = (INV_FACTORIAL[12] - INV_FACTORIAL[14] * s) + INV_FACTORIAL[16] * s2;
    let cos = 1.0 - 0.5 * s + s2 * (cos_low + cos_high * s4);
    (sin, cos)
}

/// `1/k!` for k up to 17; every factorial up to 18! is exact in `f64`.
const INV_FACTORIAL: [f64; 18] = {
    let mut table = [1.0; 18];
    let mut factorial = 1.0;
    let mut k = 1;
    while k < table.len() {
        factorial *= k as f64;
        table[k] = 1.0 / factorial;
        k += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const SAMPLES: u32 = 20_000;

    /// Returns the integer part of `turns` in `[0, 4)`.
    fn quadrant_of(turns: f64) -> u32 {
        [1.0, 2.0, 3.0].map(|start| u32::from(turns >= start)).iter().sum()
    }

    #[test]
    fn azimuth_agrees_with_atan2() {
        // Two roundings of the argument, the quotient, the series and the last subtraction, each
        // eps/2 relative, and the same for atan2 and its scaling.
        let tolerance = 6.0 * f64::EPSILON;
        for k in 0..SAMPLES {
            let phi = TAU * (f64::from(k) + 0.5) / f64::from(SAMPLES);
            let (y, x) = phi.sin_cos();
            let got = Azimuth::of_xy(x, y);
            let turns = y.atan2(x).rem_euclid(TAU) * FRAC_2_PI;
            assert_eq!(got.quadrant, quadrant_of(turns), "phi {phi}");
            let since = turns - turns.floor();
            assert!(
                (got.since - since).abs() <= tolerance * turns.max(1.0),
                "phi {phi}: {got:?} against {since}"
            );
            assert!((got.since + got.until - 1.0).abs() <= f64::EPSILON, "{got:?}");
            let from_phi = Azimuth::of_phi(phi);
            assert_eq!(from_phi.quadrant, got.quadrant, "phi {phi}");
            assert!(
                (from_phi.since - since).abs() <= tolerance * turns.max(1.0),
                "phi {phi}: {from_phi:?} against {since}"
            );
        }
    }

    #[test]
    fn small_distances_from_an_axis_keep_their_digits() {
        for small in [1e-3, 1e-10, 1e-100, 1e-300] {
            let expected = small * FRAC_2_PI;
            // atan(t) = t (1 - t^2/3): below 1e-8 the first term suffices.
            let tolerance = (small * small + 4.0 * f64::EPSILON) * expected;
            for (x, y, starts) in [
                (1.0, small, true),
                (small, 1.0, false),
                (-small, 1.0, true),
                (-1.0, small, false),
                (-1.0, -small, true),
                (-small, -1.0, false),
                (small, -1.0, true),
                (1.0, -small, false),
            ] {
                let a = Azimuth::of_xy(x, y);
                let near = if starts { a.since } else { a.until };
                assert!((near - expected).abs() <= tolerance, "({x}, {y}): {a:?}");
            }
        }
    }

    #[test]
    fn axes_belong_to_the_quadrant_they_start() {
        for (x, y, quadrant) in [
            (1.0, 0.0, 0),
            (1.0, -0.0, 0),
            (0.0, 1.0, 1),
            (-0.0, 1.0, 1),
            (-1.0, 0.0, 2),
            (-1.0, -0.0, 2),
            (0.0, -1.0, 3),
            (-0.0, -1.0, 3),
            (0.0, 0.0, 0),
            (-0.0, -0.0, 0),
        ] {
            let a = Azimuth::of_xy(x, y);
            assert_eq!((a.quadrant, a.since), (quadrant, 0.0), "({x}, {y}): {a:?}");
        }
        for (phi, quadrant) in [(0.0, 0), (-0.0, 0), (TAU, 0), (-TAU, 0), (-TAU / 4.0, 3)] {
            let a = Azimuth::of_phi(phi);
            assert_eq!((a.quadrant, a.since), (quadrant, 0.0), "phi {phi}: {a:?}");
        }
    }

    #[test]
    fn longitudes_are_reduced_exactly() {
        let far = [4503599627370495.5, 4503599627370496.0, 1e15 + 0.3, 1e16, 1e300, f64::MAX];
        let near = [0.0, 5e-324, 1e-300, 0.1, 1.5, TAU / 4.0, TAU / 2.0, TAU, 7.0, 1e3, 12345.678];
        for phi in far.into_iter().chain(near) {
            let turns = (phi * FRAC_2_PI) % 4.0;
            let (quadrant, part) = (quadrant_of(turns), turns - turns.floor());
            let expected = Azimuth { quadrant, since: part, until: 1.0 - part };
            assert_eq!(Azimuth::of_phi(phi), expected, "{phi}");
            // Westwards, quadrants are traversed from their ends.
            let expected = if part > 0.0 {
                Azimuth { quadrant: 3 - quadrant, since: 1.0 - part, until: part }
            } else {
                Azimuth { quadrant: (4 - quadrant) % 4, since: 0.0, until: 1.0 }
            };
            assert_eq!(Azimuth::of_phi(-phi), expected, "-{phi}");
        }
    }

    #[test]
    fn a_longitude_just_below_zero_is_in_the_last_quadrant() {
        for phi in [-1e-3, -1e-17, -f64::MIN_POSITIVE, -TAU - 1e-9] {
            let a = Azimuth::of_phi(phi);
            assert_eq!(a.quadrant, 3, "phi {phi}: {a:?}");
            assert!(a.until > 0.0, "phi {phi}: {a:?}");
        }
    }

    #[test]
    fn sine_and_cosine_agree_with_the_library() {
        for k in 0..=SAMPLES {
            let eighth = 2.0 * f64::from(k) / f64::from(SAMPLES) - 1.0;
            let (sin, cos) = sin_cos_eighths(eighth);
            let (lib_sin, lib_cos) = (eighth * FRAC_PI_4).sin_cos();
            // One rounding of each side and at most one more in the series.
            assert!(
                (sin - lib_sin).abs() <= 1.5 * f64::EPSILON * lib_sin.abs(),
                "{eighth}: {sin} against {lib_sin}"
            );
            assert!(
                (cos - lib_cos).abs() <= 1.5 * f64::EPSILON * lib_cos,
                "{eighth}: {cos} against {lib_cos}"
            );
        }
        assert_eq!(sin_cos_eighths(0.0), (0.0, 1.0));
    }
}
