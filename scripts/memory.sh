#!/usr/bin/env bash
# The most memory that the program takes, by megapixels, as rows of the table in docs/performance.md:
# scripts/memory.sh PROGRAM [MEGAPIXELS…]. It makes its own pictures (PNG by Python, JPEG of them by the program), some of them
# large: 200 megapixels need 1 GB of disk, up to 4 GB of memory and half an hour. FOLDER says where they are kept.
set -u
program=${1:?usage: scripts/memory.sh PROGRAM [MEGAPIXELS…]}
shift
[ $# -gt 0 ] || set -- 12 48 108 200
folder=${FOLDER:-$(mktemp -d)}

# A picture with soft and fine structure, four to three, row by row.
picture() {
    python3 - "$1" "$2" <<'END'
import random, struct, sys, zlib
path, megapixels = sys.argv[1], float(sys.argv[2])
width = int((megapixels * 1e6 * 4 / 3) ** 0.5) // 16 * 16
height = int(megapixels * 1e6 / width) // 16 * 16
random.seed(1)
fine = [bytes(random.randrange(256) for _ in range(3 * 4096)) for _ in range(8)]
out = open(path, "wb")
def chunk(kind, data):
    out.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
out.write(b"\x89PNG\r\n\x1a\n")
chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
pack = zlib.compressobj(1)
for y in range(height):
    soft = bytes([40 + 160 * y // height, 90, 200 - 160 * y // height]) * 2048
    row = (soft + fine[y // 64 % 8][: 3 * 2048] if y // 512 % 2 else soft * 2) * (width // 4096 + 1)
    piece = pack.compress(b"\0" + row[: 3 * width])
    if piece:
        chunk(b"IDAT", piece)
chunk(b"IDAT", pack.flush())
chunk(b"IEND", b"")
END
}

# peak COMMAND…: its peak in MiB, or what it says.
peak() {
    local said
    if said=$(/usr/bin/time -f %M -o "$folder/peak" "$@" 2>&1 >/dev/null); then
        echo "$(($(tail -n 1 "$folder/peak") / 1024)) MiB"
    else
        printf '%s\n' "$said" | tail -n 1 | cut -c 1-200
    fi
}

echo '| megapixels | file | opened (`info`) | f/28 | f/1.4 | f/1.4 from (3, 0) |'
echo '|---|---|---|---|---|---|'
for megapixels; do
    png=$folder/$megapixels.png jpeg=$folder/$megapixels.jpg
    [ -s "$png" ] || picture "$png" "$megapixels"
    [ -s "$jpeg" ] || "$program" refocus "$png" -o "$jpeg" --f-number 28 --force >/dev/null 2>&1
    for photo in "$png" "$jpeg"; do
        [ -s "$photo" ] || continue
        out=$folder/out.${photo##*.}
        lens() { rm -f "$out"; peak "$program" refocus "$photo" -o "$out" "$@"; }
        echo "| $megapixels | ${photo##*.} | $(peak "$program" info "$photo") | $(lens --f-number 28) |" \
            "$(lens --f-number 1.4) | $(lens --f-number 1.4 --at 3,0) |"
    done
done
