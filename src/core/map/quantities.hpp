// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is seen of a chunk's points beside their colours.
#pragma once

#include <functional>
#include <vector>

#include "cloud_colorizer/surface/zorder.hpp"
#include "map/workspace.hpp"

namespace cloud_colorizer {

struct SeenQuantities {
  Values fields;               ///< a row for each field of the recording's quantities, one after the other
  std::vector<Unseen> unseen;  ///< of each point, by the views of all quantities
  Eigen::VectorXi count;       ///< views of the quantity that most views tell
};

/// `views_of`: those that may see the points.
SeenQuantities seeQuantities(Workspace& work, const Surface& surface, const ZOrderGrid& grid,
                             const std::function<std::vector<std::size_t>(const Quantity&)>& views_of);

}  // namespace cloud_colorizer
