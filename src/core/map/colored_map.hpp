// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is done with the coloured tiles.
#pragma once

#include "cloud_colorizer/map/colorize.hpp"
#include "map/workspace.hpp"

namespace cloud_colorizer {

/// Counts the coloured points and why the others are not.
ColorizeSummary summarize(const Workspace& work);

/// Gives the points of a tile that no view saw the colour of the nearest coloured point within fill_distance, in this
/// tile or a neighbouring one. Their view_count stays 0.
void fillUncolored(const Workspace& work, std::size_t tile, TileColors& colors);

}  // namespace cloud_colorizer
