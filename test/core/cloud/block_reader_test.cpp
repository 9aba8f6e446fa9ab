// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/block_reader.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

std::string randomText(std::size_t size) {
  std::mt19937 random(7);
  std::string text(size, ' ');
  for (auto& c : text) c = random() % 40 == 0 ? '\n' : static_cast<char>('a' + random() % 26);
  return text;
}

std::string readBytes(BlockReader& reader, std::size_t size) {
  std::string bytes(size, '\0');
  reader.read(bytes.data(), size);
  return bytes;
}

TEST(BlockReader, EmptyFileHasNothing) {
  ScratchDirectory scratch;
  writeText(scratch / "a", "");
  BlockReader reader(scratch / "a");
  std::string line = "before";
  EXPECT_EQ(reader.remaining(), 0U);
  EXPECT_FALSE(reader.readLine(line));
  EXPECT_EQ(line, "");
  EXPECT_NO_THROW(readBytes(reader, 0));
  EXPECT_NO_THROW(reader.skip(0));
  EXPECT_ERROR(readBytes(reader, 1), "a is truncated: 1 bytes are expected at byte 0, but only 0");
  EXPECT_ERROR(BlockReader(scratch / "none"), "No such file");
}

TEST(BlockReader, LinesEndAnyWay) {
  ScratchDirectory scratch;
  writeText(scratch / "a", "one\n\r\ntwo\r\n\nlast");
  BlockReader reader(scratch / "a");
  std::string line;
  for (const char* expected : {"one", "", "two", "", "last"}) {
    EXPECT_TRUE(reader.readLine(line));
    EXPECT_EQ(line, expected);
  }
  EXPECT_FALSE(reader.readLine(line));
}

/// Whatever the size of the blocks, also one byte, and wherever their borders are.
TEST(BlockReader, BlocksDoNotShow) {
  ScratchDirectory scratch;
  const auto text = randomText(300);
  writeText(scratch / "a", text);
  for (const std::size_t block : {1, 2, 7, 64, 299, 300, 301}) {
    BlockReader reader(scratch / "a", block);
    std::string line;
    ASSERT_TRUE(reader.readLine(line));
    std::size_t at = line.size() + 1;
    EXPECT_EQ(line, text.substr(0, at - 1));
    for (const std::size_t size : {1, 5, 0, 64, 20}) {
      EXPECT_EQ(readBytes(reader, size), text.substr(at, size)) << block;
      at += size;
      reader.skip(size / 2);
      at += size / 2;
      EXPECT_EQ(reader.remaining(), text.size() - at);
    }
    ASSERT_TRUE(reader.readLine(line));
    EXPECT_EQ(line, text.substr(at, text.find('\n', at) - at)) << block;
  }
}

TEST(BlockReader, RecordLargerThanManyBlocks) {
  ScratchDirectory scratch;
  const auto text = randomText(5'000'000);
  writeText(scratch / "a", text);
  BlockReader reader(scratch / "a");
  EXPECT_EQ(readBytes(reader, 1), text.substr(0, 1));
  EXPECT_EQ(readBytes(reader, 4'000'000), text.substr(1, 4'000'000));
  reader.skip(999'990);
  EXPECT_EQ(readBytes(reader, 9), text.substr(4'999'991));
  EXPECT_EQ(reader.remaining(), 0U);
}

TEST(BlockReader, WhatIsNotThereIsSaidAndNothingIsTaken) {
  ScratchDirectory scratch;
  writeText(scratch / "a", "0123456789");
  BlockReader reader(scratch / "a", 4);
  reader.skip(3);
  EXPECT_ERROR(readBytes(reader, 8), "8 bytes are expected at byte 3, but only 7 are there");
  EXPECT_ERROR(reader.skip(8), "8 bytes are expected at byte 3, but only 7 are there");
  EXPECT_ERROR(reader.skip(~0ULL), "but only 7 are there");
  EXPECT_EQ(readBytes(reader, 7), "3456789");
}

TEST(BlockReader, LineWithoutEndIsNoCloud) {
  ScratchDirectory scratch;
  writeText(scratch / "a", std::string(3 << 20, 'x'));
  BlockReader reader(scratch / "a");
  std::string line;
  EXPECT_ERROR(reader.readLine(line), "it has a line of more than 1048576 bytes");
}

}  // namespace
}  // namespace cloud_colorizer
