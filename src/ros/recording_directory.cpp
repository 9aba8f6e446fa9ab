// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>

#include "ros/recording_session.hpp"

namespace cloud_colorizer {
namespace {

std::string dateAndTime() {
  const std::time_t now = std::time(nullptr);
  std::tm local = {};
  localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d-%H-%M-%S", &local);
  return text;
}

/// The first of `name`, `name`_2, `name`_3, ... that does not exist.
std::string unusedName(const std::string& name) {
  std::string candidate = name;
  for (int i = 2; std::filesystem::exists(candidate); ++i) candidate = name + "_" + std::to_string(i);
  return candidate;
}

}  // namespace

std::string resolveRecordingDirectory(const std::string& recording_dir) {
  if (!recording_dir.empty()) return std::filesystem::absolute(recording_dir).lexically_normal().string();
  const char* ros_home = std::getenv("ROS_HOME");
  const char* home = std::getenv("HOME");
  const std::string base = ros_home != nullptr ? ros_home : std::string(home != nullptr ? home : "/tmp") + "/.ros";
  std::filesystem::create_directories(base + "/cloud_colorizer");
  return unusedName(base + "/cloud_colorizer/" + dateAndTime());
}

std::string setAside(const std::string& directory) {
  std::string name = directory;
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  std::string target = unusedName(name + "." + dateAndTime());
  std::filesystem::rename(name, target);
  return target;
}

}  // namespace cloud_colorizer
