use std::fmt;
use std::sync::OnceLock;

use glam::DVec3;

use crate::{Domain, Error, PointSet, PointSets, Space, Square};

/// The content of a point file, as a [`FileResolver`](crate::FileResolver) reads it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFile<P = DVec3> {
    /// The file, for messages.
    pub name: String,
    /// The number of points in the name of the file, if the name was made from a template with
    /// `{n}`.
    pub stated_count: Option<usize>,
    /// The sets, at least one; directions of any length, or points of the square.
    pub sets: Vec<PointSet<P>>,
    /// Where each set begins in the file, for messages, such as `sets.csv:12`.
    pub starts: Vec<String>,
    /// Where the first point lies that the hemisphere does not have, for messages; `None` if there
    /// is none. The square has no use for it.
    pub first_below: Option<String>,
}

impl PointFile {
    /// Checks that the sets can be sampled.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] with the file, the place and the set, for sets that [`PointSets`] rejects,
    /// weights that sum to 0, and a number of points other than that in the name.
    pub fn check(&self) -> Result<(), Error> {
        FileSets::new(self, Domain::Sphere).map(|_| ())
    }
}

impl PointFile<[f64; 2]> {
    /// Checks that the sets can be sampled, as files of directions are checked.
    ///
    /// # Errors
    ///
    /// Those of the check of files of directions, and [`Error::Given`] for points outside
    /// `[0, 1)^2`.
    pub fn check(&self) -> Result<(), Error> {
        FileSets::new(self, Square).map(|_| ())
    }
}

/// The point sets of one file, or of the files of a template, by number of points.
pub(crate) struct PointFiles<S: Space = Domain> {
    /// In ascending order of their numbers of points, which are distinct.
    files: Vec<FileSets<S>>,
    is_template: bool,
}

/// The point sets of one file: directions on the sphere and, once they are needed, on the
/// hemisphere, or points of the square.
struct FileSets<S: Space> {
    given: PointSets<S>,
    hemisphere: OnceLock<Result<PointSets<S>, Error>>,
    first_below: Option<String>,
}

impl<S: Space> PointFiles<S> {
    /// Returns the sets of one or more files on a space that holds all their points.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] with the file, the place and the set, for sets that [`PointSets`] rejects,
    /// weights that sum to 0, a number of points other than that in the name, and files with equal
    /// numbers of points.
    pub(crate) fn new(files: Vec<PointFile<S::Point>>, space: S) -> Result<Self, Error> {
        let is_template = files.iter().any(|file| file.stated_count.is_some());
        let mut names = Vec::new();
        for file in files {
            let sets = FileSets::new(&file, space)?;
            names.push((sets.n_points(), file.name, sets));
        }
        names.sort_by_key(|named| named.0);
        if let Some(same) = names.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let reason = format!("{} and {} both have {} points", same[0].1, same[1].1, same[0].0);
            return Err(Error::Given { reason });
        }
        if names.is_empty() {
            return Err(Error::Given { reason: "there is no file".to_owned() });
        }
        Ok(Self { files: names.into_iter().map(|named| named.2).collect(), is_template })
    }

    /// Returns the numbers of points in ascending order.
    pub(crate) fn counts(&self) -> Vec<usize> {
        self.files.iter().map(FileSets::n_points).collect()
    }

    /// Returns whether the files come from a template, so that the number of points selects one.
    pub(crate) fn is_template(&self) -> bool {
        self.is_template
    }

    /// Returns a hash of the points and weights of the file with `n_points` points.
    pub(crate) fn stream_group(&self, n_points: usize) -> Option<usize> {
        Some(self.at(n_points)?.given.group())
    }

    fn at(&self, n_points: usize) -> Option<&FileSets<S>> {
        self.files.iter().find(|file| file.n_points() == n_points)
    }
}

impl PointFiles<Square> {
    /// Returns the sets of the file with `n_points` points, if there is one.
    pub(crate) fn square_sets(&self, n_points: usize) -> Option<PointSets<Square>> {
        Some(self.at(n_points)?.given.clone())
    }
}

impl PointFiles {
    /// Returns the sets of the file with `n_points` points, if there is one. On the hemisphere,
    /// points below the plane are replaced by their antipodes if `fold`.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] for points below the plane unless `fold`.
    pub(crate) fn sets(
        &self,
        n_points: usize,
        domain: Domain,
        fold: bool,
    ) -> Option<Result<PointSets, Error>> {
        let file = self.at(n_points)?;
        Some(match (domain, &file.first_below) {
            (Domain::Sphere, _) => Ok(file.given.clone()),
            (_, Some(place)) if !fold => Err(Error::Given {
                reason: format!(
                    "{place}; the hemisphere needs z >= 0 (the option fold=yes replaces points by their antipodes)"
                ),
            }),
            _ => {
                let folded = || PointSets::new(file.given.sets().to_vec(), domain);
                file.hemisphere.get_or_init(folded).clone()
            }
        })
    }
}

impl<S: Space> FileSets<S> {
    fn new(file: &PointFile<S::Point>, space: S) -> Result<Self, Error> {
        let name = &file.name;
        if let Some(i) = file.sets.iter().position(|set| {
            set.weights.len() == set.len() && !set.is_empty() && set.n_effective() <= 0.0
        }) {
            let start = file.starts.get(i).unwrap_or(name);
            let reason = format!("{start}: the weights of set {i} (0-based) sum to 0");
            return Err(Error::Given { reason });
        }
        let given = PointSets::new(file.sets.clone(), space).map_err(|error| {
            let reason = match error {
                Error::Given { reason } => reason,
                other => other.to_string(),
            };
            Error::Given { reason: format!("{name}: {reason}") }
        })?;
        let got = given.mean_count();
        if let Some(stated) = file.stated_count.filter(|&stated| stated != got) {
            let reason = format!("{name}: its name states {stated} points, but it has {got}");
            return Err(Error::Given { reason });
        }
        let first_below = file.first_below.clone();
        Ok(Self { given, hemisphere: OnceLock::new(), first_below })
    }

    fn n_points(&self) -> usize {
        self.given.mean_count()
    }
}

/// Files are equal if their numbers of points and hashes of their contents are.
impl<S: Space> PartialEq for PointFiles<S> {
    fn eq(&self, other: &Self) -> bool {
        let key = |files: &Self| -> Vec<(usize, usize)> {
            let of = |file: &FileSets<S>| (file.n_points(), file.given.group());
            files.files.iter().map(of).collect()
        };
        self.is_template == other.is_template && key(self) == key(other)
    }
}

/// Omits the points, which can be numerous.
impl<S: Space> fmt::Debug for PointFiles<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PointFiles").field("counts", &self.counts()).finish_non_exhaustive()
    }
}
