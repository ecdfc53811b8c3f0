//! Parameters at the ends of their ranges, and frequencies to the last one.

use std::f64::consts::{PI, TAU};

use sphvar_integrands::{
    Disk, Energy, Error, Exponential, Gaussian, HalfPlane, Interpolation, SquareImage,
    SquareIntegrand, Wave, ZonePlate,
};
use sphvar_sh::{ByAxis, Frequencies, TailClasses};

use super::cases::energies;

fn at(energy: &Energy<Frequencies>, k: [i32; 2]) -> f64 {
    energy.per_band()[energy.bands().band_of(k).unwrap()]
}

#[track_caller]
fn close(got: f64, expected: f64, tolerance: f64) {
    assert!((got / expected - 1.0).abs() < tolerance, "{got:e} and {expected:e}");
}

/// `int_0^1 e^{ax - 2 pi i k x} dx = (e^a - 1)/(a - 2 pi i k)`, to relative rounding at every k.
#[test]
fn energies_of_exponentials_are_accurate_to_the_last_frequency() {
    for (a, b) in [(1.0, -2.0), (100.0, 0.5), (-30.0, 1e-7)] {
        let energy = energies(&Exponential::new([a, b]).unwrap(), 20, 1 << 17);
        let factor = |a: f64, k: i32| {
            let frequency = TAU * f64::from(k);
            a.exp_m1().powi(2) / (a * a + frequency * frequency)
        };
        for k in [[1, 0], [0, 3], [2, 5], [-9, 17], [1000, 0], [0, 65535], [131072, 0]] {
            close(at(&energy, k), 2.0 * factor(a, k[0]) * factor(b, k[1]), 2e-12);
        }
    }
    let constant = energies(&Exponential::new([0.0, 0.0]).unwrap(), 3, 3);
    assert_eq!((constant.total(), constant.centred()), (1.0, ByAxis::default()));
}

/// Narrow peaks inside the square have the totals of the plane and Gaussian coefficients; wide ones
/// are a constant and a parabola.
#[test]
fn gaussians_of_any_width_have_accurate_energies() {
    for width in [1e-9, 1e-6, 1e-3, 0.05] {
        let energy = energies(&Gaussian::new(width, [0.5, 0.45]).unwrap(), 30, 1 << 17);
        let (integral, square) = ((TAU).sqrt() * width, PI.sqrt() * width);
        let axis = (square - integral * integral) * integral * integral;
        let total = square * square - integral.powi(4);
        let centred = energy.centred();
        close(energy.per_band()[0], integral.powi(4), 1e-13);
        close(centred.u, axis, 1e-12);
        close(centred.v, axis, 1e-12);
        close(centred.sum(), total, 1e-12);
        for k in [[1, 0], [3, -2], [20, 11], [500, 0], [0, 131072]] {
            let norm = f64::from(k[0]).hypot(f64::from(k[1]));
            let expected = 2.0 * integral.powi(4) * (-(TAU * width * norm).powi(2)).exp();
            let error = (at(&energy, k) - expected).abs();
            assert!(error < 1e-11 * expected + 1e-30 * total, "{width}, {k:?}");
        }
    }
    for width in [1e4f64, 1e9] {
        let energy = energies(&Gaussian::new(width, [0.5, 0.5]).unwrap(), 30, 1000);
        // The variance of (x - 1/2)^2/(2 width^2).
        let axis = 0.25 / 180.0 / width.powi(4);
        let centred = energy.centred();
        close(centred.u, axis, 1e-7);
        close(centred.v, axis, 1e-7);
        close(centred.off, axis * axis, 1e-7);
        // The coefficients of x^2 are 1/(2 pi^2 k^2).
        close(at(&energy, [7, 0]), 0.5 * (1.0 / (98.0 * PI * PI * width * width)).powi(2), 1e-7);
    }
}

