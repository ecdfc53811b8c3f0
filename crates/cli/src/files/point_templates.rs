//! Paths that name a point file for each number of points.

use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::file_error::{FileError, Place};

/// The placeholder of the number of points.
const PLACE: &str = "{n}";

/// Returns the files that a path names: itself, or for a template with `{n}` all files whose names
/// have a number in its place, with that number, in ascending order.
///
/// # Errors When a folder cannot be read or no file matches a template.
pub(crate) fn point_files(path: &Path) -> Result<Vec<(Option<usize>, PathBuf)>, FileError> {
    let Some(text) = path.to_str().filter(|text| text.contains(PLACE)) else {
        return Ok(vec![(None, path.to_path_buf())]);
    };
    // The first component with a placeholder is searched for in its folder; its numbers determine
    // the rest of the path.
    let components: Vec<Component<'_>> = path.components().collect();
    let name_of = |component: &Component<'_>| component.as_os_str().to_str().map(str::to_owned);
    let has_place =
        |component: &Component<'_>| name_of(component).is_some_and(|name| name.contains(PLACE));
    let first = components.iter().position(has_place).unwrap_or(0);
    let folder: PathBuf = components[..first].iter().collect();
    let name = name_of(&components[first]).unwrap_or_default();
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let unreadable = |source| FileError::Read { path: listed.display().to_string(), source };
    let mut files = Vec::new();
    for entry in fs::read_dir(listed).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?.file_name();
        let Some(digits) = entry.to_str().and_then(|entry| number_in(&name, entry)) else {
            continue;
        };
        let Ok(n) = digits.parse::<usize>() else { continue };
        let filled = |component: &Component<'_>| -> OsString {
            let name = name_of(component);
            name.map_or_else(
                || component.as_os_str().to_owned(),
                |n| n.replace(PLACE, digits).into(),
            )
        };
        let path = folder.join(components[first..].iter().map(filled).collect::<PathBuf>());
        if path.is_file() {
            files.push((Some(n), path));
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(FileError::Layout {
            path: text.to_owned(),
            place: Place::Whole,
            expected: format!("files such as {}", text.replace(PLACE, "256")),
            got: "none".to_owned(),
        });
    }
    Ok(files)
}

/// Returns the digits in place of the placeholders of `template`, if `name` is the template with
/// the same digits in each.
fn number_in<'n>(template: &str, name: &'n str) -> Option<&'n str> {
    let (before, after) = template.split_once(PLACE)?;
    let rest = name.strip_prefix(before)?;
    let others = after.matches(PLACE).count();
    // The length of the name determines the number of digits.
    let fixed = before.len() + after.len() - others * PLACE.len();
    let length = name.len().checked_sub(fixed)? / (1 + others);
    let digits = rest.get(..length).filter(|digits| !digits.is_empty())?;
    let is_number = digits.bytes().all(|b| b.is_ascii_digit());
    (is_number && template.replace(PLACE, digits) == name).then_some(digits)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::{number_in, point_files};

    #[test]
    fn numbers_take_the_place() {
        for (template, name, digits) in [
            ("s-{n}.npy", "s-256.npy", Some("256")),
            ("{n}", "0012", Some("0012")),
            ("{n}-of-{n}.csv", "16-of-16.csv", Some("16")),
            ("{n}-of-{n}.csv", "16-of-17.csv", None),
            ("s-{n}.npy", "s-.npy", None),
            ("s-{n}.npy", "s-2x.npy", None),
            ("s-{n}.npy", "s-+2.npy", None),
            ("s-{n}.npy", "s-2.npy.gz", None),
            ("1{n}1", "11", None),
            ("1{n}1", "1", None),
        ] {
            assert_eq!(number_in(template, name), digits, "{template} {name}");
        }
    }

    #[test]
    fn templates_find_files_in_any_folder() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["s-16.npy", "s-9.npy", "s-x.npy", "16/p.csv", "32/q.csv"] {
            fs::create_dir_all(at(name).parent().unwrap()).unwrap();
            fs::write(at(name), "").unwrap();
        }
        fs::create_dir(at("s-4.npy")).unwrap();
        let found = |template: &str| point_files(&at(template));
        let expected = vec![(Some(9), at("s-9.npy")), (Some(16), at("s-16.npy"))];
        assert_eq!(found("s-{n}.npy").unwrap(), expected);
        assert_eq!(found("{n}/p.csv").unwrap(), [(Some(16), at("16/p.csv"))]);
        let message = found("t-{n}.npy").unwrap_err().to_string();
        assert!(message.ends_with("t-256.npy, got none"), "{message}");
        assert!(found("none/s-{n}.npy").is_err());
        let plain = point_files(Path::new("a{i}.npy")).unwrap();
        assert_eq!(plain, [(None, PathBuf::from("a{i}.npy"))]);
    }
}
