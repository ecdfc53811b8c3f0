//! Integrands with their Fourier integrals by quadrature.

use std::f64::consts::{PI, TAU};

use sphvar_integrands::{
    Disk, Exponential, Gaussian, HalfPlane, Interpolation, SquareImage, SquareIntegrand, Wave,
    ZonePlate,
};
use sphvar_sh::{Frequencies, GaussLegendre};

/// A complex number.
pub(super) type Complex = [f64; 2];

/// Nodes and weights along v, each with weighted nodes along u.
type Slices = Vec<(f64, f64, Vec<(f64, f64)>)>;

pub(super) struct Case {
    pub(super) name: String,
    pub(super) integrand: Box<dyn SquareIntegrand + Send>,
    /// A rule that integrates the function times waves of up to 40 periods to rounding. Nodes stand
    /// where the function is smooth.
    slices: Slices,
}

impl Case {
    /// Returns the Fourier integral of the values at the nodes.
    pub(super) fn coefficient(&self, [k1, k2]: [i32; 2]) -> Complex {
        let mut sum = [0.0; 2];
        for (v, weight, nodes) in &self.slices {
            for (u, along) in nodes {
                let value = weight * along * self.integrand.eval([*u, *v]);
                let (sin, cos) = (-TAU * (f64::from(k1) * u + f64::from(k2) * v)).sin_cos();
                sum = [sum[0] + value * cos, sum[1] + value * sin];
            }
        }
        sum
    }

    /// Returns the root mean square of the values.
    pub(super) fn size(&self) -> f64 {
        let along = |v: f64, nodes: &[(f64, f64)]| -> f64 {
            nodes.iter().map(|(u, w)| w * self.integrand.eval([*u, v]).powi(2)).sum()
        };
        self.slices.iter().map(|(v, weight, nodes)| weight * along(*v, nodes)).sum::<f64>().sqrt()
    }
}

/// Returns the nodes and weights of a rule on intervals between consecutive ends.
fn composite(ends: &[f64]) -> Vec<(f64, f64)> {
    let rule = GaussLegendre::new(48).unwrap();
    let panel = |pair: &[f64]| {
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        let nodes = rule.nodes().iter().zip(rule.weights());
        nodes.map(|(x, w)| (middle + half * x, half * w)).collect::<Vec<_>>()
    };
    ends.windows(2).filter(|pair| pair[1] > pair[0]).flat_map(panel).collect()
}

/// Returns n equal intervals.
fn equal(n: usize) -> Vec<f64> {
    (0..=n).map(|i| i as f64 / n as f64).collect()
}

/// A function that is smooth between lines u = const and v = const.
fn tensor(
    name: &str,
    integrand: impl SquareIntegrand + Send + 'static,
    ends: [Vec<f64>; 2],
) -> Case {
    let [along_u, along_v] = ends.map(|ends| composite(&ends));
    let slices = along_v.iter().map(|&(v, w)| (v, w, along_u.clone())).collect();
    Case { name: name.to_owned(), integrand: Box::new(integrand), slices }
}

/// An indicator of intervals of u, whose ends are smooth functions of v between some values.
fn indicator(
    name: &str,
    integrand: impl SquareIntegrand + Send + 'static,
    along_v: Vec<(f64, f64)>,
    interval: impl Fn(f64) -> [f64; 2],
) -> Case {
    let slice = |(v, w): (f64, f64)| {
        let [from, to] = interval(v);
        let mut ends = vec![from];
        ends.extend(equal(4).iter().map(|t| from + t * (to - from)));
        (v, w, composite(&ends))
    };
    let slices = along_v.into_iter().map(slice).collect();
    Case { name: name.to_owned(), integrand: Box::new(integrand), slices }
}

fn disk(radius: f64) -> Case {
    // v = 1/2 + r sin t removes the roots at the ends.
    let place = |(t, w): (f64, f64)| {
        let (sin, cos) = (0.5 * PI * t).sin_cos();
        (0.5 + radius * sin, w * 0.5 * PI * radius * cos)
    };
    let along_v = composite(&[-1.0, -0.5, 0.0, 0.5, 1.0]).into_iter().map(place).collect();
    let half = move |v: f64| (radius * radius - (v - 0.5) * (v - 0.5)).sqrt() * (1.0 - 1e-15);
    let integrand = Disk::new(radius, [0.5, 0.5]).unwrap();
    indicator(&format!("disk {radius}"), integrand, along_v, move |v| {
        [0.5 - half(v), 0.5 + half(v)]
    })
}

