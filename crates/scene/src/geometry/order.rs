use glam::DVec3;

/// The number of cells of an octant along each of its two coordinates.
const CELLS: f64 = 256.0;
/// The position above the interleaved bits of two numbers up to `CELLS`.
const OCTANT_BIT: u32 = 20;

/// Returns the indices of the directions in a coherent order, in which successive directions are
/// close to each other: octant by octant, and within an octant along Morton's curve in the plane
/// `|x| + |y| + |z| = 1`.
pub(crate) fn coherent_order(dirs: &[DVec3]) -> Vec<u32> {
    let mut keys = Vec::with_capacity(dirs.len());
    #[expect(
        clippy::cast_possible_truncation,
        reason = "there is not enough memory for that many directions"
    )]
    keys.extend(dirs.iter().enumerate().map(|(i, &dir)| key(dir) << 32 | u64::from(i as u32)));
    keys.sort_unstable();
    #[expect(clippy::cast_possible_truncation, reason = "the number is in the lower half")]
    keys.iter().map(|&key| key as u32).collect()
}

#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "of a number from 0 to CELLS, or of NaN, which gives 0"
)]
fn key(dir: DVec3) -> u64 {
    let octant = u64::from(dir.x < 0.0) << 2 | u64::from(dir.y < 0.0) << 1 | u64::from(dir.z < 0.0);
    let [x, y, z] = dir.abs().to_array();
    let per_cell = CELLS / (x + y + z);
    octant << OCTANT_BIT
        | interleave((x * per_cell) as u32) << 1
        | interleave((y * per_cell) as u32)
}

/// Returns the bits of a 16-bit number with a 0 inserted before each.
fn interleave(x: u32) -> u64 {
    let x = (x | x << 8) & 0x00ff_00ff;
    let x = (x | x << 4) & 0x0f0f_0f0f;
    let x = (x | x << 2) & 0x3333_3333;
    u64::from((x | x << 1) & 0x5555_5555)
}
