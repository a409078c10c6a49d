//! Errors and warnings of the commands: the two forms that `--message-format` names, and where they go.

use std::ffi::OsString;
use std::io::Write as _;
use std::str::FromStr;

/// `--message-format`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MessageFormat {
    /// `human`: sentences.
    #[default]
    Human,
    /// `json`: an object a line.
    Json,
}

impl FromStr for MessageFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<MessageFormat, String> {
        match text {
            "human" => Ok(MessageFormat::Human),
            "json" => Ok(MessageFormat::Json),
            _ => Err("expected human or json".to_owned()),
        }
    }
}

impl MessageFormat {
    /// The form that a command line asks for which cannot be read as a whole.
    pub fn asked_for(words: impl Iterator<Item = OsString>) -> MessageFormat {
        let words: Vec<OsString> = words.collect();
        let in_two = words.windows(2).any(|pair| pair == ["--message-format", "json"]);
        if in_two || words.iter().any(|word| word == "--message-format=json") {
            MessageFormat::Json
        } else {
            MessageFormat::Human
        }
    }
}

/// The sentence about wrong usage, out of the text that the flags' library has for people.
pub fn usage_sentence(text: &str) -> String {
    let first = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
    first.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A line on standard error. Where that is closed nobody can be told.
pub fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_is_found_in_a_line_that_makes_no_sense() {
        let asked = |line: &str| MessageFormat::asked_for(line.split(' ').map(OsString::from));
        assert_eq!(asked("fct --message-format json look"), MessageFormat::Json);
        assert_eq!(asked("fct look --message-format=json"), MessageFormat::Json);
        assert_eq!(asked("fct look json"), MessageFormat::Human);
        assert_eq!(asked("fct --message-format human json"), MessageFormat::Human);
        assert!("xml".parse::<MessageFormat>().is_err());
    }

    #[test]
    fn wrong_usage_is_one_sentence() {
        let said = "error: unexpected argument '--x'\n  found\n\nUsage: fct\n";
        assert_eq!(usage_sentence(said), "unexpected argument '--x' found");
    }
}
