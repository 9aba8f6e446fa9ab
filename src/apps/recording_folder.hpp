// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The folder of a recording that a program makes: the user's own, or a new one that is removed at the end. When the
/// work on a whole recording fails or is stopped, the new one is kept too, for it may have taken hours to make.
#pragma once

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

class RecordingFolder {
 public:
  /// `keep` is the user's folder; where it is empty, a new folder is made beside the file `output`.
  RecordingFolder(const std::string& keep, const std::string& output, const Callbacks& callbacks)
      : path_(keep), output_(output), callbacks_(callbacks), is_own_(keep.empty()) {
    if (!is_own_) return;
    path_ = output + ".XXXXXX";
    require(mkdtemp(path_.data()) != nullptr, "cannot make a temporary folder ", path_, ": ", std::strerror(errno));
  }
  ~RecordingFolder() {
    std::error_code ignored;
    if (is_own_ && !is_whole_) std::filesystem::remove_all(path_, ignored);
    if (is_own_ && is_whole_ && callbacks_.log) {
      callbacks_.log(LogLevel::kWarning, "the recording is kept in " + path_ + "; `colorize " + path_ + " --output " +
                                             output_ + "`, with the same parameters, goes on from here");
    }
  }
  RecordingFolder(const RecordingFolder&) = delete;
  RecordingFolder& operator=(const RecordingFolder&) = delete;

  const std::string& path() const { return path_; }
  void setWhole() { is_whole_ = true; }  ///< all is recorded
  void setDone() { is_whole_ = false; }  ///< nobody needs it any more

 private:
  std::string path_;
  std::string output_;
  Callbacks callbacks_;
  bool is_own_, is_whole_ = false;
};

}  // namespace cloud_colorizer
