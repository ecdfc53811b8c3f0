use glam::DVec3;

use super::product;
use crate::ensemble::progress::Tick;
use crate::{Domain, Error, Fibonacci};

/// Candidates per chosen point at the end of a level; twice as many at its start.
const PER_POINT: usize = 4;

/// The number of chosen points of the first level, which later levels double.
const FIRST_LEVEL: usize = 256;

/// The number of candidates in a block: their coordinates and products fit into a cache of 32 KiB
/// while they are multiplied by the distances from many points.
const BLOCK: usize = 1024;

/// A lattice of candidates with the products of their distances from the previous points.
///
/// The lattice is replaced by one of twice as many candidates when the number of points reaches the
/// next power of two, so that points do not depend on the number requested.
#[derive(Debug)]
pub(super) struct Candidates {
    domain: Domain,
    /// The number of chosen points for which the lattice suffices.
    level: usize,
    /// The number of previous points in the products.
    n_multiplied: usize,
    coordinates: [Vec<f64>; 3],
    products: Vec<f64>,
}

impl Candidates {
    pub(super) fn new(domain: Domain) -> Self {
        Self {
            domain,
            level: 0,
            n_multiplied: 0,
            coordinates: Default::default(),
            products: Vec::new(),
        }
    }

    /// Returns the side of a square with the area of a candidate.
    pub(super) fn spacing(&self) -> f64 {
        (self.domain.area() / self.products.len() as f64).sqrt()
    }

    /// Returns the candidate with the largest product of distances from all previous points, of
    /// which `n_chosen` were chosen and the others are antipodes.
    ///
    /// `previous` begins with the points of the last call.
    pub(super) fn best(
        &mut self,
        previous: &[DVec3],
        n_chosen: usize,
        tick: Tick<'_>,
    ) -> Result<DVec3, Error> {
        if n_chosen >= self.level {
            self.level = (2 * self.level).max(FIRST_LEVEL);
            self.replace_lattice()?;
        }
        let new = &previous[self.n_multiplied..];
        self.n_multiplied = previous.len();
        let (mut best, mut largest) = (0, -1.0);
        let [x, y, z] = &self.coordinates;
        for (k, products) in self.products.chunks_mut(BLOCK).enumerate() {
            tick()?;
            let block = k * BLOCK..k * BLOCK + products.len();
            let [x, y, z] = [x, y, z].map(|axis| &axis[block.clone()]);
            for &point in new {
                multiply(products, [x, y, z], point);
            }
            for (i, &product) in block.zip(&*products) {
                if product > largest {
                    (best, largest) = (i, product);
                }
            }
        }
        Ok(DVec3::new(x[best], y[best], z[best]))
    }

    fn replace_lattice(&mut self) -> Result<(), Error> {
        let n = PER_POINT.saturating_mul(self.level);
        let lattice = Fibonacci::new(n, self.domain)?;
        self.coordinates.iter_mut().for_each(Vec::clear);
        for point in lattice.points() {
            for (values, value) in self.coordinates.iter_mut().zip(point.to_array()) {
                values.push(value);
            }
        }
        self.products.clear();
        self.products.resize(n, 1.0);
        self.n_multiplied = 0;
        Ok(())
    }
}

/// Multiplies the products of candidates at `[x, y, z]` by `UNIT_MEAN (1 - x.y)` for a point y.
fn multiply(products: &mut [f64], [x, y, z]: [&[f64]; 3], point: DVec3) {
    let along = point * product::UNIT_MEAN;
    for (((product, x), y), z) in products.iter_mut().zip(x).zip(y).zip(z) {
        *product *= product::UNIT_MEAN - (x * along.x + y * along.y + z * along.z);
    }
}
