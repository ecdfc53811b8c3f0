use std::f64::consts::PI;

/// Returns the coefficients, highest power first, of the polynomial in t that interpolates `f` at
/// the Chebyshev points of [-1, 1].
pub fn interpolate(f: impl Fn(f64) -> f64, degree: usize) -> Vec<f64> {
    let n = degree + 1;
    let angle = |k: usize| PI * (k as f64 + 0.5) / n as f64;
    let values: Vec<f64> = (0..n).map(|k| f(angle(k).cos())).collect();
    // Chebyshev coefficients by the discrete cosine transform of the values.
    let chebyshev: Vec<f64> = (0..n)
        .map(|j| {
            let terms = values.iter().enumerate().map(|(k, v)| v * (j as f64 * angle(k)).cos());
            terms.sum::<f64>() * if j == 0 { 1.0 } else { 2.0 } / n as f64
        })
        .collect();
    let mut coefficients = monomials(&chebyshev);
    coefficients.reverse();
    coefficients
}

/// Returns the coefficients of 1, t, t^2, ... of a Chebyshev series.
fn monomials(chebyshev: &[f64]) -> Vec<f64> {
    let n = chebyshev.len();
    let (mut before, mut current) = (vec![0.0; n], vec![0.0; n]);
    let mut sum = vec![0.0; n];
    current[0] = 1.0;
    for (j, c) in chebyshev.iter().enumerate() {
        for (s, t) in sum.iter_mut().zip(&current) {
            *s += c * t;
        }
        // T_{j+1} = 2 t T_j - T_{j-1}, and T_1 = t.
        let factor = if j == 0 { 1.0 } else { 2.0 };
        let mut next: Vec<f64> = before.iter().map(|b| if j == 0 { 0.0 } else { -b }).collect();
        for d in 1..n {
            next[d] += factor * current[d - 1];
        }
        before = std::mem::replace(&mut current, next);
    }
    sum
}
