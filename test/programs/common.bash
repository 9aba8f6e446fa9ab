# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Sourced first by the tests of the programs. They run from the repository's root with the devel space sourced, make
# what they need in $tmp, and exit with 1 when a check failed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

tmp=$(mktemp -d)
problems=0
background=()
clean_up() {
  local code=$? pid
  for pid in "${background[@]}"; do kill -KILL "$pid" 2>/dev/null || true; done
  if mountpoint -q "$tmp/small_disk" 2>/dev/null; then umount "$tmp/small_disk"; fi
  rm -rf "$tmp"
  if [ "$code" = 0 ] && [ "$problems" != 0 ]; then code=1; fi
  exit "$code"
}
trap clean_up EXIT

problem() { echo "PROBLEM: $*"; problems=$((problems + 1)); }

# The programs of the space that is sourced, as rosrun finds them, without its start-up time.
for prefix in ${CMAKE_PREFIX_PATH//:/ }; do
  [ -x "$prefix/lib/cloud_colorizer/colorize" ] || continue
  PATH=$prefix/lib/cloud_colorizer:$PATH
  break
done
command -v colorize >/dev/null || { echo "colorize is not found; first: . devel/setup.bash"; exit 1; }

# expect CODE PATTERN COMMAND...: it must exit with CODE and say something that matches PATTERN (an extended regular
# expression). What it says is in $tmp/log.
expect() {
  local code=$1 pattern=$2 found=0; shift 2
  "$@" >"$tmp/log" 2>&1 || found=$?
  [ "$found" = "$code" ] || { problem "exit code $found, not $code, of: $*"; tail -5 "$tmp/log"; }
  grep -qE -- "$pattern" "$tmp/log" || { problem "nothing about '$pattern' from: $*"; tail -5 "$tmp/log"; }
}

# A drive of a second or two of computing.
make_drive() { simulate --output "$1" --preset clean --frames 3 --width 320 --height 200 --azimuths 300 >"$tmp/log" 2>&1; }

# forget DIR: removes from a recording what was derived from it.
forget() { rm -rf "$1"/{moving,surfels,alignment,depth,colored}; }
