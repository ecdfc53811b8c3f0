use super::DoubleDouble;

/// The difference of pi from the sum of its first two parts.
const PI_THIRD: f64 = -2.994769809718339666e-33;
/// The difference of pi from its nearest `f64`.
const PI_SECOND: f64 = 1.2246467991473531772e-16;

impl DoubleDouble {
    /// Returns pi to 106 bits.
    #[must_use]
    pub fn pi() -> Self {
        Self::normal(std::f64::consts::PI, PI_SECOND, 0)
    }

    /// Returns `pi - theta` of an angle in `[0, PI]`, to 106 bits of the difference.
    ///
    /// Near pi the first two parts of pi cancel; the third preserves the digits.
    #[must_use]
    pub fn supplement(theta: f64) -> Self {
        // Exact for theta above pi/2, and an ordinary difference below it.
        let first = Self::from(std::f64::consts::PI) - Self::from(theta);
        first + (Self::from(PI_SECOND) + Self::from(PI_THIRD))
    }

    /// Returns sine and cosine of an angle in radians.
    ///
    /// The angle is reduced to `[-pi, pi]` by a multiple of `2 pi`; then the Taylor series at a
    /// 64th of it and six doublings are used. The error is below `1e-30` of the larger of the two
    /// and, for angles below 3 that need no reduction, of the sine itself. A reduction adds `1e-32`
    /// times the angle. Valid for angles up to `1e15` in absolute value.
    #[must_use]
    pub fn sin_cos(self) -> (Self, Self) {
        const DOUBLINGS: i64 = 6;
        const TERMS: u64 = 24;
        let period = Self::from(2.0) * Self::pi();
        let turns = (self.value() / std::f64::consts::TAU).round();
        let reduced = if turns == 0.0 { self } else { self - Self::from(turns) * period };
        let t = reduced.shifted(-DOUBLINGS);
        let (mut sin, mut cosm1) = (Self::ZERO, Self::ZERO);
        let mut term = Self::ONE;
        for k in 1..=TERMS {
            term = term * t / Self::from(k);
            let signed = if k % 4 >= 2 { -term } else { term };
            if k % 2 == 1 {
                sin += signed;
            } else {
                cosm1 += signed;
            }
        }
        // cos - 1 is doubled instead of cos, which would lose digits in each step.
        for _ in 0..DOUBLINGS {
            let cos = cosm1 + Self::ONE;
            (sin, cosm1) = (Self::from(2.0) * sin * cos, -(Self::from(2.0) * sin * sin));
        }
        (sin, cosm1 + Self::ONE)
    }

    /// Returns the angle of the point `(x, y)` in radians, in `[-pi, pi]`: the `f64` angle with one
    /// correction.
    ///
    /// The error is about `1e-31`; the result is 0 for the origin.
    #[must_use]
    pub fn atan2(y: Self, x: Self) -> Self {
        // A common scale brings both into the range of f64.
        let larger = x.leading().1.max(y.leading().1);
        let (x, y) = (x.shifted(-larger), y.shifted(-larger));
        let guess = y.value().atan2(x.value());
        let (sin, cos) = Self::from(guess).sin_cos();
        // The tangent of the remaining angle is below 1e-15, so its cube is beyond the last digit.
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        if along == Self::ZERO { Self::ZERO } else { Self::from(guess) + across / along }
    }
}
