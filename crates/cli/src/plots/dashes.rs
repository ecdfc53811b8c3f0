//! Dashed lines, and the selection of lines that need dashes because they cover others.

use super::chart::{Series, Style};
use super::palette::Ink;
use super::plane::Plane;

/// Alternating lengths of dashes and gaps, in units; empty for a line without gaps.
pub(super) type Pattern = &'static [f64];

/// The patterns of lines that cover others, by the number of lines covered: those beneath show in
/// the gaps.
const OVER_OTHERS: [Pattern; 4] = [&[], &[13.0, 9.0], &[7.0, 13.0], &[3.0, 15.0]];
/// The patterns of the user's own curves from the second on, which have one colour.
const OWN: [Pattern; 3] = [&[14.0, 5.0], &[12.0, 4.0, 2.5, 4.0], &[3.5, 4.0]];
/// The pattern of dashed lines.
const DASHED: Pattern = &[8.0, 4.5];
/// Lines within this distance look like one, in units.
const MAX_VISUAL_DISTANCE: f64 = 1.6;
/// The fraction of a line that must be covered for it to count as coinciding with another.
const HIDDEN: f64 = 0.4;

/// Returns the dash patterns of series in drawing order.
pub(super) fn patterns(series: &[&Series], plane: &Plane) -> Vec<Pattern> {
    let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut patterns = Vec::new();
    for one in series {
        if !one.style.has_line() {
            patterns.push(OVER_OTHERS[0]);
            continue;
        }
        let line: Vec<_> = one.points.iter().filter_map(|&point| plane.place(point)).collect();
        let beneath = lines.iter().filter(|other| coincide(&line, other)).count();
        lines.push(line);
        patterns.push(match one.style {
            Style::Dashed => DASHED,
            Style::Solid => OVER_OTHERS[0],
            _ => match one.ink {
                Ink::User(number @ 1..) => OWN[(number - 1) % OWN.len()],
                _ => OVER_OTHERS[beneath.min(OVER_OTHERS.len() - 1)],
            },
        });
    }
    patterns
}

/// Returns whether a considerable part of a line's points is on another line, both from left to
/// right.
fn coincide(line: &[(f64, f64)], other: &[(f64, f64)]) -> bool {
    let on_other = |&(x, y): &(f64, f64)| {
        let after = other.partition_point(|point| point.0 < x);
        let at = match (after.checked_sub(1).map(|i| other[i]), other.get(after)) {
            (_, Some(&(ox, oy))) if (ox - x).abs() < 1e-9 => oy,
            (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
            _ => return false,
        };
        (at - y).abs() <= MAX_VISUAL_DISTANCE
    };
    let hidden = line.iter().filter(|point| on_other(point)).count();
    line.len() > 1 && hidden as f64 >= HIDDEN * line.len() as f64
}

/// Returns the dashes of a line through these points.
pub(super) fn dashes(points: &[(f64, f64)], pattern: &[f64]) -> Vec<Vec<(f64, f64)>> {
    if pattern.is_empty() {
        return vec![points.to_vec()];
    }
    let mut dashes = Vec::new();
    let (mut index, mut left) = (0, pattern[0]);
    let mut dash: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    for side in points.windows(2) {
        let (mut from, to) = (side[0], side[1]);
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            if length < left {
                left -= length;
                dash.push(to);
                break;
            }
            let part = left / length;
            from = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
            dash.push(from);
            if index % 2 == 0 {
                dashes.push(std::mem::take(&mut dash));
            }
            dash = vec![from];
            index += 1;
            left = pattern[index % pattern.len()];
        }
    }
    if index % 2 == 0 && dash.len() > 1 {
        dashes.push(dash);
    }
    dashes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_their_part() {
        let line: Vec<_> = (0..=100).map(|i| (f64::from(i), 10.0 * f64::from(i % 2))).collect();
        let length = |points: &[(f64, f64)]| -> f64 {
            points.windows(2).map(|s| (s[1].0 - s[0].0).hypot(s[1].1 - s[0].1)).sum()
        };
        let drawn: f64 = dashes(&line, &[3.0, 1.0]).iter().map(|dash| length(dash)).sum();
        assert!((drawn / length(&line) - 0.75).abs() < 0.01, "{drawn}");
        assert_eq!(dashes(&line, &[]), vec![line]);
        assert!(dashes(&[], DASHED).is_empty());
    }
}
