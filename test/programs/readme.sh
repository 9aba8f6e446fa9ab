#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# What README.md says is so: its examples run, and its names and defaults are those of the programs.
. "$(dirname "$0")/common.bash"
root=$PWD

# ---- the parameters ----
# rows_of README: "name=default" of every row of the tables of parameters, as written for camera_0.
rows_of() {
  sed -nE 's/^\| `([a-z0-9_<>\/]+)` \| (`([^`]*)`|\(empty\)) \|.*/\1=\3/p' "$1" | sed 's/^camera_<i>/camera_0/' | sort
}
colorize --help | sed -nE '/^Parameters/,/^Exit/ s/^  ([a-z0-9_]+=[^ ]*) .*/\1/p' | sort >"$tmp/method"
colorizer_node --defaults | sed -nE 's/^([a-z0-9_\/]+): ([^ ]*) .*/\1=\2/p' | sed 's/=""$/=/' | sort >"$tmp/all"
rows_of README.md >"$tmp/readme"
[ "$(wc -l <"$tmp/method")" -gt 30 ] || problem "colorize --help lists too few parameters for this test to mean anything"
missing=$(comm -23 "$tmp/method" "$tmp/all")
[ -z "$missing" ] || problem "colorize has parameters that the node has not, or other defaults: $missing"
missing=$(comm -23 "$tmp/all" "$tmp/readme")
[ -z "$missing" ] || problem "README.md lacks, or has other defaults of:" $missing
missing=$(comm -13 "$tmp/all" "$tmp/readme")
[ -z "$missing" ] || problem "README.md has what the programs have not:" $missing

# ---- topics, services, launch files, pictures ----
# The name that is advertised or subscribed to as a literal.
names=$(sed -nE 's/.*(advertise|serve)<[^>]*>\("([a-z_]+)".*/\2/p; s/.*subscribeTo<[^>]*>\("([a-z_\/]+)".*/\1/p' \
  src/ros/*.cpp)
[ "$(wc -w <<<"$names")" -gt 8 ] || problem "too few names found in src/ros for this test to mean anything"
for name in $names; do grep -qE "\`~?$name\`" README.md || problem "README.md has no row for the topic or service $name"; done
# Commands over several lines are joined first.
sed -e ':a' -e '/\\$/N; s/\\\n//; ta' README.md >"$tmp/joined"
launches=0
while read -r file arguments; do
  [ -f "launch/$file" ] || { problem "README.md launches $file, which does not exist"; continue; }
  for argument in $(grep -oE '[a-z_0-9]+:=' <<<"$arguments"); do
    grep -q "<arg name=\"${argument%:=}\"" "launch/$file" || problem "$file has no argument ${argument%:=}"
  done
  launches=$((launches + 1))
done < <(grep -oE 'roslaunch cloud_colorizer [a-z_]+\.launch[^`]*' "$tmp/joined" | sed 's/^roslaunch cloud_colorizer //')
[ "$launches" -ge 2 ] || problem "only $launches launch commands are found in README.md"
for file in $(grep -oE '\]\([A-Za-z_./]+\)' README.md | tr -d ']()'); do
  [ -e "$file" ] || problem "README.md refers to $file, which does not exist"
done

# ---- the examples ----
# That in C++ stands in a test.
awk '/^```cpp$/ { inside = 1; next } /^```$/ { inside = 0 } inside' README.md >"$tmp/example.cpp"
sed -e '1,/README begins/d' -e '/README ends/,$d' -e 's/^  //' test/core/map/pcl_example_test.cpp >"$tmp/tested.cpp"
[ -s "$tmp/example.cpp" ] && cmp -s "$tmp/example.cpp" "$tmp/tested.cpp" ||
  problem "the C++ example in README.md is not the one in test/core/map/pcl_example_test.cpp"

make_drive "$tmp/drive"
mkdir "$tmp/work"
cp "$tmp/drive/drive.bag" "$tmp/work/DRIVE.bag"
# The rig file is an example, too.
awk '/^```yaml$/ { getline; inside = /^# rig.yaml/ } /^```$/ { inside = 0 } inside' README.md >"$tmp/work/rig.yaml"
colorize_bag "$tmp/drive/drive.bag" --recording "$tmp/recording" --output "$tmp/work/cloud.ply" >"$tmp/log" 2>&1
/usr/bin/python3 test/programs/colmap_model.py "$tmp/recording" "$tmp/work/sparse"
mv "$tmp/recording/images" "$tmp/work/images"

# Each block marked as tested becomes a file.
awk -v prefix="$tmp/block_" '/^```bash$/ { getline; if ($0 == "# tested") { n++; file = prefix n ".sh"; next } }
  /^```$/ { file = "" } file { print > file }' README.md
blocks=$(find "$tmp" -maxdepth 1 -name 'block_*.sh' | sort -V)
[ "$(wc -w <<<"$blocks")" -ge 3 ] || problem "too few blocks are marked as tested in README.md"
cd "$tmp/work" || exit 1
for block in $blocks; do
  bash -euo pipefail "$block" >"$tmp/log" 2>&1 || { problem "this example fails:"; cat "$block"; tail -20 "$tmp/log"; }
done
for file in map.ply map.png closest.ply filled.pcd colored.ply; do
  [ -s "$file" ] || problem "the examples made no $file"
done
read -r num_points num_colored _ < <(/usr/bin/python3 "$root/test/programs/ply.py" count colored.ply) || true
[ "${num_colored:-0}" -gt 1000 ] || problem "colorize_map coloured $num_colored of $num_points points"
