//! Which names joints may have, wherever they are read.

use std::collections::HashSet;

const LONGEST: usize = 200;

/// The first name that a joint cannot have, if any: each occurs once, has at most 200 bytes, no comma,
/// control character or outer space, and no code that XML refuses.
pub fn unfit_joint_name(names: &[String]) -> Option<&str> {
    let mut seen = HashSet::new();
    let is_fit = |name: &str| {
        let is_refused =
            |c: char| c == ',' || c.is_control() || matches!(c, '\u{FFFE}' | '\u{FFFF}');
        (1..=LONGEST).contains(&name.len()) && name.trim() == name && !name.contains(is_refused)
    };
    let unfit = names.iter().find(|name| !is_fit(name) || !seen.insert(name.as_str()));
    unfit.map(String::as_str)
}

#[cfg(test)]
mod tests {
    use super::unfit_joint_name;

    #[test]
    fn b15_e30_names_that_a_file_or_a_terminal_cannot_hold_are_found() {
        let names = |bad: &str| vec!["elbow".to_owned(), bad.to_owned()];
        let long = "x".repeat(65_536);

        for bad in ["", " a", "a,b", "a\nb", "\u{1b}[31m", "a\0", "\u{FFFE}", "elbow", &long] {
            assert_eq!(unfit_joint_name(&names(bad)), Some(bad));
        }
        for good in ["shoulder pan", "łokieć", &long[..200]] {
            assert_eq!(unfit_joint_name(&names(good)), None);
        }
    }
}
