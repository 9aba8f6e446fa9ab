// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_lock.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <filesystem>

#include "cloud_colorizer/base/check.hpp"
#include "recording/recording_files.hpp"

namespace cloud_colorizer {
namespace {

void prepareDirectory(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  require(!error, "cannot create the recording ", directory, ": ", error.message());
  if (hasRecording(directory)) return;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const auto name = entry.path().filename().string();
    require(name == "recorder.lock" || name.rfind("recording.yaml", 0) == 0, "cannot record into ", directory,
            ": it holds other files (", name, ") and no recording.yaml; give a new directory");
  }
}

}  // namespace

RecordingLock::RecordingLock(const std::string& directory)
    : file_((prepareDirectory(directory), directory + "/recorder.lock"), O_RDWR | O_CREAT) {
  require(file_.tryLock(true), "another program is recording into ", directory,
          "; stop it, or record into another directory");
}

bool RecordingLock::isInPlace() const {
  struct stat locked = {}, found = {};
  return ::fstat(file_.descriptor(), &locked) == 0 && ::stat(file_.path().c_str(), &found) == 0 &&
         locked.st_dev == found.st_dev && locked.st_ino == found.st_ino;
}

}  // namespace cloud_colorizer
