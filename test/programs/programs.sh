#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# The programs from end to end on a small drive: help, threads, interruption, chunks, uncoloured points.
. "$(dirname "$0")/common.bash"
ply() { /usr/bin/python3 test/programs/ply.py "$@"; }

# ---- help ----
expect 0 '--output.*--config.*--recording' colorize_bag --help
expect 0 '--cloud.*--images.*--model.*--output' colorize_map --help
expect 0 'RECORDING \[--output' colorize --help
expect 0 '--output.*--eye.*--field' render_map --help
expect 0 '--frames' simulate --help
expect 0 '^cloud_colorizer [0-9]+\.[0-9]+\.[0-9]+$' colorize --version
expect 0 'score' evaluate --help
expect 0 '--image-size' simulate city --help
for command in tables ablations heldout score visibility city; do expect 0 "Usage: evaluate $command" evaluate $command --help; done
for program in colorize_bag colorize_map colorize; do
  expect 0 '^  lambda=1 ' $program --help
  grep -q 'Exit codes' "$tmp/log" || problem "$program --help tells no exit codes"
done

# ---- from a bag to a map ----
make_drive "$tmp/drive"
recording=$tmp/recording
expect 0 'points coloured' colorize_bag "$tmp/drive/drive.bag" --config "$tmp/drive/rig.yaml" --recording "$recording" \
  --output "$tmp/map.ply" tile_size=5
read -r num_points num_colored _ < <(ply count "$tmp/map.ply")
[ "$num_colored" -gt 1000 ] || problem "only $num_colored of $num_points points are coloured"
expect 2 'must be .ply' colorize "$recording" --output "$tmp/map.pcd" --splats "$tmp/splats.splat"
expect 0 'saved' colorize "$recording" --output "$tmp/map.pcd" --write-model "$tmp/model" --splats "$tmp/splats.ply"
head -c 600 "$tmp/splats.ply" | grep -aq "element vertex $num_colored" || problem "--splats writes another number of splats"
for file in cameras.txt images.txt points3D.txt trajectory_camera_0.txt; do
  [ -s "$tmp/model/$file" ] || problem "--write-model writes no $file"
done
num_written=$(grep -vc '^#' "$tmp/model/points3D.txt")
[ "$num_written" = "$num_colored" ] || problem "--write-model writes $num_written points of $num_colored"
grep -v '^#' "$tmp/model/points3D.txt" | awk 'NF != 8 || $5 > 255 || $6 > 255 || $7 > 255 { exit 1 }' ||
  problem "points3D.txt has other lines than id x y z r g b error"
expect 0 'saved' colorize_map --cloud "$tmp/map.pcd" --images "$recording/images" --model "$tmp/model" \
  --output "$tmp/again.ply" method=mean
expect 2 'needs --write-model' colorize "$recording" --output "$tmp/flat.ply" --undistort
expect 0 'saved' colorize "$recording" --output "$tmp/flat.las" --write-model "$tmp/flat" --undistort crs=EPSG:25832
! grep -v '^#' "$tmp/flat/cameras.txt" | grep -qv ' PINHOLE ' || problem "--undistort leaves cameras with distortion"
expect 0 'saved' colorize_map --cloud "$tmp/flat.las" --images "$tmp/flat/images" --model "$tmp/flat" \
  --output "$tmp/again.las" method=mean
grep -aq 'PROJCS."ETRS89 / UTM zone 32N"' "$tmp/again.las" || problem "the coordinate reference system is lost"
expect 2 'crs: .*EPSG:1' colorize "$recording" --output "$tmp/flat.las" crs=EPSG:1
head -c 200 "$tmp/map.pcd" | grep -aq 'FIELDS x y z .*rgb view_count color_stddev' || problem "map.pcd has other fields"
expect 0 '' render_map "$tmp/map.ply" --output "$tmp/map.png" --size 320x200
[ -s "$tmp/map.png" ] || problem "no picture is drawn"

# ---- any number of threads, and any interruption, gives the same bytes ----
for threads in 1 2; do
  forget "$recording"
  expect 0 'saved' colorize "$recording" --output "$tmp/threads.ply" num_threads=$threads
  cmp "$tmp/map.ply" "$tmp/threads.ply" || problem "another map with num_threads=$threads"
done

