//! Names of groups: one each.

use std::collections::{HashMap, HashSet};

/// Gives each name but the first of several equal ones a number: `part`, `part_2`, `part_3`, in their order.
///
/// Files of one name in different folders, one file given twice and instances of a scene have equal names. A number is
/// passed over where another group has that name already.
pub(super) fn tell_apart(names: &mut [String]) {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    // Of a name that was met, the number that its next group may have.
    let mut next: HashMap<String, u64> = HashMap::new();
    for name in names {
        let Some(number) = next.get_mut(name.as_str()) else {
            next.insert(name.clone(), 2);
            continue;
        };
        let numbered = loop {
            let candidate = format!("{name}_{number}");
            *number += 1;
            if taken.insert(candidate.clone()) {
                break candidate;
            }
        };
        *name = numbered;
    }
}

#[cfg(test)]
mod tests {
    use super::tell_apart;

    fn told_apart(names: &[&str]) -> Vec<String> {
        let mut names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        tell_apart(&mut names);
        names
    }

    #[test]
    fn equal_names_are_numbered_in_their_order() {
        assert_eq!(told_apart(&["part", "wing", "part", "part"]), ["part", "wing", "part_2", "part_3"]);
        assert_eq!(told_apart(&["", ""]), ["", "_2"]);
        assert_eq!(told_apart(&["a", "b"]), ["a", "b"]);
    }

    #[test]
    fn a_number_that_another_group_has_is_passed_over() {
        assert_eq!(told_apart(&["a", "a", "a_2", "a_2"]), ["a", "a_3", "a_2", "a_2_2"]);
    }

    #[test]
    fn many_equal_names_take_no_square_of_time() {
        let names = told_apart(&vec!["solid"; 200_000]);
        assert_eq!(names[199_999], "solid_200000");
    }
}
