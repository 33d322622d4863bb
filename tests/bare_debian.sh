#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Proves the README's two commands on a Debian 12 that has nothing installed: makes a minimal root
# with debootstrap, clones this repository into it and runs ./setup.sh demo and ./setup.sh test.
#
# usage, as root: tests/bare_debian.sh FOLDER [COMMAND...]
#   FOLDER   the root; made when it is not there, else used as it is
#   COMMAND  run in the clone instead of the two commands
# DEBIAN_MIRROR names another mirror than the one debootstrap knows.
set -euo pipefail

[ $# -ge 1 ] || { sed -n 's/^# //; /^usage/,/^DEBIAN/p' "$0" >&2; exit 2; }
root=$1
shift
repository=$(cd "$(dirname "$0")/.." && pwd)

say() { echo "bare_debian: $*"; }

say_size() { say "$1: $(du -sxm "$root" --exclude=proc | cut -f1) MB in $root"; }

# runs a command in the root, in the clone, with nothing of this environment; prints its time
inside() {
  local begin=$SECONDS
  chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 \
    PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
    /bin/bash -c 'cd /srv/elastogen && exec "$@"' bash "$@"
  say "$*: $((SECONDS - begin)) s"
}

if [ ! -e "$root/etc/debian_version" ]; then
  say "debootstrap"
  debootstrap --variant=minbase bookworm "$root" ${DEBIAN_MIRROR:+"$DEBIAN_MIRROR"}
fi
cp /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
say_size "bare root"

rm -rf "$root/srv/elastogen"
git clone --quiet --no-hardlinks "$repository" "$root/srv/elastogen"
say "clone of commit $(git -C "$root/srv/elastogen" rev-parse --short HEAD)"

# /proc is wanted, not needed: without it one thread more or less is found
if mount -t proc proc "$root/proc" 2>/dev/null; then
  trap 'umount "$root/proc"' EXIT
else
  say "/proc cannot be mounted here"
fi

if [ $# -gt 0 ]; then
  inside "$@"
else
  inside ./setup.sh demo
  say_size "after the demo"
  inside ./setup.sh test
fi
say_size "at the end"
