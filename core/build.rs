//! Tells the crate whether its target always has the dual 16-bit multiply-accumulate: `rustc` states no such feature of
//! Arm on its stable channel.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(smlad)");
    // Armv7E-M is Armv7-M with the DSP extension. Armv8-M has it or has not, so its targets take the portable form.
    if std::env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv7em-")) {
        println!("cargo::rustc-cfg=smlad");
    }
}
