// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Headers of PCD files: any that can be read, and the binary v0.7 that we write.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud/block_reader.hpp"
#include "cloud/cloud_layout.hpp"

namespace cloud_colorizer {

/// Reads the header; the reader then stands at the first point. Throws std::runtime_error with file and reason.
CloudHeader readPcdHeader(BlockReader& input);

/// Header of x, y, z (float, or double) followed by `fields`, packed. The number of points always takes ten digits, so
/// that it can be updated in place.
std::string pcdHeader(const std::vector<Field>& fields, bool double_positions, std::uint64_t num_points);

}  // namespace cloud_colorizer
