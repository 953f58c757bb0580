#!/usr/bin/env bash
# Makes the pictures of README anew, from the sample that the program draws itself: `scripts/pictures.sh`.
set -eu
cd "$(dirname "$0")/.."
cargo build --release --package plenoscope-app
plenoscope=${CARGO_TARGET_DIR:-target}/release/plenoscope
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
"$plenoscope" sample -o "$scratch"
animate() { "$plenoscope" export "$scratch/sample.png" --no-cache --as animation --frames 20 --size 420x280 "$@"; }
animate --motion circle -o docs/look.gif
animate --motion focus-pull --f-number 1.4 -o docs/pull.gif
# The window is drawn by a test, which needs a graphics driver and no screen.
PLENOSCOPE_PICTURES=$PWD/docs cargo test --release --test ui picture_of_readme
ls -l docs
