use crate::{Claim, Content, FigureId};

/// A figure: its panels and the claims of the thesis that it checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The identifier.
    pub id: FigureId,
    /// The panels, in the order of rows and columns of the thesis.
    pub panels: Vec<Panel>,
    /// The claims of the thesis in or about the figure.
    pub claims: Vec<Claim>,
    /// Notes for the reader: numbers of points and realizations, and choices that the thesis does
    /// not state.
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
    /// The content.
    pub content: Content,
}
