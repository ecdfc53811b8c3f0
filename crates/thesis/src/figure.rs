use crate::{Claim, Content, FigureId};

/// A figure: what is shown and what of the thesis's numbers it decides.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Which one.
    pub id: FigureId,
    /// What is shown, in the thesis's order of rows and columns.
    pub panels: Vec<Panel>,
    /// The numbers that the thesis states with the figure or about it.
    pub claims: Vec<Claim>,
    /// What a reader should know: numbers of points and realizations, where the thesis leaves something open.
    pub notes: Vec<String>,
}

impl Figure {
    /// Adds a panel. `name` becomes part of file names: lower-case letters, digits and hyphens.
    pub(crate) fn panel(
        &mut self,
        name: &str,
        title: impl Into<String>,
        content: impl Into<Content>,
    ) {
        self.panels.push(Panel {
            name: name.to_owned(),
            title: title.into(),
            content: content.into(),
        });
    }

    /// Adds a remark.
    pub(crate) fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }
}

/// One part of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The name within the figure, for file names: `white-noise-sphere`.
    pub name: String,
    /// The heading.
    pub title: String,
    /// What is in it.
    pub content: Content,
}
