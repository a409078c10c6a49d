//! Numbers of things, written as people read them.

/// Writes a number with its digits in groups of three, such as `871,414`.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let groups: Vec<String> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(|group| group.iter().copied().map(char::from).collect())
        .collect();
    groups.join(",")
}

/// A number of things in words, such as `1 face` and `2,000 faces`; `thing` is the singular of a regular noun.
pub fn counted(n: u64, thing: &str) -> String {
    format!("{} {thing}{}", grouped(n), if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_stand_in_threes_and_one_is_no_plural() {
        assert_eq!(
            [0, 12, 999, 1000, 871_414, 1_000_000].map(grouped),
            ["0", "12", "999", "1,000", "871,414", "1,000,000"]
        );
        assert_eq!([0, 1, 2000].map(|n| counted(n, "face")), ["0 faces", "1 face", "2,000 faces"]);
    }
}
