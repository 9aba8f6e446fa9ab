// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Score of a recording without truth: the map coloured without some views must predict their images.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "evaluation/table.hpp"

namespace cloud_colorizer {

struct HeldoutParams {
  int every = 8;            ///< every n-th view of a camera is left out
  double moved_error = 60;  ///< of 255; where even the median of the views misses the image by more than this, the
                            ///< surface moved or reflects: such points are counted and left out of the trimmed mean
  std::vector<Method> methods = {Method::kClosest, Method::kMean, Method::kMedian, Method::kPaper, Method::kDefault};
  Params params;  ///< of the methods

  void check() const;
};

/// Views that are left out: of each camera every n-th, beginning in the middle of the first n.
std::vector<std::size_t> heldoutViews(const std::vector<View>& views, int every);

/// A recording in `directory` that has the cameras and points of `recording` (as links) but only the given views.
Recording withViews(const Recording& recording, const std::vector<std::size_t>& views, const std::string& directory);

struct HeldoutResult {
  ResultTable methods;  ///< one row a method: errors over all held-out images
  ResultTable views;    ///< one row a method and view
};

/// Colours the map by each method without the held-out views, in `directory`/training, and predicts their images at
/// the visible points. Writes `directory`/view_<n>.png (image, prediction, overlay, error) for the last method.
/// Throws std::runtime_error when no view is held out or none is left.
HeldoutResult scoreHeldout(const Recording& recording, const HeldoutParams& params, const std::string& directory,
                           const Callbacks& callbacks);

}  // namespace cloud_colorizer
