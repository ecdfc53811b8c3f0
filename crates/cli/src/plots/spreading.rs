//! Moves labels apart by the smallest distances.

/// Returns the middles of labels of these heights between `low` and `high` such that no labels
/// overlap and, apart from the limits, the sum of the squared distances from the wanted middles is
/// minimal, or `None` if they do not fit. The order of wanted middles is preserved.
pub(super) fn spread(wanted: &[f64], heights: &[f64], low: f64, high: f64) -> Option<Vec<f64>> {
    if heights.iter().sum::<f64>() > high - low {
        return None;
    }
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&a, &b| wanted[a].total_cmp(&wanted[b]));
    // After subtraction of the heights of the labels before, middles need only be nondecreasing:
    // this is isotonic regression, whose blocks of equal values are pooled from first to last.
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    let mut offsets = Vec::with_capacity(order.len());
    let mut before = 0.0;
    for &label in &order {
        let offset = before + 0.5 * heights[label];
        before += heights[label];
        offsets.push(offset);
        let mut block = (wanted[label] - offset, 1_usize);
        while let Some(&(mean, count)) = blocks.last().filter(|last| last.0 > block.0) {
            let all = count + block.1;
            block = ((mean * count as f64 + block.0 * block.1 as f64) / all as f64, all);
            blocks.pop();
        }
        blocks.push(block);
    }
    let places = blocks.iter().flat_map(|&(mean, count)| std::iter::repeat_n(mean, count));
    let mut middles = vec![0.0; wanted.len()];
    for ((&label, offset), place) in order.iter().zip(offsets).zip(places) {
        middles[label] = place.clamp(low, high - before) + offset;
    }
    Some(middles)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn labels_with_space_stay() {
        let wanted = [30.0, 80.0, 55.0];
        assert_eq!(spread(&wanted, &[10.0; 3], 0.0, 100.0).unwrap(), wanted);
        assert_eq!(spread(&[50.0, 50.0], &[10.0; 2], 0.0, 100.0).unwrap(), [45.0, 55.0]);
        assert_eq!(spread(&[99.0, 99.0], &[10.0; 2], 0.0, 100.0).unwrap(), [85.0, 95.0]);
        assert_eq!(spread(&[1.0; 11], &[10.0; 11], 0.0, 100.0), None);
    }

    proptest! {
        #[test]
        fn none_overlap(
            labels in prop::collection::vec((-50.0..150.0_f64, 0.5..6.0_f64), 0..16),
        ) {
            let (wanted, heights): (Vec<f64>, Vec<f64>) = labels.into_iter().unzip();
            let middles = spread(&wanted, &heights, 0.0, 100.0).unwrap();
            for (i, (&a, &height)) in middles.iter().zip(&heights).enumerate() {
                prop_assert!(a - 0.5 * height >= -1e-9 && a + 0.5 * height <= 100.0 + 1e-9);
                for (&b, &other) in middles.iter().zip(&heights).skip(i + 1) {
                    prop_assert!((a - b).abs() >= 0.5 * (height + other) - 1e-9);
                }
            }
        }
    }
}
