// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// PLY files: the header of any that can be read, and the binary little endian that we write.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud/block_reader.hpp"
#include "cloud/cloud_layout.hpp"

namespace cloud_colorizer {

/// Reads the header; the reader then stands at the first point. Throws std::runtime_error with file and reason.
CloudHeader readPlyHeader(BlockReader& input);

/// How many items of a list in a binary file follow; the reader stands at its length.
std::uint64_t readListLength(BlockReader& input, FieldType type, Encoding encoding);

/// The faces of a mesh, whose points CloudReader reads, as triangles: fans of those with more corners. None where the
/// file has points only. Throws std::runtime_error with file and reason, also for an index that no point has.
std::vector<Eigen::Vector3i> readPlyFaces(const std::string& path);

/// Header of x, y, z (float, or double) followed by `fields`: a packed rgb becomes uchar red, green, blue, and fields
/// that have these names already get the prefix "input_"; arrays become name_0, name_1, ...
std::string plyHeader(const std::vector<Field>& fields, bool double_positions, std::uint64_t num_points);
PackedFormat plyFormat(const std::vector<Field>& fields, bool double_positions);

}  // namespace cloud_colorizer