# A bag that is read again, after a kill while it was read, gives what one undisturbed reading gives.
for lines in 2 4; do
  found=0
  colorize_bag "$tmp/drive/drive.bag" --config "$tmp/drive/rig.yaml" --recording "$tmp/killed_$lines" \
    --output "$tmp/killed.ply" tile_size=5 >"$tmp/log" 2>&1 &
  pid=$!; background+=("$pid")
  while kill -0 "$pid" 2>/dev/null; do
    [ "$(cat "$tmp/killed_$lines/views.csv" 2>/dev/null | wc -l)" -lt "$lines" ] || break
  done
  kill -KILL "$pid" 2>/dev/null || true
  { wait "$pid" || found=$?; } 2>/dev/null
  [ "$found" = 137 ] || problem "colorize_bag was through before it could be killed"
  expect 0 'already recorded' colorize_bag "$tmp/drive/drive.bag" --config "$tmp/drive/rig.yaml" \
    --recording "$tmp/killed_$lines" --output "$tmp/killed.ply" tile_size=5
  cmp "$tmp/map.ply" "$tmp/killed.ply" || problem "another map when the bag is read again after $lines lines of views.csv"
done

# interrupt SIGNAL CODE FOLDER: ends a run as soon as FOLDER has a first file of results. (After the surfels comes the
# alignment, the longest stage: time enough for the signal.)
interrupt() {
  local signal=$1 code=$2 folder=$3 found=0 pid
  forget "$recording"; rm -f "$tmp"/stopped.ply*
  colorize "$recording" --output "$tmp/stopped.ply" num_threads=1 >"$tmp/log" 2>&1 &
  pid=$!; background+=("$pid")
  until [ -n "$(find "$recording/$folder" -name '*.bin' -print -quit 2>/dev/null)" ]; do
    kill -0 "$pid" 2>/dev/null || break
    sleep 0.005
  done
  kill "-$signal" "$pid" 2>/dev/null || true
  { wait "$pid" || found=$?; } 2>/dev/null  # no word about a killed job
  [ "$found" = "$code" ] || { problem "exit code $found, not $code, after SIG$signal at $folder"; tail -5 "$tmp/log"; }
  [ -z "$(find "$tmp" -maxdepth 1 -name 'stopped.ply*')" ] || problem "SIG$signal at $folder leaves a half map"
  expect 0 'saved' colorize "$recording" --output "$tmp/stopped.ply"
  cmp "$tmp/map.ply" "$tmp/stopped.ply" || problem "another map after SIG$signal at $folder"
}
interrupt INT 130 surfels
interrupt TERM 130 surfels
interrupt KILL 137 surfels

# ---- chunked = whole ----
# At the borders of chunks the solutions differ a little; the points and what sees them do not.
expect 0 'saved' colorize "$recording" --output "$tmp/chunked.ply" max_chunk_points=4000
difference=$(ply compare "$tmp/map.ply" "$tmp/chunked.ply") || problem "$difference"
awk -v d="$difference" 'BEGIN { exit !(d < 0.5) }' || problem "chunked and whole differ by $difference of 255"
cmp -s "$tmp/map.ply" "$tmp/chunked.ply" && problem "max_chunk_points=4000 changes nothing: this test tests nothing"

# ---- what becomes of points that no view sees ----
expect 0 'saved' colorize "$recording" --output "$tmp/drop.ply" uncolored=drop
read -r points colored _ < <(ply count "$tmp/drop.ply")
[ "$points $colored" = "$num_colored $num_colored" ] || problem "uncolored=drop keeps $points points, $num_colored are coloured"
expect 0 'saved' colorize "$recording" --output "$tmp/keep.ply"
read -r points colored keep_visible < <(ply count "$tmp/keep.ply")
[ "$points $colored" = "$num_points $num_colored" ] || problem "uncolored=keep changes the points"
expect 0 'saved' colorize "$recording" --output "$tmp/fill.ply" uncolored=fill
read -r points colored fill_visible < <(ply count "$tmp/fill.ply")
[ "$points $colored" = "$num_points $num_colored" ] || problem "uncolored=fill changes points or view_count"
[ "$fill_visible" -gt "$keep_visible" ] || problem "uncolored=fill fills nothing"

# ---- scores of a map ----
expect 0 '[0-9]' evaluate score --truth "$tmp/drive/truth.ply" --result "$tmp/map.ply"
