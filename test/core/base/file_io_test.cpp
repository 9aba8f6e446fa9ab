// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/file_io.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

TEST(FileIo, WholeFileReplacesTheOldOne) {
  ScratchDirectory scratch;
  writeText(scratch / "a", "old");
  writeFileAtomically(scratch / "a", "new!", 4);
  EXPECT_EQ(readText(scratch / "a"), "new!");
  const auto bytes = readFile(scratch / "a");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "new!");
  writeFileAtomically(scratch / "a", nullptr, 0);
  EXPECT_EQ(readFile(scratch / "a").size(), 0U);
  EXPECT_EQ(scratch.numFiles(), 1U);
}

TEST(FileIo, WithoutCommitNothingRemains) {
  ScratchDirectory scratch;
  {
    AtomicFile file(scratch / "a");
    const std::string large(3 << 20, 'x');
    file.append(large.data(), large.size());
    EXPECT_EQ(scratch.numFiles(), 1U);
  }
  EXPECT_EQ(scratch.numFiles(), 0U);
}

TEST(FileIo, WhatAKilledProgramLeftIsRemovedAndWhatIsBeingWrittenStays) {
  ScratchDirectory scratch;
  writeText(scratch / "map.ply.0123456789abcdef.tmp", "half");
  writeText(scratch / "other.ply.0123456789abcdef.tmp", "half");
  writeText(scratch / "map.ply.mine.tmp", "mine");
  AtomicFile file(scratch / "map.ply");
  removeAbandonedFiles(scratch.path(), "map.ply.");
  const auto exists = [&](const char* name) { return std::filesystem::exists(scratch / name); };
  EXPECT_FALSE(exists("map.ply.0123456789abcdef.tmp"));
  EXPECT_TRUE(exists("other.ply.0123456789abcdef.tmp"));
  EXPECT_TRUE(exists("map.ply.mine.tmp"));
  file.commit(false);
  EXPECT_TRUE(exists("map.ply"));
}

TEST(FileIo, ErrorsNameThePathAndTheReason) {
  ScratchDirectory scratch;
  EXPECT_ERROR(readFile(scratch / "none"), "none: No such file or directory");
  EXPECT_ERROR(writeFileAtomically(scratch / "none/a", "x", 1), "No such file or directory");
  writeText(scratch / "a", "four");
  const File file(scratch / "a", O_RDONLY);
  char bytes[8];
  EXPECT_ERROR(file.readAt(0, bytes, sizeof bytes), "ends at byte 4, 4 bytes early");
}

TEST(FileIo, FullDiskIsReportedAndTheOldFileStays) {
  ScratchDirectory scratch;
  if (!scratch.mountDisk("size=64k")) GTEST_SKIP() << "no right to mount a small disk";
  writeText(scratch / "a", "old");
  const std::string large(1 << 18, 'x');
  EXPECT_ERROR(writeFileAtomically(scratch / "a", large.data(), large.size()), "No space left on device");
  EXPECT_EQ(readText(scratch / "a"), "old");
  EXPECT_EQ(scratch.numFiles(), 1U);
}

TEST(File, ALockIsSharedOrNotAndOtherFailuresSayTheirReason) {
  ScratchDirectory scratch;
  const std::string path = scratch / "lock";
  File first(path, O_RDWR | O_CREAT), second(path, O_RDONLY);
  EXPECT_TRUE(first.tryLock(false));
  EXPECT_TRUE(second.tryLock(false));
  EXPECT_FALSE(second.tryLock(true));
  first.close();
  EXPECT_TRUE(second.tryLock(true));
  EXPECT_ERROR(first.tryLock(true), "cannot lock " + path);
}

}  // namespace
}  // namespace cloud_colorizer
