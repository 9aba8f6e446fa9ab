// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// One camera of the collector: its camera_info, the images and masks that wait, and the keyframes that it chose.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "cloud_colorizer/ros/collector.hpp"
#include "ros/transform_buffer.hpp"
#include "ros/view_writer.hpp"

namespace cloud_colorizer {

/// An image of either kind.
struct ImageMessage {
  std_msgs::Header header;
  sensor_msgs::ImageConstPtr raw;
  sensor_msgs::CompressedImageConstPtr compressed;

  static ImageMessage of(const sensor_msgs::ImageConstPtr& raw) { return {raw->header, raw, nullptr}; }
  static ImageMessage of(const sensor_msgs::CompressedImageConstPtr& compressed) {
    return {compressed->header, nullptr, compressed};
  }
};

/// Says something about a camera: how bad it is, a word for its kind (those of one kind are throttled), and the text.
using Say = std::function<void(LogLevel, const char* kind, const std::string& text)>;

class CameraStream {
 public:
  /// Reads the mask file; throws std::runtime_error when it cannot be read.
  CameraStream(const CameraParams& params, std::size_t number);

  const std::string& name() const { return name_; }
  const CameraParams& params() const { return params_; }
  const sensor_msgs::CameraInfoConstPtr& info() const { return info_; }
  const Eigen::Vector3d& baseline() const { return baseline_; }  ///< m, of P, in the frame of the camera_info
  /// The image's frame, or where it has none the camera_info's. Throws Refused.
  std::string frameOf(const ImageMessage& image) const;

  void takeInfo(const sensor_msgs::CameraInfoConstPtr& message, double max_image_size, Recorder& into, const Say& say);
  /// The camera of another recording.
  void enter(Recorder& into, double max_image_size, const Say& say);
  void takeMask(ImageMessage mask);

  /// Id and intrinsics. Throws NotYet, or Refused where there is no good camera_info.
  PendingView newView(const ImageMessage& image, double max_image_size, Recorder& into);
  /// Whether an earlier program recorded this view; of a panorama the faces that it recorded are taken out. A bag that
  /// is read again chooses the keyframes that it chose the first time: by what lies before them in the bag.
  bool isRecorded(PendingView& view, Recorder& recorder);
  bool isKeyframe(const Eigen::Isometry3d& pose, const RecordParams& record) const;
  /// Of a camera whose last keyframe lies in a recording that is continued.
  void resumeAt(const Eigen::Isometry3d& pose, double stamp);
  /// Looks at the image, and completes the view by its bits and its mask. Throws Refused, or NotYet while its mask may
  /// come.
  void inspect(const ImageMessage& image, PendingView& view, const Say& say);
  void keep(const PendingView& view) { last_kept_ = view.map_from_camera; }
  void dropMasksBefore(ros::Time stamp);

  std::deque<ImageMessage> queue;

 private:
  void readInfo(Recorder& into, double max_image_size, const Say& say);
  PendingView newPanorama(const ImageMessage& image, double max_image_size, Recorder& into);
  void checkSize(double max_image_size);
  int bitsOfCamera(const ImageMessage& image, const Say& say);
  cv::Mat1b maskOf(const ImageMessage& image) const;

  CameraParams params_;
  std::string name_;
  cv::Mat1b mask_;                        ///< of the file
  sensor_msgs::CameraInfoConstPtr info_;  ///< the newest
  std::optional<std::uint32_t> id_;       ///< in the recording; set when the camera_info is good
  std::vector<PendingFace> faces_;        ///< of a panorama, from its first image on
  Intrinsics intrinsics_;
  int bits_ = 0;                                     ///< of images with 16 bits a channel; 0: none came yet
  Eigen::Vector3d baseline_{0, 0, 0};                ///< m
  Refused info_error_{Outcome::kBadCameraInfo, ""};  ///< why there is no id
  std::optional<Eigen::Isometry3d> last_kept_;
  std::optional<double> resumed_at_;  ///< s, newest stamp that an earlier program recorded; until the first image
  std::deque<ImageMessage> masks_;    ///< by arrival
};

}  // namespace cloud_colorizer
