# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""Small clouds as other programs write them, for dialects.sh.

dialects.py DIR               writes them
dialects.py compare A B       mean absolute difference of two .ppm pictures, 0 to 255
"""
import math
import pathlib
import struct
import sys

CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
# A chequered floor with two unequal towers; every channel reaches 255 and differs.
POINTS = [(x, y, height, (85 * (x % 4), 51 * (y % 6), 255 if height else 17 * (x + y)))
          for x in range(6) for y in range(5) for height in range(1 + (x == 4) * 3 + (y == 1))]


def write_ply(path, properties, rows):
    """`properties`: (type, name) after x, y and z."""
    text = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n"
    text += "".join(f"property {kind} {name}\n" for kind, name in [("float", axis) for axis in "xyz"] + properties)
    layout = "<fff" + "".join(CODES[kind] for kind, _ in properties)
    path.write_bytes((text + "end_header\n").encode() + b"".join(struct.pack(layout, *row) for row in rows))


def write_pcd(path, name, kind, packed):
    text = (f"VERSION .7\nFIELDS x y z {name}\nSIZE 4 4 4 4\nTYPE F F F {kind}\nCOUNT 1 1 1 1\nWIDTH {len(POINTS)}\n"
            f"HEIGHT 1\nPOINTS {len(POINTS)}\nDATA binary\n")
    path.write_bytes(text.encode() + b"".join(struct.pack("<fffI", x, y, z, packed(*color))
                                              for x, y, z, color in POINTS))


def channels(kind, names="rgb"):
    full = {"r": "red", "g": "green", "b": "blue"}
    return [(kind, full[name]) for name in names]


def colored(change=lambda value: value):
    return [(x, y, z, *map(change, color)) for x, y, z, color in POINTS]


def write_all(folder):
    folder.mkdir()
    write_ply(folder / "reference.ply", channels("uchar"), colored())
    write_ply(folder / "optical.ply", channels("uchar"), [(x, -z, y, *color) for x, y, z, color in POINTS])
    for kind in "int", "uint", "float", "double", "short":
        write_ply(folder / f"color_{kind}.ply", channels(kind), colored())
    write_ply(folder / "color_ushort.ply", channels("ushort"), colored(lambda value: 257 * value))
    for kind in "float", "double":
        write_ply(folder / f"color_unit_{kind}.ply", channels(kind), colored(lambda value: value / 255))
    write_ply(folder / "color_bgr.ply", [("double", "time"), *channels("uchar", "bgr")],
              [(x, y, z, 1e9, *color[::-1]) for x, y, z, color in POINTS])
    write_ply(folder / "color_nan.ply", channels("uchar"),
              [*colored(), (math.nan, 1, 2, 9, 9, 9), (1, math.inf, 2, 9, 9, 9)])
    write_pcd(folder / "color_rgb.pcd", "rgb", "F", lambda r, g, b: r << 16 | g << 8 | b)
    write_pcd(folder / "color_rgba.pcd", "rgba", "U", lambda r, g, b: 255 << 24 | r << 16 | g << 8 | b)
    for kind in CODES:
        is_whole = kind not in ("float", "double")
        rows = [(x, y, z, int(x + 2 * y) if is_whole else x + 0.5 * y) for x, y, z, _ in POINTS]
        write_ply(folder / f"field_{'whole' if is_whole else 'broken'}_{kind}.ply", [(kind, "number")], rows)


def pixels(path):
    return pathlib.Path(path).read_bytes().split(b"255\n", 1)[1]


if sys.argv[1] == "compare":
    one, two = map(pixels, sys.argv[2:])
    print(sum(abs(a - b) for a, b in zip(one, two)) / len(one))
else:
    write_all(pathlib.Path(sys.argv[1]))
