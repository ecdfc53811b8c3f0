use std::path::{Path, PathBuf};
use std::sync::Arc;

use sphvar_grammar::{Declaration, Parametric, ResolveError};

use crate::definition::{Definition, FileResolver};
use crate::{
    CostOrder, Domain, Error, PatternFacts, PointFile, PointFiles, Rate, Sampler, Space,
    ValidCounts,
};

/// Parameters of the pattern `file`: point sets from a file, one of which is drawn uniformly.
///
/// The pattern has the number of points of its file; where sizes differ, their mean. A template
/// such as `sets-{n}.npy` names a file for each number of points.
/// [`Pattern::parse`](crate::Pattern::parse) reads the files;
/// [`PointSets`](crate::PointSets) are the same without files. On the square the parameters are
/// [`SquarePointFileParameters`](crate::SquarePointFileParameters), without `fold`.
#[derive(Clone, Debug, PartialEq)]
pub struct PointFileParameters<S: Space = Domain> {
    /// `None` in the default.
    file: Option<PathBuf>,
    /// The meaning of the columns, in the notation of the resolver.
    pub columns: Option<String>,
    /// The table of a FITS file: its number or its name.
    pub hdu: Option<String>,
    /// Whether vectors may have any length; on the square, whether coordinates are taken modulo 1.
    pub normalize: bool,
    /// Whether rows without a valid point or with an invalid weight are skipped.
    pub skip_invalid: bool,
    /// Whether points below the plane are replaced by their antipodes on the hemisphere; otherwise
    /// they are errors there.
    pub fold: bool,
    /// Whether [`Pattern::label`](crate::Pattern::label) has the path instead of the name of the
    /// file, because another file has the same name. Not part of the text form.
    pub has_long_label: bool,
    /// `None` until a resolver has read the files.
    content: Option<Arc<PointFiles<S>>>,
}

impl<S: Space> PointFileParameters<S> {
    /// The parameters without a file, which cannot be built.
    pub const DEFAULT: Self = Self {
        file: None,
        columns: None,
        hdu: None,
        normalize: false,
        skip_invalid: false,
        fold: false,
        has_long_label: false,
        content: None,
    };

    /// Returns the path of the file, or of several files, with `{n}` in place of their numbers of
    /// points.
    #[must_use]
    pub fn file(&self) -> &Path {
        self.file.as_deref().unwrap_or(Path::new(""))
    }

    /// Declares the parameters of the sphere and of the square.
    pub(crate) fn declare_table(&mut self, d: &mut Declaration<'_>, normalize: &'static str) {
        let summary = "points as CSV or other text, NPY, NPZ, PLY or a FITS table; {n} in the name \
                       stands for the number of points of one file each";
        d.required_file("file", summary, self.file.get_or_insert_default());
        let summary = "roles of the columns, as in columns=\"ra,dec,_,w\"";
        d.word("columns", summary, "by their names", &mut self.columns);
        d.word("hdu", "table of a FITS file", "the first", &mut self.hdu);
        d.choice("normalize", normalize, &mut self.normalize);
        d.choice("skip-invalid", "skip rows with invalid numbers", &mut self.skip_invalid);
    }

    /// Returns the numbers of points of the files; none before they are read.
    pub(crate) fn counts(&self) -> ValidCounts {
        let counts = self.content.as_ref().map_or_else(Vec::new, |content| content.counts());
        ValidCounts::Listed(counts.into())
    }

    /// Returns the files.
    ///
    /// # Errors
    ///
    /// [`Error::Given`] before they are read.
    pub(crate) fn content(&self) -> Result<&PointFiles<S>, Error> {
        self.content.as_deref().ok_or_else(unread)
    }

    /// Sets the content to that of the files that `read` returns.
    pub(crate) fn read(
        &mut self,
        space: S,
        read: impl FnOnce(&Self) -> Result<Vec<PointFile<S::Point>>, ResolveError>,
    ) -> Result<(), Error> {
        if self.file().as_os_str().is_empty() {
            let reason = "the name of the file is empty; expected file:PATH".to_owned();
            return Err(ResolveError::new(reason).into());
        }
        self.content = Some(Arc::new(PointFiles::new(read(self)?, space)?));
        Ok(())
    }

    /// Returns the number of points of a single file; `None` for a template and before files are
    /// read.
    pub(crate) fn own_count(&self) -> Option<usize> {
        let content = self.content.as_ref().filter(|content| !content.is_template())?;
        content.counts().first().copied()
    }

    /// Returns the parameters with the label's file name.
    pub(crate) fn shortened(&self) -> Self {
        match self.file().file_name().filter(|_| !self.has_long_label) {
            Some(name) => Self { file: Some(name.into()), ..self.clone() },
            None => self.clone(),
        }
    }
}

impl<S: Space> Default for PointFileParameters<S> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for PointFileParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        self.declare_table(d, "accept vectors of any length");
        let summary = "on the hemisphere, replace points below the plane by their antipodes";
        d.choice("fold", summary, &mut self.fold);
    }
}

/// Returns the error of a pattern whose file has not been read.
pub(crate) fn unread() -> Error {
    Error::Given { reason: "no file has been read".to_owned() }
}

/// The known properties of given points.
pub(crate) const FACTS: PatternFacts = PatternFacts {
    cost: CostOrder::LINEAR,
    low_degrees: "that of the points",
    smooth_rate: Rate::Depends,
    jump_rate: Rate::Depends,
    is_extensible: false,
    source: "the user",
};

impl Definition for PointFileParameters {
    fn facts(&self) -> PatternFacts {
        FACTS
    }

    fn valid_counts(&self, _domain: Domain) -> ValidCounts {
        self.counts()
    }

    fn stream_group(&self, n_points: usize) -> Option<usize> {
        self.content().ok()?.stream_group(n_points)
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let sets = self.content()?.sets(n_points, domain, self.fold);
        Ok(Box::new(sets.ok_or_else(unread)??))
    }

    fn resolve(&mut self, files: &dyn FileResolver) -> Result<(), Error> {
        self.read(Domain::Sphere, |source| files.points(source))
    }
}
