#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# StVK beyond nu = 0.4, which fits from a random start do not reach: each from the one before.
#
# usage: training/stvk.sh TRAINER FOLDER [OPTIONS...]
#   TRAINER  elastogen-train, or 'elastogen train mtl'
#   FOLDER   has stvk-0.4.weights, gets those of 0.41 ... 0.45
#   OPTIONS  for every fit, e.g. --device cuda
set -euo pipefail
[ $# -ge 2 ] || { sed -n 's/^# //; /^StVK/,/^  OPTIONS/p' "$0" >&2; exit 2; }
trainer=$1 folder=$2
shift 2

# fit NU START OPTIONS...: exit status 4 is that of a fit that misses its limits
fit() {
  local nu=$1 start=$2
  shift 2
  $trainer --law stvk --poisson "$nu" --start "$folder/stvk-$start.weights" \
    --out "$folder/stvk-$nu.weights" "$@" || [ $? -eq 4 ]
}

last=0.4
for nu in 0.41 0.42 0.43 0.44; do
  fit $nu $last --steps 1500 --rate 1e-3 "$@"
  last=$nu
done
fit 0.45 0.44 --steps 7000 --samples 1536 --rate 2e-3 "$@"
