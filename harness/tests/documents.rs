//! The files that the tutorial shows are those that `tests/tutorial` compiles and runs.

use std::path::Path;

#[test]
fn the_tutorial_shows_the_files_that_are_tested() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/tutorial-rust.md")).unwrap();
    let files: Vec<(&str, &str)> = text
        .split("\n`tests/tutorial/")
        .skip(1)
        .map(|part| {
            let (name, rest) = part.split_once("`:\n\n```").unwrap();
            (name, rest.split_once('\n').unwrap().1.split_once("```\n").unwrap().0)
        })
        .collect();
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["main.rs", "counter.v", "counter.rs", "fifo.v", "fifo.rs"]);
    for (name, shown) in files {
        assert_eq!(shown, std::fs::read_to_string(root.join("tests/tutorial").join(name)).unwrap(), "{name}");
    }
}
