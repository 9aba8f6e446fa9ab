// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Files whose errors carry the path and the reason, and files that are complete or absent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace cloud_colorizer {

/// An open file. Every function throws std::runtime_error with the path and the system's reason.
class File {
 public:
  /// `flags` as for open(2); a new file gets the permissions that the umask leaves.
  File(std::string path, int flags);
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;

  const std::string& path() const { return path_; }
  int descriptor() const { return descriptor_; }
  std::uint64_t size() const;
  void readAt(std::uint64_t offset, void* bytes, std::size_t size) const;  ///< throws when the file is shorter
  void writeAt(std::uint64_t offset, const void* bytes, std::size_t size);
  void truncate(std::uint64_t size);
  bool tryLock(bool exclusive);  ///< until it is closed; false when another program's lock forbids it
  void sync();                   ///< until the disk has it
  void close();                  ///< reports what a network or quota disk only reports here

 private:
  std::string path_;
  int descriptor_ = -1;
};

/// The first bytes of a file; only what is touched is read. The file must keep them while this lives.
class MappedFile {
 public:
  /// Throws std::runtime_error with the path and the reason, also when the file is shorter.
  MappedFile(const std::string& path, std::size_t size);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::uint8_t* data() const { return static_cast<const std::uint8_t*>(data_); }
  std::size_t size() const { return size_; }

 private:
  void* data_ = nullptr;
  std::size_t size_;
};

/// A file written front to back under a temporary name beside `path`, in large blocks, and renamed by commit():
/// `path` holds either its old or its whole new content. Without commit() the temporary file is removed.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void append(const void* bytes, std::size_t size);
  /// `durable`: wait until the disk has the bytes, so that even a power failure leaves a whole file.
  void commit(bool durable);

 private:
  void writeBuffer();

  std::string path_;
  File file_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t num_written_ = 0;
  bool committed_ = false;
};

/// Removes what programs that were killed left of an AtomicFile: of those in the directory whose name begins with
/// `name`.
void removeAbandonedFiles(const std::string& directory, const std::string& name = "");

/// Writes `bytes` to `path` through a temporary name; throws std::runtime_error with the reason.
void writeFileAtomically(const std::string& path, const void* bytes, std::size_t size);

/// The whole content of a file.
std::vector<std::uint8_t> readFile(const std::string& path);

}  // namespace cloud_colorizer
