// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/trajectory_file.hpp"

#include <cmath>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "exchange/text_lines.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kTum = 8, kKitti = 12;  // numbers

/// Exactly, which a double of today's seconds is not.
std::int64_t nanoseconds(const std::string& word, const std::string& where) {
  double seconds = 0;
  require(parseDouble(word, seconds) && seconds >= 0 && seconds < 4e9, where, ": \"", word,
          "\" is no stamp in seconds");
  const auto point = word.find('.');
  long long whole = 0, fraction = 0;
  std::string digits = point == std::string::npos ? "" : word.substr(point + 1, 9);
  digits.resize(9, '0');
  const bool is_plain = parseInteger(word.substr(0, point), whole) && parseInteger(digits, fraction);
  return is_plain ? whole * 1'000'000'000 + fraction : std::llround(seconds * 1e9);
}

Eigen::Isometry3d poseOfMatrix(const std::vector<double>& v, const std::string& where) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t col = 0; col < 4; ++col) {
      pose.matrix()(static_cast<int>(row), static_cast<int>(col)) = v[4 * row + col];
    }
  }
  const Eigen::Matrix3d r = pose.linear();
  require((r * r.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.01 && r.determinant() > 0, where,
          ": its 3 x 3 part is no rotation");
  pose.linear() = Eigen::Quaterniond(r).normalized().toRotationMatrix();
  return pose;
}

}  // namespace

std::vector<TrajectoryPose> readTrajectory(const std::string& path) {
  LineFile file(path);
  std::vector<TrajectoryPose> poses;
  std::size_t num_words = 0;
  for (std::string line; file.nextEntry(line);) {
    const std::string where = file.where();
    const auto words = splitWords(line);
    if (num_words == 0) num_words = words.size();
    require(words.size() == num_words && (num_words == kTum || num_words == kKitti), where, ": ", words.size(),
            " numbers; a pose is `stamp x y z qx qy qz qw` (TUM) or the 12 numbers of a matrix (KITTI)");
    std::vector<double> v;
    v.reserve(words.size());
    for (const std::string& word : words) v.push_back(finiteNumber(word, where));
    TrajectoryPose pose;
    if (num_words == kKitti) {
      pose.map_from_base = poseOfMatrix(v, where);
    } else {
      pose.stamp = nanoseconds(words[0], where);
      require(poses.empty() || *poses.back().stamp < *pose.stamp, where,
              ": its stamp is not after that of the pose before");
      pose.map_from_base = checkedPose({v[7], v[4], v[5], v[6]}, {v[1], v[2], v[3]}, where);
    }
    poses.push_back(pose);
  }
  require(!poses.empty(), path, " has no poses");
  return poses;
}

}  // namespace cloud_colorizer
