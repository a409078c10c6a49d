//! Rows that are kept: `docs/benchmarks/<machine>/<date>.csv`.

use std::error::Error;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

/// The columns of every file.
const HEADING: &str = "what,input,setting,value,unit,how";

/// One figure.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    /// What was measured.
    pub(crate) what: String,
    /// The mesh, with its faces.
    pub(crate) input: String,
    /// What was set, and for which size.
    pub(crate) setting: String,
    /// The figure.
    pub(crate) value: String,
    /// Its unit.
    pub(crate) unit: &'static str,
    /// The command and what else is needed to repeat it.
    pub(crate) how: String,
}

/// Appends rows to today's file of a machine and names it.
///
/// # Errors
/// When the machine's name is no folder's, or the file cannot be written.
pub(crate) fn append(machine: &str, entries: &[Entry]) -> Result<PathBuf, Box<dyn Error>> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if machine.is_empty() || !machine.chars().all(plain) {
        return Err(
            format!("--append {machine}: a machine's name is made of letters, digits, - and _").into()
        );
    }
    let folder = super::workspace().join("docs/benchmarks").join(machine);
    std::fs::create_dir_all(&folder)?;
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs();
    let path = folder.join(format!("{}.csv", date(seconds / 86_400)));
    let mut file = OpenOptions::new().create(true).append(true).open(&path)?;
    let mut text = String::new();
    if file.metadata()?.len() == 0 {
        text += HEADING;
        text.push('\n');
    }
    for e in entries {
        let cells = [&e.what, &e.input, &e.setting, &e.value, e.unit, &e.how].map(cell);
        text += &cells.join(",");
        text.push('\n');
    }
    file.write_all(text.as_bytes())?;
    Ok(path)
}

/// A cell, quoted if it has to be.
fn cell(text: impl AsRef<str>) -> String {
    let text = text.as_ref();
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// The date (year-month-day, universal time) of a day counted from the first of January 1970.
fn date(day: u64) -> String {
    // Years that begin in March end with the leap day; 400 of them have 146,097 days.
    let day = day + 719_468;
    let (era, in_era) = (day / 146_097, day % 146_097);
    let year = (in_era - in_era / 1_460 + in_era / 36_524 - in_era / 146_096) / 365;
    let in_year = in_era - (365 * year + year / 4 - year / 100);
    let month = (5 * in_year + 2) / 153;
    let in_month = in_year - (153 * month + 2) / 5 + 1;
    let (shown, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{shown:02}-{in_month:02}", era * 400 + year + next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_become_dates() {
        let known =
            [(0, "1970-01-01"), (11_016, "2000-02-29"), (11_017, "2000-03-01"), (20_454, "2026-01-01")];
        for (day, expected) in known {
            assert_eq!(date(day), expected);
        }
        // A year's days are all different and in order.
        let days: Vec<String> = (20_454..20_454 + 365).map(date).collect();
        assert!(days.is_sorted() && days[364] == "2026-12-31");
    }

    #[test]
    fn cells_with_commas_and_quotes_are_quoted() {
        assert_eq!([cell("a b"), cell("a, b"), cell("a \"b\"")], ["a b", "\"a, b\"", "\"a \"\"b\"\"\""]);
    }

    #[test]
    fn a_machine_cannot_be_a_path() {
        for name in ["", "..", "a/b", "a b"] {
            assert!(append(name, &[]).is_err(), "{name}");
        }
    }
}
