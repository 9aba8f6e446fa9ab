// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Colours for points that no view saw.
#pragma once

#include "map/workspace.hpp"

namespace cloud_colorizer {

/// Gives the points of a tile that no view saw the colour of the nearest coloured point within fill_distance, in this
/// tile or a neighbouring one. Their view_count stays 0.
void fillUncolored(const Workspace& work, std::size_t tile, TileColors& colors);

}  // namespace cloud_colorizer
