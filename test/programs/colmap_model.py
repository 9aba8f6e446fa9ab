# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""colmap_model.py RECORDING MODEL: a recording's cameras and views as COLMAP's text files, for the tests."""
import csv
import os
import sys

import yaml


def rotate(q, v):
    """Rotates v by the unit quaternion q = (x, y, z, w)."""
    x, y, z, w = q
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]]


recording, model = sys.argv[1:3]
os.makedirs(model, exist_ok=True)
with open(f"{recording}/recording.yaml") as file:
    origin = yaml.safe_load(file)["origin"]
with open(f"{recording}/cameras.yaml") as file:
    cameras = yaml.safe_load(file)
cameras = cameras["cameras"] if isinstance(cameras, dict) else cameras
with open(f"{model}/cameras.txt", "w") as file:
    for i, camera in enumerate(cameras, start=1):
        # COLMAP has pixel centres at +0.5. Higher terms of the distortion are left out: OPENCV has four.
        numbers = [camera["fx"], camera["fy"], camera["cx"] + 0.5, camera["cy"] + 0.5] + camera["distortion"][:4]
        print(i, "OPENCV", camera["width"], camera["height"], *numbers, file=file)
with open(f"{recording}/views.csv") as views, open(f"{model}/images.txt", "w") as file:
    for i, view in enumerate(csv.DictReader(views), start=1):
        x, y, z, w = (float(view[name]) for name in ("qx", "qy", "qz", "qw"))
        position = [float(view[name]) + o for name, o in zip("xyz", origin)]
        translation = [-t for t in rotate((-x, -y, -z, w), position)]
        name = os.path.relpath(view["image"], "images")
        print(i, w, -x, -y, -z, *translation, int(view["camera"]) + 1, name, file=file)
        print(file=file)
