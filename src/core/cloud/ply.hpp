// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Headers of PLY files.
#pragma once

#include "cloud/block_reader.hpp"
#include "cloud/cloud_layout.hpp"

namespace cloud_colorizer {

/// Reads the header; the reader then stands at the first point. Throws std::runtime_error with file and reason.
CloudHeader readPlyHeader(BlockReader& input);

}  // namespace cloud_colorizer
