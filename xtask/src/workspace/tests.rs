//! Fixtures and this workspace → what is read of them.

use super::fixture::package;
use super::*;

#[test]
fn dependencies_are_read_from_every_table_under_their_real_names() {
    let manifest = "
        [dependencies]
        torquewise-motion.workspace = true
        short = { package = 'torquewise-model', version = '1' }
        [build-dependencies]
        cc = '1'
        [target.'cfg(unix)'.dependencies]
        libc = '0.2'
        [dev-dependencies]
        proptest = '1'
    ";

    let package = package("torquewise-report", manifest, &[]);

    let expected = ["cc", "libc", "torquewise-model", "torquewise-motion"];
    assert!(package.dependencies.iter().eq(expected.iter()));
    assert!(package.dev_dependencies.iter().eq(["proptest"].iter()));
}

#[test]
fn sources_come_in_reading_order() {
    let package = package(
        "sparse",
        "",
        &[
            ("tests/contract.rs", ""),
            ("src/select/lasso.rs", ""),
            ("src/select.rs", "mod stlsq;\nmod lasso;"),
            ("src/lib.rs", "mod error;\nmod select;\nmod kmeans;"),
            ("src/kmeans.rs", ""),
            ("src/select/stlsq.rs", ""),
            ("src/error.rs", ""),
        ],
    );

    let order: Vec<&str> = package.sources.iter().map(|s| s.within.as_str()).collect();
    let expected = [
        "src/lib.rs",
        "src/error.rs",
        "src/select.rs",
        "src/select/stlsq.rs",
        "src/select/lasso.rs",
        "src/kmeans.rs",
        "tests/contract.rs",
    ];
    assert_eq!(order, expected);
}

#[test]
fn a_file_knows_its_module_path() {
    let path =
        |within: &str| Source::new("crates/a", &format!("crates/a/{within}"), "").module_path();

    assert_eq!(path("src/lib.rs"), Some(vec![]));
    assert_eq!(path("src/select/lasso.rs"), Some(vec!["select".into(), "lasso".into()]));
    assert_eq!(path("src/select/mod.rs"), Some(vec!["select".into()]));
    assert_eq!(path("examples/01_quickstart.rs"), None);
}

#[test]
fn a_module_declared_for_tests_is_a_test() {
    let files = [
        ("src/lib.rs", "mod gram;\n#[cfg(test)]\nmod fixture;\n"),
        ("src/gram.rs", ""),
        ("src/fixture.rs", ""),
        ("src/gram/tests.rs", ""),
        ("tests/contract.rs", ""),
    ];

    let package = package("sparse", "", &files);

    let tests: Vec<bool> = files.iter().map(|f| package.source(f.0).unwrap().is_test).collect();
    assert_eq!(tests, [false, false, true, true, true]);
}

#[test]
fn the_first_line_is_a_crate_comment_or_none() {
    let first = |text: &str| Source::new("a", "a/src/b.rs", text).first_line().map(str::to_owned);

    assert_eq!(first("//! A → B: c.\n"), Some("A → B: c.".to_owned()));
    assert_eq!(first("use a;\n"), None);
}

#[test]
fn a_missing_folder_is_an_error_that_names_it() {
    let error = Workspace::read(Path::new("/no/such/folder")).unwrap_err();

    assert_eq!(error.to_string(), "cannot list /no/such/folder/crates");
}

#[test]
fn this_program_finds_itself() {
    let workspace = Workspace::read(&root()).unwrap();

    assert!(workspace.packages.iter().any(|package| package.name == "xtask"));
    assert!(workspace.sources().any(|source| source.path == "xtask/src/workspace.rs"));
}
