//! Things by their number.

use fct::grouped;

/// `1 vertex`, `2,000 vertices`: the number with the word that fits it.
pub(crate) fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(n), if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_thing_is_no_things() {
        let said = [0, 1, 2000].map(|n| counted(n, "vertex", "vertices"));
        assert_eq!(said, ["0 vertices", "1 vertex", "2,000 vertices"]);
    }
}
