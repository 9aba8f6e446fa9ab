#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# The report of a small drive, made with the map and made later, and looked at in a browser.
. "$(dirname "$0")/common.bash"
make_drive "$tmp/drive"
expect 0 'saved .*report.html' colorize_bag "$tmp/drive/drive.bag" --recording "$tmp/recording" --output "$tmp/map.ply" \
  --report "$tmp/report"
expect 0 'the page is as it should be' /usr/bin/python3 test/programs/report_page.py "$tmp/report/report.html" "$tmp/page.png"
/usr/bin/python3 -m jsonschema -i "$tmp/report/report.json" doc/report.schema.json || problem "report.json is not as doc/ says"
expect 0 'saved .*report.html' report "$tmp/recording" --output "$tmp/later"
expect 4 'map.points>1 holds' report "$tmp/recording" --output "$tmp/later" --fail-if 'map.points>1'
expect 2 'has no map.point' report "$tmp/recording" --output "$tmp/later" --fail-if 'map.point>1'
expect 2 'needs --report' colorize "$tmp/recording" --output "$tmp/map.ply" --fail-if 'map.points>1'
expect 2 'points = 0 must be from 1' report "$tmp/recording" --output "$tmp/later" --points 0
expect 0 'saved' report "$tmp/recording" --output "$tmp/few" --points 100
[ "$(stat -c %s "$tmp/few/report.html")" -lt "$(stat -c %s "$tmp/report/report.html")" ] || problem "--points does nothing"
size=$(stat -c %s "$tmp/report/report.html")
[ "$size" -lt 15000000 ] || problem "the page has $size bytes"
