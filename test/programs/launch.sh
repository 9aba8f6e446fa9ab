#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
#
# The launch files take any number of cameras, and one is the default everywhere.
. "$(dirname "$0")/common.bash"

# launched ARGUMENTS...: the command line and the parameters that the node would get.
launched() { roslaunch --args /colorizer "$@" >"$tmp/log" 2>&1; roslaunch --dump-params "$@" >>"$tmp/log" 2>&1; }
gives() { grep -qF -- "$1" "$tmp/log" || { problem "nothing of '$1'"; cat "$tmp/log"; }; }

[ "$(colorizer_node --defaults | sed -n 's/^num_cameras: *\([0-9]*\).*/\1/p')" = 1 ] || problem "the node has another default"
for file in launch/colorize.launch launch/replay.launch; do
  launched "$file" bag:=drive.bag
  gives "num_cameras: 1"
  gives "camera_0/image:=camera_0/image "
  launched "$file" bag:=drive.bag cameras:="/front  /left /right /rear up down" image:=image_raw
  gives "num_cameras: 6"
  gives " camera_0/image:=/front/image_raw camera_0/camera_info:=/front/camera_info camera_1/image:=/left/image_raw "
  gives " camera_5/image:=down/image_raw camera_5/camera_info:=down/camera_info cloud_in:=cloud_in "
  launched "$file" bag:=drive.bag num_cameras:=5 camera_1:=/left
  gives "num_cameras: 5"
  gives " camera_1/image:=/left/image "
  gives " camera_4/image:=camera_4/image "
done
