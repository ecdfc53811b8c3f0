use rand::Rng;
use sphvar_grammar::Parametric;

use super::radical_inverse::fraction;
use crate::definition::Definition;
use crate::{
    CostOrder, Error, PatternFacts, PointSet, Progress, Rate, Share, Square, SquareSampler, count,
};

/// Progressive multi-jittered (0,2) samples (Christensen, Kensler and Kilpatrick 2018): a random
/// sequence of which the first 2^m points are a (0, m, 2)-net in base 2 for every m, and the first
/// 4^k are stratified on a grid of 2^k x 2^k cells, too.
///
/// With N points present, N a power of 4, the next N lie in the cells of those, in the same order,
/// in the quarters diagonally opposite to theirs; the 2N points after them take the other two
/// quarters, one of them at random first. Within its quarter, a point is uniform in the only
/// rectangle of width and height 1/(2N) that leaves at most one point in every elementary interval
/// of area 1/(2N).
///
/// The publication finds that rectangle by trial. Here its digits follow one by one: if the first a
/// binary digits of u and the first m - a of v are known, the elementary interval that they denote
/// holds one point of the net present, from which the next digit must differ. The cost is about
/// `m` steps for each point, and 4 bytes in addition to the 32 of a point.
#[derive(Clone, Copy, Debug)]
pub struct Pmj02 {
    n: u32,
}

impl Pmj02 {
    /// Returns the first `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)? })
    }
}

impl SquareSampler for Pmj02 {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn nominal_work(&self) -> f64 {
        let n = f64::from(self.n);
        n * (1.0 + 0.1 * n.log2())
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet<[f64; 2]>) -> Result<(), Error> {
        self.sample_watched(rng, set, &())
    }

    fn sample_watched(
        &self,
        rng: &mut dyn Rng,
        set: &mut PointSet<[f64; 2]>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let n = self.n as usize;
        let share = Share::new(progress, self.nominal_work());
        let mut digits: Vec<[u64; 2]> = Vec::with_capacity(n);
        digits.push([rng.next_u64(), rng.next_u64()]);
        let mut owners = Vec::new();
        let mut m = 0;
        while digits.len() < n {
            double(&mut digits, n, m, &mut owners, rng, &share)?;
            m += 1;
        }
        set.start().extend(digits.iter().map(|point| point.map(fraction)));
        Ok(share.finish()?)
    }
}

/// No parameters.
pub(super) struct Parameters;

impl Parametric for Parameters {}

impl Definition<Square> for Parameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEARITHMIC,
            low_degrees: "irregular",
            // Owen 1997, for N = 2^m; about N^-2 for other N.
            smooth_rate: Rate::Power { exponent: -3.0, logarithm: 1.0 },
            jump_rate: Rate::power(-1.5),
            is_extensible: true,
            source: "Christensen, Kensler and Kilpatrick 2018",
        }
    }

    fn build(&self, n_points: usize, _: Square) -> Result<Box<dyn SquareSampler>, Error> {
        Ok(Box::new(Pmj02::new(n_points)?))
    }
}

/// Appends up to 2^m points, to a total of at most `n`, to a net of 2^m points. The first digit of a
/// coordinate is its highest bit.
fn double(
    digits: &mut Vec<[u64; 2]>,
    n: usize,
    m: u32,
    owners: &mut Vec<u32>,
    rng: &mut dyn Rng,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let present = digits.len();
    let total = n.min(2 * present);
    let known = m / 2 + 1;
    let mut random = Vec::with_capacity(total - present);
    for index in present..total {
        let words = [rng.next_u64(), rng.next_u64()];
        let quarter = u64::MAX >> (known - 1) ^ u64::MAX >> known;
        // The highest bit of the first word serves as a coin: digits that follow replace it.
        let (from, flips) = match (m % 2, words[0] >> 63) {
            (1, coin) if index < present + present / 2 => {
                (index - present, if coin == 1 { [quarter, 0] } else { [0, quarter] })
            }
            (1, _) => (index - present / 2, [quarter; 2]),
            _ => (index - present, [quarter; 2]),
        };
        let start = |d: usize| (digits[from][d] ^ flips[d]) & !(u64::MAX >> known);
        digits.push([start(0), start(1)]);
        random.push(words);
    }
    for split in known..=m {
        for axis in [0, 1] {
            progress.tick(0.0)?;
            next_digits(digits, present, [split, m - split], axis, owners);
        }
    }
    for (point, words) in digits[present..].iter_mut().zip(random) {
        // The m + 1 first digits are determined.
        *point = [0, 1].map(|d: usize| point[d] | words[d] & u64::MAX >> (m + 1));
    }
    Ok(())
}

/// Sets the digit after the first `lengths[0]` of coordinate `axis` of the new points: unlike that of
/// the point present that shares these and the first `lengths[1]` of the other coordinate.
fn next_digits(
    digits: &mut [[u64; 2]],
    present: usize,
    lengths: [u32; 2],
    axis: usize,
    owners: &mut Vec<u32>,
) {
    #[expect(clippy::cast_possible_truncation, reason = "below the number of points")]
    let interval = |point: &[u64; 2]| {
        // A shift by 64 leaves no digit.
        let first = |x: u64, length: u32| x.checked_shr(64 - length).unwrap_or(0);
        let [along, across] = [point[axis], point[1 - axis]];
        (first(along, lengths[0]) << lengths[1] | first(across, lengths[1])) as usize
    };
    let (net, new) = digits.split_at_mut(present);
    owners.clear();
    owners.resize(present, 0);
    for (index, point) in (0..).zip(&*net) {
        owners[interval(point)] = index;
    }
    let digit = 1 << (63 - lengths[0]);
    for point in new {
        let owner = net[owners[interval(point)] as usize];
        point[axis] |= !owner[axis] & digit;
    }
}
