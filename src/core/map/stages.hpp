// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The stages between a recording and its coloured tiles. Each does what is not done yet, in parallel, unit by unit.
#pragma once

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/tone.hpp"
#include "map/workspace.hpp"

namespace cloud_colorizer {

/// Leaves out the views whose image cannot be used, and names them in the log. Throws when none is left.
void checkImages(Workspace& work, const Callbacks& callbacks);
/// Votes of all scans on every point: does it belong to something that moved?
void findMoving(Workspace& work, const Callbacks& callbacks);
void makeSurfels(Workspace& work, const Callbacks& callbacks);
void alignViews(Workspace& work, const Callbacks& callbacks);
void makeDepthImages(Workspace& work, const Callbacks& callbacks);
/// The radiances of all tiles, and what their tone needs to know of them.
void colorChunks(Workspace& work, const Callbacks& callbacks);

/// m, side of the cells in which colorChunks() sums up the exposures.
double toneCellSize(const Recording& recording);
/// From the radiances of the coloured tiles to what is shown.
ToneField makeTone(const Workspace& work);

/// Depth image of the whole map for a view at any pose. Asks `callbacks` (takingTurns) at each tile whether to go on.
DepthImage renderDepth(Workspace& work, std::size_t view, const Eigen::Isometry3d& map_from_camera,
                       const Callbacks& callbacks);

}  // namespace cloud_colorizer
