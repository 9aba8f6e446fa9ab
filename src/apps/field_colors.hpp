// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The numbers of a field of a map as colours.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Measured values (NAME beside NAME_views) on the scale of what is between their least and greatest hundredth; classes
/// (NAME beside NAME_confidence) each in a colour of its own; other numbers from 0 to 20. Grey where there is none.
class FieldColors {
 public:
  /// Reads the map once where that tells the range. `low`, `high`: where given, the ends of the scale. Throws
  /// std::runtime_error where the map has no such field.
  FieldColors(const std::string& path, const std::string& name, std::optional<float> low, std::optional<float> high);

  Values operator()(const Cloud& cloud) const;  ///< 3 x n
  void drawBar(cv::Mat& picture) const;         ///< in its lower left corner, with the ends of the scale

 private:
  std::optional<float> numberAtPoint(const Cloud& cloud, std::size_t i) const;
  void findRange(const std::string& path);

  std::string name_;
  std::size_t record_size_;
  LocatedField field_;
  std::optional<LocatedField> known_;  ///< 0 where the number says nothing
  bool is_class_ = false;
  float low_ = 0, high_ = 20;
};

}  // namespace cloud_colorizer
