# Compares the rooms that the code names (`crate::room`, in the programs `plenoscope::room`) with scripts/borders.txt.
# Tests and comments may name any.
BEGIN {
    while ((getline line < "scripts/borders.txt") > 0) {
        count = split(line, word, /[ >-]+/)
        known[word[1]] = 1
        for (n = 2; n <= count; n++) if (word[n] != "") allowed[word[1], word[n]] = 1
    }
}
FNR == 1 {
    room = FILENAME
    sub(/^src\//, "", room)
    sub(/[\/.].*/, "", room)
    home = room ~ /^(app|python|train|xtask)$/ ? "plenoscope" : "crate"
    seen[room] = 1
    if (!(room in known)) tell(room " is no room of scripts/borders.txt")
}
/^#\[cfg\(test\)\]/ { getline; if (/^mod .*\{/) nextfile }
/^ *\/\// { next }
{
    rest = $0
    while (match(rest, "(^|[^a-z_])" home "::[a-z_{]+")) {
        name = substr(rest, RSTART, RLENGTH)
        rest = substr(rest, RSTART + RLENGTH)
        sub(/.*::/, "", name)
        gone[room, name] = 1
        if (name != room && !((room, name) in allowed)) tell(FILENAME ":" FNR ": " room " may not name " name)
    }
}
END {
    for (arrow in allowed) {
        split(arrow, ends, SUBSEP)
        if (ends[1] in seen && ends[2] in seen && !(arrow in gone)) tell(ends[1] " -> " ends[2] " is allowed, and nobody needs it")
    }
    exit bad
}
function tell(text) { print text; bad = 1 }
