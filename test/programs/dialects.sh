#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# One small coloured cloud in the dialects of other programs: render_map draws the same picture of each, and `evaluate
# score` finds no difference.
. "$(dirname "$0")/common.bash"
/usr/bin/python3 test/programs/dialects.py "$tmp/clouds"

picture() {  # CLOUD ARGUMENTS...: into $tmp/picture.ppm
  expect 0 'wrote' render_map "$1" --output "$tmp/picture.ppm" --size 96x64 --point-size 0.3 "${@:2}"
}
picture "$tmp/clouds/reference.ply"
mv "$tmp/picture.ppm" "$tmp/reference.ppm"
for cloud in "$tmp"/clouds/color_*; do
  picture "$cloud"
  cmp "$tmp/reference.ppm" "$tmp/picture.ppm" || problem "another picture of $(basename "$cloud")"
  expect 0 'AEP 0\.000, REP 0\.0000' evaluate score --truth "$tmp/clouds/reference.ply" --result "$cloud"
done
expect 0 'color_ushort.ply: .*0 to 65535' evaluate score --truth "$tmp/clouds/reference.ply" \
  --result "$tmp/clouds/color_ushort.ply"
expect 0 'color_unit_float.ply: .*0 to 1$' render_map "$tmp/clouds/color_unit_float.ply" --output "$tmp/picture.ppm"

# ---- fields of every type ----
for kind in whole broken; do
  rm -f "$tmp/reference.ppm"
  for cloud in "$tmp/clouds/field_$kind"_*; do
    picture "$cloud" --field number
    [ -e "$tmp/reference.ppm" ] || mv "$tmp/picture.ppm" "$tmp/reference.ppm"
    [ ! -e "$tmp/picture.ppm" ] || cmp "$tmp/reference.ppm" "$tmp/picture.ppm" ||
      problem "another picture of $(basename "$cloud")"
  done
done

# ---- a map in a camera's frame stands upright with --up ----
view=(--eye 9,-7,4 --target 2,2,0)
picture "$tmp/clouds/reference.ply" "${view[@]}"
mv "$tmp/picture.ppm" "$tmp/reference.ppm"
view=(--eye 9,-4,-7 --target 2,0,2)  # the same place as x, -z, y
picture "$tmp/clouds/optical.ply" "${view[@]}"
cmp -s "$tmp/reference.ppm" "$tmp/picture.ppm" && problem "the map lies on its side without --up, or should"
picture "$tmp/clouds/optical.ply" "${view[@]}" --up 0,-1,0
difference=$(/usr/bin/python3 test/programs/dialects.py compare "$tmp/reference.ppm" "$tmp/picture.ppm")
awk -v d="$difference" 'BEGIN { exit !(d < 0.1) }' || problem "with --up the picture differs by $difference of 255"
picture "$tmp/clouds/optical.ply" --up 0,-1,0  # from above
expect 2 'up 0,0,0.*no length' render_map "$tmp/clouds/optical.ply" --output "$tmp/picture.ppm" --up 0,0,0
expect 2 'up.*0,1.*3 values' render_map "$tmp/clouds/optical.ply" --output "$tmp/picture.ppm" --up 0,1