/// Small arguments of the sine leave its first power: x^2 + y^2.
#[test]
fn zone_plates_of_any_scale_have_accurate_energies() {
    let of_scale = |scale| energies(&ZonePlate::new(scale).unwrap(), 30, 1 << 16);
    let [tiny, small, double] = [1e-9, 1e-3, 2e-3].map(of_scale);
    for (scale, energy) in [(1e-9, &tiny), (1e-3, &small)] {
        let axis = 4.0 / 45.0 * f64::powi(scale, 4);
        close(energy.centred().u, axis, 1e-5);
        close(energy.centred().v, axis, 1e-5);
        // int_0^1 x^2 e^{-2 pi i k x} dx = 1/(2 pi^2 k^2) + i/(2 pi k).
        let expected = |k: f64| {
            let (re, im) = (0.5 / (PI * k).powi(2), 0.5 / (PI * k));
            2.0 * (re * re + im * im) * scale.powi(4)
        };
        for k in [1, 30, 65536] {
            close(at(energy, [k, 0]), expected(f64::from(k)), 1e-5);
        }
    }
    // The part off the axes is -(x^4 y^2 + x^2 y^4)/2 to the first power.
    close(double.centred().off / small.centred().off, 4096.0, 1e-4);
    // At many periods beyond those of the function, the jump across the sides decides.
    let energy = of_scale(100.0);
    let k = 65536.0;
    let jump = |y: f64| (1e4 + y * y).sin() - (y * y).sin();
    let n = 1 << 20;
    let mean = (0..n).map(|i| jump(100.0 * (f64::from(i) + 0.5) / f64::from(n))).sum::<f64>();
    close(at(&energy, [65536, 0]), 2.0 * (mean / f64::from(n) / (TAU * k)).powi(2), 0.02);
    close(energy.centred().sum(), 0.5, 0.01);
}

/// Edges along and across the sides have the energies of a step; edges nearly parallel to them, or
/// nearly diagonal, nearly the same ones.
#[test]
fn half_planes_of_special_angles_are_limits_of_others() {
    let of = |degrees, offset| energies(&HalfPlane::new(degrees, offset).unwrap(), 60, 1 << 16);
    for offset in [0.0, 0.25, -0.3, 0.4999] {
        let step = of(0.0, offset);
        let inside: f64 = 0.5 - offset;
        assert_eq!((step.centred().off, step.centred().v), (0.0, 0.0));
        close(step.centred().u, inside * (1.0 - inside), 1e-14);
        close(step.per_band()[0], inside * inside, 1e-14);
        for k in [1, 7, 65535] {
            let phase = PI * f64::from(k) * inside;
            let expected = 2.0 * (phase.sin() / (PI * f64::from(k))).powi(2);
            assert!((at(&step, [k, 0]) - expected).abs() < 1e-10 * expected + 1e-28, "{k}");
        }
        for degrees in [90.0, -90.0, 180.0, 270.0, 360.0] {
            let energy = of(degrees, offset);
            let is_across = degrees % 180.0 != 0.0;
            let centred = energy.centred();
            let (along, across) =
                if is_across { (centred.v, centred.u) } else { (centred.u, centred.v) };
            assert_eq!((along, across, centred.off), (step.centred().u, 0.0, 0.0), "{degrees}");
            let k = if is_across { [0, 5] } else { [5, 0] };
            let error = (at(&energy, k) - at(&step, [5, 0])).abs();
            assert!(error < 1e-16, "{degrees}: {error:e}");
        }
    }
    for exact in [0.0, 45.0, 90.0, 135.0, 225.0] {
        for offset in [0.0, 0.2, -0.45] {
            let one = of(exact, offset);
            for difference in [1e-9, -1e-9, 1e-12] {
                let other = of(exact + difference, offset);
                let pairs = one.per_band().iter().zip(other.per_band());
                let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(largest < 1e-10, "{exact} {offset} {difference}: {largest:e}");
                // A slight slope turns t/6 of the variance of the axis to other frequencies.
                let off = other.centred().off;
                if exact % 90.0 == 0.0 {
                    // The rounding of 270 degrees limits the difference.
                    let tolerance = 2e-4 + 6e-14 / difference.abs();
                    close(off, f64::to_radians(difference.abs()) / 6.0, tolerance);
                }
            }
        }
    }
}

