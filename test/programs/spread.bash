# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# What the tests of spread_dask and spread_slurm share.
params=(max_chunk_points=2000)

# Makes $recording, $tmp/whole.ply coloured from it by one program, and $tmp/colorize: the first time that node n2 makes
# surfels, it stops in the middle of them and tells so in $tmp/victim.
make_recording() {
  make_drive "$tmp/drive"
  recording=$tmp/recording
  expect 0 'saved' colorize_bag "$tmp/drive/drive.bag" --recording "$recording" --output "$tmp/whole.ply" tile_size=5 "${params[@]}"
  forget "$recording"
  rm -rf "$recording/damaged_images"
  cat >"$tmp/colorize" <<PROGRAM
#!/usr/bin/env bash
node=\${SLURMD_NODENAME:-\${NODE:-}}
if [ "\$node" = n2 ] && [[ "\$*" = *surfels* ]] && mkdir "$tmp/first" 2>/dev/null; then
  $(command -v colorize) "\$@" &
  while ! compgen -G "$recording/surfels/*.bin" >/dev/null && kill -0 \$!; do sleep 0.01; done
  kill -STOP \$! && echo "\$*" >"$tmp/victim"
  wait
fi
exec $(command -v colorize) "\$@"
PROGRAM
  cat >"$tmp/colorize_without_lambda" <<PROGRAM
#!/usr/bin/env bash
case "\$*" in *surfels*) set -- "\$@" lambda=-1 ;; esac
exec $(command -v colorize) "\$@"
PROGRAM
  chmod +x "$tmp"/colorize*
}

await_victim() {
  local tries
  for ((tries = 0; tries < 600; ++tries)); do
    [ ! -s "$tmp/victim" ] || return 0
    sleep 0.1
  done
  return 1
}

expect_the_same() { cmp "$tmp/whole.ply" "$tmp/parts.ply" || problem "another map in parts than of one program"; }
