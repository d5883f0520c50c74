//! A report as one self-contained HTML file: text, verdicts, tables and figures.

use crate::data::{DataFormat, Files};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;

/// The most rows of a table that is not folded.
const FOLDED: usize = 20;

/// A report.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// The title of the page.
    pub title: String,
    /// One line below the title, which says what was run, when and on what machine.
    pub subtitle: String,
    /// The sections, listed at the top of the page.
    pub sections: Vec<Section>,
}

/// A section of a [`Report`].
#[derive(Debug, Clone)]
pub struct Section {
    /// The heading, also listed in the table of contents.
    pub heading: String,
    /// The contents below the heading.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Debug, Clone)]
pub enum Block {
    /// A paragraph of plain text.
    Text(String),
    /// A statement and whether it holds.
    Verdict(Verdict, String),
    /// A table. One of more than 20 rows is folded behind a summary line.
    Table(Table),
    /// A figure over the full width.
    Figure(Figure),
    /// Two figures side by side, one below the other on a narrow screen.
    Pair(Figure, Figure),
    /// Blocks hidden behind a summary line until it is opened.
    Fold(String, Vec<Block>),
}

/// The result of checking a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The statement holds.
    Holds,
    /// The statement does not hold.
    Fails,
    /// A remark without a verdict.
    Note,
}

impl Verdict {
    /// The verdict in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Note => "note",
        }
    }
}

/// A table. Columns of numbers are aligned to the right.
#[derive(Debug, Clone)]
pub struct Table {
    /// The names of the columns.
    pub header: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
}

/// A figure: a chart, its caption and its files.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The chart as SVG text.
    pub svg: String,
    /// The caption.
    pub caption: String,
    /// The file of the chart, relative to the report.
    pub file: String,
    /// The file of the numbers in the chart as CSV, relative to the report.
    pub data: String,
}

impl Report {
    /// The report as one HTML file, with links to the files that are written.
    pub fn html(&self, files: Files) -> String {
        let mut figures = 0;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(include_str!("report.css"))) }
                }
                body {
                    header {
                        h1 { (self.title) }
                        p.subtitle { (self.subtitle) }
                    }
                    nav aria-label="Contents" {
                        ol {
                            @for (n, section) in self.sections.iter().enumerate() {
                                li { a href=(format!("#s{}", n + 1)) { (section.heading) } }
                            }
                        }
                    }
                    main {
                        @for (n, section) in self.sections.iter().enumerate() {
                            section id=(format!("s{}", n + 1)) {
                                h2 { (n + 1) ". " (section.heading) }
                                @for block in &section.blocks { (block.html(&mut figures, files)) }
                            }
                        }
                    }
                }
            }
        };
        page.into_string()
    }
}

