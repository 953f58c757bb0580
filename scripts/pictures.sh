#!/usr/bin/env bash
# Makes the pictures of README and of the book anew, from the sample that the program draws itself: `scripts/pictures.sh`.
set -eu
cd "$(dirname "$0")/.."
cargo build --release --package plenoscope-app
plenoscope=${CARGO_TARGET_DIR:-target}/release/plenoscope
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
"$plenoscope" sample -o "$scratch"
animate() { "$plenoscope" export "$scratch/sample.png" --no-cache --as animation --frames 20 --size 420x280 "$@"; }
animate --motion circle -o docs/book/src/images/look.gif
animate --motion focus-pull --f-number 1.4 -o docs/book/src/images/pull.gif
# The big daisy, and the bokeh behind everything.
daisy=514,340 far=60,60
of_book() { "$plenoscope" "$1" "$scratch/sample.png" --no-cache -o "docs/book/src/images/$2" "${@:3}"; }
of_book refocus f28.jpg --size 420x280 --f-number 28
of_book refocus f3.5.jpg --size 420x280 --f-number 3.5 --focus "$daisy"
of_book refocus f1.4.jpg --size 420x280 --f-number 1.4 --focus "$daisy"
of_book refocus far.jpg --size 420x280 --f-number 1.4 --focus "$far"
of_book depth depth.png --colormap turbo
of_book epi epi.png --row 150
# The window is drawn by a test, which needs a graphics driver and no screen.
PLENOSCOPE_PICTURES=$PWD/docs/book/src/images cargo test --release --test ui picture_of_readme
ls -l docs/book/src/images
