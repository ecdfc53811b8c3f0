//! Poisson disks that are repeated in tiles.

use sphvar_samplers::{
    Error, Purpose, SquarePattern, SquareSampler, Streams, TiledDisks, toroidal_separation,
};

fn sample(sampler: &dyn SquareSampler) -> Vec<[f64; 2]> {
    sampler.sample(&mut Streams::new(2, Purpose::Pattern, 0).realization(0)).unwrap().points
}

/// Returns `|sum exp(-2 pi i k.u)|^2/N`.
fn power(points: &[[f64; 2]], [k1, k2]: [i32; 2]) -> f64 {
    let phase = |[u, v]: [f64; 2]| std::f64::consts::TAU * (f64::from(k1) * u + f64::from(k2) * v);
    let [re, im] = points.iter().fold([0.0, 0.0], |[re, im], &p| {
        let (sin, cos) = phase(p).sin_cos();
        [re + cos, im + sin]
    });
    (re * re + im * im) / points.len() as f64
}

#[test]
fn the_power_lies_at_multiples_of_the_repeats() {
    for repeats in [1, 2, 3, 5] {
        let k = i32::try_from(repeats).unwrap();
        let tiled = TiledDisks::new(40 * (repeats * repeats) as usize, repeats, None).unwrap();
        let points = sample(&tiled);
        // The same random numbers give the same tile.
        let tile = sample(&tiled.tile());
        for k1 in -12..=12 {
            for k2 in 0..=12 {
                let is_multiple = k1 % k == 0 && k2 % k == 0;
                let of_tile = || f64::from(k * k) * power(&tile, [k1 / k, k2 / k]);
                let expected = if is_multiple { of_tile() } else { 0.0 };
                let got = power(&points, [k1, k2]);
                assert!((got - expected).abs() < 1e-9, "{repeats} {k1} {k2}: {got}, {expected}");
            }
        }
    }
}

#[test]
fn disks_do_not_overlap_across_tiles() {
    let tiled = TiledDisks::new(450, 3, None).unwrap();
    let (points, distance) = (sample(&tiled), tiled.tile().distance() / 3.0);
    assert_eq!(points.len(), 450);
    assert!(points.iter().flatten().all(|x| (0.0..1.0).contains(x)));
    let separation = toroidal_separation(&points, &()).unwrap().unwrap();
    assert!(separation >= distance * (1.0 - 1e-9), "{separation} below {distance}");
}

#[test]
fn counts_are_multiples_of_the_number_of_tiles() {
    let pattern: SquarePattern = "tiled-disks:repeats=3".parse().unwrap();
    assert_eq!(pattern.nearest_count(100), 99);
    assert_eq!(pattern.nearest_count(1), 9);
    assert!(matches!(pattern.build(100), Err(Error::InvalidCount { nearest: 99, .. })));
    assert!(matches!(TiledDisks::new(100, 3, None), Err(Error::InvalidCount { nearest: 99, .. })));
    assert!(TiledDisks::new(0, 3, None).is_err() && TiledDisks::new(usize::MAX, 2, None).is_err());
    for repeats in [0, TiledDisks::MAX_REPEATS + 1] {
        assert!(matches!(TiledDisks::new(100, repeats, None), Err(Error::Parameter { .. })));
    }
    // One point in each tile: a regular grid.
    assert_eq!(sample(&TiledDisks::new(4, 2, None).unwrap()).len(), 4);
}