/// Text in which words between backticks are code.
fn prose(text: &str) -> Markup {
    html! {
        @for (i, part) in text.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

impl Block {
    /// The place in a section: findings, charts, how they were made, tables.
    pub(crate) fn place(&self) -> u8 {
        match self {
            Block::Verdict(..) => 0,
            Block::Figure(_) | Block::Pair(..) => 1,
            Block::Text(_) => 2,
            Block::Table(_) | Block::Fold(..) => 3,
        }
    }

    /// The block as HTML; `figures` counts the figures so far.
    fn html(&self, figures: &mut usize, files: Files) -> Markup {
        match self {
            Block::Text(text) => html! { p { (prose(text)) } },
            Block::Verdict(verdict, text) => {
                let class = match verdict {
                    Verdict::Holds => "holds",
                    Verdict::Fails => "fails",
                    Verdict::Note => "note",
                };
                html! {
                    p class={ "verdict " (class) } {
                        span.badge { (verdict.describe()) } " " span { (prose(text)) }
                    }
                }
            }
            Block::Table(table) if table.rows.len() > FOLDED => html! {
                details {
                    summary { "Table of " (table.rows.len()) " rows" }
                    (table.html())
                }
            },
            Block::Table(table) => table.html(),
            Block::Figure(figure) => figure.html(figures, files),
            Block::Pair(left, right) => {
                html! { div.pair { (left.html(figures, files)) (right.html(figures, files)) } }
            }
            Block::Fold(summary, blocks) => html! {
                details {
                    summary { (summary) }
                    @for block in blocks {
                        @if let Block::Table(table) = block { (table.html()) }
                        @else { (block.html(figures, files)) }
                    }
                }
            },
        }
    }
}

impl Table {
    fn html(&self) -> Markup {
        let numeric: Vec<bool> = (0..self.header.len()).map(|n| self.is_numeric(n)).collect();
        let class = |n: usize| numeric.get(n).is_some_and(|numeric| *numeric).then_some("number");
        html! {
            div.scroll tabindex="0" {
                table {
                    thead {
                        tr {
                            @for (n, name) in self.header.iter().enumerate() {
                                th class=[class(n)] { (name) }
                            }
                        }
                    }
                    tbody {
                        @for row in &self.rows {
                            tr {
                                @for (n, cell) in row.iter().enumerate() {
                                    td class=[class(n)] { (cell) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// Whether a column holds numbers. Cells without a value are ignored.
    fn is_numeric(&self, column: usize) -> bool {
        let cells = || self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.trim());
        let none = |cell: &str| {
            matches!(cell, "" | "-" | "–" | "—" | "n/a" | "NaN" | "inf" | "-inf" | "∞")
        };
        cells().any(starts_with_number)
            && cells().all(|cell| none(cell) || starts_with_number(cell))
    }
}

/// Whether a text is a number. A sign or a relation may precede it, and a unit or an error may
/// follow.
fn starts_with_number(text: &str) -> bool {
    let text = text.trim_start_matches(['+', '-', '−', '<', '>', '≈', '≤', '≥', '~', ' ']);
    let tail = text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let tail = match tail.strip_prefix(['e', 'E']) {
        Some(exponent) => exponent
            .trim_start_matches(['+', '-', '−'])
            .trim_start_matches(|c: char| c.is_ascii_digit()),
        None => tail,
    };
    text.starts_with(|c: char| c.is_ascii_digit() || c == '.')
        && !tail.starts_with(char::is_alphabetic)
}

impl Figure {
    /// The file of the chart as a PNG picture.
    fn picture(&self) -> String {
        format!("{}.png", self.file.trim_end_matches(".svg"))
    }

    /// The file of the numbers in the format of the tables.
    fn table(&self, format: DataFormat) -> String {
        match self.data.strip_suffix(".csv") {
            Some(name) => format!("{name}.{}", format.extension()),
            None => self.data.clone(),
        }
    }

    fn html(&self, figures: &mut usize, files: Files) -> Markup {
        *figures += 1;
        let table = self.table(files.tables);
        html! {
            figure id=(format!("f{figures}")) {
                div.chart tabindex="0" { (PreEscaped(with_own_ids(&self.svg, *figures))) }
                figcaption {
                    b { "Figure " (figures) ". " } (self.caption) " "
                    span.files {
                        "Chart: " a href=(self.file) { (self.file) }
                        @if files.png { " (or " a href=(self.picture()) { "PNG" } ")" }
                        ", data: " a href=(table) { (table) }
                    }
                }
            }
        }
    }
}

/// The chart with a prefix before each of its ids and each reference to one, as all figures share
/// one page.
fn with_own_ids(svg: &str, figure: usize) -> String {
    let mut svg = svg.to_string();
    for mark in [" id=\"", "url(#", "href=\"#"] {
        svg = svg.replace(mark, &format!("{mark}f{figure}-"));
    }
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    const SVG: &str = r##"<svg xmlns="http://www.w3.org/2000/svg">
        <defs><clipPath id="c0"><rect /></clipPath></defs>
        <g clip-path="url(#c0)"><use href="#c0" /></g></svg>"##;

    fn figure() -> Figure {
        Figure {
            svg: SVG.into(),
            caption: "a & b".into(),
            file: "a.svg".into(),
            data: "a.csv".into(),
        }
    }

    fn report(blocks: Vec<Block>) -> String {
        let sections = vec![Section { heading: "One <1>".into(), blocks }];
        Report { title: "T".into(), subtitle: "S".into(), sections }.html(Files::default())
    }

    #[test]
    fn text_is_escaped() {
        let html = report(vec![
            Block::Text("x < y".into()),
            Block::Verdict(Verdict::Fails, "<b>".into()),
            Block::Fold("<s>".into(), vec![Block::Figure(figure())]),
        ]);
        for text in
            ["One &lt;1&gt;", "x &lt; y", "&lt;b&gt;", "&lt;s&gt;", "a &amp; b", "does not hold"]
        {
            assert!(html.contains(text), "{text}");
        }
    }

    #[test]
    fn nothing_is_fetched() {
        let html = report(vec![Block::Figure(figure())])
            .replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for sign in ["http", "//", "src=", "@import", "<link", "<script"] {
            assert!(!html.contains(sign), "{sign}");
        }
    }

    #[test]
    fn ids_are_unique_and_referred_to() {
        let html = report(vec![Block::Figure(figure()), Block::Pair(figure(), figure())]);
        let mut ids: Vec<_> =
            html.split(" id=\"").skip(1).map(|rest| rest.split('"').next()).collect();
        assert_eq!(ids.len(), 7);
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), 7);
        assert!(
            html.contains("id=\"f3-c0\"")
                && html.contains("url(#f3-c0)")
                && html.contains("href=\"#f3-c0\"")
        );
        assert!(!html.contains("(#c0)"));
    }

    #[test]
    fn long_tables_are_folded_once() {
        let table = |rows| {
            let rows = vec![vec!["cell".to_string()]; rows];
            Block::Table(Table { header: vec!["h".into()], rows })
        };
        let folds = |block| report(vec![block]).matches("<details>").count();
        assert_eq!([folds(table(20)), folds(table(21))], [0, 1]);
        assert_eq!(folds(Block::Fold("all".into(), vec![table(21)])), 1);
        assert!(report(vec![table(21)]).contains("Table of 21 rows"));
    }

    #[test]
    fn a_figure_links_its_files() {
        let html = report(vec![Block::Figure(figure())]);
        assert!(["a.svg", "a.png", "a.csv"].iter().all(|file| html.contains(file)));
    }

    #[test]
    fn columns_of_numbers_are_told_from_text() {
        let column = |cells: &[&str]| {
            let rows = cells.iter().map(|cell| vec![(*cell).to_string()]).collect();
            Table { header: vec!["h".into()], rows }.is_numeric(0)
        };
        assert!(column(&["1.5", "−3e-12", "< 4", "2.00 ± 0.01", "12 %", "—", "10⁻³"]));
        assert!(!column(&["1.5", "midpoint"]));
        assert!(!column(&["2nd", "4th"]));
        assert!(!column(&["—", ""]));
    }
}
