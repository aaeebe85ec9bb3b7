//! Modules → backward imports: a module may use only those listed above it.

use crate::code::{Child, paths_from};
use crate::violation::Violation;
use crate::workspace::{Package, Source};

/// Every import in `src` of a module that is listed further down, and every module listed by no
/// file. A module and the one that declares it count as one; tests may import anything.
pub(crate) fn check(package: &Package) -> Vec<Violation> {
    let mut violations = Vec::new();
    for source in package.sources.iter().filter(|source| !source.is_test) {
        let module = source.module_path().unwrap_or_default();
        if module.is_empty() || is_binary(&module) {
            continue;
        }
        match unlisted(package, source, &module) {
            Some(violation) => violations.push(violation),
            None => violations.extend(backward_imports(package, source, &module)),
        }
    }
    violations
}

/// `src/bin/*.rs` are crates of their own.
fn is_binary(module: &[String]) -> bool {
    module.first().is_some_and(|first| first == "bin")
}

fn unlisted(package: &Package, source: &Source, module: &[String]) -> Option<Violation> {
    let (name, parent) = module.split_last()?;
    let listed = package.children(parent).iter().any(|child| child.name == *name);
    let message = format!("no `mod {name};` lists this file: list it in reading order, or drop it");
    (!listed).then(|| Violation::new(&source.path, 1, message))
}

fn backward_imports(package: &Package, source: &Source, module: &[String]) -> Vec<Violation> {
    let mut violations = Vec::new();
    for reference in paths_from(&source.shipped, "crate") {
        let path = &reference.segments[1..];
        if let Some(message) = judge(package, module, path) {
            violations.push(Violation::new(&source.path, reference.line, message));
        }
    }
    for reference in paths_from(&source.shipped, "super") {
        let path = resolve_supers(module, &reference.segments);
        if let Some(message) = judge(package, module, &path) {
            violations.push(Violation::new(&source.path, reference.line, message));
        }
    }
    violations
}

/// `super::x` in module `a::b` is `a::x`.
fn resolve_supers(module: &[String], segments: &[String]) -> Vec<String> {
    let n_supers = segments.iter().take_while(|segment| *segment == "super").count();
    let kept = module.len().saturating_sub(n_supers);
    module[..kept].iter().chain(&segments[n_supers..]).cloned().collect()
}

/// What is wrong with `module` naming `path`, both from the crate root.
fn judge(package: &Package, module: &[String], path: &[String]) -> Option<String> {
    let common = module.iter().zip(path).take_while(|(a, b)| a == b).count();
    let (here, there) = (module.get(common)?, path.get(common)?);
    let siblings = package.children(&module[..common]);
    let place = |name: &str| siblings.iter().position(|child: &Child| child.name == name);
    match (place(here), place(there)) {
        (Some(own), Some(other)) if other > own => Some(format!(
            "{here} uses {there}, which is listed below it: a module may use only those above"
        )),
        (_, None) if common == 0 => Some(format!(
            "`crate::{there}` is no module: import by module path, not from the crate root"
        )),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::fixture::package;

    const ROOT: (&str, &str) = ("src/lib.rs", "pub mod gram;\npub mod select;\npub mod kmeans;");
    const SELECT: (&str, &str) = ("src/select.rs", "mod stlsq;\nmod lasso;");

    fn messages(files: &[(&str, &str)]) -> Vec<String> {
        check(&package("sparse", "", files)).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_module_may_use_those_above_it() {
        let kmeans = ("src/kmeans.rs", "use crate::{gram::Gram, select::Term};");

        assert_eq!(messages(&[ROOT, kmeans]), [""; 0]);
    }

    #[test]
    fn an_import_from_below_is_reported_with_its_line() {
        let gram = ("src/gram.rs", "//! A → B: c.\nuse crate::{\n    kmeans::Centre,\n};");

        let found = messages(&[ROOT, gram]);

        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("crates/sparse/src/gram.rs:2: gram uses kmeans"));
    }

    #[test]
    fn order_holds_among_submodules_too() {
        let by_super = ("src/select/stlsq.rs", "use super::lasso::path;");
        let by_crate = ("src/select/stlsq.rs", "use crate::select::lasso::path;");

        assert_eq!(messages(&[ROOT, SELECT, by_super]).len(), 1);
        assert_eq!(messages(&[ROOT, SELECT, by_crate]).len(), 1);
    }

    #[test]
    fn a_submodule_keeps_the_order_of_its_parent() {
        let lasso = ("src/select/lasso.rs", "use super::super::kmeans;");

        assert_eq!(messages(&[ROOT, SELECT, lasso]).len(), 1);
    }

    #[test]
    fn a_submodule_may_use_its_parent_and_what_is_above() {
        let lasso =
            ("src/select/lasso.rs", "use super::{Term, stlsq::fit};\nuse crate::gram::Gram;");

        assert_eq!(messages(&[ROOT, SELECT, lasso]), [""; 0]);
    }

    #[test]
    fn tests_may_import_anything() {
        let gram = ("src/gram.rs", "#[cfg(test)]\nmod tests {\n    use crate::kmeans::Centre;\n}");

        assert_eq!(messages(&[ROOT, gram]), [""; 0]);
    }

    #[test]
    fn an_import_from_the_crate_root_is_reported() {
        let select = ("src/select.rs", "use crate::Gram;");

        assert!(messages(&[ROOT, select])[0].contains("`crate::Gram` is no module"));
    }

    #[test]
    fn a_file_that_no_module_lists_is_reported() {
        let stray = ("src/stray.rs", "");

        assert!(messages(&[ROOT, stray])[0].contains("no `mod stray;`"));
    }

    #[test]
    fn a_path_in_a_comment_is_no_import() {
        let gram = ("src/gram.rs", "/// See [`crate::kmeans`].\nfn f() {}");

        assert_eq!(messages(&[ROOT, gram]), [""; 0]);
    }
}
