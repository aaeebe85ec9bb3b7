//! Code → shipped code: whatever stands under `#[cfg(test)]` becomes blanks.

use crate::code::end_of_item;

const TEST_MARK: &str = "#[cfg(test)]";

/// The code (see [`super::blank()`]) without its tests; line breaks are kept.
pub(crate) fn shipped(code: &[char]) -> Vec<char> {
    let mark: Vec<char> = TEST_MARK.chars().collect();
    let mut kept = code.to_vec();
    let mut at = 0;
    while at + mark.len() <= code.len() {
        if code[at..at + mark.len()] != mark[..] {
            at += 1;
            continue;
        }
        let end = end_of_item(code, at + mark.len());
        for c in &mut kept[at..end] {
            if *c != '\n' {
                *c = ' ';
            }
        }
        at = end;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::shipped;

    #[test]
    fn a_test_module_is_cut_and_what_follows_stays() {
        let code: Vec<char> = "a\n#[cfg(test)]\nmod tests { fn b() {} }\nc".chars().collect();

        let kept: String = shipped(&code).into_iter().collect();

        assert_eq!(kept.split_whitespace().collect::<Vec<_>>(), ["a", "c"]);
        assert_eq!(kept.lines().count(), 4);
    }
}
