// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Reads a file front to back, lines and bytes, in large blocks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/file_io.hpp"

namespace cloud_colorizer {

class BlockReader {
 public:
  explicit BlockReader(const std::string& path);

  const std::string& path() const { return file_.path(); }
  std::uint64_t remaining() const { return size_ - position(); }  ///< bytes to the end of the file

  bool readLine(std::string& line);  ///< without its end (\n or \r\n); false at the end of the file
  void read(void* bytes, std::size_t size);
  void skip(std::uint64_t size);

 private:
  std::uint64_t position() const { return block_start_ + next_; }
  bool fill();

  File file_;
  std::uint64_t size_ = 0;
  std::vector<char> block_;
  std::uint64_t block_start_ = 0;
  std::size_t next_ = 0;  ///< in the block
};

}  // namespace cloud_colorizer
