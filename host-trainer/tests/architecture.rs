//! The layers of `src/lib.rs` hold: a module uses only layers below its own.

use std::fs;
use std::path::{Path, PathBuf};

/// The layers, from the ground up, as the table of `src/lib.rs` lists them.
const LAYERS: [&str; 15] = [
    "stats",
    "paper",
    "recording",
    "signal",
    "rig",
    "model",
    "rivals",
    "sweep",
    "features",
    "identify",
    "diagnose",
    "fleet",
    "report",
    "evaluate",
    "cli",
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Code without comments and without what is compiled for tests only.
fn code(path: &Path) -> Option<String> {
    let is_test = |name: &str| name == "tests" || name.ends_with("_tests") || name.starts_with("test_");
    if path.iter().any(|part| is_test(part.to_str().unwrap().trim_end_matches(".rs"))) {
        return None;
    }
    let text = fs::read_to_string(path).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    Some(text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n"))
}

#[test]
fn invariant_a_module_uses_only_layers_below_its_own() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    assert!(files.len() > 200, "{}", files.len());
    let mut upward = Vec::new();
    for file in &files {
        let inside = file.strip_prefix(&src).unwrap();
        let layer = inside.iter().next().unwrap().to_str().unwrap();
        let Some(own) = LAYERS.iter().position(|name| *name == layer) else {
            assert!(["lib.rs", "main.rs"].contains(&layer), "{layer} is in no layer");
            continue;
        };
        let Some(code) = code(file) else { continue };
        assert!(!code.contains("use crate::{"), "{}: one `use crate::…` a layer", inside.display());
        for (at, _) in code.match_indices("crate::") {
            let rest = &code[at + "crate::".len()..];
            let used: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if let Some(other) = LAYERS.iter().position(|name| *name == used)
                && other > own
            {
                upward.push(format!("{}: {used}", inside.display()));
            }
        }
    }
    assert!(upward.is_empty(), "used from below: {upward:#?}");
}

#[test]
fn golden_the_table_of_the_layers_is_their_order() {
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    let rows =
        lib.lines().filter_map(|line| line.strip_prefix("//! | [`")?.trim_start_matches("mod@").split('`').next());
    assert_eq!(rows.collect::<Vec<_>>(), LAYERS);
}