fn half_plane(degrees: f64, offset: f64) -> Case {
    let (sin, cos) = degrees.to_radians().sin_cos();
    // The edge meets the sides u = 0 and u = 1 at these v.
    let meet = |u: f64| (0.5 + (offset - (u - 0.5) * cos) / sin).clamp(0.0, 1.0);
    let mut ends = equal(6);
    ends.extend((0..=8).map(|i| meet(0.125 * f64::from(i))));
    ends.sort_by(f64::total_cmp);
    let edge = move |v: f64| (0.5 + (offset - (v - 0.5) * sin) / cos).clamp(0.0, 1.0);
    let name = format!("half plane {degrees} {offset}");
    let integrand = HalfPlane::new(degrees, offset).unwrap();
    indicator(&name, integrand, composite(&ends), move |v| {
        if cos > 0.0 { [edge(v), 1.0] } else { [0.0, edge(v)] }
    })
}

fn image(width: usize, height: usize, interpolation: Interpolation) -> Case {
    let texel = |k: usize| (k * 7919 % 31) as f64 / 31.0 - 0.3;
    let texels = (0..width * height).map(texel).collect();
    let integrand = SquareImage::new(width, height, texels, interpolation).unwrap();
    let shift = if interpolation == Interpolation::Constant { 0.0 } else { 0.5 };
    let ends = |n: usize| {
        let inner = (0..n).map(|i| (i as f64 + shift) / n as f64);
        [0.0, 0.5].into_iter().chain(inner).chain([1.0]).collect::<Vec<_>>()
    };
    let sorted = |mut ends: Vec<f64>| {
        ends.sort_by(f64::total_cmp);
        ends
    };
    let name = format!("image {width} x {height}, {interpolation:?}");
    tensor(&name, integrand, [width, height].map(|n| sorted(ends(n))))
}

/// Every integrand, with parameters at which the integrals above are accurate.
pub(super) fn cases() -> Vec<Case> {
    let smooth = || [equal(3), equal(3)];
    let gaussian = |width, centre| Gaussian::new(width, centre).unwrap();
    let mut cases = vec![
        tensor("wave", Wave::new([3, -2]).unwrap(), smooth()),
        tensor("wave along u", Wave::new([-5, 0]).unwrap(), smooth()),
        tensor("wave along v", Wave::new([0, 7]).unwrap(), smooth()),
        tensor("constant", Wave::new([0, 0]).unwrap(), smooth()),
        tensor("gaussian 0.08", gaussian(0.08, [0.4, 0.55]), smooth()),
        tensor("gaussian 0.9", gaussian(0.9, [0.1, 1.0]), smooth()),
        tensor("gaussian 3", gaussian(3.0, [0.0, 0.5]), smooth()),
        tensor("exponential", Exponential::new([1.0, -2.0]).unwrap(), smooth()),
        tensor("exponential along u", Exponential::new([-6.0, 0.0]).unwrap(), smooth()),
        tensor("zone plate 1", ZonePlate::new(1.0).unwrap(), smooth()),
        tensor("zone plate 9", ZonePlate::new(9.0).unwrap(), [equal(6), equal(6)]),
    ];
    cases.extend([0.03, 0.25, 0.5].map(disk));
    let edges = [(30.0, 0.0), (30.0, -0.2), (100.0, 0.1), (45.0, 0.0), (44.0, 0.5), (251.0, 0.43)];
    cases.extend(edges.map(|(degrees, offset)| half_plane(degrees, offset)));
    cases.push(half_plane(-140.0, -0.55));
    for interpolation in [Interpolation::Bilinear, Interpolation::Constant] {
        let sizes = [(1, 1), (1, 5), (4, 1), (2, 2), (6, 3)];
        cases.extend(sizes.map(|(width, height)| image(width, height, interpolation)));
    }
    cases
}

/// Returns the energies of a function by frequency.
pub(super) fn energies(
    integrand: &dyn SquareIntegrand,
    kmax: usize,
    axis_max: usize,
) -> sphvar_integrands::Energy<Frequencies> {
    let frequencies = Frequencies::new(kmax).unwrap().with_axes(axis_max).unwrap();
    integrand.energy(&frequencies).unwrap()
}
