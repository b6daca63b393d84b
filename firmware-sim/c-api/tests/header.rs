//! `include/ballrace.h` is what cbindgen makes of the source. `BALLRACE_BLESS=1` writes it anew.

use std::path::Path;

#[test]
fn golden_header() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let sources = ["src/types.rs", "src/lib.rs"].map(|file| folder.join(file));
    let builder = sources.iter().fold(cbindgen::Builder::new(), |builder, file| builder.with_src(file));
    let mut made = Vec::new();
    builder.with_config(config).generate().unwrap().write(&mut made);
    let path = folder.join("include/ballrace.h");
    if std::env::var_os("BALLRACE_BLESS").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let found = std::fs::read(&path).unwrap_or_default();
    assert!(found == made, "include/ballrace.h is not current; BALLRACE_BLESS=1 writes it anew");
}
