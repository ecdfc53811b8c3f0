//! Fits names of series into lines: breaks them at separators and, if that does not suffice,
//! shortens long words.

use plotters::prelude::DrawingBackend;

use super::canvas::Canvas;
use super::plot_error::PlotError;

/// Separators, each of which ends a part of a name: `name:key=value,key=value`, paths, words.
const SEPARATORS: [char; 5] = [':', ',', '=', '/', ' '];
/// The separators at which lines are broken.
const BREAKS: [char; 3] = [':', ',', ' '];
const ELLIPSIS: char = '\u{2026}';
/// The minimum number of characters of a shortened part.
const MIN_PART: usize = 4;
/// Keys of up to this number of characters are not shortened either.
const SHORT_PART: usize = 10;

/// Returns a name in at most `max_lines` lines no wider than `width`. If it does not fit, its
/// longest parts are shortened in the middle, keys of parameters last, so that every parameter is
/// still shown.
pub(super) fn fitted<DB: DrawingBackend>(
    name: &str,
    size: f64,
    width: f64,
    max_lines: usize,
    canvas: &Canvas<DB>,
) -> Result<Vec<String>, PlotError> {
    let mut parts: Vec<Vec<char>> =
        name.split_inclusive(SEPARATORS).map(|part| part.chars().collect()).collect();
    let mut lines = broken(&parts, &BREAKS, size, width, canvas)?;
    loop {
        if lines.len() <= max_lines && all_within(&lines, size, width, canvas)? {
            return Ok(lines);
        }
        let is_key = |part: &[char]| part.last() == Some(&'=');
        let length = |part: &[char]| match part.len() {
            length if !is_key(part) && length > SHORT_PART => length + name.len(),
            length => length,
        };
        let longest = parts.iter_mut().max_by_key(|part| length(part));
        match longest.filter(|part| part.len() > MIN_PART) {
            Some(part) => shorten(part),
            // Applies to names of hundreds of parts.
            None => return cut(lines, size, width, max_lines, canvas),
        }
        lines = broken(&parts, &SEPARATORS, size, width, canvas)?;
    }
}

/// Removes a character from the middle of a part and marks the place with an ellipsis.
fn shorten(part: &mut Vec<char>) {
    match part.iter().position(|&c| c == ELLIPSIS) {
        None => {
            let middle = part.len() / 2;
            part.splice(middle - 1..=middle, [ELLIPSIS]);
        }
        Some(place) if place + 1 + place < part.len() => {
            part.remove(place + 1);
        }
        Some(place) => {
            part.remove(place - 1);
        }
    }
}

/// Joins parts to lines that are as long as fits, broken after `breaks`, or after any part where
/// the text between two breaks does not fit in a line.
fn broken<DB: DrawingBackend>(
    parts: &[Vec<char>],
    breaks: &[char],
    size: f64,
    width: f64,
    canvas: &Canvas<DB>,
) -> Result<Vec<String>, PlotError> {
    let ends = |part: &[char]| part.last().is_some_and(|end| breaks.contains(end));
    let fits = |text: &str| Ok::<_, PlotError>(canvas.text_width(text.trim_end(), size)? <= width);
    let mut lines = vec![String::new()];
    for joined in parts.chunk_by(|a, _| !ends(a)) {
        let whole: String = joined.iter().flatten().collect();
        let pieces = if fits(&whole)? {
            vec![whole]
        } else {
            joined.iter().map(|part| part.iter().collect()).collect()
        };
        for piece in pieces {
            match lines.last_mut() {
                Some(line) if fits(&format!("{line}{piece}"))? => line.push_str(&piece),
                _ => lines.push(piece),
            }
        }
    }
    lines.iter_mut().for_each(|line| line.truncate(line.trim_end().len()));
    lines.retain(|line| !line.is_empty());
    Ok(lines)
}

fn all_within<DB: DrawingBackend>(
    lines: &[String],
    size: f64,
    width: f64,
    canvas: &Canvas<DB>,
) -> Result<bool, PlotError> {
    for line in lines {
        if canvas.text_width(line, size)? > width {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Returns the first lines, cut at the width.
fn cut<DB: DrawingBackend>(
    mut lines: Vec<String>,
    size: f64,
    width: f64,
    max_lines: usize,
    canvas: &Canvas<DB>,
) -> Result<Vec<String>, PlotError> {
    if lines.len() > max_lines {
        lines.truncate(max_lines);
        if let Some(last) = lines.last_mut() {
            last.push(ELLIPSIS);
        }
    }
    for line in &mut lines {
        while line.chars().count() > 1 && canvas.text_width(line, size)? > width {
            line.pop();
            line.pop();
            line.push(ELLIPSIS);
        }
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::super::figure::measured;
    use super::*;

    fn names(name: &str, width: f64, max_lines: usize) -> Vec<String> {
        measured(|canvas| fitted(name, 14.0, width, max_lines, canvas)).unwrap()
    }

    #[test]
    fn parameters_are_kept() {
        assert_eq!(names("jittered", 200.0, 2), ["jittered"]);
        let lines = names("ccvt:capacity=64,mass=white", 170.0, 2);
        assert_eq!(lines, ["ccvt:capacity=64,", "mass=white"]);
        let long = "file:/home/somebody/measurements/of/last/winter/points-of-the-first-kind.npy";
        let joined = names(long, 200.0, 2).concat();
        assert!(joined.starts_with("file:/") && joined.ends_with("npy"), "{joined}");
        assert!(joined.contains(ELLIPSIS), "{joined}");
        let long = format!("blue:alpha=0.123,{}=7,iterations=100", "x".repeat(200));
        let joined = names(&long, 150.0, 3).concat();
        for part in ["alpha=", "0.123,", "=7,", "iterations=100"] {
            assert!(joined.contains(part), "{part} of {joined}");
        }
        let long = format!("file:/{}set.npy,iterations=100000", "folder-of-folders/".repeat(3));
        let joined = names(&long, 200.0, 3).concat();
        for part in ["file:/", "set.npy,", "iterations=", "100000"] {
            assert!(joined.contains(part), "{part} of {joined}");
        }
    }

    #[test]
    fn any_name_ends() {
        for name in ["", " ", &"x".repeat(500), &"a,".repeat(300), "\u{2026}\u{2026}", ":::::"] {
            for width in [3.0, 40.0, 200.0] {
                let lines = names(name, width, 2);
                assert!(lines.len() <= 2, "{lines:?}");
            }
        }
    }
}
