#!/usr/bin/env bash
# All that is checked beside the tests, the quick things first. `scripts/check.sh --fast` leaves the compiler out.
set -u
cd "$(dirname "$0")/.." || exit 1
failed=0

# check NAME COMMAND…: runs it, shows what it says only when it fails.
check() {
    local name=$1 said
    shift
    if said=$("$@" 2>&1); then
        echo "ok    $name"
    else
        printf '%s\n' "$said" | tail -n 60
        echo "FAIL  $name"
        failed=1
    fi
}

# only_in PATTERN WHERE…: no Rust file outside the pathspecs WHERE names PATTERN.
only_in() {
    local pattern=$1
    shift
    ! git grep -nE "$pattern" -- '*.rs' ':!tests/' ':!app/tests/' ':!benches/' ':!**/tests/' "${@/#/:!}"
}

# Which room may name which: scripts/borders.txt says it, ARCHITECTURE draws it.
borders() {
    git ls-files 'src/*.rs' 'app/src/*.rs' 'python/src/*.rs' 'xtask/src/*.rs' | grep -vE '(_|/)tests(\.rs|/)|^src/lib\.rs$' |
        xargs awk -f scripts/borders.awk &&
        sed -n '/^```borders$/,/^```$/{//!p}' ARCHITECTURE.md | diff - scripts/borders.txt
}

long_files() {
    ! git ls-files '*.rs' '*.wgsl' | xargs wc -l | awk '$2 != "total" && $1 > 600 { print $2 " has " $1 " lines, more than 600"; bad = 1 } END { exit !bad }'
}

headless_files() {
    ! git ls-files '*.rs' | while read -r file; do
        grep -qE '^//!' "$file" || echo "$file does not say at its head what it is (//!)"
    done | grep .
}

large_files() {
    ! git ls-files -z | xargs -0 du -k | awk '$1 > 12288 { print $2 " is larger than 12 MiB"; bad = 1 } END { exit !bad }'
}

# The program as people get it, without symbols; docs/building.md says what is in it.
size_budget() {
    local small bytes
    small=$(mktemp) || return 1
    strip -o "$small" "$program" && bytes=$(wc -c <"$small")
    rm -f "$small"
    [ "${bytes:-0}" -gt 0 ] || return 1
    [ "$bytes" -le 64000000 ] || { echo "the program has $bytes bytes, more than 64 million: see docs/building.md"; return 1; }
}

# The program's crates on this system; docs/building.md says why each counts.
crate_budget() {
    local crates
    crates=$(cargo tree --locked --package plenoscope-app --edges normal,build --prefix none --no-dedupe --format '{p}' | sort -u | wc -l) || return 1
    [ "$crates" -le 430 ] || { echo "the program has $crates crates, more than its budget: see docs/building.md"; return 1; }
}

# The lists of deny.toml, by our own means.
dependencies() {
    local host
    host=$(rustc -vV | sed -n 's/^host: //p')
    set -o pipefail
    cargo metadata --quiet --locked --format-version 1 --filter-platform "$host" | python3 scripts/dependencies.py
}

no_machine_paths() {
    # /home/me stands for anybody's.
    ! git grep -nIE '(^|[^[:alnum:]_.])/(home|Users|root)/[[:alnum:]]' -- . ':!*.lock' ':!scripts/check.sh' | grep -v '/home/me/'
}

check "formatting" cargo fmt --all --check
check "tract only in synth/tract and the trainer's export" only_in '\btract(_onnx|_core|_linalg|_data|_hir)\b' 'src/synth/tract*' 'src/train/export*' 'src/train/*/export*'
check "wgpu only in render/gpu, render/lens/gpu, splats/gpu and ui" only_in '\bwgpu::' src/render/gpu 'src/render/lens/gpu*' 'src/splats/gpu*' src/ui
check "egui only in ui and render/gpu/present" only_in '\b(egui|eframe|egui_wgpu)::' src/ui 'src/render/gpu/present*'
check "Fluent only in the window's words" only_in '\bfluent_(bundle|syntax)::' src/ui/words
check "pyo3 only in the Python package" only_in '\bpyo3::' python
check "burn only in the trainer" only_in '\bburn::' src/train
check "libtorch only behind its feature" only_in '\btch::' src/train/torch.rs
# The op hands the kernel memory that nobody has written yet: clearing it first costs as much as a layer.
check "unsafe only in the kernel and the op that calls it" only_in '\bunsafe\b *(\{|fn|impl|trait|extern)' src/kernel src/synth/tract/op.rs
check "ONNX Runtime only behind its feature" only_in '\bort::' 'src/bench*'
check "rooms name only those that they may" borders
check "no file over 600 lines" long_files
check "every file says what it is" headless_files
check "no large file" large_files
check "no path of somebody's machine" no_machine_paths
check "no more crates than the budget" crate_budget
program=${CARGO_TARGET_DIR:-target}/release/plenoscope
if [ -x "$program" ] && command -v strip >/dev/null; then
    check "the program within its size" size_budget
else
    echo "skip  size of the program: no release build is here, or no strip"
fi

if [ "${1:-}" != "--fast" ]; then
    # The features of `cargo xtask test`, so that what is compiled here is compiled once.
    check "clippy" cargo clippy --quiet --workspace --all-targets --features plenoscope/onnxruntime -- -D warnings
    # One after the other: library and program share a name, and so the folder of their pages.
    check "documentation" env RUSTDOCFLAGS="-D warnings" cargo doc --quiet --jobs 1 --workspace --no-deps --document-private-items
    command -v typos >/dev/null && check "typos" typos
    if ! cargo deny --version >/dev/null 2>&1; then
        check "licences, bans and sources of this system's dependencies" dependencies
        echo "skip  advisories on dependencies: cargo-deny, or its database, is not here"
    else
        check "licences and sources of dependencies" cargo deny --log-level error check licenses bans sources
        if cargo deny --log-level error fetch db >/dev/null 2>&1; then
            check "advisories on dependencies" cargo deny --log-level error check advisories
        else
            echo "skip  advisories on dependencies: their database cannot be fetched"
        fi
    fi
fi
exit "$failed"