/// A corner of area A has `|G_k| = A` at low frequencies, and the part of an axis A (the mean chord)
/// where that is small.
#[test]
fn small_corners_have_accurate_energies() {
    for degrees in [45.0, 30.0, 89.0, 210.0] {
        let radians = f64::to_radians(degrees);
        let (sin, cos) = (radians.sin().abs(), radians.cos().abs());
        let offset = 0.5 * (sin + cos) - 1e-5;
        let depth: f64 = 0.5 * (sin + cos) - offset;
        let area = 0.5 * depth * depth / (sin * cos);
        let corner = HalfPlane::new(degrees, offset).unwrap();
        let energy = energies(&corner, 5, 5);
        close(corner.exact().unwrap(), area, 1e-9);
        close(energy.centred().sum(), area, 1e-3);
        for k in [[1, 0], [0, 1], [2, -1], [1, 2]] {
            close(at(&energy, k), 2.0 * area * area, 1e-2);
        }
    }
    for offset in [0.8, 1.0, -1.0] {
        let constant = HalfPlane::new(30.0, offset).unwrap();
        let energy = energies(&constant, 5, 50);
        let total = f64::from(u8::from(offset < 0.0));
        assert_eq!(energy.total().to_bits(), total.to_bits());
        assert_eq!((energy.centred(), constant.kurtosis()), (ByAxis::default(), None));
    }
}

/// Bessel functions at large arguments, and disks that nearly touch themselves.
#[test]
fn disks_of_any_radius_have_accurate_energies() {
    let tiny = energies(&Disk::new(1e-9, [0.0, 1.0]).unwrap(), 3, 1 << 17);
    close(at(&tiny, [0, 1 << 17]), 2.0 * (PI * 1e-18f64).powi(2), 1e-6);
    close(tiny.centred().off, PI * 1e-18, 1e-7);
    // r J_1(x)/k with x = 2 pi r k and J_1 = sqrt(2/(pi x)) (cos(x - 3 pi/4) - 3/(8 x) sin(..)).
    let (r, k) = (0.3, 4001.0);
    let x: f64 = TAU * r * k;
    let phase = x - 0.75 * PI;
    let j = (2.0 / (PI * x)).sqrt() * (phase.cos() - 0.375 / x * phase.sin());
    let energy = energies(&Disk::new(r, [0.5, 0.5]).unwrap(), 3, 1 << 13);
    close(at(&energy, [4001, 0]), 2.0 * (r * j / k).powi(2), 1e-5);
    // Values continue across the sides.
    let corner = Disk::new(0.25, [0.0, 0.9]).unwrap();
    let inside = [[0.0, 0.9], [0.99, 0.95], [0.8, 0.9], [0.01, 0.1], [0.2, 0.99]];
    assert!(inside.iter().all(|point| corner.eval(*point) > 0.5));
    assert!([[0.5, 0.9], [0.0, 0.5], [0.2, 0.1]].iter().all(|point| corner.eval(*point) < 0.5));
}

/// Pictures have no energy at the multiples of their size, and a constant picture none but its mean.
#[test]
fn pictures_have_energies_at_aliases_of_their_texels() {
    for interpolation in [Interpolation::Bilinear, Interpolation::Constant] {
        let texel = |i: usize| (i * 31 % 17) as f64 - 4.0;
        let texels = || (0..35).map(texel).collect::<Vec<_>>();
        let image = SquareImage::new(5, 7, texels(), interpolation).unwrap();
        let energy = energies(&image, 40, 1 << 16);
        for k in [[5, 0], [0, 7], [10, 7], [5, 3], [2, 14], [65535, 0]] {
            let got = at(&energy, k);
            assert!(got <= 0.0, "{interpolation:?} {k:?}: {got:e}");
        }
        // |G| falls as 1/k1 or 1/k1^2 along aliases.
        let ratio = if interpolation == Interpolation::Constant { 36.0 } else { 1296.0 };
        close(at(&energy, [1, 2]) / at(&energy, [6, 2]), ratio, 1e-12);
        // Neither the mean nor the scale costs digits.
        for scale in [1e-140, 1e140] {
            let texels = texels().iter().map(|x| scale * x).collect();
            let scaled = SquareImage::new(5, 7, texels, interpolation).unwrap();
            let scaled = energies(&scaled, 8, 8);
            close(scaled.centred().sum(), scale * scale * energy.centred().sum(), 1e-12);
            close(at(&scaled, [1, 2]), scale * scale * at(&energy, [1, 2]), 1e-12);
        }
        let flat = SquareImage::new(3, 2, vec![1e5; 6], interpolation).unwrap();
        let energy = energies(&flat, 8, 8);
        assert_eq!((energy.total(), energy.centred()), (1e10, ByAxis::default()));
        assert_eq!((flat.kurtosis(), flat.variation()), (None, Some(0.0)));
    }
}

