//! HTML form of a document.

use std::fmt::Write;

use super::{Cell, Document, Part, Section, Tone};

const STYLE: &str = include_str!("style.css");

/// Text escaped for use between tags or in a quoted attribute.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

impl Document {
    /// Complete HTML file.
    pub fn html(&self) -> String {
        let (tone, verdict) = &self.verdict;
        let tone = match tone {
            Tone::Good => "good",
            Tone::Bad => "bad",
            Tone::Open => "open",
        };
        let title = escape(&self.title);
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
             <p class=\"about\">{}</p>\n<p class=\"verdict {tone}\">{}</p>\n",
            escape(&self.about),
            escape(verdict)
        );
        self.sections.iter().for_each(|s| section(&mut out, s));
        let version = env!("CARGO_PKG_VERSION");
        let _ = write!(out, "<footer>ballrace {version}</footer>\n</body>\n</html>\n");
        out
    }
}

// Writing to a string cannot fail, here and below.
fn section(out: &mut String, section: &Section) {
    let _ = writeln!(out, "<section>\n<h2>{}</h2>", escape(&section.heading));
    for part in &section.parts {
        match part {
            Part::Paragraph(text) => {
                let _ = writeln!(out, "<p>{}</p>", escape(text));
            }
            Part::Table { caption, head, rows } => table(out, caption, head, rows),
            Part::Figure { svg, caption } => {
                let (svg, caption) = (inline(svg), escape(caption));
                let _ = writeln!(
                    out,
                    "<figure>\n<div class=\"scroll\">\n{svg}\n</div>\n<figcaption>{caption}</figcaption>\n</figure>"
                );
            }
            Part::Equations(lines) => {
                let lines: Vec<String> = lines.iter().map(|line| escape(line)).collect();
                let _ = writeln!(out, "<div class=\"equations\">{}</div>", lines.join("\n"));
            }
            Part::Link { path, text } => {
                let _ = writeln!(out, "<p><a href=\"{}\">{}</a></p>", escape(path), escape(text));
            }
        }
    }
    out.push_str("</section>\n");
}

fn table(out: &mut String, caption: &str, head: &[String], rows: &[Vec<Cell>]) {
    out.push_str("<div class=\"scroll\">\n<table>\n");
    if !caption.is_empty() {
        let _ = writeln!(out, "<caption>{}</caption>", escape(caption));
    }
    if !head.is_empty() {
        out.push_str("<thead><tr>");
        for (column, name) in head.iter().enumerate() {
            // A column's name is aligned as its numbers are.
            let class = match rows.first().and_then(|row| row.get(column)) {
                Some(Cell::Number(_)) => " class=\"number\"",
                _ => "",
            };
            let _ = write!(out, "<th{class}>{}</th>", escape(name));
        }
        out.push_str("</tr></thead>\n");
    }
    out.push_str("<tbody>\n");
    for row in rows {
        out.push_str("<tr>");
        for cell in row {
            let _ = match cell {
                Cell::Text(text) => write!(out, "<td>{}</td>", escape(text)),
                Cell::Number(text) => write!(out, "<td class=\"number\">{}</td>", escape(text)),
            };
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table>\n</div>\n");
}

/// SVG without its namespace: HTML needs none, and its address would look like an external resource.
fn inline(svg: &str) -> String {
    svg.trim().replacen(" xmlns=\"http://www.w3.org/2000/svg\"", " role=\"img\"", 1)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Tags that have no end.
    const VOID: [&str; 4] = ["!DOCTYPE", "meta", "br", "hr"];

    /// Asserts that tags close in order, that nothing external is loaded and that no number is NaN.
    pub(crate) fn assert_well_formed(html: &str) {
        let mut open: Vec<&str> = Vec::new();
        for piece in html.split('<').skip(1) {
            let (tag, _) = piece.split_once('>').expect("a tag that ends");
            let name = tag.split([' ', '\n', '/']).find(|part| !part.is_empty()).expect("a tag with a name");
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed), "near {piece:.60}");
            } else if !tag.ends_with('/') && !VOID.contains(&name) {
                open.push(name);
            }
        }
        assert!(open.is_empty(), "{open:?}");
        for bad in ["NaN", "http:", "https:", "url(", "@import", "<script", "<link", ">inf", "src="] {
            assert!(!html.contains(bad), "{bad}");
        }
    }

    #[test]
    fn everything_but_pictures_is_escaped() {
        let evil = "<script>alert(\"x\")</script> & 'y'";
        let escaped = "&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt; &amp; &#39;y&#39;";
        assert_eq!(escape(evil), escaped);
        let section = Section::new(evil)
            .paragraph(evil)
            .table(evil, &[evil, evil], vec![vec![Cell::text(evil), Cell::number(evil)]])
            .figure("<svg xmlns=\"http://www.w3.org/2000/svg\"><g></g></svg>", evil)
            .equations(vec![evil.to_owned(), evil.to_owned()]);
        let html = Document::new(evil, evil, Tone::Bad, evil).section(section).html();
        assert_well_formed(&html);
        // Twice the title, about, verdict, heading, paragraph, caption, two names, two cells, figure's caption, two lines.
        assert_eq!(html.matches(escaped).count(), 14);
        assert!(html.contains("<svg role=\"img\"><g></g></svg>"));
    }

    #[test]
    #[should_panic(expected = "near")]
    fn the_check_sees_tags_in_the_wrong_order() {
        assert_well_formed("<p><b></p></b>");
    }
}
