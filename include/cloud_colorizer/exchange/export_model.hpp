// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The poses that a map was coloured with, for other programs.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// Writes into `directory`, which is made when missing, in the map frame (the recording's origin added):
///   cameras.txt images.txt points3D.txt   COLMAP's text model, without points; all our camera models are COLMAP's too
///   trajectory_camera_i.txt               TUM: stamp tx ty tz qx qy qz qw of map_from_camera, one file a camera
/// The poses are the corrected ones when colorize() aligned the recording with these parameters, else the recorded
/// ones. `names`: of the images, one a view; empty: their files relative to the recording's folder `images`.
/// Each file is complete or absent. Throws std::runtime_error with path and reason.
void exportModel(const Recording& recording, const Params& params, const std::string& directory,
                 const std::vector<std::string>& names = {});

}  // namespace cloud_colorizer
