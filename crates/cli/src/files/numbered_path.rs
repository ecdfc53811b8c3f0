//! Names of numbered files with one set each.

use std::path::{Path, PathBuf};

/// The placeholder of the number of a set.
const PLACE: &str = "{i}";

/// A path with the placeholder `{i}` for the number of a set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NumberedPath<'a> {
    pattern: &'a str,
}

impl<'a> NumberedPath<'a> {
    /// Returns the numbered path if `path` contains the placeholder.
    pub(crate) fn of(path: &'a Path) -> Option<Self> {
        path.to_str().filter(|text| text.contains(PLACE)).map(|pattern| Self { pattern })
    }

    /// Returns the path of a set, counted from 0 as in the column `set`. Numbers have at least six
    /// digits, so that names sort in the order of the sets.
    pub(crate) fn path(self, set: usize) -> PathBuf {
        self.pattern.replace(PLACE, &format!("{set:06}")).into()
    }
}

#[cfg(test)]
mod tests {
    use super::{NumberedPath, Path};

    #[test]
    fn numbers_take_the_place() {
        assert!(NumberedPath::of(Path::new("sets.npy")).is_none());
        assert!(NumberedPath::of(Path::new("sets-{}-{j}.npy")).is_none());
        let path = Path::new("a{i}/set-{i}.npy");
        let numbered = NumberedPath::of(path).unwrap();
        assert_eq!(numbered.path(0), Path::new("a000000/set-000000.npy"));
        assert_eq!(numbered.path(1234567), Path::new("a1234567/set-1234567.npy"));
    }
}
