// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Derived files: arrays one after the other, native byte order, and a checksum at the end.
#pragma once

#include <fcntl.h>

#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/file_io.hpp"

namespace cloud_colorizer {

using Checksum = std::uint32_t;

class BlobWriter {
 public:
  template <class T>
  void add(const T* data, std::size_t count) {
    const std::size_t before = blob_.size();
    blob_.resize(before + count * sizeof(T));
    if (count > 0) std::memcpy(blob_.data() + before, data, count * sizeof(T));
  }
  template <class Matrix>
  void add(const Matrix& matrix) {
    add(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  /// Does not wait for the disk: what a power failure tears can be made again.
  void save(const std::string& path);

 private:
  std::vector<std::uint8_t> blob_;
};

/// The content of a file without its checksum; nothing where the file is not there or not what was written.
std::optional<std::vector<std::uint8_t>> readWholeBlob(const std::string& path);

/// Whether a file is there with that many bytes before its checksum, and what was written.
bool isWholeBlob(const std::string& path, std::size_t size);

/// All of a file that is whole. Throws std::runtime_error on one that is not.
class BlobReader {
 public:
  explicit BlobReader(const std::string& path) : BlobReader(path, readWholeBlob(path)) {}
  BlobReader(std::string path, std::optional<std::vector<std::uint8_t>> blob);

  template <class T>
  void read(T* data, std::size_t count) {
    requireWhole(count <= (blob_.size() - next_) / sizeof(T));
    if (count > 0) std::memcpy(data, blob_.data() + next_, count * sizeof(T));
    next_ += count * sizeof(T);
  }
  template <class Matrix>
  void read(Matrix& matrix) {
    read(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }
  template <class T>
  T read() {
    T value{};
    read(&value, 1);
    return value;
  }

 private:
  void requireWhole(bool whole) const;

  std::string path_;
  std::vector<std::uint8_t> blob_;
  std::size_t next_ = 0;
};

/// Pieces of a file that an earlier look found whole: no other byte of it is read. Throws std::runtime_error where the
/// file is shorter.
class BlobPieces {
 public:
  explicit BlobPieces(const std::string& path, std::uint64_t offset = 0) : file_(path, O_RDONLY), next_(offset) {}

  template <class T>
  void read(T* data, std::size_t count) {
    file_.readAt(next_, data, count * sizeof(T));
    next_ += count * sizeof(T);
  }
  template <class Matrix>
  void read(Matrix& matrix) {
    read(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }

 private:
  File file_;
  std::uint64_t next_;
};

}  // namespace cloud_colorizer
