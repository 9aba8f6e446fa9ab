// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the text files of other programs have in common. Errors are std::runtime_error; `where`: file and line, for
/// them.
#pragma once

#include <Eigen/Geometry>
#include <fstream>
#include <string>

namespace cloud_colorizer {

/// The lines of a text file, with their numbers for messages.
class LineFile {
 public:
  explicit LineFile(const std::string& path);
  bool next(std::string& line);
  /// The next line that is neither empty nor a comment (#).
  bool nextEntry(std::string& line);
  static bool isEntry(const std::string& line);
  std::string where() const { return path_ + " line " + std::to_string(number_); }

 private:
  std::string path_;
  std::ifstream stream_;
  std::size_t number_ = 0;
};

/// Throws for a word that is no number, or none that is finite.
double finiteNumber(const std::string& word, const std::string& where);

/// Throws for a quaternion whose norm is not 1 (to a hundredth, it is normalized), or a translation that is not finite.
Eigen::Isometry3d checkedPose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation,
                              const std::string& where);

}  // namespace cloud_colorizer