#[test]
fn parameters_out_of_range_are_errors() {
    let is_parameter = |error: Result<(), Error>| matches!(error, Err(Error::Parameter { .. }));
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-10, 0.51] {
        assert!(is_parameter(Disk::new(bad, [0.5; 2]).map(|_| ())), "{bad}");
    }
    for bad in [f64::NAN, f64::INFINITY, 0.0, -2.0, 1e10] {
        assert!(is_parameter(Gaussian::new(bad, [0.5; 2]).map(|_| ())), "{bad}");
        assert!(is_parameter(ZonePlate::new(bad).map(|_| ())), "{bad}");
    }
    for bad in [f64::NAN, -0.1, 1.1] {
        assert!(is_parameter(Disk::new(0.1, [bad, 0.5]).map(|_| ())), "{bad}");
        assert!(is_parameter(Gaussian::new(0.1, [0.5, bad]).map(|_| ())), "{bad}");
    }
    for bad in [f64::NAN, 101.0] {
        assert!(is_parameter(Exponential::new([bad, 0.0]).map(|_| ())), "{bad}");
        assert!(is_parameter(HalfPlane::new(10.0, bad).map(|_| ())), "{bad}");
        assert!(is_parameter(HalfPlane::new(5.0 * bad, 0.0).map(|_| ())), "{bad}");
    }
    for bad in [i32::MIN, i32::MAX, (1 << 24) + 1] {
        assert!(is_parameter(Wave::new([0, bad]).map(|_| ())), "{bad}");
    }
    let image = |width, height, texels| {
        SquareImage::new(width, height, texels, Interpolation::Bilinear).map(|_| ())
    };
    assert!(is_parameter(image(0, 0, vec![])));
    assert!(matches!(image(2, 2, vec![1.0; 3]), Err(Error::TexelCount { got: 3, .. })));
    assert!(matches!(
        image(2, 1, vec![1.0, f64::NAN]),
        Err(Error::Texel { row: 0, column: 1, .. })
    ));
    assert!(matches!(image(2, 1, vec![1e200, 0.0]), Err(Error::Magnitude { .. })));
}

/// Edges along a side but for a slight slope t, at the distance d from the middle: a corner of area
/// `(t - 2 e)^2/(8 t)` with `e = d/cos a - 1/2`, or a strip of `1/2 - d/cos a`.
#[test]
fn edges_close_to_a_side_keep_their_digits() {
    for degrees in [1e-12, 1e-9, 1e-5, 1e-2] {
        for turn in [0.0, 90.0, 180.0, 270.0] {
            let slope = f64::to_radians(degrees).tan();
            // 1/cos a - 1 = t^2/(1 + 1/cos a).
            let excess = slope * slope / (1.0 + (1.0 + slope * slope).sqrt());
            for (offset, area) in [
                (0.5, (slope - excess).powi(2) / (8.0 * slope)),
                (0.5 - 2f64.powi(-40), {
                    let gap = 2f64.powi(-40) * (1.0 + excess) - 0.5 * excess;
                    if gap > 0.5 * slope {
                        gap
                    } else {
                        (0.5 * slope + gap).powi(2) / (2.0 * slope)
                    }
                }),
            ] {
                // Angles near the other axes are rounded.
                let tolerance = 1e-14 + 4.0 * f64::EPSILON * turn / degrees;
                let inside = HalfPlane::new(turn + degrees, offset).unwrap().exact().unwrap();
                close(inside, area, tolerance);
                let outside = HalfPlane::new(turn + degrees, -offset).unwrap().exact().unwrap();
                assert!((outside + area - 1.0).abs() < 1e-15, "{turn} {degrees}: {outside}");
            }
        }
    }
}
