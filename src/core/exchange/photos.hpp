// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The images that a model names, as the files that people have of them: scaled, turned, of 10 to 16 bits, with masks.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "camera/pixels.hpp"
#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/exchange/import_model.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

/// A file that was checked.
class Photo {
 public:
  Photo(std::string path, cv::Size size) : path_(std::move(path)), size_(size) {}

  cv::Size size() const { return size_; }  ///< px
  int bits() const { return bits_; }       ///< of 16 bits a channel, those that are filled; 16 of others
  void setBits(int bits) { bits_ = bits; }
  void setMask(std::string path) { mask_path_ = std::move(path); }

  EncodedImage encoded() const;  ///< the file as it is, or with the full scale of its bits
  ViewPixels decoded() const;    ///< with its mask. Throws std::runtime_error where it is damaged
  /// A part of it, without loss where the file has none.
  EncodedImage encodedFace(const cv::Mat& rgb) const;
  cv::Mat1b mask() const;  ///< of its size; empty: none. Throws std::runtime_error where it is no image

 private:
  std::string path_, mask_path_;
  cv::Size size_;
  int bits_ = 16;
};

/// In the order of the model. What cannot be decoded passes, with the size of its camera: the colouring leaves it out.
/// Throws std::runtime_error: a file that is missing, or of another shape than its camera.
std::vector<Photo> checkPhotos(const ModelFiles& files, const ColmapModel& model, const Callbacks& callbacks);

/// Of photos that are larger or smaller than the model says by the same factor on both sides.
Intrinsics scaledTo(const Intrinsics& camera, cv::Size size);

/// The file in `folder` that belongs to the image `name`. COLMAP calls that of a/b.jpg a/b.jpg.png; others a/b.png.
/// Empty where there is none.
std::string findBeside(const std::string& folder, const std::string& name, const std::vector<std::string>& extensions);

/// What is said of many files at once: the first one's name, and how many there are.
class Notice {
 public:
  void add(const std::string& name) {
    if (count_++ == 0) first_ = name;
  }
  void log(const Callbacks& callbacks, LogLevel level, const std::string& text) const {
    if (count_ == 0 || !callbacks.log) return;
    const std::string others = count_ > 1 ? " (and " + std::to_string(count_ - 1) + " more)" : "";
    callbacks.log(level, first_ + others + ": " + text);
  }
  std::size_t count() const { return count_; }

 private:
  std::string first_;
  std::size_t count_ = 0;
};

}  // namespace cloud_colorizer
