//! Reports: one HTML file that needs nothing else, to be read on a screen or printed.
//!
//! | module | holds |
//! |---|---|
//! | [`html`] | escaping, and a document as text |
//! | [`model`] | sections on a fit: scores, equations, sizes |
//! | [`signal`] | sections on recordings: spectra, prediction and residual |
//! | [`held_out`] | pictures of a recording before and after |
//! | [`number`] | numbers as people read them |
//! | [`fit`], [`monitor`], [`calibrate`], [`calibrate_sdof`], [`diagnosis`], [`spectra`] | what those commands report |
//!
//! All text is escaped; pictures are the SVG of [`plot`](crate::report::plot). A report states no time of day
//! and no duration, so that the same input gives the same bytes.

pub mod calibrate;
pub mod calibrate_sdof;
pub mod diagnosis;
pub mod fit;
pub mod held_out;
pub mod html;
pub mod model;
pub mod monitor;
pub mod plot;
pub mod signal;
pub mod spectra;

/// What a verdict is to the reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Nothing to worry about.
    Good,
    /// Something to act on.
    Bad,
    /// Neither.
    Open,
}

/// A cell of a table, and whether it stands to the right as numbers do.
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

/// A part of a section.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// A paragraph.
    Paragraph(String),
    /// A table: names of its columns, and rows of as many cells.
    Table {
        /// What it shows; empty for none.
        caption: String,
        /// Names of the columns.
        head: Vec<String>,
        /// Rows.
        rows: Vec<Vec<Cell>>,
    },
    /// A picture.
    Figure {
        /// As SVG, trusted: it comes from `plot`.
        svg: String,
        /// What it shows.
        caption: String,
    },
    /// Lines of mathematics.
    Equations(Vec<String>),
    /// A way to a file beside this one.
    Link {
        /// Its path from the report's folder.
        path: String,
        /// What is there.
        text: String,
    },
}

/// A heading and what is under it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    heading: String,
    parts: Vec<Part>,
}

impl Section {
    /// A section with nothing in it.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), parts: Vec::new() }
    }

    /// With a paragraph more.
    #[must_use]
    pub fn paragraph(mut self, text: impl Into<String>) -> Self {
        self.parts.push(Part::Paragraph(text.into()));
        self
    }

    /// With a table more.
    #[must_use]
    pub fn table(mut self, caption: impl Into<String>, head: &[&str], rows: Vec<Vec<Cell>>) -> Self {
        let head = head.iter().map(|h| (*h).to_owned()).collect();
        self.parts.push(Part::Table { caption: caption.into(), head, rows });
        self
    }

    /// With a picture more.
    #[must_use]
    pub fn figure(mut self, svg: impl Into<String>, caption: impl Into<String>) -> Self {
        self.parts.push(Part::Figure { svg: svg.into(), caption: caption.into() });
        self
    }

    /// With a way to a file more, its path as seen from the report's folder.
    #[must_use]
    pub fn link(mut self, path: impl Into<String>, text: impl Into<String>) -> Self {
        self.parts.push(Part::Link { path: path.into(), text: text.into() });
        self
    }

    /// With lines of mathematics more.
    #[must_use]
    pub fn equations(mut self, lines: Vec<String>) -> Self {
        self.parts.push(Part::Equations(lines));
        self
    }
}

/// A report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Document {
    title: String,
    about: String,
    verdict: (Tone, String),
    sections: Vec<Section>,
}

impl Document {
    /// A report with its verdict, which stands on top, and a line on what it is about.
    pub fn new(title: impl Into<String>, about: impl Into<String>, tone: Tone, verdict: impl Into<String>) -> Self {
        Self { title: title.into(), about: about.into(), verdict: (tone, verdict.into()), sections: Vec::new() }
    }

    /// With a section more.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// With sections more.
    #[must_use]
    pub fn sections(mut self, sections: impl IntoIterator<Item = Section>) -> Self {
        self.sections.extend(sections);
        self
    }
}
