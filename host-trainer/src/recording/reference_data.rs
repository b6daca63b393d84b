//! Where the real recordings are that tests and benchmarks compare against. They are not part of
//! this repository.

use std::{env, path::PathBuf};

/// The folder `name` of the reference data (`femto`, `cwru`, …): in `$BALLRACE_DATA`, else in
/// `../shared/data` beside the workspace. Where there is none, says on stderr what was skipped.
///
/// For tests and benchmarks run by cargo, which states where the crate is.
pub fn folder(name: &str) -> Option<PathBuf> {
    let stated = env::var_os("BALLRACE_DATA").map(PathBuf::from);
    let beside = || Some(PathBuf::from(env::var_os("CARGO_MANIFEST_DIR")?).join("../../shared/data"));
    let folder = stated.or_else(beside).map(|data| data.join(name));
    let folder = folder.filter(|folder| folder.is_dir());
    if folder.is_none() {
        eprintln!("skipped: no folder `{name}` in $BALLRACE_DATA or ../shared/data");
    }
    folder
}
