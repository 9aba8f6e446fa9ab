// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// From messages to a recording: what the node and colorize_bag share.
///
/// Messages wait in one queue a topic until tf knows their exact stamp; nothing is extrapolated. Every queue is worked
/// off in its order of arrival, so the recording depends on the messages and not on threads or on when tf came.
#pragma once

#include <ros/time.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/recording/recorder.hpp"

namespace cloud_colorizer {

struct CameraParams {
  double time_offset = 0;  ///< s, added to the stamps of the images
  std::string mask;        ///< image file, black where the camera must not colour; empty: none
  bool masks = false;      ///< every image gets a mask of its own by addMask(); without it, it is not recorded
  /// camera_info: as that says; equirectangular: of all directions, twice as wide as high; there is no camera_info.
  std::string model = "camera_info";
  bool rectified = false;   ///< the images are rectified: P counts, without distortion
  double readout_time = 0;  ///< s from the first row of an image, at its stamp, to the last; 0: all at once
  /// Of images with 16 bits a channel: how many the camera fills; 0: as few of 10, 12, 14 and 16 as hold its first
  /// image.
  int bits = 0;
  ImageKind kind = ImageKind::kColor;
  std::string quantity;          ///< field of the map that the numbers give; empty: temperature, or label
  double scale = 1, offset = 0;  ///< radiometric: value = scale * number + offset
  std::string names;             ///< labels, logits: file that tells what the numbers mean, kept beside the map

  Quantity toldQuantity() const;
  bool isPanorama() const { return model == "equirectangular"; }
};

struct CollectorParams {
  std::string map_frame = "map";
  std::string sensor_frame;      ///< frame from which ranges are measured; empty: the cloud's own
  double tf_wait = 2;            ///< s of message time that a message waits for its transform
  double tf_max_gap = 0.5;       ///< s between two transforms of a frame that moves, which may be interpolated; 0: any
  double cloud_time_offset = 0;  ///< s, added to the stamps of the clouds
  /// Whether the motion of the sensor during a cloud is undone by the times of its points: on, off, or auto: where that
  /// makes the map thinner. Clouds whose points have no time are taken as they are.
  std::string deskew = "auto";
  /// ppm, png or jpg, of raw images. ppm is the default because OpenCV 4.6 needs about 200 ms for a 1 Mpixel PNG (1.6
  /// ms for a PPM, 11 ms for a JPEG), and 20 such images may come in a second.
  std::string raw_image_format = "ppm";
  int encode_threads = 1;       ///< threads that encode raw images
  double max_image_size = 200;  ///< Mpx; a camera_info with more is refused, before anything is allocated
  std::vector<CameraParams> cameras = std::vector<CameraParams>(1);
  RecordParams record;  ///< keyframe distance and angle

  void check() const;
};

/// What became of a message.
enum class Outcome {
  kKept,
  kNotKeyframe,
  kRecordedBefore,
  kNoTransform,
  kNoCameraInfo,
  kBadCameraInfo,
  kTooLarge,
  kSizeMismatch,
  kUndecodable,
  kNoMask,
  kMalformed,
  kNoStamp,
  kBadStamp,
  kTimeJump,
  kOverflow,
  kNumOutcomes
};
const char* toString(Outcome outcome);

/// Of the stamps of a topic [s]; first > last: there are none.
struct StampRange {
  double first = 1, last = 0;

  bool empty() const { return first > last; }
  void extend(double stamp) {
    first = empty() ? stamp : std::min(first, stamp);
    last = std::max(last, stamp);
  }
};

struct StreamStats {
  std::size_t received = 0;
  StampRange stamps;
  std::array<std::size_t, static_cast<std::size_t>(Outcome::kNumOutcomes)> outcomes{};
  std::string last_error;

  std::size_t count(Outcome outcome) const { return outcomes[static_cast<std::size_t>(outcome)]; }
};

struct CollectorStats {
  StreamStats cloud;
  std::vector<StreamStats> cameras;
  Recorder::InsertCounts points;
  std::size_t time_jumps = 0;
  std::size_t bad_transforms = 0;  ///< with a stamp that is out of range
  std::string last_tf_error;
  StampRange tf_stamps;

  std::string describe() const;  ///< one line a topic: "camera_0: 154 received, 120 kept, 34 not a keyframe"
  /// Why no point or no view was recorded, and what to do: what became of most messages, and its last reason.
  std::string whyNoPoints() const;
  std::string whyNoViews() const;
};

/// Bytes of an image file that are shared with whoever needs them.
using SharedBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

/// What the collector tells the outside; every member may be empty. Called from the thread that calls the collector.
struct CollectorEvents {
  /// Throttled: a kind of warning about a topic comes at most every ten seconds, with the number left out.
  std::function<void(LogLevel, const std::string&)> log;
  std::function<void(const Cloud&, const Eigen::Isometry3d& map_from_sensor, double stamp)> cloud_kept;
  /// The pose is in the map frame, not relative to the recording's origin.
  std::function<void(std::size_t camera, const View&, const Intrinsics&, const SharedBytes&)> view_kept;
};

/// Used from one thread at a time. What Recorder throws (a full disk) passes through; the message is then lost.
class Collector {
 public:
  /// Reads the masks; throws std::runtime_error when one cannot be read.
  Collector(Recorder& recorder, const CollectorParams& params, CollectorEvents events);
  ~Collector();

  void addTransforms(const tf2_msgs::TFMessage& message, bool is_static);
  void addCloud(const sensor_msgs::PointCloud2ConstPtr& message);
  void addCameraInfo(std::size_t camera, const sensor_msgs::CameraInfoConstPtr& message);
  void addImage(std::size_t camera, const sensor_msgs::ImageConstPtr& message);
  void addImage(std::size_t camera, const sensor_msgs::CompressedImageConstPtr& message);
  /// For the image with the same stamp, before or after it: black where it must not colour. Of the image's shape.
  void addMask(std::size_t camera, const sensor_msgs::ImageConstPtr& message);
  void addMask(std::size_t camera, const sensor_msgs::CompressedImageConstPtr& message);

  /// Goes on into another recording: transforms, camera_info and waiting messages stay, counters start again. Views
  /// whose images are being encoded belong to the old one, see drain(). When it throws, the old one stays in use.
  void useRecorder(Recorder& recorder);

  /// Records what can be recorded by now. Called by the owner after adding, as often as it likes.
  void process();
  /// Likewise, and does not wait for further clouds to tell whether their motion is to be undone.
  void settle();
  void drain();  ///< waits for the encoders and writes their views
  /// Records what can be recorded, gives up on the rest, and drains.
  void finish();
  std::size_t numPending() const;  ///< messages that wait for tf, camera_info or an encoder

  const CollectorStats& stats() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cloud_colorizer
