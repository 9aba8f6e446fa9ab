#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# A map that a Dask scheduler's workers colour in parts, one of which is killed at work: the bytes of a single run.
. "$(dirname "$0")/common.bash"
. "$(dirname "$0")/spread.bash"
make_recording

export DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=100ms
port=$((20000 + RANDOM % 10000))
address=tcp://127.0.0.1:$port
dask-scheduler --host 127.0.0.1 --port "$port" --no-dashboard >"$tmp/scheduler.log" 2>&1 &
background+=($!)
for name in n1 n2; do
  # In a session of its own, so that a worker can be killed with its program, as when its machine is switched off.
  NODE=$name setsid dask-worker "$address" --name "$name" --nthreads 1 --no-dashboard --no-nanny --local-directory "$tmp/$name" \
    >"$tmp/$name.log" 2>&1 &
  worker=$!
  background+=("$worker")
done
(await_victim && kill -KILL -- "-$worker") &
expect 0 'merge 1/1 is done' scripts/spread_dask "$recording" --scheduler "$address" --output "$tmp/parts.ply" --parts 3 \
  --colorize "$tmp/colorize" "${params[@]}"
expect_the_same
grep -q 'surfels' "$tmp/victim" || problem "no worker was killed at work"
! kill -0 "$worker" 2>/dev/null || problem "the worker lives"

expect 1 'error: surfels .*exit code 2: error: .*lambda' scripts/spread_dask "$recording" --scheduler "$address" \
  --output "$tmp/parts.ply" --retries 0 --colorize "$tmp/colorize_without_lambda"
expect 2 'error: the following arguments are required: --scheduler' scripts/spread_dask "$recording" --output "$tmp/parts.ply"
