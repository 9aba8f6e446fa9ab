// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/blob.hpp"

#include <zlib.h>

#include <filesystem>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

Checksum checksum(const std::uint8_t* bytes, std::size_t size) {
  return static_cast<Checksum>(crc32_z(0, bytes, size));
}

}  // namespace

void BlobWriter::save(const std::string& path) {
  const Checksum sum = checksum(blob_.data(), blob_.size());
  add(&sum, 1);
  writeFileAtomically(path, blob_.data(), blob_.size());
}

std::optional<std::vector<std::uint8_t>> readWholeBlob(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  std::vector<std::uint8_t> bytes = readFile(path);
  if (bytes.size() < sizeof(Checksum)) return std::nullopt;
  Checksum found = 0;
  const std::size_t size = bytes.size() - sizeof(found);
  std::memcpy(&found, bytes.data() + size, sizeof(found));
  if (found != checksum(bytes.data(), size)) return std::nullopt;
  bytes.resize(size);
  return bytes;
}

bool isWholeBlob(const std::string& path, std::size_t size) {
  std::error_code error;
  if (std::filesystem::file_size(path, error) != size + sizeof(Checksum) || error) return false;
  return readWholeBlob(path).has_value();
}

BlobReader::BlobReader(std::string path, std::optional<std::vector<std::uint8_t>> blob) : path_(std::move(path)) {
  requireWhole(blob.has_value());
  blob_ = *std::move(blob);
}

void BlobReader::requireWhole(bool whole) const {
  require(whole, "cannot use ", path_, ": it is missing or damaged; colour the recording again, it will be made anew");
}

}  // namespace cloud_colorizer
