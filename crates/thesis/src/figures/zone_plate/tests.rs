use super::{Aliasing, PlanePattern, Screen};
use crate::Error;

/// The exact means and the rendered ones agree where many samples resolve the rings, for regular
/// samples.
#[test]
fn means_over_pixels_are_the_limit_of_samples() -> Result<(), Error> {
    let few = Screen::new(16)?;
    let exact = few.pixel_means()?;
    let many = Screen { side: 16 * 64, ..few.clone() };
    let fine = many.pixel_means()?;
    let rendered = few.render(&grid(16 * 64));
    for pixel in 0..16 * 16 {
        let (column, row) = (pixel % 16, pixel / 16);
        let cells =
            (0..64).flat_map(|y| (0..64).map(move |x| (64 * row + y) * 1024 + 64 * column + x));
        let mean = cells.map(|cell| fine[cell]).sum::<f64>() / 4096.0;
        // Both are exact: thousands of roundings.
        assert!((mean - exact[pixel]).abs() < 1e-13, "{pixel}: {mean}, {}", exact[pixel]);
        // The midpoint rule with 64 intervals of a phase of 8: (8/64)^2/24 of each coordinate.
        assert!((rendered[pixel] - exact[pixel]).abs() < 2e-3, "{pixel}");
    }
    Ok(())
}

/// Returns the centres of the cells of a grid.
fn grid(side: usize) -> Vec<[f64; 2]> {
    let at = |i: usize| (i as f64 + 0.5) / side as f64;
    (0..side).flat_map(|row| (0..side).map(move |column| [at(column), at(row)])).collect()
}

/// Away from the frequencies of pixels, filtered and unfiltered pictures agree: the filter has a
/// mean of 1 and no first moment.
#[test]
fn the_reference_shows_the_centre_as_it_is() -> Result<(), Error> {
    let screen = Screen::new(1024)?;
    let (filtered, means) = (screen.mitchell()?, screen.pixel_means()?);
    for pixel in (0..8).flat_map(|row| (0..8).map(move |column| row * 1024 + column)) {
        // A second moment below 1 times the curvature 2 (extent/1024)^2 = 8e-3.
        assert!((filtered[pixel] - means[pixel]).abs() < 8e-3, "{pixel}");
    }
    Ok(())
}

#[test]
fn empty_pixels_show_the_nearest_sample() -> Result<(), Error> {
    let screen = Screen::new(16)?;
    let points = [[0.1, 0.1], [0.9, 0.3], [0.51, 0.95], [0.55, 0.97]];
    let picture = screen.render(&points);
    for (pixel, got) in picture.iter().enumerate() {
        let centre = [pixel % 16, pixel / 16].map(|i| (i as f64 + 0.5) / 16.0);
        let distance = |p: &[f64; 2]| (p[0] - centre[0]).hypot(p[1] - centre[1]);
        let in_pixel =
            |p: &&[f64; 2]| p.iter().zip(centre).all(|(x, c)| (x - c).abs() < 0.5 / 16.0);
        let own: Vec<_> = points.iter().filter(in_pixel).collect();
        let nearest = points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
        let shown = if own.is_empty() { vec![nearest] } else { own };
        let value =
            |p: &&[f64; 2]| p.iter().map(|x| (screen.extent * x).powi(2)).sum::<f64>().sin();
        let expected = shown.iter().map(value).sum::<f64>() / shown.len() as f64;
        assert!((got - expected).abs() < 1e-13, "{pixel}: {got}, {expected}");
    }
    assert!(screen.render(&[]).iter().all(|value| *value == 0.0));
    Ok(())
}

/// A regular grid aliases into waves, and jitter into noise: 12.0 and 1.00 by an independent
/// program. The standard deviation for jitter is 0.01, so the margin is exceeded once in 1e6 seeds.
#[test]
fn jitter_turns_aliases_into_noise() -> Result<(), Error> {
    let screen = Screen::new(256)?;
    let exact = screen.pixel_means()?;
    let structure =
        |points: &[[f64; 2]]| Aliasing::new(&screen.render(points), &exact, screen.side);
    let regular = structure(&grid(256));
    // Half a unit of the last digit of the independent program: 0.39021 and 0.51015/0.042446.
    assert!((regular.mse - 0.390_21).abs() < 5e-6, "{regular:?}");
    assert!((regular.structure - 12.0185).abs() < 1e-3, "{regular:?}");
    let jittered = structure(&PlanePattern::Jittered.ensemble(256 * 256).set(3, 0)?);
    assert!((jittered.structure - 1.0).abs() < 0.05, "{jittered:?}");
    // 1/e of the pixels repeat a neighbour: 1.17 to 1.21 by an independent program.
    let white = structure(&PlanePattern::WhiteNoise.ensemble(256 * 256).set(3, 0)?);
    assert!((white.structure - 1.18).abs() < 0.08, "{white:?}");
    Ok(())
}
