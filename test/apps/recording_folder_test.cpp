// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/recording_folder.hpp"

#include <gtest/gtest.h>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

/// Runs `work` on a folder beside map.ply, then tells the folder and what was logged.
template <class Work>
std::pair<std::string, std::string> runIn(const ScratchDirectory& scratch, Work work) {
  std::string path, log;
  Callbacks callbacks;
  callbacks.log = [&](LogLevel, const std::string& line) { log += line; };
  try {
    RecordingFolder folder("", scratch / "map.ply", callbacks);
    path = folder.path();
    EXPECT_TRUE(std::filesystem::is_directory(path));
    work(folder);
  } catch (const std::runtime_error&) {
  }
  return {path, log};
}

TEST(RecordingFolder, IsRemovedAfterSuccess) {
  ScratchDirectory scratch;
  const auto [path, log] = runIn(scratch, [](RecordingFolder& folder) {
    folder.setWhole();
    folder.setDone();
  });
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(log, "");
}

TEST(RecordingFolder, IsRemovedWhenCollectingFails) {
  ScratchDirectory scratch;
  const auto [path, log] = runIn(scratch, [](RecordingFolder&) { throw std::runtime_error("no such topic"); });
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_EQ(log, "");
}

TEST(RecordingFolder, IsKeptAndNamedWhenALaterStepFailsOrIsStopped) {
  ScratchDirectory scratch;
  const auto [path, log] = runIn(scratch, [](RecordingFolder& folder) {
    folder.setWhole();
    throw Cancelled();
  });
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_NE(log.find("`colorize " + path + " --output " + (scratch / "map.ply") + "`"), std::string::npos) << log;
}

TEST(RecordingFolder, OfTheUserStays) {
  ScratchDirectory scratch;
  std::filesystem::create_directories(scratch / "mine");
  { const RecordingFolder folder(scratch / "mine", scratch / "map.ply", {}); }
  EXPECT_TRUE(std::filesystem::exists(scratch / "mine"));
}

}  // namespace
}  // namespace cloud_colorizer
