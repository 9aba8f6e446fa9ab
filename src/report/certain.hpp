// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Of what a camera certainly saw, how much got a colour?
#pragma once

#include <nlohmann/json.hpp>

#include "map/workspace.hpp"
#include "report/map_sample.hpp"

namespace cloud_colorizer {

/// Share of the points in an image that a scan of that moment measured: nothing lay between the scanner, which is
/// beside the camera, and the point. Of some views, spread over the drive, and some points. Null where there are no
/// scans.
nlohmann::json certainlySeenColored(Workspace& work, const MapSample& sample);

}  // namespace cloud_colorizer
