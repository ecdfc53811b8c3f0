use std::f64::consts::PI;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::azimuth::{Azimuth, NO_FRACTION, quarter_turns};
use crate::cell_map::assert_unit;
use crate::lanes::{LaneCell, LaneOrder};
use crate::{Cell, Error};

/// Number of points processed together: enough for two of the widest registers, and few enough to
/// speed up short lists.
const WIDTH: usize = 16;

/// Writes the pixel of `dirs[i]` to `pixels[i]`.
///
/// # Panics
///
/// Panics if the slices differ in length; in debug builds also if a direction is not a unit vector.
pub(crate) fn pixels_into(order: &impl LaneOrder, dirs: &[DVec3], pixels: &mut [u64]) {
    assert_lengths("directions", dirs.len(), pixels.len());
    dirs.iter().for_each(|dir| assert_unit(*dir));
    fill(order, dirs, pixels);
}

/// Writes the pixel of colatitude and longitude `angles[i]` to `pixels[i]`.
///
/// # Errors
///
/// That of the first pair of angles that is out of range; `pixels` is then unspecified.
///
/// # Panics
///
/// Panics if the slices differ in length.
pub(crate) fn pixels_of_angles_into(
    order: &impl LaneOrder,
    angles: &[[f64; 2]],
    pixels: &mut [u64],
) -> Result<(), Error> {
    assert_lengths("pairs of angles", angles.len(), pixels.len());
    let (blocks, rest) = angles.as_chunks();
    let (block_pixels, rest_pixels) = pixels.as_chunks_mut();
    Arch::new().dispatch(AngleBlocks { order, angles: blocks, pixels: block_pixels })?;
    for (&[theta, phi], pixel) in rest.iter().zip(rest_pixels) {
        *pixel = order.pixel_of_angles(theta, phi)?;
    }
    Ok(())
}

fn assert_lengths(what: &str, n: usize, n_pixels: usize) {
    assert!(n == n_pixels, "the output has {n_pixels} pixels for {n} {what}");
}

/// Implements [`pixels_into`] without its checks; extra elements of the longer slice are ignored.
fn fill(order: &impl LaneOrder, dirs: &[DVec3], pixels: &mut [u64]) {
    let (blocks, rest) = dirs.as_chunks();
    let (block_pixels, rest_pixels) = pixels.as_chunks_mut();
    Arch::new().dispatch(Blocks { order, dirs: blocks, pixels: block_pixels });
    for (dir, pixel) in rest.iter().zip(rest_pixels) {
        *pixel = order.pixel_of_cell(Cell::of_any_vector(order.nside(), *dir));
    }
}

struct Blocks<'a, O> {
    order: &'a O,
    dirs: &'a [[DVec3; WIDTH]],
    pixels: &'a mut [[u64; WIDTH]],
}

impl<O: LaneOrder> WithSimd for Blocks<'_, O> {
    type Output = ();

    /// Uses plain loops, which the compiler vectorizes for the instruction set of the call. No
    /// product is fused with a sum, so results are bit-identical for all instruction sets.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (dirs, pixels) in self.dirs.iter().zip(self.pixels) {
            let mut components = [[0.0; WIDTH]; 3];
            for (i, dir) in dirs.iter().enumerate() {
                (components[0][i], components[1][i], components[2][i]) = (dir.x, dir.y, dir.z);
            }
            let [x, y, z] = components;
            for i in 0..WIDTH {
                let cell = LaneCell::of_any_vector(self.order.nside(), x[i], y[i], z[i]);
                pixels[i] = self.order.pixel_of_lane(cell);
            }
        }
    }
}

struct AngleBlocks<'a, O> {
    order: &'a O,
    angles: &'a [[[f64; 2]; WIDTH]],
    pixels: &'a mut [[u64; WIDTH]],
}

