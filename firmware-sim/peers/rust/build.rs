//! Puts the network of the folder that `BALLRACE_NETWORK` names into the library.

use std::env;
use std::fs;
use std::path::Path;

fn main() {
    println!("cargo::rerun-if-env-changed=BALLRACE_NETWORK");
    let folder = env::var("BALLRACE_NETWORK").expect("BALLRACE_NETWORK, a folder that the example peer_networks wrote");
    let out = env::var("OUT_DIR").expect("cargo sets it");
    for file in ["float.bin", "fixed.bin", "sizes.rs"] {
        let from = Path::new(&folder).join(file);
        println!("cargo::rerun-if-changed={}", from.display());
        fs::copy(&from, Path::new(&out).join(file)).unwrap_or_else(|error| panic!("{}: {error}", from.display()));
    }
}
