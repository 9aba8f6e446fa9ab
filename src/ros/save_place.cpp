// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/save_place.hpp"

#include <algorithm>
#include <filesystem>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

bool isBelow(const fs::path& path, const fs::path& directory) {
  const auto [rest, unused] = std::mismatch(directory.begin(), directory.end(), path.begin(), path.end());
  return rest == directory.end();
}

fs::path withoutLinks(const fs::path& path, const std::string& what) {
  std::error_code error;
  fs::path resolved = fs::canonical(path, error);
  require(!error, what, path.string(), ": ", error.message(), "; create it first");
  return resolved;
}

}  // namespace

SavePlace::SavePlace(const std::string& directory)
    : directory_(withoutLinks(fs::absolute(directory), "cannot use ~save_dir ").string()) {}

std::string SavePlace::resolve(const std::string& path, bool overwrite) const {
  require(path.find('\0') == std::string::npos, "cannot write ", path.c_str(), ": the path has a byte 0 in it");
  const fs::path asked = fs::path(directory_) / path;  // an absolute path stays as it is
  const fs::path folder = withoutLinks(asked.parent_path(), "cannot write into ");
  const fs::path file = folder / asked.filename();
  require(isBelow(folder, directory_), "cannot write ", path, ": it lies outside ", directory_,
          "; give a path below it, or start the node with another ~save_dir");
  for (fs::path above = folder; isBelow(above, directory_); above = above.parent_path()) {
    require(!fs::exists(above / "recording.yaml"), "cannot write ", path, ": ", above.string(),
            " is a recording; give a path beside it");
    if (above == above.root_path()) break;
  }
  CloudWriter::checkPath(file.string());
  const fs::file_status status = fs::symlink_status(file);
  if (!fs::exists(status)) return file.string();
  require(fs::is_regular_file(status), "cannot write ", path, ": it is a link, a device or something else that is no ",
          "regular file; give another name");
  const std::lock_guard<std::mutex> lock(mutex_);
  require(overwrite || own_.count(file.string()) > 0, "cannot write ", path,
          ": the file is there already; give another name, or overwrite: true");
  return file.string();
}

void SavePlace::own(const std::string& file) {
  const std::lock_guard<std::mutex> lock(mutex_);
  own_.insert(file);
}

}  // namespace cloud_colorizer
