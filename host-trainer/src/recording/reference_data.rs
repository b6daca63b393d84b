//! Location of the real recordings for tests and benchmarks, which are not part of this repository.

use std::{env, path::PathBuf};

/// Folder `name` of the reference data (`femto`, `cwru`, …): in `$BALLRACE_DATA`, else in `../shared/data` next to the
/// workspace: of the crate's, which cargo states, or else of the present folder. `None`, with a note on stderr, if it is missing.
pub fn folder(name: &str) -> Option<PathBuf> {
    let stated = env::var_os("BALLRACE_DATA").map(PathBuf::from);
    let beside = || Some(PathBuf::from(env::var_os("CARGO_MANIFEST_DIR")?).join("../../shared/data"));
    let data = stated.or_else(beside).unwrap_or_else(|| "../shared/data".into());
    let folder = Some(data.join(name)).filter(|folder| folder.is_dir());
    if folder.is_none() {
        eprintln!("skipped: no folder `{name}` in $BALLRACE_DATA or ../shared/data");
    }
    folder
}
