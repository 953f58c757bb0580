#!/usr/bin/env bash
# Installs the .deb into a bare Debian and uses it there, as root: scripts/try-deb.sh FILE.deb bookworm|trixie
# The command line without anything else, then the window on a virtual display with a software Vulkan.
set -eu
deb=$(realpath "$1")
suite=$2
mirror=${DEBIAN_MIRROR:-http://deb.debian.org/debian}
cache=$(cd "$(dirname "$0")/.." && pwd)/target/debian
dir=$(mktemp -d /tmp/plenoscope-deb.XXXXXX)
root=$dir/root
in_root() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
leave() {
    status=$?
    umount "$root/proc" 2>/dev/null || true
    rm -rf --one-file-system "$dir"
    exit "$status"
}
trap leave EXIT
mkdir -p "$cache/$suite"
# A suite that this debootstrap does not know yet is made like the others.
script=/usr/share/debootstrap/scripts/$suite
[ -e "$script" ] || script=/usr/share/debootstrap/scripts/sid
debootstrap --variant=minbase --cache-dir="$cache/$suite" "$suite" "$root" "$mirror" "$script" >"$dir/debootstrap.log" 2>&1 ||
    { tail -n 20 "$dir/debootstrap.log"; exit 1; }
mount -t proc proc "$root/proc"
cp /etc/resolv.conf "$root/etc/resolv.conf"
for name in http_proxy https_proxy; do
    [ -z "${!name:-}" ] || echo "Acquire::${name%_proxy}::Proxy \"${!name}\";" >>"$root/etc/apt/apt.conf.d/90proxy"
done
cp "$deb" "$root/tmp/plenoscope.deb"
in_root apt-get update -q >/dev/null

# What it needs alone: the command line works, and without a display the window is one sentence.
in_root apt-get install -yq --no-install-recommends /tmp/plenoscope.deb >"$dir/apt.log" 2>&1 || { tail -n 20 "$dir/apt.log"; exit 1; }
echo "$suite: installed with $(in_root dpkg-query -W -f '${Depends}' plenoscope), nothing else"
in_root plenoscope --version
in_root plenoscope sample -o /tmp
in_root plenoscope refocus /tmp/sample.png -o /tmp/out.jpg --f-number 2
in_root plenoscope info /tmp/out.jpg
! in_root plenoscope 2>"$dir/said" || { echo "a window without a display?"; exit 1; }
[ "$(wc -l <"$dir/said")" = 1 ] && grep '^error: ' "$dir/said"
for file in share/man/man1/plenoscope.1.gz share/applications/plenoscope.desktop share/icons/hicolor/scalable/apps/plenoscope.svg \
    share/bash-completion/completions/plenoscope share/doc/plenoscope/licences-of-crates.txt.gz; do
    [ -s "$root/usr/$file" ] || { echo "$file is missing"; exit 1; }
done

# What it recommends, and a display: the window.
recommended=$(in_root dpkg-query -W -f '${Recommends}' plenoscope | sed 's/|[^,]*//g; s/,//g')
# shellcheck disable=SC2086
in_root apt-get install -yq --no-install-recommends $recommended xvfb xauth x11-utils imagemagick >"$dir/apt.log" 2>&1 || { tail -n 20 "$dir/apt.log"; exit 1; }
cat >"$root/tmp/look" <<'LOOK'
plenoscope --fresh /tmp/sample.png &
program=$!
for _ in $(seq 120); do
    xwininfo -root -tree | grep -q Plenoscope && found=1 && break
    kill -0 $program || exit 1
    sleep 0.5
done
[ "${found:-}" = 1 ] || { echo "no window came"; kill $program; exit 1; }
sleep 12
kill -0 $program || { echo "the window went"; exit 1; }
import -window root /tmp/window.png
xwininfo -root -tree | grep Plenoscope
kill $program
LOOK
in_root xvfb-run -a -s '-screen 0 1440x900x24' sh -e /tmp/look
# A black screen has one colour.
colors=$(in_root convert /tmp/window.png -format %k info:)
[ "$colors" -gt 200 ] || { echo "the window shows nothing ($colors colours)"; exit 1; }
[ -z "${KEEP:-}" ] || cp "$root/tmp/window.png" "$KEEP"
in_root apt-get remove -yq plenoscope >/dev/null
[ ! -e "$root/usr/bin/plenoscope" ]
echo "ok: $suite: installed, used, looked at ($colors colours), removed"
