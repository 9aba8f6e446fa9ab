// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The runner: from a recording to a coloured map.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"
#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// What a stage took of a run that did it.
struct StageCost {
  std::string name;
  double seconds = 0, cpu_seconds = 0;
  double peak_megabytes = 0;  ///< resident, of the program up to its end
};

struct ColorizeSummary {
  std::size_t num_points = 0, num_colored = 0;
  std::array<std::size_t, 6> by_reason{};  ///< number of points, by Unseen
  std::size_t num_damaged_views = 0;       ///< left out, since their images cannot be used
  /// Root mean square difference of the views of a point from its colour, over that of the points from their mean; 0
  /// where too few points were seen twice. Near 1, the views tell no more about a point than about any other.
  double disagreement = 0;
  double seconds = 0;
  std::vector<StageCost> stages;  ///< in their order
  std::string describe() const;   ///< one line for the log
};

/// Colours every tile: surfels, depth images, (alignment,) chunks. A view whose image is damaged is left out. Finished
/// units of work are kept in the recording and used again when the same recording is coloured with the same parameters.
/// Throws std::runtime_error with reason and remedy when there is nothing to colour or from.
ColorizeSummary colorize(const Recording& recording, const Params& params, const Callbacks& callbacks);

/// map_from_camera of every view, relative to the origin: corrected when colorize() aligned the recording with these
/// parameters; as recorded where nothing was aligned. Throws when the alignment is of other parameters or views.
std::vector<Eigen::Isometry3d> usedPoses(const Recording& recording, const Params& params);

/// Fields of the coloured map: those of the recording (a clash gets the prefix "input_"; what an earlier run added is
/// replaced), then rgb (FLOAT32, packed), view_count (UINT16), color_stddev (FLOAT32), with `appearance` diffuse_red,
/// diffuse_green, diffuse_blue (FLOAT32) and specular (UINT8), with `moving: mark`, where the recording has scans,
/// moving (UINT8; from 128 on something that moved), and those of quantities that are no colours.
std::vector<Field> coloredFields(const Recording& recording, const Params& params);

/// The coordinate reference system that a saved .las names: the parameter's, else the recording's; empty: none.
std::string coloredCrs(const Recording& recording, const Params& params);

/// Visits the coloured map tile by tile (after colorize). Positions are relative to the origin where `relative`.
void forEachColoredTile(const Recording& recording, const Params& params, bool relative,
                        const std::function<void(const Cloud&)>& visit);

/// Writes the coloured map; returns the number of points written. A PCD of points far from 0 is relative to the
/// recording's origin, which originFile() beside it tells.
std::size_t saveColored(const Recording& recording, const Params& params, const std::string& path,
                        const Callbacks& callbacks);

/// Writes the coloured map as files of at most two million points, or one tile of the recording, each a cube of space:
/// `directory`/x_y_z`extension` (".ply", ".pcd" or ".las"), and tiles.json, which lists them with their boxes. Files of
/// an earlier such map that this one has not are removed. Returns the number of points.
std::size_t saveColoredTiles(const Recording& recording, const Params& params, const std::string& directory,
                             const std::string& extension, const Callbacks& callbacks);

}  // namespace cloud_colorizer
