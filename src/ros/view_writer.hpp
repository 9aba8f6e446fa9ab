// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Writes views into a recording, in order, while other threads encode the raw images among them.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <functional>
#include <future>
#include <string>
#include <vector>

#include "camera/panorama.hpp"
#include "camera/pixels.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/collector.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/encoder_pool.hpp"

namespace cloud_colorizer {

/// A face of a panorama, and its camera in the recording.
struct PendingFace {
  PanoramaFace face;
  std::uint32_t id = 0;
};

/// What an encoder makes of an image or a face of it, and the mask that belongs to that.
struct EncodedPixels {
  EncodedImage image;
  cv::Mat1b mask;
};

/// A view whose image may still be with an encoder.
struct PendingView {
  std::size_t camera = 0;  ///< of the collector
  std::uint32_t id = 0;    ///< of the recording
  double stamp = 0;
  Eigen::Isometry3d map_from_camera;
  Twist readout_motion = Twist::Zero();  ///< see View::readout_motion
  Intrinsics intrinsics;
  SharedBytes bytes;  ///< of a compressed image, as received
  std::string extension;
  ImageKind kind = ImageKind::kColor;
  bool is_decoded = false;         ///< a compressed image that is not kept as received: a mosaic, or scaled to 16 bits
  cv::Mat1b mask;                  ///< of this view alone; empty: none
  int bits = 16;                   ///< of 16 bits a channel, those that are filled
  std::vector<PendingFace> faces;  ///< of a panorama: what is recorded instead of it
  /// Of a raw image, of one that is decoded, or of each face.
  std::future<std::vector<EncodedPixels>> encoded;
};

class ViewWriter {
 public:
  using Kept = std::function<void(const PendingView&)>;

  /// `kept` is called for every view that is written.
  ViewWriter(int num_threads, const std::string& raw_image_format, Kept kept);

  /// Takes a view with its image; waits for the first ones when too many are in work.
  void add(PendingView view, const sensor_msgs::ImageConstPtr& raw, Recorder& recorder);
  void add(PendingView view, const sensor_msgs::CompressedImageConstPtr& compressed, Recorder& recorder);
  void writeReady(Recorder& recorder) { write(kMaxEncoding, recorder); }
  void writeAll(Recorder& recorder) { write(0, recorder); }
  void clear() { views_.clear(); }
  std::size_t numPending() const { return views_.size(); }

 private:
  static constexpr std::size_t kMaxEncoding = 8;  // images in work

  template <class MessagePtr>
  std::future<std::vector<EncodedPixels>> encode(const MessagePtr& message, const PendingView& view,
                                                 const std::string& format);
  void record(const PendingView& view, Recorder& recorder);
  /// Writes the views that are encoded, and waits where more than `max_left` would be left.
  void write(std::size_t max_left, Recorder& recorder);

  std::string raw_image_format_;
  Kept kept_;
  std::deque<PendingView> views_;
  EncoderPool<std::vector<EncodedPixels>> pool_;  ///< last: its threads end before what they use
};

}  // namespace cloud_colorizer
