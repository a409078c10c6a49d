//! Sizes in bytes, read and written as people do.

use crate::grouped;
use std::fmt;
use std::str::FromStr;

/// A number of bytes above 0 that is spoken of in the unit in which it was typed.
///
/// It reads `800M`, `1.5GiB`, `2GB` or plain bytes: K, M, G and T alone are binary, with B decimal.
#[derive(Clone, Debug, PartialEq)]
pub struct Size {
    bytes: u64,
    /// What was typed, its unit, and the bytes of that; `None` for a size that nobody typed.
    typed: Option<(String, String, f64)>,
}

impl Size {
    /// A size that nobody typed: it is written with a decimal unit, such as `512 MB`.
    pub fn of_bytes(bytes: u64) -> Size {
        Size { bytes, typed: None }
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Writes `n` bytes in this size's unit, rounded up, so that more than this size also reads as more.
    pub fn same_unit(&self, n: u64) -> String {
        match &self.typed {
            Some((_, unit, factor)) if *factor > 1.0 => {
                let value = n as f64 / factor;
                if value < 10.0 {
                    format!("{:.1}{unit}", (value * 10.0).ceil() / 10.0)
                } else {
                    format!("{}{unit}", grouped(saturated(value.ceil())))
                }
            }
            Some(_) => format!("{} bytes", grouped(n)),
            None => with_decimal_unit(n),
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

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
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
            // A limit above 2^64 bytes is no limit.
            Ok(n) if n * factor >= 1.0 => Ok(Size {
                bytes: saturated(n * factor),
                typed: Some((text.to_owned(), unit.to_owned(), factor)),
            }),
            _ => Err(refused()),
        }
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, as is wanted"
)]
fn saturated(value: f64) -> u64 {
    value as u64
}

fn with_decimal_unit(n: u64) -> String {
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
            ("99999999T", u64::MAX),
        ] {
            assert_eq!(text.parse().map(|size: Size| size.bytes()), Ok(expected), "{text}");
        }
        for text in ["", "0", "-1", "G", "1 X", "1e3", "..", "0.1"] {
            assert!(text.parse::<Size>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_size_is_spoken_of_as_it_was_typed() {
        for (text, said, other) in [
            ("300M", "300M", "477M"),
            ("0.5 GiB", "0.5 GiB", "0.5 GiB"),
            ("2048", "2,048 bytes", "500,000,000 bytes"),
        ] {
            let size: Size = text.parse().unwrap();
            assert_eq!((size.to_string(), size.same_unit(500_000_000)), (said.to_owned(), other.to_owned()));
        }
        for (bytes, said) in [(999, "999 bytes"), (1_500, "1.5 kB"), (512_300_000, "512 MB")] {
            let size = Size::of_bytes(bytes);
            assert_eq!((size.to_string(), size.same_unit(1_500)), (said.to_owned(), "1.5 kB".to_owned()));
        }
    }
}
