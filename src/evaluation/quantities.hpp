// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How right are the measured values and the classes of a map?
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Of one field that both clouds have, over the points that some view tells of.
struct QuantityScore {
  std::string name;
  std::size_t num_points = 0;
  double coverage = 0;  ///< share of the truth's points
  bool is_class = false;
  double accuracy = 0;        ///< of a class: share of the points that have the right one
  double mean_error = 0;      ///< of a value: mean absolute error
  double error_of_views = 0;  ///< of a value: mean of 1 / sqrt(number of views), to be compared with the noise of one

  std::string describe() const;  ///< one line
};

/// Every point of the truth is compared with the nearest one of the result, if that is within `max_distance` [m].
/// Values are fields NAME beside NAME_views of the result, classes NAME beside NAME_confidence.
std::vector<QuantityScore> scoreQuantities(const Cloud& truth, const Cloud& result, double max_distance);

}  // namespace cloud_colorizer
