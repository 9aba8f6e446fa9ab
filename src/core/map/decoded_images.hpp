// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The images of a recording, each decoded once.
#pragma once

#include <memory>
#include <string>

#include "base/file_io.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "map/lru_cache.hpp"

namespace cloud_colorizer {

/// In memory as far as they fit there. Where not all do, and the disk has room, their pixels also go into a folder of
/// the recording, from which only those that a part of the map falls on are read. Safe to use from several threads and,
/// where none is `alone`, from several programs, which share them. `name` tells one version of the images from others.
class DecodedImages {
 public:
  DecodedImages(const Recording& recording, std::size_t max_bytes, const std::string& name, bool alone);
  ~DecodedImages();  ///< removes the folder, where alone
  DecodedImages(const DecodedImages&) = delete;
  DecodedImages& operator=(const DecodedImages&) = delete;

  /// Where the pixels of a recording's images are while it is coloured.
  static std::string folderOf(const Recording& recording) { return recording.directory() + "/decoded"; }

  /// As Recording::readPixels(), whose errors it throws.
  std::shared_ptr<const ViewPixels> get(std::size_t view);

 private:
  struct Decoded {
    ViewPixels pixels;
    std::shared_ptr<const MappedFile> file;  ///< that holds them; null where they are in memory
  };

  Decoded load(std::size_t view);
  void prepareFolder();

  Recording recording_;
  std::size_t max_bytes_;
  std::string folder_;  ///< of the pixels
  bool alone_;
  std::once_flag prepared_;
  bool on_disk_ = false;
  LruCache<Decoded> images_;
};

}  // namespace cloud_colorizer
