//! Errors and warnings in the two forms that `--message-format` names.

use crate::error::Error;
use crate::flags::MessageFormat;
use serde_json::json;
use std::ffi::OsString;
use std::io::Write as _;
use std::path::Path;

/// A line on standard error. Where that is closed nobody can be told.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// The line for an error.
pub(crate) fn error_line(format: MessageFormat, error: &Error) -> String {
    match format {
        MessageFormat::Human => format!("error[{}]: {error}", error.code()),
        MessageFormat::Json => json!({
            "level": "error", "code": error.code(), "exit": error.exit_code(), "message": error.to_string(),
        })
        .to_string(),
    }
}

/// The line for a warning about a tree.
pub(crate) fn warning_line(format: MessageFormat, tree: &Path, code: &str, name: &str, text: &str) -> String {
    match format {
        MessageFormat::Human => format!("warning[{code}]: {}: {text}", tree.display()),
        MessageFormat::Json => json!({
            "level": "warning", "code": code, "name": name, "message": text, "count": 1,
            "path": tree.to_string_lossy(),
        })
        .to_string(),
    }
}

/// The line for wrong usage, out of the text that the flags' library has for people.
pub(crate) fn said_as_json(text: &str) -> String {
    let first = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
    let message = first.split_whitespace().collect::<Vec<_>>().join(" ");
    json!({ "level": "error", "code": "FC100", "exit": 2, "message": message }).to_string()
}

/// Whether a command line that cannot be read as a whole asks for messages as JSON.
pub(crate) fn is_json_asked_for(words: impl Iterator<Item = OsString>) -> bool {
    let words: Vec<OsString> = words.collect();
    words.windows(2).any(|pair| pair == ["--message-format", "json"])
        || words.iter().any(|word| word == "--message-format=json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_is_found_in_a_line_that_makes_no_sense() {
        let asks = |line: &str| is_json_asked_for(line.split(' ').map(OsString::from));
        assert!(asks("fct --message-format json look") && asks("fct look --message-format=json"));
        assert!(!asks("fct look json") && !asks("fct --message-format human json"));
    }

    #[test]
    fn wrong_usage_is_one_line() {
        let line = said_as_json("error: unexpected argument '--x'\n  found\n\nUsage: fct\n");
        let object: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!(object["message"], "unexpected argument '--x' found");
        assert_eq!((&object["code"], &object["exit"]), (&json!("FC100"), &json!(2)));
    }
}
