//! Errors and warnings in the two forms that `--message-format` names.

use crate::error::Error;
use fct::{MessageFormat, usage_sentence};
use serde_json::json;
use std::path::Path;

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
pub(crate) fn usage_line(text: &str) -> String {
    json!({ "level": "error", "code": "FC100", "exit": 2, "message": usage_sentence(text) }).to_string()
}
