// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Cameras as COLMAP writes them: https://colmap.github.io/cameras.html
#pragma once

#include <string>

#include "cloud_colorizer/camera/camera.hpp"
#include "exchange/colmap_entries.hpp"

namespace cloud_colorizer {

constexpr double kColmapPixelCentre = 0.5;  ///< COLMAP's first pixel centre; ours is 0

/// Throws std::runtime_error, with the place, on a model that is unknown or that our lenses cannot follow.
Intrinsics intrinsicsOfColmap(const ColmapEntries::Camera& camera);

/// A line of cameras.txt.
std::string colmapCameraLine(std::size_t id, const Intrinsics& k);

}  // namespace cloud_colorizer
