// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/block_reader.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cstring>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

constexpr std::size_t kMaxLine = 1 << 20;

}  // namespace

BlockReader::BlockReader(const std::string& path, std::size_t block_size)
    : file_(path, O_RDONLY), block_size_(block_size), size_(file_.size()) {}

bool BlockReader::fill() {
  block_start_ += block_.size();
  next_ = 0;
  block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(block_size_, size_ - block_start_)));
  file_.readAt(block_start_, block_.data(), block_.size());
  return !block_.empty();
}

bool BlockReader::readLine(std::string& line) {
  line.clear();
  bool found = false, any = false;
  while (!found && (next_ < block_.size() || fill())) {
    any = true;
    const char* first = block_.data() + next_;
    const auto available = block_.size() - next_;
    const auto* end = static_cast<const char*>(std::memchr(first, line_end_, available));
    found = end != nullptr;
    const auto length = found ? static_cast<std::size_t>(end - first) : available;
    line.append(first, length);
    next_ += length + (found ? 1 : 0);
    require(line.size() <= kMaxLine, path(), " is no cloud: it has a line of more than ", kMaxLine, " bytes");
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return any;
}

void BlockReader::startText() {
  static const std::string kMark = "\xEF\xBB\xBF";
  if (block_.empty()) fill();
  if (std::string(block_.data(), std::min(kMark.size(), block_.size())) == kMark) next_ = kMark.size();
  const auto end = std::find_if(block_.begin(), block_.end(), [](char c) { return c == '\n' || c == '\r'; });
  const bool is_alone =
      end != block_.end() && *end == '\r' && std::next(end) != block_.end() && *std::next(end) != '\n';
  if (is_alone) line_end_ = '\r';
}

void BlockReader::checkRemaining(std::uint64_t size) const {
  require(size <= remaining(), path(), " is truncated: ", size, " bytes are expected at byte ", position(),
          ", but only ", remaining(), " are there");
}

void BlockReader::read(void* bytes, std::size_t size) {
  checkRemaining(size);
  auto* target = static_cast<char*>(bytes);
  while (size > 0) {
    if (next_ == block_.size()) fill();
    const auto part = std::min(size, block_.size() - next_);
    std::memcpy(target, block_.data() + next_, part);
    next_ += part;
    target += part;
    size -= part;
  }
}

void BlockReader::skip(std::uint64_t size) {
  checkRemaining(size);
  if (size <= block_.size() - next_) {
    next_ += static_cast<std::size_t>(size);
    return;
  }
  block_start_ = position() + size;
  block_.clear();
  next_ = 0;
}

}  // namespace cloud_colorizer
