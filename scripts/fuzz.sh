#!/usr/bin/env bash
# Coverage-guided fuzzing of all readers, two at a time: scripts/fuzz.sh HOURS [READER…]. HOURS are of the clock, for all
# together. A later call goes on with the corpus that lies in fuzz/corpus. Afterwards each corpus is made smaller, and
# docs/fuzzing.md is written. A finding lies in fuzz/artifacts/READER; `scripts/fuzz.sh try READER FILE` reads it again.
# It needs a nightly toolchain, and nothing else (cargo-fuzz is not needed).
set -u
cd "$(dirname "$0")/.." || exit 1
target=x86_64-unknown-linux-gnu
program=fuzz/target/$target/debug/readers
corpus=fuzz/corpus artifacts=fuzz/artifacts told=fuzz/artifacts/told
# The sanitizer's shadow and quarantine come on top of what a reader takes, and it works ten times as long;
# tests/bad_input.rs measures both without.
limits=(-timeout=25 -rss_limit_mb=3072 -malloc_limit_mb=1024 -max_len=65536)
export ASAN_OPTIONS=quarantine_size_mb=16:detect_leaks=0 RAYON_NUM_THREADS=1
[ -d /dev/shm ] && export TMPDIR=/dev/shm

build() {
    local coverage="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
    coverage+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
    coverage+=" -Cllvm-args=-sanitizer-coverage-trace-compares"
    (cd fuzz && RUSTFLAGS="$coverage -Zsanitizer=address --cfg fuzzing" cargo +nightly build --target "$target")
}

dictionary() {
    case $1 in
        heic* | avif* | spatial) echo boxes ;;
        xmp | jpeg | gdepth | dynamic-depth | apple | several | lfp-picture) echo xmp ;;
        recipe | carried | views-lightfield.json | lfp* | metrics) echo json ;;
        splats | pfm | side-file | pnm | hci* | middlebury* | lens | manifest) echo text ;;
    esac
}

# one SECONDS READER: fuzzes until the time is over; a finding ends a run, and the next one begins.
one() {
    local name=$2 end=$((SECONDS + $1)) log=$told/$2.log options=("${limits[@]}") words code=0
    [ -d "$corpus/$name" ] || { echo "$name is no reader" >&2; return 1; }
    mkdir -p "$artifacts/$name" "$told"
    words=$(dictionary "$name")
    [ -n "$words" ] && options+=("-dict=fuzz/dictionaries/$words.dict")
    while [ "$SECONDS" -lt "$end" ]; do
        local began=$SECONDS
        FUZZ_READER=$name "$program" "${options[@]}" -max_total_time=$((end - SECONDS)) -print_final_stats=1 \
            -artifact_prefix="$artifacts/$name/" "$corpus/$name" >"$log" 2>&1 || code=$?
        awk -v secs=$((SECONDS - began)) '
            / cov: / { for (i = 1; i < NF; i++) if ($i == "cov:") edges = $(i + 1) }
            /^#[0-9]/ { runs = substr($1, 2) }
            /number_of_executed_units/ { runs = $2 }
            END { print secs + 0, runs + 0, edges + 0 }' "$log" >>"$told/$name.runs"
        # One that cannot even begin would do so for ever.
        [ "$SECONDS" -gt "$began" ] || sleep 1
    done
    smaller "$name" "${options[@]}"
    echo "$name: $(table_row "$name")"
    return 0
}

# smaller READER OPTION…: keeps of its corpus what reaches something that nothing else reaches.
smaller() {
    local name=$1 new=$corpus/$1.smaller
    shift
    rm -rf "$new" && mkdir -p "$new"
    if FUZZ_READER=$name timeout 120 "$program" "$@" -merge=1 "$new" "$corpus/$name" >"$told/$name.merge" 2>&1; then
        rm -rf "${corpus:?}/$name" && mv "$new" "$corpus/$name"
    fi
    rm -rf "$new"
}

table_row() {
    local files kib findings
    files=$(find "$corpus/$1" -type f | wc -l)
    kib=$(find "$corpus/$1" -type f -printf '%s\n' | awk '{ n += $1 } END { print int((n + 1023) / 1024) }')
    findings=$(find "$artifacts/$1" -type f 2>/dev/null | wc -l)
    awk -v name="$1" -v files="$files" -v kib="$kib" -v findings="$findings" '
        { secs += $1; runs += $2; if ($3 > edges) edges = $3 }
        END { printf "| %s | %d | %d | %d | %d (%d KiB) | %d |\n", name, secs / 60 + 0.5, runs, edges, files, kib, findings }' "$told/$1.runs"
}

table() {
    echo '# Coverage-guided fuzzing'
    echo
    echo 'Written by `scripts/fuzz.sh`: libFuzzer with the address sanitizer, debug assertions and overflow checks on. Minutes are of'
    echo 'one core, all runs together; edges are branches of the program that the corpus reaches; findings are files that still'
    echo 'lie there: panics, faults, more than 25 s or 3 GiB with the sanitizer. What came of them: [reliability](reliability.md).'
    echo
    echo '| reader | minutes | executions | edges | corpus | findings |'
    echo '|---|---|---|---|---|---|'
    for runs in "$told"/*.runs; do table_row "$(basename "$runs" .runs)"; done
}

case ${1:-} in
    one) one "$2" "$3"; exit ;;
    try) FUZZ_READER=$2 exec "$program" "${limits[@]}" "$3" ;;
    table) table >docs/fuzzing.md; exit ;;
    '' | *[!0-9.]*) echo "usage: scripts/fuzz.sh HOURS [READER…]" >&2; exit 2 ;;
esac
build || exit 1
hours=$1 readers=("${@:2}")
names=$(FUZZ_SEEDS=$corpus "$program") || exit 1
[ ${#readers[@]} -gt 0 ] || mapfile -t readers <<<"$names"
seconds=$(awk -v hours="$hours" -v count=${#readers[@]} 'BEGIN { print int(hours * 7200 / count) + 1 }')
echo "${#readers[@]} readers, $seconds s each"
printf '%s\n' "${readers[@]}" | xargs -P 2 -n 1 nice -n 19 "$0" one "$seconds"
table >docs/fuzzing.md
