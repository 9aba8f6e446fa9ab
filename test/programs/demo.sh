#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# scripts/demo on a short, small, clean drive leaves everything that it promises.
set -euo pipefail
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
BUILD_TESTS=ON FRAMES=8 RVIZ_SECONDS=12 SIMULATE="--preset clean --width 640 --height 400 --azimuths 600" scripts/demo "$out"
for file in drive.bag truth.ply recording/recording.yaml map.ply closest.ply street.png above.png detail.png \
  coverage.png rviz.png report.html; do
  [ -s "$out/$file" ] || { echo "$file is missing"; exit 1; }
done
# Grey rviz alone compresses to a few kilobytes; a street does not.
[ "$(stat -c %s "$out/street.png")" -gt 100000 ] || { echo "street.png shows nothing"; exit 1; }
scores=$(rosrun cloud_colorizer evaluate visibility "$out/recording" --scene "$out/scene.yaml" --map "$out/map.ply")
echo "$scores"
awk '/truly visible/ { ok = $NF == "%" && $(NF-1) >= 90; exit } END { exit !ok }' <<<"$scores"
