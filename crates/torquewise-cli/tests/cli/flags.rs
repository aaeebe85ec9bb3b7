//! Flags that what is fitted does not use: refused with the method, the reason and the way out.

use crate::terminal::Terminal;

#[test]
fn a_chain_refuses_the_flags_of_libraries_and_says_why_it_is_fitted() {
    let terminal = Terminal::with_log();
    let chain = "a learned chain of rigid bodies";
    let library = "--library energy or --library product";

    for (flags, flag, because) in [
        ("--filter 20 --select lasso", "--select", "the log is filtered"),
        ("--filter 20 --threshold 0.1", "--threshold", "the log is filtered"),
        ("--friction linear --bootstrap 0", "--bootstrap", "friction was asked for"),
        ("--counterbalance joint1 --bootstrap 3", "--bootstrap", "a joint is counterbalanced"),
        ("--library chain --threshold 0.1", "--threshold", "the library was chosen"),
    ] {
        let line = format!("fit log.csv -o model.json {flags}");
        terminal.misused(&line, &[flag, chain, because, "leave it out", library]);
    }
}

#[test]
fn an_energy_library_beyond_four_joints_is_a_chain_unless_its_order_is_given() {
    let terminal = Terminal::new();
    terminal.done("simulate generic-6 -o six.csv --seconds 4 --rate 50 --seed 1");

    for library in ["", "--library energy"] {
        let line = format!("fit six.csv -o model.json --select lasso {library}");
        terminal.misused(&line, &["--select", "chain", "the log has 6 joints", "--interaction"]);
    }
}

#[test]
fn libraries_and_sindy_refuse_what_they_do_not_use() {
    let terminal = Terminal::with_log();
    let sindy = "one-shot SINDy over the product library";

    for (flags, words) in [
        ("--interaction 2 --library product", ["--interaction", "--library energy"]),
        ("--trig-order 3", ["--trig-order", "no other library was chosen"]),
        ("--counterbalance joint1 --library energy", ["the energy library", "--library chain"]),
        ("--method sindy --gravity-order 2", [sindy, "--method stepwise"]),
        ("--method sindy --friction linear", [sindy, "SINDy was chosen"]),
        ("--method sindy --counterbalance joint1", [sindy, "--library chain"]),
        ("--method sindy --library chain", ["SINDy", "product library"]),
    ] {
        terminal.misused(&format!("fit log.csv -o model.json {flags}"), &words);
    }
}

#[test]
fn flags_are_judged_before_the_log_is_read_where_they_can_be() {
    let terminal = Terminal::new();

    for flags in ["--library chain --bootstrap 3", "--method sindy --gravity-order 2"] {
        terminal.misused(&format!("fit missing.csv -o model.json {flags}"), &["leave it out"]);
    }
    terminal.refused("fit missing.csv -o model.json --bootstrap 3", &["missing.csv"]);
}

#[test]
fn moments_take_no_flags_of_a_selection_and_solve_those_of_their_method() {
    let terminal = Terminal::with_log();
    terminal.done("moments log.csv -o library.moments");
    terminal.done("moments log.csv -o chain.moments --library chain");

    for flags in ["--select bic", "--threshold 0.1", "--bootstrap 3", "--no-noise-correction"] {
        let line = format!("moments log.csv -o other.moments {flags}");
        terminal.misused(&line, &["only summed up", "give it to solve"]);
    }
    let because = "the logs were summed for it";
    for (line, words) in [
        ("chain.moments --bootstrap 3", ["--bootstrap", "chain", because]),
        ("chain.moments --select lasso", ["--select", "choose --library", because]),
        ("library.moments --counterbalance joint1", ["--counterbalance", "energy", because]),
        ("library.moments --friction linear", ["friction", "all logs", "do not add up"]),
    ] {
        terminal.misused(&format!("solve {line} -o model.json"), &words);
    }
    terminal.json("solve chain.moments -o chain.json --friction none --no-noise-correction");
    terminal.json(
        "solve library.moments -o library.json --select stlsq --threshold 0.01 --bootstrap 2",
    );
}

#[test]
fn compare_and_orders_refuse_what_they_do_not_use() {
    let terminal = Terminal::with_log();

    for (flags, words) in [
        ("--counterbalance joint1", ["--counterbalance", "one-shot SINDy"]),
        ("--gravity-order 2", ["--gravity-order", "the energy library"]),
        ("--library product --interaction 2", ["--interaction", "the product library"]),
        ("--library chain", ["a chain is not compared", "the product library"]),
    ] {
        terminal.misused(&format!("compare log.csv --test log.csv {flags}"), &words);
    }
    for flags in ["--select lasso", "--threshold 0.1", "--bootstrap 3", "--library product"] {
        terminal.misused(&format!("orders log.csv {flags}"), &["unexpected argument"]);
    }
}
