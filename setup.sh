#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# From a bare Debian 12 to a built elastogen. Installs the packages that are missing, configures
# what is not configured, builds what is out of date.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: ./setup.sh demo [options]   build, then run "elastogen demo" with these options
       ./setup.sh test [options]   build, then run all tests; options go to ctest
       ./setup.sh build            build only
TEXT
}

say() { echo "setup: $*" >&2; }

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    say "needs root and there is no sudo; run as root: $*"
    exit 1
  fi
}

# names in packages.txt that dpkg does not list as installed
missing_packages() {
  local name
  sed -e 's/#.*//' packages.txt | tr -s '[:space:]' '\n' | sed '/^$/d' | while read -r name; do
    case "$(dpkg-query -W -f '${db:Status-Abbrev}' "$name" 2>/dev/null || true)" in
      *i\ *) ;;
      *) echo "$name" ;;
    esac
  done
}

install_packages() {
  if ! command -v dpkg-query >/dev/null; then
    say "this is not a Debian system: install what packages.txt lists by hand"
    return
  fi
  local missing
  missing=$(missing_packages)
  if [ -z "$missing" ]; then
    say "all packages of packages.txt are installed"
    return
  fi
  say "installing:" $missing
  as_root apt-get update -q
  as_root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends $missing
}

build() {
  if [ ! -f build/cpu/build.ninja ]; then
    say "configuring build/cpu"
    cmake --preset cpu
  fi
  say "building build/cpu"
  cmake --build --preset cpu
}

here=$PWD
cd "$(dirname "$0")"
repository=$PWD
verb=${1:-}
[ $# -gt 0 ] && shift

case "$verb" in
  build | test | demo) ;;
  -h | --help) usage; exit 0 ;;
  *) usage >&2; exit 2 ;;
esac

install_packages
build
case "$verb" in
  demo) cd "$here" && exec "$repository/build/cpu/elastogen" demo "$@" ;;
  test) exec ctest --preset cpu -j "$(nproc)" "$@" ;;
esac
