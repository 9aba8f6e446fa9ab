// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The header of the binary PCD v0.7 files that we write.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Header of x, y, z (float, or double) followed by `fields`, packed. The number of points always takes ten digits, so
/// that it can be updated in place.
std::string pcdHeader(const std::vector<Field>& fields, bool double_positions, std::uint64_t num_points);

}  // namespace cloud_colorizer
