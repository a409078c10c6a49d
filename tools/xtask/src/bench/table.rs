//! Tables of text, aligned.

use std::io::{self, Write};

/// Rows of cells under a heading; the first column is flush left, the others flush right.
#[derive(Debug)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with a heading.
    pub(crate) fn new(heading: &[&str]) -> Table {
        Table { rows: vec![heading.iter().map(|s| (*s).to_owned()).collect()] }
    }

    /// Adds a row; missing cells are empty.
    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Writes all rows; nothing when there is only the heading.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn print(&self, out: &mut impl Write) -> io::Result<()> {
        if self.rows.len() < 2 {
            return Ok(());
        }
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |k: usize| self.rows.iter().filter_map(|r| r.get(k)).map(|c| c.chars().count()).max();
        let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0)).collect();
        for row in &self.rows {
            let mut line = String::new();
            for (k, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let pad = " ".repeat(width - cell.chars().count());
                // The last column is a remark.
                let flush_left = k == 0 || k + 1 == columns;
                line += if k == 0 { "" } else { "  " };
                line += &if flush_left { format!("{cell}{pad}") } else { format!("{pad}{cell}") };
            }
            writeln!(out, "{}", line.trim_end())?;
        }
        writeln!(out)
    }
}

/// A number with three digits that say something: 0.0123, 1.23, 12.3, 123, 1230.
pub(crate) fn three(x: f64) -> String {
    let size = x.abs();
    if !x.is_finite() {
        return "inf".to_owned();
    }
    let decimals = match size {
        _ if size >= 99.95 || size == 0.0 => 0,
        _ if size >= 9.995 => 1,
        _ if size >= 0.9995 => 2,
        _ if size >= 0.09995 => 3,
        _ => 4,
    };
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_numbers_short() {
        let mut table = Table::new(&["mesh", "rms", "remark"]);
        table.row(vec!["bunny".into(), three(5.4123), "high".into()]);
        table.row(vec!["dragon".into(), three(1234.5), String::new()]);
        let mut out = Vec::new();
        table.print(&mut out).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "mesh     rms  remark\nbunny   5.41  high\ndragon  1234\n\n"
        );
        assert_eq!(
            [0.0, 0.01234, 0.5, 99.96, f64::INFINITY].map(three),
            ["0", "0.0123", "0.500", "100", "inf"]
        );
    }
}
