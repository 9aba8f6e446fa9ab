// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The pose of a view that took no part in an alignment, on the trajectory that the others were corrected to.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "cloud_colorizer/camera/view.hpp"

namespace cloud_colorizer {

/// map_from_camera of `view` with the correction of its neighbours in time of the same camera: between the one before
/// and the one after it, by time. Where neighbours are a second or more away (photographs, say), the view moves with
/// the map: by the rigid motion that the corrections of all views have in common.
/// `corrected`: map_from_camera of `views` as corrected.
Eigen::Isometry3d poseOnTrajectory(const View& view, const std::vector<View>& views,
                                   const std::vector<Eigen::Isometry3d>& corrected);

}  // namespace cloud_colorizer
