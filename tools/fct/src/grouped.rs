//! Numbers as people read them.

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

/// `1 vertex`, `2,000 vertices`: the number with the word that fits it.
pub(crate) fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(n), if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::{counted, grouped};

    #[test]
    fn one_thing_is_no_things() {
        let said = [0, 1, 2000].map(|n| counted(n, "vertex", "vertices"));
        assert_eq!(said, ["0 vertices", "1 vertex", "2,000 vertices"]);
    }

    #[test]
    fn digits_stand_in_threes() {
        assert_eq!(
            [0, 999, 1000, 871_414, 1_000_000].map(grouped),
            ["0", "999", "1,000", "871,414", "1,000,000"]
        );
    }
}
