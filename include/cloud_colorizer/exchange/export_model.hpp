// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The poses that a map was coloured with, for other programs.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

struct ExportedImages {
  std::vector<std::string> names;  ///< one a view; empty: their files relative to the recording's folder `images`
  /// The images are written as well, below `images`, as pinhole cameras would have taken them, which are then the
  /// cameras of the model: JPEG where the recording has it, else PNG. Those that cannot be decoded are left out.
  bool undistort = false;
};

/// Writes into `directory`, which is made when missing, in the map frame (the recording's origin added):
///   cameras.txt images.txt points3D.txt   COLMAP's text model, whose camera models ours are; without points
///   trajectory_camera_i.txt               TUM: stamp tx ty tz qx qy qz qw of map_from_camera, one file a camera
/// The poses are the corrected ones when colorize() aligned the recording with these parameters, else the recorded
/// ones. Each file is complete or absent. Throws std::runtime_error with path and reason.
void exportModel(const Recording& recording, const Params& params, const std::string& directory,
                 const ExportedImages& images = {}, const Callbacks& callbacks = {});

/// Writes the coloured points of the map (after colorize) into points3D.txt of that folder, every k-th so that there
/// are at most `max_points`: what programs that train Gaussian splats begin with. Their tracks are empty. Throws as
/// forEachColoredTile().
void exportPoints(const Recording& recording, const Params& params, const std::string& directory,
                  std::size_t max_points = 1'000'000);

/// Writes every k-th coloured point (after colorize), at most `max_splats`, as a Gaussian splat into a .ply as trainers
/// and viewers of splats have it: x y z nx ny nz f_dc_0..2 opacity scale_0..2 rot_0..3, without harmonics of higher
/// degree. A splat is as wide as the points are apart, and flat where they lie on a surface. Positions are relative to
/// the recording's origin, as floats. Throws as forEachColoredTile(); std::runtime_error where the file cannot be
/// written.
void exportSplats(const Recording& recording, const Params& params, const std::string& path,
                  std::size_t max_splats = 2'000'000);

}  // namespace cloud_colorizer
