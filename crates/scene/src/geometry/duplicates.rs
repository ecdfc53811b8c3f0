use std::collections::HashMap;

use glam::DVec3;

/// Removes triangles whose three corners coincide with those of an earlier triangle, in any order.
pub(crate) fn remove_duplicates(vertices: &[DVec3], faces: &mut Vec<[u32; 3]>) {
    let key = |face: &[u32; 3]| {
        // The two zeros are the same coordinate.
        let mut places = face.map(|v| vertices[v as usize].to_array().map(|x| (x + 0.0).to_bits()));
        places.sort_unstable();
        places
    };
    let hash = |face: &[u32; 3]| {
        let words = key(face);
        words.as_flattened().iter().fold(0u64, |hash, word| {
            let mixed = (hash ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            mixed ^ mixed >> 29
        })
    };
    let mut hashes: Vec<(u64, u32)> = faces.iter().map(hash).zip(0..).collect();
    hashes.sort_unstable();
    let mut is_repeated = vec![false; faces.len()];
    for run in hashes.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        let mut seen = HashMap::new();
        for &(_, i) in run {
            let first = seen.insert(key(&faces[i as usize]), ());
            is_repeated[i as usize] = first.is_some();
        }
    }
    let mut repeated = is_repeated.into_iter();
    faces.retain(|_| !repeated.next().unwrap_or(false));
}
