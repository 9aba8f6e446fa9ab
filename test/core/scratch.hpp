// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Scratch directories for tests that write files.
#pragma once

#include <sys/mount.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace cloud_colorizer {

class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "cloud_colorizer_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot create " + pattern);
    path_ = pattern;
  }
  ~ScratchDirectory() {
    if (is_mounted_) umount2(path_.c_str(), MNT_DETACH);
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

  /// Puts a small disk there; false without the right to mount.
  bool mountDisk(const char* size_option) {
    is_mounted_ = mount("tmpfs", path_.c_str(), "tmpfs", 0, size_option) == 0;
    return is_mounted_;
  }

  std::size_t numFiles() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) count += entry.is_regular_file();
    return count;
  }

 private:
  std::string path_;
  bool is_mounted_ = false;
};

inline std::string readText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void writeText(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// The message of the exception that `f` throws; empty when it throws none.
template <class F>
std::string messageOf(F&& f) {
  try {
    f();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

/// Expects that `f` throws an exception whose message holds `part`.
#define EXPECT_ERROR(statement, part)                                       \
  do {                                                                      \
    const auto message = messageOf([&] { statement; });                     \
    EXPECT_NE(message.find(part), std::string::npos) << "got: " << message; \
  } while (false)

}  // namespace cloud_colorizer
