// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The folder of a recording that a program makes: the user's own, or a new one that is removed at the end.
#pragma once

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

class RecordingFolder {
 public:
  /// `keep` is the user's folder; where it is empty, a new folder is made beside the file `output`.
  RecordingFolder(const std::string& keep, const std::string& output) : path_(keep), remove_(keep.empty()) {
    if (!remove_) return;
    path_ = output + ".XXXXXX";
    require(mkdtemp(path_.data()) != nullptr, "cannot make a temporary folder ", path_, ": ", std::strerror(errno));
  }
  ~RecordingFolder() {
    std::error_code ignored;
    if (remove_) std::filesystem::remove_all(path_, ignored);
  }
  RecordingFolder(const RecordingFolder&) = delete;
  RecordingFolder& operator=(const RecordingFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  bool remove_;
};

}  // namespace cloud_colorizer
