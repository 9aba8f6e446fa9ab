// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The stages between a recording and its coloured tiles, and the units that each is made of.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/color/tone.hpp"
#include "map/workspace.hpp"

namespace cloud_colorizer {

/// Units from `first` on, up to and without `last`.
struct UnitRange {
  std::size_t first = 0, last = 0;

  std::size_t size() const { return last - first; }
};

/// Of each unit of a stage, the names of its files.
using UnitFiles = std::vector<std::vector<std::string>>;

/// A stage does those of its units that are not done yet, in parallel, each into files of its own. So several programs
/// may do different units of one stage at the same time, and the same ones without harm.
struct Stage {
  const char* name;                ///< as people give it
  const char* unit;                ///< what its units are, for people
  const char* folder;              ///< of the recording, where its files are
  std::vector<std::string> after;  ///< stages that must be whole before
  /// What each unit has to do, in the order of the map or of time: points or views. None where the parameters do not
  /// ask for the stage.
  std::function<std::vector<double>(const Workspace&)> units;
  std::function<std::string(const Workspace&)> key;  ///< what the files are made from
  std::function<UnitFiles(const Workspace&)> files;  ///< in the folder
  std::function<void(Workspace&, UnitRange, const Callbacks&)> run;
  /// Hands what was found to the stages that follow; null where they read the files themselves.
  std::function<void(Workspace&, const Callbacks&)> handOn;
};

/// In their order: each needs some of those before it.
const std::vector<Stage>& allStages();

Stage imageStage();      ///< for each view: is its image whole? Throws when none is
Stage movingStage();     ///< for each tile: what later and earlier scans saw through
Stage surfelStage();     ///< for each block of tiles: what closes the surface between the points
Stage alignmentStage();  ///< for all views: exposures, and small corrections of the poses
Stage depthStage();      ///< for each view: what it can see of the whole map
Stage colorStage();      ///< for each chunk: observe, graph, system, solve; eq. (1)-(5). Radiances of its tiles

/// m, side of the cells in which the colour stage sums up the exposures.
double toneCellSize(const Recording& recording);
/// m, side of the cells in which it tells sheen from colours: some hundred points of a surface.
double sheenCellSize(const Recording& recording);
/// From the radiances of the coloured tiles to what is shown.
ToneField makeTone(const Workspace& work);

/// Depth image of the whole map for a view at any pose. Asks `callbacks` (takingTurns) at each tile whether to go on.
DepthImage renderDepth(Workspace& work, std::size_t view, const Eigen::Isometry3d& map_from_camera,
                       const Callbacks& callbacks);

}  // namespace cloud_colorizer
