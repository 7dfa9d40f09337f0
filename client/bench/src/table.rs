//! Tables of the page.

use crate::chart::escaped;

/// A column by its title, and how its cells stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    /// Words, from the left; not said again below while it and all before it stay.
    Group(&'static str),
    /// Words, from the left.
    Text(&'static str),
    /// Words that may take several lines.
    Long(&'static str),
    /// Numbers, from the right.
    Number(&'static str),
}

impl Column {
    fn title(self) -> &'static str {
        match self {
            Self::Group(title) | Self::Text(title) | Self::Long(title) | Self::Number(title) => {
                title
            }
        }
    }

    /// Attributes of a cell.
    fn class(self) -> &'static str {
        match self {
            Self::Group(_) | Self::Text(_) => " class=\"text\"",
            Self::Long(_) => " class=\"text long\"",
            Self::Number(_) => "",
        }
    }
}

/// Rows with a cell for every column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// No rows yet.
    pub(crate) fn new(columns: impl Into<Vec<Column>>) -> Self {
        Self {
            columns: columns.into(),
            rows: Vec::new(),
        }
    }

    /// With these rows below.
    pub(crate) fn with<R: Into<Vec<String>>>(mut self, rows: impl IntoIterator<Item = R>) -> Self {
        self.rows.extend(rows.into_iter().map(Into::into));
        self
    }

    /// Whether it has no rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Its rows, top first.
    #[cfg(test)]
    pub(crate) fn rows(&self) -> &[Vec<String>] {
        &self.rows
    }

    /// As HTML; nothing without rows.
    pub(crate) fn html(&self) -> String {
        if self.is_empty() {
            return String::new();
        }
        let title = |column: &Column| tagged("th", *column, column.title());
        let head: String = self.columns.iter().map(title).collect();
        let above = std::iter::once(None).chain(self.rows.iter().map(Some));
        let rows = self.rows.iter().zip(above);
        let body: String = rows.map(|(row, above)| self.line(row, above)).collect();
        format!("<div class=\"table\"><table>\n<tr>{head}</tr>\n{body}</table></div>\n")
    }

    fn line(&self, row: &[String], above: Option<&Vec<String>>) -> String {
        let above = above.into_iter().flatten();
        let same = row
            .iter()
            .zip(above)
            .take_while(|(cell, above)| cell == above);
        let said = same.count();
        let cells = self.columns.iter().zip(row).enumerate();
        let cells = cells.map(|(place, (column, cell))| {
            let again = place < said && matches!(column, Column::Group(_));
            tagged("td", *column, if again { "" } else { cell })
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    }
}

fn tagged(tag: &str, column: Column, text: &str) -> String {
    format!("<{tag}{}>{}</{tag}>", column.class(), escaped(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_named_once_and_cells_are_escaped() {
        let columns = [Column::Group("scene"), Column::Number("seconds")];
        let rows = [["cube", "1 s"], ["cube", "<2 s"], ["ball", "3 s"]];
        let table = Table::new(columns).with(rows.map(|row| row.map(str::to_owned)));
        let html = table.html();
        assert_eq!(html.matches("cube").count(), 1);
        assert!(html.contains("<tr><td class=\"text\"></td><td>&lt;2 s</td></tr>"));
        assert!(html.contains("<th class=\"text\">scene</th><th>seconds</th>"));
        assert_eq!(Table::new(columns).html(), "");
    }
}
