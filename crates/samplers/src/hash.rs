/// Returns the 32-bit hash of Fowler, Noll and Vo (FNV-1a), which is specified byte for byte.
pub(crate) fn fnv1a(bytes: &[u8]) -> u32 {
    let step = |hash: u32, byte: &u8| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
    bytes.iter().fold(0x811c_9dc5, step)
}
