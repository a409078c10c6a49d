//! Pieces of the page that explains the figures.

use std::fmt::Write as _;

/// A picture in a row of pictures.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Its file, beside the page.
    pub(crate) file: String,
    /// What it shows, for those who cannot see it.
    pub(crate) alt: String,
    /// What stands below it.
    pub(crate) caption: String,
}

/// Pictures side by side, so many in a row.
pub(crate) fn panels(list: &[Panel], across: usize) -> String {
    let mut out = String::new();
    for (i, row) in list.chunks(across.max(1)).enumerate() {
        let cells = |f: &dyn Fn(&Panel) -> String| {
            let mut line: Vec<String> = row.iter().map(f).collect();
            line.resize(across.min(list.len()).max(1), String::new());
            format!("| {} |\n", line.join(" | "))
        };
        out += &cells(&|p| format!("![{}]({})", p.alt, p.file));
        if i == 0 {
            out += &format!("|{}\n", ":-:|".repeat(across.min(list.len()).max(1)));
        }
        out += &cells(&|p| p.caption.clone());
    }
    out
}

/// A table; numbers stand right, what is in the first column left.
pub(crate) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut out = format!("| {} |\n|---|{}\n", head.join(" | "), "--:|".repeat(head.len().saturating_sub(1)));
    for row in rows {
        let _ = writeln!(out, "| {} |", row.join(" | "));
    }
    out
}

/// A whole number with commas between thousands.
pub(crate) fn whole(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

/// Three digits that count.
pub(crate) fn three(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let places = (2 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{x:.places$}")
}

/// Yes or no, as a claim stands.
pub(crate) fn verdict(holds: bool) -> &'static str {
    if holds { "**Reproduces.**" } else { "**Does not reproduce.**" }
}

/// `a`, `b` and `c`.
pub(crate) fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!([0, 999, 1000, 871_414].map(whole), ["0", "999", "1,000", "871,414"]);
        assert_eq!([53.4, 0.012_345, 1234.6, 9.999].map(three), ["53.4", "0.0123", "1235", "10.00"]);
    }

    #[test]
    fn rows_are_filled_up() {
        let panel = |n: &str| Panel { file: format!("{n}.png"), alt: n.to_owned(), caption: n.to_owned() };
        let text = panels(&["a", "b", "c"].map(panel), 2);
        assert!(text.lines().all(|l| l.matches('|').count() == 3), "{text}");
        assert_eq!(text.lines().count(), 5);
    }
}
