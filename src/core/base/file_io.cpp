// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/file_io.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>
#include <system_error>
#include <utility>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

constexpr std::size_t kBufferSize = 1 << 20;

[[noreturn]] void throwErrno(const char* what, const std::string& path, int error) {
  throw std::runtime_error(std::string("cannot ") + what + " " + path + ": " + std::generic_category().message(error));
}

/// As createTemporary() names them.
bool isTemporary(const std::string& name) {
  constexpr std::size_t kDigits = 16;
  const std::string ending = ".tmp";
  if (name.size() < ending.size() + kDigits + 2) return false;
  const std::size_t dot = name.size() - ending.size() - kDigits - 1;
  return name.compare(name.size() - ending.size(), ending.size(), ending) == 0 && name[dot] == '.' &&
         name.find_first_not_of("0123456789abcdef", dot + 1) == name.size() - ending.size();
}

/// A new file beside `path`. The name is random, since other machines may write into the same directory.
File createTemporary(const std::string& path) {
  std::random_device random;
  char suffix[32];
  std::snprintf(suffix, sizeof suffix, ".%08x%08x.tmp", random(), random());
  return File(path + suffix, O_WRONLY | O_CREAT | O_EXCL);
}

}  // namespace

File::File(std::string path, int flags) : path_(std::move(path)) {
  do {
    descriptor_ = ::open(path_.c_str(), flags | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) throwErrno((flags & O_CREAT) != 0 ? "create" : "open", path_, errno);
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

File::File(File&& other) noexcept : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

std::uint64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) throwErrno("examine", path_, errno);
  return static_cast<std::uint64_t>(status.st_size);
}

void File::readAt(std::uint64_t offset, void* bytes, std::size_t size) const {
  auto* next = static_cast<std::uint8_t*>(bytes);
  while (size > 0) {
    const auto num_read = ::pread(descriptor_, next, size, static_cast<off_t>(offset));
    if (num_read < 0 && errno == EINTR) continue;
    if (num_read < 0) throwErrno("read", path_, errno);
    require(num_read > 0, "cannot read ", path_, ": it ends at byte ", offset, ", ", size, " bytes early");
    next += num_read;
    offset += static_cast<std::uint64_t>(num_read);
    size -= static_cast<std::size_t>(num_read);
  }
}

void File::writeAt(std::uint64_t offset, const void* bytes, std::size_t size) {
  const auto* next = static_cast<const std::uint8_t*>(bytes);
  while (size > 0) {
    const auto num_written = ::pwrite(descriptor_, next, size, static_cast<off_t>(offset));
    if (num_written < 0 && errno == EINTR) continue;
    if (num_written < 0) throwErrno("write", path_, errno);
    next += num_written;
    offset += static_cast<std::uint64_t>(num_written);
    size -= static_cast<std::size_t>(num_written);
  }
}

void File::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) throwErrno("truncate", path_, errno);
}

bool File::tryLock(bool exclusive) {
  if (::flock(descriptor_, (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0) return true;
  if (errno != EWOULDBLOCK) throwErrno("lock", path_, errno);
  return false;
}

void File::sync() {
  if (::fsync(descriptor_) != 0) throwErrno("write", path_, errno);
}

void File::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) throwErrno("write", path_, errno);
}

MappedFile::MappedFile(const std::string& path, std::size_t size) : size_(size) {
  const File file(path, O_RDONLY);
  require(file.size() >= size, "cannot read ", path, ": it has ", file.size(), " of ", size, " bytes");
  if (size == 0) return;
  data_ = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.descriptor(), 0);
  if (data_ == MAP_FAILED) throwErrno("map", path, errno);
}

MappedFile::~MappedFile() {
  if (size_ > 0) ::munmap(data_, size_);
}

AtomicFile::AtomicFile(const std::string& path) : path_(path), file_(createTemporary(path)) {
  // Tells that somebody writes it; a file system without locks only keeps what is abandoned.
  (void)::flock(file_.descriptor(), LOCK_EX | LOCK_NB);
}

AtomicFile::~AtomicFile() {
  if (!committed_) ::unlink(file_.path().c_str());
}

void AtomicFile::append(const void* bytes, std::size_t size) {
  if (buffer_.size() + size > kBufferSize) writeBuffer();
  if (size > kBufferSize) {
    file_.writeAt(num_written_, bytes, size);
    num_written_ += size;
    return;
  }
  const auto* first = static_cast<const std::uint8_t*>(bytes);
  buffer_.insert(buffer_.end(), first, first + size);
}

void AtomicFile::writeBuffer() {
  file_.writeAt(num_written_, buffer_.data(), buffer_.size());
  num_written_ += buffer_.size();
  buffer_.clear();
}

void AtomicFile::commit(bool durable) {
  writeBuffer();
  if (durable) file_.sync();
  file_.close();
  if (std::rename(file_.path().c_str(), path_.c_str()) != 0) throwErrno("write", path_, errno);
  committed_ = true;
}

void removeAbandonedFiles(const std::string& directory, const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  for (fs::directory_iterator it(directory, error), end; !error && it != end; it.increment(error)) {
    const std::string found = it->path().filename().string();
    if (!isTemporary(found) || found.compare(0, name.size(), name) != 0) continue;
    try {
      if (File(it->path().string(), O_RDWR).tryLock(true)) ::unlink(it->path().c_str());
    } catch (const std::runtime_error&) {
      // Gone meanwhile, or not ours to remove.
    }
  }
}

void writeFileAtomically(const std::string& path, const void* bytes, std::size_t size) {
  AtomicFile file(path);
  file.append(bytes, size);
  file.commit(false);
}

std::vector<std::uint8_t> readFile(const std::string& path) {
  const File file(path, O_RDONLY);
  std::vector<std::uint8_t> bytes(file.size());
  file.readAt(0, bytes.data(), bytes.size());
  return bytes;
}

}  // namespace cloud_colorizer
