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

}  // namespace cloud_colorizer
