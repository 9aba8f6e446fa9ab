// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/text_lines.hpp"

#include <cmath>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

LineFile::LineFile(const std::string& path) : path_(path), stream_(path) {
  require(stream_.is_open(), "cannot open ", path);
}

bool LineFile::next(std::string& line) {
  ++number_;
  if (!std::getline(stream_, line)) return false;
  if (number_ == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);  // of an editor under Windows
  return true;
}

bool LineFile::nextEntry(std::string& line) {
  while (next(line)) {
    if (isEntry(line)) return true;
  }
  return false;
}

bool LineFile::isEntry(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r");
  return first != std::string::npos && line[first] != '#';
}

double finiteNumber(const std::string& word, const std::string& where) {
  double number = 0;
  require(parseDouble(word, number) && std::isfinite(number), where, ": \"", word, "\" is no number");
  return number;
}

Eigen::Isometry3d checkedPose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation,
                              const std::string& where) {
  require(std::abs(rotation.norm() - 1) < 0.01, where, ": its quaternion has the norm ", rotation.norm(),
          ", which must be 1");
  require(translation.allFinite(), where, ": its translation is not finite");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

}  // namespace cloud_colorizer
