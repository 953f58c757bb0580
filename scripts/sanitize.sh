#!/usr/bin/env bash
# The tests of src/kernel under Miri (its portable path) and under the address sanitizer (AVX2 and AVX-512 too):
# scripts/sanitize.sh miri|address [TEST…]. The kernel needs little of the library, so a package of those files alone is made;
# a nightly toolchain is needed, for Miri with `rustup component add miri rust-src`.
set -eu
cd "$(dirname "$0")/.."
root=$PWD package=target/sanitize/package
mkdir -p "$package/src"
cat >"$package/Cargo.toml" <<END
[package]
name = "kernel-alone"
version = "0.0.0"
edition = "2024"

[dependencies]
base64 = "0.22"
glam = { version = "0.34", features = ["serde"] }
libc = "0.2"
moxcms = "0.8"
rayon = "1.12"
serde = { version = "1", features = ["derive"] }
serde_json = "1"
thiserror = "2"

[dev-dependencies]
tempfile = "3"

[lints.rust]
dead_code = "allow"
unexpected_cfgs = "allow"

[workspace]

[profile.dev]
opt-level = 1
END
rm -f "$package"/src/*
for room in field job job.rs kernel; do
    ln -s "$root/src/$room" "$package/src/$room"
done
printf 'pub mod %s;\n' field job kernel >"$package/src/lib.rs"
cp Cargo.lock "$package/Cargo.lock"
how=$1
shift
cd "$package"
case $how in
    miri)
        export MIRIFLAGS="-Zmiri-disable-isolation -Zmiri-ignore-leaks -Zmiri-tree-borrows"
        # It does not know how the C library's allocator is asked to keep memory.
        cargo +nightly miri test --lib --target-dir "$root/target/sanitize/miri" -- "${@:-kernel::}" --skip kernel::blocks ;;
    address)
        export RUSTFLAGS=-Zsanitizer=address ASAN_OPTIONS=detect_leaks=0
        cargo +nightly test --lib --target x86_64-unknown-linux-gnu --target-dir "$root/target/sanitize/address" -- "${@:-kernel::}" ;;
    *) echo "usage: scripts/sanitize.sh miri|address [TEST…]" >&2; exit 2 ;;
esac
