//! Moments of parts, merged and solved: the model of `fit`, byte for byte.

use crate::terminal::Terminal;

#[test]
fn parts_merged_and_solved_are_the_model_of_fit() {
    let terminal = Terminal::new();
    for part in 1..=3 {
        terminal.done(&format!(
            "simulate planar-2 -o p{part}.csv --seconds 60 --rate 50 --case 2 --seed {part}"
        ));
        terminal.done(&format!("moments p{part}.csv -o p{part}.moments"));
    }

    terminal.done("merge p3.moments p1.moments p2.moments -o all.moments");
    terminal.done("solve all.moments -o solved.json");
    terminal.done("fit p1.csv p2.csv p3.csv -o fit.json");

    assert_eq!(terminal.read("solved.json"), terminal.read("fit.json"));
}

#[test]
fn moments_tell_what_they_are_and_what_does_not_add_up_is_refused() {
    let terminal = Terminal::with_log();
    let said = terminal.json("moments log.csv -o a.moments");
    terminal.run("moments log.csv -o b.moments --library product");

    assert_eq!((said["rows"].as_u64(), said["logs"].as_u64()), (Some(3000), Some(1)));
    assert_eq!(said["joints"].as_array().unwrap().len(), 2);
    assert!(said["bytes"].as_u64().unwrap() > 1000);
    terminal.refused("merge a.moments b.moments -o c.moments", &["b.moments", "library", "same"]);
    terminal.refused(
        "solve log.csv -o c.json",
        &["log.csv", "moments", "make the file of moments again"],
    );
    terminal.refused("merge none.moments -o c.moments", &["none.moments", "exists"]);
}
