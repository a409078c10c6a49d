//! Numbers in text files: what counts as one, and how a wrong one is shown.

/// Longest text that is taken for a number; anything longer is garbage.
pub(super) const LONGEST: usize = 400;

/// Reads a floating-point number, also `nan`, `inf` and what older Windows programs print for them.
pub(super) fn float64(text: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(text).ok()?;
    text.parse().ok().or_else(|| windows_nan(text).map(f64::from))
}

/// Reads a coordinate of a format whose numbers are meant as `f32`: what `f32` cannot hold is infinite.
pub(super) fn coordinate(text: &[u8]) -> Option<f64> {
    let x = float64(text)?;
    Some(if x.abs() > f64::from(f32::MAX) { x.signum() * f64::INFINITY } else { x })
}

/// As [`float64`], rounded once to single precision.
pub(super) fn float32(text: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(text).ok()?;
    text.parse().ok().or_else(|| windows_nan(text))
}

/// Reads a whole number.
pub(super) fn integer(text: &[u8]) -> Option<i64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// The nearest `f32`; overflow gives infinity.
#[allow(clippy::cast_possible_truncation, reason = "rounding to single precision is the purpose")]
pub(super) fn narrow(x: f64) -> f32 {
    x as f32
}

fn windows_nan(text: &str) -> Option<f32> {
    let (sign, digits) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let name = digits.strip_prefix("1.#")?;
    if name.starts_with("INF") {
        Some(sign * f32::INFINITY)
    } else {
        ["QNAN", "SNAN", "IND"].iter().any(|n| name.starts_with(n)).then_some(f32::NAN)
    }
}

/// Shows a piece of a file in a message: quoted, control characters escaped, at most 40 characters.
pub(super) fn shown(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text.get(..text.len().min(160)).unwrap_or_default());
    let mut out: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() {
        out.push('…');
    }
    format!("\"{out}\"")
}

/// What to advise about text that is no number.
pub(super) fn advice(text: &[u8]) -> &'static str {
    if text.contains(&b',') {
        "write numbers with a decimal point, not a comma"
    } else {
        "correct the file or export it again"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accepts_what_programs_write() {
        for (text, value) in [
            ("1", 1.0),
            ("-.5", -0.5),
            ("+2.e1", 20.0),
            ("1E-3", 1e-3),
            ("inf", f64::INFINITY),
            ("-1.#INF", f64::NEG_INFINITY),
        ] {
            assert_eq!(float64(text.as_bytes()), Some(value), "{text}");
        }
        assert!(float64(b"-1.#IND000").unwrap().is_nan() && float32(b"nan").unwrap().is_nan());
        for text in ["", "1,5", "x", "1.2.3", "0x10", "\u{661}"] {
            assert_eq!(float64(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn shows_hostile_text_on_one_short_line() {
        let text = shown(&[b'\n'; 500]);
        assert!(text.len() < 100 && !text.contains('\n'));
        assert_eq!(shown(b"a\xff"), "\"a\u{fffd}\"");
    }
}
