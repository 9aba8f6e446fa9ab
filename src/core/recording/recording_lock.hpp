// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The directory of a recording that is being filled: made, locked against other programs, and watched.
#pragma once

#include <string>

#include "base/file_io.hpp"

namespace cloud_colorizer {

class RecordingLock {
 public:
  /// Takes a new directory, a recording, or what is left of one that crashed at once; never somebody's home.
  explicit RecordingLock(const std::string& directory);

  /// Whether the directory is still the one that was locked.
  bool isInPlace() const;

 private:
  File file_;
};

}  // namespace cloud_colorizer
