use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::DVec3;

use super::environment::RgbEnvironment;
use super::{DirectionalLight, luminance};
use crate::Error;

impl RgbEnvironment {
    /// Returns `n` lights by the median cut algorithm (Debevec 2005): the map is divided
    /// recursively along the longer side of each region, between rows or columns, into regions of
    /// equal luminance, and each region becomes a light at the centroid of its luminance.
    ///
    /// The longer side is measured with widths times the sine of the colatitude at the middle of
    /// the region. Numbers that are no powers of two divide the luminance in proportion to the
    /// numbers of lights. Texels of negative luminance count by its magnitude. Parts without
    /// luminance get no lights, and a single texel that is to be divided becomes several lights at
    /// its centre.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if `n` is 0.
    pub fn median_cut(&self, n: usize) -> Result<Vec<DirectionalLight>, Error> {
        if n == 0 {
            let name = "the number of lights";
            return Err(Error::Setting { name, range: "at least 1", got: 0.0 });
        }
        let (map, from_map) = (&self.channels()[0], self.to_map().inverse());
        let grid = Grid { environment: self, width: map.width(), height: map.height() };
        let mut pending = vec![(Region { rows: 0..grid.height, columns: 0..grid.width }, n)];
        let mut lights = Vec::with_capacity(n);
        while let Some((region, n)) = pending.pop() {
            if n == 1 || (region.rows.len() == 1 && region.columns.len() == 1) {
                let DirectionalLight { direction, irradiance } = grid.light(&region);
                let direction = from_map * direction;
                let irradiance = irradiance.map(|x| x / n as f64);
                lights.extend((0..n).map(|_| DirectionalLight { direction, irradiance }));
                continue;
            }
            let first = n / 2;
            match grid.divide(&region, first as f64 / n as f64) {
                Division::Both(a, b) => pending.extend([(b, n - first), (a, first)]),
                Division::Brighter(part) => pending.push((part, n)),
            }
        }
        Ok(lights)
    }
}

/// The texels as a map of light.
struct Grid<'a> {
    environment: &'a RgbEnvironment,
    width: usize,
    height: usize,
}

#[derive(Clone)]
struct Region {
    rows: Range<usize>,
    columns: Range<usize>,
}

/// The parts of a region that have luminance.
enum Division {
    Both(Region, Region),
    Brighter(Region),
}

impl Grid<'_> {
    fn theta(&self, edge: f64) -> f64 {
        PI * edge / self.height as f64
    }

    /// Returns the solid angle of a texel.
    fn solid_angle(&self, row: usize) -> f64 {
        let (middle, half) = (self.theta(row as f64 + 0.5), 0.5 * self.theta(1.0));
        TAU / self.width as f64 * 2.0 * middle.sin() * half.sin()
    }

    fn centre(&self, row: usize, column: usize) -> DVec3 {
        let map = &self.environment.channels()[0];
        let phi = map.first_longitude() + TAU * (column as f64 + 0.5) / self.width as f64;
        let ((st, ct), (sp, cp)) = (self.theta(row as f64 + 0.5).sin_cos(), phi.sin_cos());
        DVec3::new(st * cp, st * sp, ct)
    }

    /// Returns the radiance of a texel, integrated over it.
    fn light_of_texel(&self, row: usize, column: usize) -> [f64; 3] {
        let solid_angle = self.solid_angle(row);
        self.environment.texel(row * self.width + column).map(|x| x * solid_angle)
    }

    fn light(&self, region: &Region) -> DirectionalLight {
        let (mut sum, mut moment, mut irradiance) = (DVec3::ZERO, DVec3::ZERO, [0.0; 3]);
        for row in region.rows.clone() {
            for column in region.columns.clone() {
                let (light, centre) = (self.light_of_texel(row, column), self.centre(row, column));
                sum += centre;
                moment += centre * luminance(light).abs();
                irradiance = [0, 1, 2].map(|c| irradiance[c] + light[c]);
            }
        }
        // The light of the whole sphere may have no centroid.
        let direction = moment.try_normalize().or(sum.try_normalize()).unwrap_or(DVec3::Z);
        DirectionalLight { direction, irradiance }
    }

    /// Returns the parts of a region of at least two texels of which the first has about this share
    /// of the luminance.
    fn divide(&self, region: &Region, share: f64) -> Division {
        let Region { rows, columns } = region;
        let middle = self.theta(0.5 * (rows.start + rows.end) as f64);
        let across = TAU * columns.len() as f64 / self.width as f64 * middle.sin();
        let is_tall =
            columns.len() == 1 || (rows.len() > 1 && self.theta(rows.len() as f64) > across);
        let luminance_of = |row, column| luminance(self.light_of_texel(row, column)).abs();
        let strips: Vec<f64> = if is_tall {
            let strip = |row| columns.clone().map(|column| luminance_of(row, column)).sum();
            rows.clone().map(strip).collect()
        } else {
            let mut strips = vec![0.0; columns.len()];
            for row in rows.clone() {
                for (strip, column) in strips.iter_mut().zip(columns.clone()) {
                    *strip += luminance_of(row, column);
                }
            }
            strips
        };
        let at = median(&strips, share);
        let part = |strips: Range<usize>| {
            let within = |side: &Range<usize>| side.start + strips.start..side.start + strips.end;
            if is_tall {
                Region { rows: within(rows), columns: columns.clone() }
            } else {
                Region { rows: rows.clone(), columns: within(columns) }
            }
        };
        let (first, last) = (part(0..at), part(at..strips.len()));
        let is_dark = |strips: &[f64]| strips.iter().all(|&strip| strip <= 0.0);
        if is_dark(&strips[at..]) {
            Division::Brighter(first)
        } else if is_dark(&strips[..at]) {
            Division::Brighter(last)
        } else {
            Division::Both(first, last)
        }
    }
}

/// Returns the number of strips, at least one and not all, whose sum is nearest to a share of that
/// of all.
fn median(strips: &[f64], share: f64) -> usize {
    let target = share * strips.iter().sum::<f64>();
    let (mut best, mut nearest, mut sum) = (1, f64::INFINITY, 0.0);
    for (i, strip) in strips[..strips.len() - 1].iter().enumerate() {
        sum += strip;
        let distance = (sum - target).abs();
        if distance < nearest {
            (best, nearest) = (i + 1, distance);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn medians_are_between_strips() {
        assert_eq!(median(&[1.0, 1.0, 1.0, 1.0], 0.5), 2);
        assert_eq!(median(&[9.0, 1.0, 1.0], 0.5), 1);
        assert_eq!(median(&[1.0, 1.0, 9.0], 0.5), 2);
        assert_eq!(median(&[0.0, 0.0], 0.5), 1);
        assert_eq!(median(&[1.0, 1.0, 1.0], 1.0 / 3.0), 1);
    }
}
