# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""Numbers about coloured maps (binary PLY files), for the tests of the programs.

ply.py count MAP      number of points, of coloured points (view_count > 0), of points that are not black
ply.py compare A B    mean absolute difference of the channels of two maps with the same points, 0 to 255
"""
import struct
import sys

CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d",
         "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f",
         "float64": "d"}


def read(path):
    """List of (x, y, z, red, green, blue, view_count)."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    names, layout, count = [], "<", 0
    for line in data[:end].decode().splitlines():
        words = line.split()
        if words[0] == "format" and words[1] != "binary_little_endian":
            sys.exit(f"{path} is {words[1]}")
        if words[0] == "element":
            count = int(words[2])
        if words[0] == "property":
            names.append(words[2])
            layout += CODES[words[1]]
    if len(data) - end != count * struct.calcsize(layout):
        sys.exit(f"{path} has {len(data) - end} bytes after its header, not {count * struct.calcsize(layout)}")
    columns = [names.index(name) for name in ("x", "y", "z", "red", "green", "blue", "view_count")]
    return [tuple(row[i] for i in columns) for row in struct.iter_unpack(layout, data[end:])]


def main():
    if sys.argv[1] == "count":
        points = read(sys.argv[2])
        print(len(points), sum(p[6] > 0 for p in points), sum(p[3:6] != (0, 0, 0) for p in points))
    else:
        a, b = (sorted(read(path)) for path in sys.argv[2:4])
        if [p[:3] for p in a] != [p[:3] for p in b]:
            sys.exit("the maps have other points")
        both = [(p, q) for p, q in zip(a, b) if p[6] > 0 and q[6] > 0]
        if not both:
            sys.exit("no point is coloured in both maps")
        print(sum(abs(p[i] - q[i]) for p, q in both for i in (3, 4, 5)) / (3 * len(both)))


main()
