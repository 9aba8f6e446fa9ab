#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# Bad input ends with an exit code, the reason, and no half file. What the library refuses is in the other tests.
. "$(dirname "$0")/common.bash"

make_drive "$tmp/drive"
bag=$tmp/drive/drive.bag
colorize_bag "$bag" --output "$tmp/map.ply" --recording "$tmp/recording" >"$tmp/log" 2>&1 ||
  { echo "the good drive is not coloured"; tail -20 "$tmp/log"; exit 1; }

mkdir "$tmp/out"
out=$tmp/out/map.ply
# refuse CODE PATTERN COMMAND...: as expect, and nothing may be left in $tmp/out.
refuse() {
  expect "$@"
  [ -z "$(ls -A "$tmp/out")" ] || { problem "left behind by ${*:3}: $(ls -A "$tmp/out")"; rm -rf "${tmp:?}/out"/*; }
}
# changed_copy: a fresh copy of the recording in $tmp/copy.
changed_copy() { rm -rf "$tmp/copy"; cp -r "$tmp/recording" "$tmp/copy"; forget "$tmp/copy"; }

# ---- the command line ----
refuse 2 'lamda.*did you mean.*lambda' colorize "$tmp/recording" --output "$out" lamda=2
refuse 2 'voxel_sise.*did you mean.*voxel_size' colorize_bag "$bag" --output "$out" voxel_sise=0.1
refuse 2 'passes.*5' colorize "$tmp/recording" --output "$out" passes=5
refuse 2 'anchor_share' colorize "$tmp/recording" --output "$out" anchor_share=nan
refuse 2 'lambda.*not a number' colorize "$tmp/recording" --output "$out" lambda=much
refuse 2 'method.*one of: default, paper, mean, median, closest' colorize "$tmp/recording" --output "$out" method=best
refuse 2 'camera_7' colorize_bag "$bag" --output "$out" camera_7/time_offset=0.1
refuse 2 'output.*missing' colorize "$tmp/recording"
refuse 2 'unknown option --ouput' colorize "$tmp/recording" --ouput "$out"
refuse 2 'too few arguments' colorize --output "$out"
refuse 2 'frames' simulate --output "$tmp/out/drive" --frames 0
refuse 2 'fames' simulate --output "$tmp/out/drive" --fames 3
refuse 2 'size' render_map "$tmp/map.ply" --output "$tmp/out/map.png" --size large

# ---- the output ----
refuse 1 'extension must be .ply, .pcd or .las' colorize "$tmp/recording" --output "$tmp/out/map.e57"
refuse 1 'extension must be .ply, .pcd or .las' colorize_bag "$bag" --output "$tmp/out/map"
refuse 1 "no directory $tmp/nowhere" colorize "$tmp/recording" --output "$tmp/nowhere/map.ply"
refuse 1 "no directory $tmp/nowhere" colorize_bag "$bag" --output "$tmp/nowhere/map.ply"
mkdir "$tmp/folder.ply"
refuse 1 'is a directory' colorize "$tmp/recording" --output "$tmp/folder.ply"
mkdir "$tmp/small_disk"
if mount -t tmpfs -o size=100k tmpfs "$tmp/small_disk" 2>/dev/null; then
  expect 1 'No space left' colorize "$tmp/recording" --output "$tmp/small_disk/map.ply"
  [ -z "$(ls -A "$tmp/small_disk")" ] || problem "left on the full disk: $(ls -A "$tmp/small_disk")"
  expect 1 'No space left' colorize_bag "$bag" --output "$out" --recording "$tmp/small_disk/recording"
  [ ! -e "$out" ] || problem "a map of a recording that did not fit"
fi

# ---- bags ----
refuse 1 'nowhere.bag' colorize_bag "$tmp/nowhere.bag" --output "$out"
head -c $(($(stat -c %s "$bag") * 6 / 10)) "$bag" >"$tmp/truncated.bag"
refuse 1 'truncated.bag.*(reindex|not closed|truncated|cut|damaged)' colorize_bag "$tmp/truncated.bag" --output "$out"
refuse 1 'map.ply' colorize_bag "$tmp/map.ply" --output "$out"
refuse 3 'set map_frame to one of them' colorize_bag "$bag" --output "$out" map_frame=nowhere
grep -q 'no transform' "$tmp/log" || problem "the counters do not tell that there was no transform"
sed 's#/lidar/points#/lidar/pionts#' "$tmp/drive/rig.yaml" >"$tmp/rig.yaml"
refuse 1 'no topic /lidar/pionts' colorize_bag "$bag" --output "$out" --config "$tmp/rig.yaml"
sed 's#time_offset#time_ofset#' "$tmp/drive/rig.yaml" >"$tmp/rig.yaml"
refuse 1 'unknown key time_ofset' colorize_bag "$bag" --output "$out" --config "$tmp/rig.yaml"
refuse 1 'nowhere.yaml' colorize_bag "$bag" --output "$out" --config "$tmp/nowhere.yaml"
expect 1 'holds other files' colorize_bag "$bag" --output "$out" --recording "$tmp/drive"

# ---- recordings ----
refuse 1 'nowhere' colorize "$tmp/nowhere" --output "$out"
refuse 1 'recording' colorize "$tmp/drive" --output "$out"
changed_copy; sed -i 's/^format_version: .*/format_version: 999/' "$tmp/copy/recording.yaml"
refuse 1 'format version 999' colorize "$tmp/copy" --output "$out"
refuse 1 'format version 999' colorize_bag "$bag" --output "$out" --recording "$tmp/copy"
changed_copy; rm -r "$tmp/copy/images"
refuse 1 'images' colorize "$tmp/copy" --output "$out"
changed_copy; echo "no image" >"$(find "$tmp/copy/images" -type f | sort | head -1)"
expect 0 'views left out because of their images: 1' colorize "$tmp/copy" --output "$tmp/without.ply"
grep -q 'cannot be decoded' "$tmp/log" || problem "the log does not name the damaged image"
changed_copy; echo "no number,1,2" >>"$tmp/copy/views.csv"
refuse 1 'views.csv.*damaged' colorize "$tmp/copy" --output "$out"
changed_copy
exec 9>"$tmp/copy/recorder.lock"; flock 9  # as a program does that records
refuse 1 'another program is recording' colorize_bag "$bag" --output "$out" --recording "$tmp/copy"
exec 9>&-
changed_copy
refuse 1 'voxel' colorize_bag "$bag" --output "$out" --recording "$tmp/copy" voxel_size=0.2

# Two programs colour one recording in different ways at the same time: each is refused, or its map is right.
for method in median closest; do
  changed_copy
  colorize "$tmp/copy" --output "$tmp/$method.ply" method=$method depth_cell_size=0.5 >"$tmp/log" 2>&1 ||
    problem "method=$method fails on a recording of its own"
done
changed_copy
colorize "$tmp/copy" --output "$tmp/first.ply" method=median depth_cell_size=0.5 num_threads=1 >"$tmp/first.log" 2>&1 &
first=$!; background+=("$first")
until [ -n "$(find "$tmp/copy/depth" -name '*.bin' -print -quit 2>/dev/null)" ]; do
  kill -0 "$first" 2>/dev/null || break
done
kill -STOP "$first" 2>/dev/null || true  # in the middle of its depth images
if colorize "$tmp/copy" --output "$tmp/second.ply" method=closest depth_cell_size=0.5 >"$tmp/log" 2>&1; then
  cmp "$tmp/closest.ply" "$tmp/second.ply" || problem "the second of two programs on one recording saved a wrong map"
else
  grep -q 'another program' "$tmp/log" || { problem "no reason why the second program stops"; tail -3 "$tmp/log"; }
fi
kill -CONT "$first" 2>/dev/null || true
if wait "$first"; then
  cmp "$tmp/median.ply" "$tmp/first.ply" || problem "the first of two programs on one recording saved a wrong map"
else
  grep -q 'another program' "$tmp/first.log" || { problem "no reason why the first program stops"; tail -3 "$tmp/first.log"; }
fi

# ---- a model and its cloud ----
model() { colorize_map --cloud "$1" --images "$2" --model "$3" --output "$out"; }
mkdir "$tmp/model" "$tmp/images"
printf '1 PINHOLE 32 20 30 30 16 10\n' >"$tmp/model/cameras.txt"
printf '1 1 0 0 0 0 0 0 1 view.png\n\n' >"$tmp/model/images.txt"
refuse 1 'images directory .*nowhere' model "$tmp/map.ply" "$tmp/nowhere" "$tmp/model"
refuse 1 'view.png' model "$tmp/map.ply" "$tmp/images" "$tmp/model"
render_map "$tmp/map.ply" --output "$tmp/images/view.png" --size 32x20 >"$tmp/log" 2>&1
refuse 1 'cameras.txt' model "$tmp/map.ply" "$tmp/images" "$tmp/nowhere"
refuse 1 'nowhere.ply' model "$tmp/nowhere.ply" "$tmp/images" "$tmp/model"
echo "no cloud" >"$tmp/text.ply"
refuse 1 'text.ply' render_map "$tmp/text.ply" --output "$tmp/out/map.png"
refuse 1 'nowhere.ply' evaluate score --truth "$tmp/nowhere.ply" --result "$tmp/map.ply"

# What was there before is intact.
expect 0 'saved' colorize "$tmp/recording" --output "$tmp/again.ply"
cmp "$tmp/map.ply" "$tmp/again.ply" || problem "the recording gives another map after all this"
