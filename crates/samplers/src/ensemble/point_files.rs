use std::fmt;
use std::sync::OnceLock;

use crate::{Domain, Error, PointSet, PointSets, Sampler};

/// The content of a point file, as a [`FileResolver`](crate::FileResolver) reads it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointFile {
    /// The file, for messages.
    pub name: String,
    /// The number of points in the name of the file, if the name was made from a template with
    /// `{n}`.
    pub stated_count: Option<usize>,
    /// The sets, at least one; directions of any length.
    pub sets: Vec<PointSet>,
    /// Where each set begins in the file, for messages, such as `sets.csv:12`.
    pub starts: Vec<String>,
    /// Where the first point lies that the hemisphere does not have, for messages; `None` if there
    /// is none.
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
        FileSets::new(self).map(|_| ())
    }
}

/// The point sets of one file, or of the files of a template, by number of points.
pub(crate) struct PointFiles {
    /// In ascending order of their numbers of points, which are distinct.
    files: Vec<FileSets>,
    is_template: bool,
}

/// The point sets of one file on both domains.
struct FileSets {
    sphere: PointSets,
    hemisphere: OnceLock<Result<PointSets, Error>>,
    first_below: Option<String>,
}

impl PointFiles {
    /// Returns the sets of one or more files.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] with the file, the place and the set, for sets that [`PointSets`] rejects,
    /// weights that sum to 0, a number of points other than that in the name, and files with equal
    /// numbers of points.
    pub(crate) fn new(files: Vec<PointFile>) -> Result<Self, Error> {
        let is_template = files.iter().any(|file| file.stated_count.is_some());
        let mut names = Vec::new();
        for file in files {
            let sets = FileSets::new(&file)?;
            names.push((sets.sphere.n_points(), file.name, sets));
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
        self.files.iter().map(|file| file.sphere.n_points()).collect()
    }

    /// Returns whether the files come from a template, so that the number of points selects one.
    pub(crate) fn is_template(&self) -> bool {
        self.is_template
    }

    /// Returns a hash of the points and weights of the file with `n_points` points.
    pub(crate) fn stream_group(&self, n_points: usize) -> Option<usize> {
        Some(self.at(n_points)?.sphere.group())
    }

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
            (Domain::Sphere, _) => Ok(file.sphere.clone()),
            (_, Some(place)) if !fold => Err(Error::Given {
                reason: format!(
                    "{place}; the hemisphere needs z >= 0 (the option fold=yes replaces points by their antipodes)"
                ),
            }),
            _ => {
                let folded = || PointSets::new(file.sphere.sets().to_vec(), domain);
                file.hemisphere.get_or_init(folded).clone()
            }
        })
    }

    fn at(&self, n_points: usize) -> Option<&FileSets> {
        self.files.iter().find(|file| file.sphere.n_points() == n_points)
    }
}

impl FileSets {
    fn new(file: &PointFile) -> Result<Self, Error> {
        let name = &file.name;
        if let Some(i) = file.sets.iter().position(|set| {
            set.weights.len() == set.len() && !set.is_empty() && set.n_effective() <= 0.0
        }) {
            let start = file.starts.get(i).unwrap_or(name);
            let reason = format!("{start}: the weights of set {i} (0-based) sum to 0");
            return Err(Error::Given { reason });
        }
        let sphere = PointSets::new(file.sets.clone(), Domain::Sphere).map_err(|error| {
            let reason = match error {
                Error::Given { reason } => reason,
                other => other.to_string(),
            };
            Error::Given { reason: format!("{name}: {reason}") }
        })?;
        let got = sphere.n_points();
        if let Some(stated) = file.stated_count.filter(|&stated| stated != got) {
            let reason = format!("{name}: its name states {stated} points, but it has {got}");
            return Err(Error::Given { reason });
        }
        let first_below = file.first_below.clone();
        Ok(Self { sphere, hemisphere: OnceLock::new(), first_below })
    }
}

/// Files are equal if their numbers of points and hashes of their contents are.
impl PartialEq for PointFiles {
    fn eq(&self, other: &Self) -> bool {
        let key = |files: &Self| -> Vec<(usize, usize)> {
            let of = |file: &FileSets| (file.sphere.n_points(), file.sphere.group());
            files.files.iter().map(of).collect()
        };
        self.is_template == other.is_template && key(self) == key(other)
    }
}

/// Omits the points, which can be numerous.
impl fmt::Debug for PointFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PointFiles").field("counts", &self.counts()).finish_non_exhaustive()
    }
}
