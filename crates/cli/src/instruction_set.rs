//! The class of machines with bit-identical results.

/// Returns the class of this machine.
///
/// The width of the registers in which sums are computed, and the use of fused multiply-add, depend
/// on the processor: the libraries select at run time. `x86-64-v3` and `x86-64-v4` are the levels
/// of the x86-64 psABI and determine the selection completely; below them the Fourier transforms
/// may still use the instruction sets listed.
pub(crate) fn instruction_set() -> String {
    let architecture = std::env::consts::ARCH.replace('_', "-");
    match pulp::Arch::new() {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        pulp::Arch::V3(_) => format!("{architecture}-v3"),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        pulp::Arch::V4(_) => format!("{architecture}-v4"),
        #[cfg(target_arch = "aarch64")]
        pulp::Arch::Neon(_) => format!("{architecture} neon"),
        _ => architecture + &lesser_sets(),
    }
}

/// Returns the instruction sets that the Fourier transforms detect.
fn lesser_sets() -> String {
    let mut sets = String::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    for (name, is_there) in [
        ("sse4.1", std::is_x86_feature_detected!("sse4.1")),
        ("avx", std::is_x86_feature_detected!("avx")),
        ("fma", std::is_x86_feature_detected!("fma")),
        ("avx2", std::is_x86_feature_detected!("avx2")),
    ] {
        if is_there {
            sets += " ";
            sets += name;
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::instruction_set;

    #[test]
    fn it_is_a_name() {
        let name = instruction_set();
        assert!(name.starts_with(&std::env::consts::ARCH.replace('_', "-")), "{name}");
        assert!(name.bytes().all(|b| b.is_ascii_graphic() || b == b' '), "{name}");
    }
}
