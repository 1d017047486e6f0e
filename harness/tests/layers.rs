//! The order of the crate's two halves: the engine does not know the bench.

use std::path::Path;

/// Asserts that no source file below a folder contains a text.
fn assert_absent(folder: &Path, text: &str) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            assert_absent(&path, text);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            assert!(!std::fs::read_to_string(&path).unwrap().contains(text), "{} contains '{text}'", path.display());
        }
    }
}

#[test]
fn the_engine_does_not_use_the_bench_and_the_scheduler_no_bus() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    assert_absent(&source.join("engine"), "crate::bench");
    assert_absent(&source.join("bench/sim"), "crate::bench::bus");
}
