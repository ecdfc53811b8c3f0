use std::path::{Path, PathBuf};
use std::sync::Arc;

use sphvar_grammar::{Declaration, Parametric, ResolveError};

use crate::definition::{Definition, FileResolver};
use crate::{CostOrder, Domain, Error, PatternFacts, PointFiles, Rate, Sampler, ValidCounts};

/// Parameters of the pattern `file`: point sets from a file, one of which is drawn uniformly.
///
/// The pattern has the number of points of its file; where sizes differ, their mean. A template
/// such as `sets-{n}.npy` names a file for each number of points.
/// [`Pattern::parse`](crate::Pattern::parse) reads the files;
/// [`PointSets`](crate::PointSets) are the same without files.
#[derive(Clone, Debug, PartialEq)]
pub struct PointFileParameters {
    /// `None` in the default.
    file: Option<PathBuf>,
    /// The meaning of the columns, in the notation of the resolver.
    pub columns: Option<String>,
    /// The table of a FITS file: its number or its name.
    pub hdu: Option<String>,
    /// Whether vectors may have any length.
    pub normalize: bool,
    /// Whether rows without a direction or with an invalid weight are skipped.
    pub skip_invalid: bool,
    /// Whether points below the plane are replaced by their antipodes on the hemisphere; otherwise
    /// they are errors there.
    pub fold: bool,
    /// Whether [`Pattern::label`](crate::Pattern::label) has the path instead of the name of the
    /// file, because another file has the same name. Not part of the text form.
    pub has_long_label: bool,
    /// `None` until a resolver has read the files.
    content: Option<Arc<PointFiles>>,
}

impl PointFileParameters {
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

impl Default for PointFileParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for PointFileParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "points as CSV or other text, NPY, NPZ, PLY or a FITS table; {n} in the name \
                       stands for the number of points of one file each";
        d.required_file("file", summary, self.file.get_or_insert_default());
        let summary = "roles of the columns, as in columns=\"ra,dec,_,w\"";
        d.word("columns", summary, "by their names", &mut self.columns);
        d.word("hdu", "table of a FITS file", "the first", &mut self.hdu);
        d.choice("normalize", "accept vectors of any length", &mut self.normalize);
        d.choice("skip-invalid", "skip rows with invalid numbers", &mut self.skip_invalid);
        let summary = "on the hemisphere, replace points below the plane by their antipodes";
        d.choice("fold", summary, &mut self.fold);
    }
}

impl Definition for PointFileParameters {
    fn facts(&self) -> PatternFacts {
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: "that of the points",
            smooth_rate: Rate::Depends,
            jump_rate: Rate::Depends,
            is_extensible: false,
            source: "the user",
        }
    }

    fn valid_counts(&self, _domain: Domain) -> ValidCounts {
        let counts = self.content.as_ref().map_or_else(Vec::new, |content| content.counts());
        ValidCounts::Listed(counts.into())
    }

    fn stream_group(&self, n_points: usize) -> Option<usize> {
        self.content.as_ref()?.stream_group(n_points)
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        let content = self.content.as_ref();
        let sets = content.and_then(|content| content.sets(n_points, domain, self.fold));
        let unread = || Error::Given { reason: "no file has been read".to_owned() };
        Ok(Box::new(sets.ok_or_else(unread)??))
    }

    fn resolve(&mut self, files: &dyn FileResolver) -> Result<(), Error> {
        if self.file().as_os_str().is_empty() {
            let reason = "the name of the file is empty; expected file:PATH".to_owned();
            return Err(ResolveError::new(reason).into());
        }
        self.content = Some(Arc::new(PointFiles::new(files.points(self)?)?));
        Ok(())
    }
}
