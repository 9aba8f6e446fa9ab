// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Coordinate reference systems of maps.
#pragma once

#include <string>

namespace cloud_colorizer {

/// "EPSG:25832", "EPSG:25832+5783" (with heights), or well-known text of any kind, as the well-known text of version 1
/// that LAS files have. Throws std::invalid_argument where PROJ does not know it.
std::string wellKnownText(const std::string& crs);

inline bool isWellKnownText(const std::string& crs) {
  return crs.find('[') != std::string::npos;
}

}  // namespace cloud_colorizer
