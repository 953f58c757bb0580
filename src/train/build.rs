//! Links libtorch whole where it is asked for: CUDA is in a part of it that registers itself, and that nothing names.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let asked = |name: &str| std::env::var(name).unwrap_or_default();
    if !asked("CARGO_FEATURE_TORCH").is_empty() && asked("CARGO_CFG_TARGET_OS") == "linux" {
        println!("cargo:rustc-link-arg=-Wl,--no-as-needed");
        println!("cargo:rustc-link-arg=-ltorch");
    }
}
