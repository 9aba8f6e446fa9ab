#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# `evaluate` from end to end on small built-in shapes: every file is there, and a second run gives the same errors.
. "$(dirname "$0")/common.bash"
report() { /usr/bin/python3 scripts/report.py "$@"; }
small=(--quick --points 2000 --views 4 --sizes 1000,2000 --time-limit 5 alignment_points=300)

# ---- the tables ----
for run in one two; do
  expect 0 '4-pass' evaluate tables "${small[@]}" --output "$tmp/$run"
  expect 0 '4-pass AEP' report "$tmp/$run" 'evaluate tables'
  grep -qE '^[0-9]+ of [0-9]+ bars missed$' "$tmp/log" || problem "no word about how many bars are missed"
done
for name in TABLES.md {table1,table2,growth,isolated,bars}.md {table1,table2,isolated}.csv \
            {closeups,error_aep,error_rep,time_by_size}.png; do
  [ -s "$tmp/one/$name" ] || problem "evaluate tables and its report write no $name"
done
for method in closest mean median 5-NN 20-NN DT 1-pass 2-pass 3-pass 4-pass "4-pass shared" default; do
  [ "$(grep -cE ",(both|extrinsics|intensities),$method,ok," "$tmp/one/table1.csv")" = 3 ] ||
    problem "table 1 has not three rows of $method that are ok"
done
# Eight graphs, three solvers, two sizes.
[ "$(grep -c ',ok,' "$tmp/one/table2.csv")" = 48 ] || problem "table 2 has not 48 rows that are ok"
errors() { cut -d, -f1-11 "$1/table1.csv"; }
cmp <(errors "$tmp/one") <(errors "$tmp/two") || problem "a second run gives other errors"
cmp "$tmp/one/isolated.csv" "$tmp/two/isolated.csv" || problem "a second run gives other parts"

# ---- ablations ----
expect 0 'ablations 100 % .84 of 84' evaluate ablations "${small[@]}" --output "$tmp/ablations"
expect 0 'wrote .*ablations.md' report "$tmp/ablations"
for what in passes anchor_share_random anchor_share_consistent lambda gradient_distance max_views \
            depth_cell_size overlap_percent texture_frequency; do
  [ -s "$tmp/ablations/ablation_$what.png" ] || problem "no plot of $what"
done

# ---- held-out views ----
make_drive "$tmp/drive"
expect 0 'saved' colorize_bag "$tmp/drive/drive.bag" --config "$tmp/drive/rig.yaml" --recording "$tmp/recording" \
  --output "$tmp/map.ply"
expect 0 '\| default \|' evaluate heldout "$tmp/recording" --every 3 --output "$tmp/heldout"
for method in closest mean median paper default; do
  grep -q "^$method," "$tmp/heldout/heldout.csv" || problem "no held-out score of $method"
done
ls "$tmp"/heldout/view_*.png >"$tmp/log" || problem "no pictures of held-out views"

# ---- a city: from points and photographs to a score ----
expect 0 'points 100 %' simulate city --output "$tmp/city" --points 30000 --views 6 --image-size 320x240
city=(--cloud "$tmp/city/cloud.ply" --images "$tmp/city/images" --model "$tmp/city/model")
expect 0 'saved' colorize_map "${city[@]}" --recording "$tmp/city_recording" --output "$tmp/city.ply" method=paper \
  max_chunk_points=8000
expect 0 'visible points coloured: [7-9][0-9]' evaluate city "$tmp/city.ply" --recording "$tmp/city_recording" \
  max_chunk_points=8000
grep -q 'at borders of chunks' "$tmp/log" || problem "evaluate city tells nothing about borders"
expect 1 'not those of the cloud' evaluate city "$tmp/city.ply" --cloud "$tmp/city/cloud.ply"
expect 1 'true_red' evaluate city "$tmp/map.ply"
expect 2 'image-size' simulate city --output "$tmp/none" --image-size 100
expect 2 'views' simulate city --output "$tmp/none" --views 1

# ---- bad input ----
expect 1 'leaves none out' evaluate heldout "$tmp/recording" --every 1000 --output "$tmp/none"
expect 1 'nowhere' evaluate tables --meshes "$tmp/nowhere" --output "$tmp/none"
mkdir "$tmp/meshes"
printf 'ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n' \
  >"$tmp/meshes/points.ply"
expect 1 'points.ply.*face' evaluate tables --meshes "$tmp/meshes" --output "$tmp/none"
expect 1 'points.ply.*no colours' evaluate score --truth "$tmp/meshes/points.ply" --result "$tmp/map.ply"
far=$tmp/far.ply
printf 'ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n' >"$far"
printf 'property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n9000 0 0 1 2 3\n' >>"$far"
expect 1 'overlap' evaluate score --truth "$far" --result "$tmp/map.ply"
expect 2 'sizes' evaluate tables --sizes 12,many --output "$tmp/none"
expect 2 'every' evaluate heldout "$tmp/recording" --every often --output "$tmp/none"
