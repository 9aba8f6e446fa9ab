// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Where ~save_map may write: any program on the network can call it.
#pragma once

#include <mutex>
#include <set>
#include <string>

namespace cloud_colorizer {

class SavePlace {
 public:
  /// Throws std::runtime_error when `directory` does not exist.
  explicit SavePlace(const std::string& directory);

  /// The file's name without links. Relative paths are below the directory. Throws std::runtime_error, with the remedy:
  /// outside of it, inside a recording, not .ply, .pcd or .las, no regular file, or one that is there already and
  /// neither `overwrite` nor of our own writing.
  std::string resolve(const std::string& path, bool overwrite) const;
  /// `file` is our own from now on.
  void own(const std::string& file);

 private:
  std::string directory_;  ///< without links
  mutable std::mutex mutex_;
  std::set<std::string> own_;
};

}  // namespace cloud_colorizer
