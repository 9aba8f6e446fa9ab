// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whether a COLMAP model can belong to a cloud, asked before anything is made of them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "cloud_colorizer/exchange/colmap.hpp"

namespace cloud_colorizer {

/// One warning for each thing that looks wrong, with what to do: rotations that were written in another order, or
/// inverted; points of the model that lie beside the cloud, as those of another frame or scale do, or that its images
/// did not see where it says. `samples` [m] are some thousand points spread over the cloud.
std::vector<std::string> doubtsAbout(const ColmapModel& model, const std::vector<Eigen::Vector3d>& samples);

}  // namespace cloud_colorizer
