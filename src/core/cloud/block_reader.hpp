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
  explicit BlockReader(const std::string& path, std::size_t block_size = 1 << 20);

  const std::string& path() const { return file_.path(); }
  std::uint64_t remaining() const { return size_ - position(); }  ///< bytes to the end of the file

  /// Without its end (\n or \r\n, or \r alone where startText() found it); false at the end of the file. Throws
  /// std::runtime_error beyond 1 MiB.
  bool readLine(std::string& line);
  /// At the start of a file: passes over a byte order mark, and finds out whether its lines end with \r alone, as those
  /// of old Macs do.
  void startText();
  /// Throw std::runtime_error, and move nothing, when fewer bytes are left.
  void read(void* bytes, std::size_t size);
  void skip(std::uint64_t size);

 private:
  std::uint64_t position() const { return block_start_ + next_; }
  bool fill();
  void checkRemaining(std::uint64_t size) const;

  File file_;
  std::size_t block_size_;
  std::uint64_t size_ = 0;
  std::vector<char> block_;
  std::uint64_t block_start_ = 0;
  std::size_t next_ = 0;  ///< in the block
  char line_end_ = '\n';
};

}  // namespace cloud_colorizer
