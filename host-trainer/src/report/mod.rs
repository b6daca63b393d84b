//! Reports: one self-contained HTML file each, to be read on a screen or printed.
//!
//! | module | holds |
//! |---|---|
//! | `html` | escaping, and a document as text |
//! | `model` | sections on a fit: scores, equations, sizes |
//! | `signal` | sections on recordings: spectra, prediction and residual |
//! | `held_out` | pictures of a recording before and after |
//! | `machine` | envelope spectra of a machine of unknown structure |
//! | `plot` | pictures as SVG |
//! | `settings` | segment lengths, limits of lists, layout |
//! | `fit`, `fleet`, `monitor`, `phases`, `features`, `paper`, `calibrate`, `calibrate_sdof`, [`diagnosis`], `spectra` | documents of these commands |
//!
//! All text is escaped. A report states no time of day and no duration, so that the same input gives the same bytes.

pub mod calibrate;
pub mod calibrate_sdof;
pub mod diagnosis;
pub(crate) mod features;
pub mod fit;
#[cfg(feature = "fleet")]
pub(crate) mod fleet;
pub(crate) mod held_out;
pub(crate) mod html;
pub(crate) mod machine;
pub(crate) mod model;
pub mod monitor;
pub(crate) mod paper;
pub mod phases;
pub(crate) mod plot;
pub(crate) mod settings;
pub(crate) mod signal;
pub mod spectra;

/// Tone of a verdict: the colour of its box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Nothing to worry about.
    Good,
    /// Something to act on.
    Bad,
    /// Undecided.
    Open,
}

/// Cell of a table; numbers are aligned to the right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, formatted.
    Number(String),
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A number, formatted.
    pub fn number(number: impl ToString) -> Self {
        Self::Number(number.to_string())
    }
}

/// Part of a section.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// A paragraph.
    Paragraph(String),
    /// A table: names of its columns, and rows of as many cells.
    Table {
        /// Caption; empty for none.
        caption: String,
        /// Names of the columns.
        head: Vec<String>,
        /// Rows.
        rows: Vec<Vec<Cell>>,
    },
    /// A picture.
    Figure {
        /// SVG, not escaped: it comes from `plot`.
        svg: String,
        /// Caption.
        caption: String,
    },
    /// Lines of mathematics.
    Equations(Vec<String>),
    /// Link to a file next to the report.
    Link {
        /// Path from the report's folder.
        path: String,
        /// Text of the link.
        text: String,
    },
}

/// Heading with its parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    heading: String,
    parts: Vec<Part>,
}

impl Section {
    /// Empty section.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), parts: Vec::new() }
    }

    /// Section with one more paragraph; an empty one is left out.
    #[must_use]
    pub fn paragraph(mut self, text: impl Into<String>) -> Self {
        let text = text.into();
        if !text.is_empty() {
            self.parts.push(Part::Paragraph(text));
        }
        self
    }

    /// Section with one more table.
    #[must_use]
    pub fn table(mut self, caption: impl Into<String>, head: &[&str], rows: Vec<Vec<Cell>>) -> Self {
        let head = head.iter().map(|h| (*h).to_owned()).collect();
        self.parts.push(Part::Table { caption: caption.into(), head, rows });
        self
    }

    /// Section with one more picture.
    #[must_use]
    pub fn figure(mut self, svg: impl Into<String>, caption: impl Into<String>) -> Self {
        self.parts.push(Part::Figure { svg: svg.into(), caption: caption.into() });
        self
    }

    /// Section with a link to a file, its path relative to the report's folder.
    #[must_use]
    pub fn link(mut self, path: impl Into<String>, text: impl Into<String>) -> Self {
        self.parts.push(Part::Link { path: path.into(), text: text.into() });
        self
    }

    /// Section with lines of mathematics.
    #[must_use]
    pub fn equations(mut self, lines: Vec<String>) -> Self {
        self.parts.push(Part::Equations(lines));
        self
    }
}

/// Report: title, subject, verdict and sections.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Document {
    title: String,
    about: String,
    verdict: (Tone, String),
    sections: Vec<Section>,
}

impl Document {
    /// Report without sections: title, a line on its subject, and the verdict at the top.
    pub fn new(title: impl Into<String>, about: impl Into<String>, tone: Tone, verdict: impl Into<String>) -> Self {
        Self { title: title.into(), about: about.into(), verdict: (tone, verdict.into()), sections: Vec::new() }
    }

    /// Report with one more section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Report with more sections.
    #[must_use]
    pub fn sections(mut self, sections: impl IntoIterator<Item = Section>) -> Self {
        self.sections.extend(sections);
        self
    }
}
