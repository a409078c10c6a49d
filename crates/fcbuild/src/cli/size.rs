//! Numbers of bytes and of things, read and written as people do.

use std::fmt;

/// A number of bytes that is spoken of in the unit in which it was typed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Size {
    /// Above 0.
    pub(crate) bytes: u64,
    /// What was typed, its unit, and the bytes of that; `None` for a size that nobody typed.
    typed: Option<(String, String, f64)>,
}

impl Size {
    /// A size that nobody typed.
    pub(crate) fn of_bytes(bytes: u64) -> Size {
        Size { bytes, typed: None }
    }

    /// Writes `n` bytes in this size's unit, rounded up, so that more than this size also reads as more.
    pub(crate) fn same_unit(&self, n: u64) -> String {
        match &self.typed {
            Some((_, unit, factor)) if *factor > 1.0 => {
                let value = n as f64 / factor;
                if value < 10.0 {
                    format!("{:.1}{unit}", (value * 10.0).ceil() / 10.0)
                } else {
                    format!("{}{unit}", grouped(value.ceil() as u64))
                }
            }
            Some(_) => format!("{} bytes", grouped(n)),
            None => bytes(n),
        }
    }
}

/// As it was typed, or with a decimal unit.
impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.typed {
            Some((text, _, factor)) if *factor > 1.0 => f.write_str(text),
            _ => f.write_str(&self.same_unit(self.bytes)),
        }
    }
}

/// Reads `800M`, `1.5GiB`, `2GB` or plain bytes. K, M, G and T alone are binary, with B decimal.
pub(crate) fn parse(text: &str) -> Result<Size, String> {
    let refused = || "expected a size above 0 such as 800M, 6GiB or 1.5GB".to_owned();
    let text = text.trim();
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let factor: f64 = match unit.trim().to_ascii_uppercase().as_str() {
        "" | "B" => 1.0,
        "K" | "KIB" => 1024.0,
        "M" | "MIB" => 1_048_576.0,
        "G" | "GIB" => 1_073_741_824.0,
        "T" | "TIB" => 1_099_511_627_776.0,
        "KB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "TB" => 1e12,
        _ => return Err(refused()),
    };
    match number.parse::<f64>() {
        // The cast saturates, and a limit above 2^64 bytes is no limit.
        Ok(n) if n * factor >= 1.0 => {
            Ok(Size { bytes: (n * factor) as u64, typed: Some((text.to_owned(), unit.to_owned(), factor)) })
        }
        _ => Err(refused()),
    }
}

/// Writes bytes with a decimal unit, such as `512 MB`.
pub(crate) fn bytes(n: u64) -> String {
    const UNITS: [(u64, &str); 4] =
        [(1_000_000_000_000, "TB"), (1_000_000_000, "GB"), (1_000_000, "MB"), (1_000, "kB")];
    match UNITS.into_iter().find(|(size, _)| n >= *size) {
        Some((size, unit)) => {
            let value = n as f64 / size as f64;
            if value < 10.0 { format!("{value:.1} {unit}") } else { format!("{value:.0} {unit}") }
        }
        None => format!("{n} bytes"),
    }
}

/// Writes a number with its digits in groups of three, such as `871,414`.
pub(crate) fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 face`, `2 faces`, `5,000 faces`.
pub(crate) fn counted(n: u64, thing: &str) -> String {
    format!("{} {thing}{}", grouped(n), if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, expected) in [
            ("17", 17),
            ("2K", 2048),
            ("2kB", 2000),
            ("1.5GiB", 3 << 29),
            ("3 MB", 3_000_000),
            ("1T", 1 << 40),
        ] {
            assert_eq!(parse(text).map(|size| size.bytes), Ok(expected), "{text}");
        }
        for text in ["", "0", "-1", "G", "1 X", "1e3", "..", "0.1"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_size_is_spoken_of_as_it_was_typed() {
        for (text, said, other) in [
            ("300M", "300M", "477M"),
            ("0.5 GiB", "0.5 GiB", "0.5 GiB"),
            ("2048", "2,048 bytes", "500,000,000 bytes"),
        ] {
            let size = parse(text).unwrap();
            assert_eq!((size.to_string(), size.same_unit(500_000_000)), (said.to_owned(), other.to_owned()));
        }
        let size = Size::of_bytes(512_300_000);
        assert_eq!((size.to_string(), size.same_unit(1_500)), ("512 MB".to_owned(), "1.5 kB".to_owned()));
    }

    #[test]
    fn sizes_and_counts_are_written() {
        assert_eq!(bytes(999), "999 bytes");
        assert_eq!(bytes(1_500), "1.5 kB");
        assert_eq!(bytes(512_300_000), "512 MB");
        assert_eq!(
            [0, 12, 999, 1000, 871_414, 1_000_000].map(grouped),
            ["0", "12", "999", "1,000", "871,414", "1,000,000"]
        );
        assert_eq!((counted(1, "face"), counted(2000, "edge")), ("1 face".into(), "2,000 edges".into()));
    }
}
