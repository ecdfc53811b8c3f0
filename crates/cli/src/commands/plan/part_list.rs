//! Lists of parts in the notation of schedulers, such as `3,7-9`.

/// Returns the list of some parts in ascending order.
pub(super) fn part_list(parts: &[u64]) -> String {
    let mut ranges: Vec<(u64, u64)> = Vec::new();
    for &part in parts {
        match ranges.last_mut() {
            Some((_, last)) if *last + 1 == part => *last = part,
            _ => ranges.push((part, part)),
        }
    }
    let text = |(first, last): (u64, u64)| match last - first {
        0 => first.to_string(),
        _ => format!("{first}-{last}"),
    };
    ranges.into_iter().map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::part_list;

    #[test]
    fn neighbours_are_ranges() {
        for (parts, text) in [
            (&[][..], ""),
            (&[3], "3"),
            (&[1, 2], "1-2"),
            (&[3, 7, 8, 9, 11], "3,7-9,11"),
            (&[1, 2, 3, 4], "1-4"),
        ] {
            assert_eq!(part_list(parts), text);
        }
    }
}
