//! Crate roots → crowded fronts: few public names, each listed by itself.

use crate::code::{items, public_uses};
use crate::violation::Violation;
use crate::workspace::{Package, Source};

/// Names at the root of a library, modules not counted.
const PUBLIC_NAMES: usize = 20;

/// A library root with too many public names, and every glob re-export of the crate.
pub(crate) fn check(package: &Package) -> Vec<Violation> {
    let mut violations: Vec<Violation> = package.sources.iter().flat_map(globs).collect();
    let Some(root) = package.source("src/lib.rs") else {
        return violations;
    };
    let n_names = n_public_names(root);
    if n_names > PUBLIC_NAMES {
        let message =
            format!("{n_names} public names, limit {PUBLIC_NAMES}: leave some to their modules");
        violations.push(Violation::new(&root.path, 1, message));
    }
    violations
}

fn globs(source: &Source) -> Vec<Violation> {
    let uses = public_uses(&source.shipped).into_iter();
    uses.filter(|reference| reference.segments.last().is_some_and(|name| name == "*"))
        .map(|reference| {
            let message = "glob re-export: list the names one by one";
            Violation::new(&source.path, reference.line, message)
        })
        .collect()
}

fn n_public_names(root: &Source) -> usize {
    let own = items(&root.shipped).into_iter();
    let n_own = own.filter(|item| item.is_public && item.keyword != "mod").count();
    n_own + public_uses(&root.shipped).len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::fixture::package;

    fn messages(text: &str) -> Vec<String> {
        let package = package("sparse", "", &[("src/lib.rs", text)]);
        check(&package).into_iter().map(|violation| violation.message).collect()
    }

    #[test]
    fn the_twenty_first_name_is_reported() {
        let names: Vec<String> = (0..19).map(|k| format!("N{k}")).collect();
        let root = format!("pub mod a;\npub use a::{{{}}};\npub fn f() {{}}\n", names.join(", "));

        assert_eq!(messages(&root), [""; 0]);
        assert!(messages(&(root + "pub struct S;"))[0].starts_with("21 public names"));
    }

    #[test]
    fn a_glob_re_export_is_reported() {
        assert_eq!(messages("pub use a::*;").len(), 1);
        assert_eq!(messages("use a::*;"), [""; 0]);
    }
}