impl<O: LaneOrder> WithSimd for AngleBlocks<'_, O> {
    type Output = Result<(), Error>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        for (angles, pixels) in self.angles.iter().zip(self.pixels) {
            let mut thetas = [0.0; WIDTH];
            let mut phis = [0.0; WIDTH];
            for (i, angles) in angles.iter().enumerate() {
                [thetas[i], phis[i]] = *angles;
            }
            let mut plain = true;
            for i in 0..WIDTH {
                plain &= (thetas[i] >= 0.0) & (thetas[i] <= PI);
                plain &= quarter_turns(phis[i]) < NO_FRACTION;
            }
            if plain {
                for i in 0..WIDTH {
                    let azimuth = Azimuth::of_quarter_turns(phis[i] < 0.0, quarter_turns(phis[i]));
                    let cell = LaneCell::of_angles(self.order.nside(), thetas[i], azimuth);
                    pixels[i] = self.order.pixel_of_lane(cell);
                }
            } else {
                // Longitudes of 10^15 turns, or angles out of range.
                for (&[theta, phi], pixel) in angles.iter().zip(pixels) {
                    *pixel = self.order.pixel_of_angles(theta, phi)?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::*;
    use crate::lanes::tests::hostile_vectors;
    use crate::{Nested, Nside, PixelOrder, Ring};

    const NSIDES: [u32; 4] = [1, 3, 1 << 10, Nside::MAX];

    /// Returns the pixels of whole blocks, computed with the given instruction set.
    fn of_vectors(simd: impl Simd, order: &impl LaneOrder, dirs: &[DVec3]) -> Vec<u64> {
        let (dirs, _) = dirs.as_chunks();
        let mut pixels = vec![[u64::MAX; WIDTH]; dirs.len()];
        simd.vectorize(Blocks { order, dirs, pixels: &mut pixels });
        pixels.concat()
    }

    /// Returns the pixels of angles in range, as [`of_vectors`].
    fn of_angles(simd: impl Simd, order: &impl LaneOrder, angles: &[[f64; 2]]) -> Vec<u64> {
        let (angles, _) = angles.as_chunks();
        let mut pixels = vec![[u64::MAX; WIDTH]; angles.len()];
        simd.vectorize(AngleBlocks { order, angles, pixels: &mut pixels }).unwrap();
        pixels.concat()
    }

    /// Checks the list, and its blocks with other instruction sets than the default.
    fn assert_vectors(order: &impl LaneOrder, vectors: &[DVec3], expected: &[u64], name: &str) {
        let mut pixels = vec![u64::MAX; vectors.len()];
        fill(order, vectors, &mut pixels);
        assert_eq!(pixels, expected, "{name}");
        let found = of_vectors(Scalar::new(), order, vectors);
        assert_eq!(found, expected[..found.len()], "{name}, no registers");
        #[cfg(target_arch = "x86_64")]
        if let Some(v3) = pulp::x86::V3::try_new() {
            let found = of_vectors(v3, order, vectors);
            assert_eq!(found, expected[..found.len()], "{name}, AVX2");
        }
    }

    #[test]
    fn lists_match_the_scalar_lookup_for_arbitrary_vectors() {
        let vectors = hostile_vectors();
        assert!(vectors.len() > WIDTH && !vectors.len().is_multiple_of(WIDTH));
        for n in NSIDES {
            let nside = Nside::new(n).unwrap();
            let ring = Ring::new(nside);
            let expected: Vec<u64> = vectors
                .iter()
                .map(|v| ring.pixel_of_cell(Cell::of_any_vector(nside, *v)))
                .collect();
            assert_vectors(&ring, &vectors, &expected, &format!("ring order, nside {n}"));

            let Ok(nested) = Nested::new(nside) else { continue };
            let expected: Vec<u64> = expected.iter().map(|&p| nested.from_ring(p)).collect();
            assert_vectors(&nested, &vectors, &expected, &format!("nested order, nside {n}"));
        }
    }

    #[test]
    fn lists_match_the_scalar_lookup_for_angles() {
        const THETAS: [f64; 11] =
            [0.0, 5e-324, 1e-160, 1e-9, 0.5, 0.841, 1.57, PI / 2.0, 2.3, 3.1, PI];
        const PHIS: [f64; 11] = [0.0, -0.0, 5e-324, -1e-9, 0.7, PI / 4.0, PI, -PI, 6.2, 1e3, -1e15];
        let pairs = || THETAS.into_iter().flat_map(|theta| PHIS.map(|phi| [theta, phi]));
        // A block with a longitude without a fraction is not vectorized, so only one block has one.
        let angles: Vec<[f64; 2]> = pairs().chain([[1.0, 1e300]]).chain(pairs()).collect();
        assert!(!angles.len().is_multiple_of(WIDTH));
        for n in NSIDES {
            let ring = Ring::new(Nside::new(n).unwrap());
            let expected: Vec<u64> =
                angles.iter().map(|a| ring.pixel_of_angles(a[0], a[1]).unwrap()).collect();
            let mut pixels = vec![u64::MAX; angles.len()];
            pixels_of_angles_into(&ring, &angles, &mut pixels).unwrap();
            assert_eq!(pixels, expected, "nside {n}");
            let found = of_angles(Scalar::new(), &ring, &angles);
            assert_eq!(found, expected[..found.len()], "nside {n}, no registers");
            #[cfg(target_arch = "x86_64")]
            if let Some(v3) = pulp::x86::V3::try_new() {
                let found = of_angles(v3, &ring, &angles);
                assert_eq!(found, expected[..found.len()], "nside {n}, AVX2");
            }
        }
    }
}
