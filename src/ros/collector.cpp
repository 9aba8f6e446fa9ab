// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/collector.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/node_log.hpp"
#include "ros/transform_buffer.hpp"
#include "ros/view_writer.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kJumpBack = 1;            // s; a stream whose stamps step back by more was restarted
constexpr std::size_t kMaxPending = 2000;  // messages of a topic; a guard for stamps that stand still
constexpr double kTfCache = 30;            // s of transforms that are kept, if tf_wait is well below it

/// tf and time offsets add up to a day to a stamp, which ros::Time then may not hold.
constexpr std::uint32_t kLastSecond = std::numeric_limits<std::uint32_t>::max() - 2 * 86400;

using Invalid = std::invalid_argument;
using Isometry = Eigen::Isometry3d;

/// An image of either kind.
struct ImageMessage {
  std_msgs::Header header;
  sensor_msgs::ImageConstPtr raw;
  sensor_msgs::CompressedImageConstPtr compressed;
};

struct CameraState {
  CameraParams params;
  std::string name;
  cv::Mat1b mask;
  sensor_msgs::CameraInfoConstPtr info;  ///< the newest
  std::optional<std::uint32_t> id;       ///< in the recording; set when the camera_info is good
  Intrinsics intrinsics;
  int bits = 0;                                     ///< of images with 16 bits a channel; 0: none came yet
  Eigen::Vector3d baseline{0, 0, 0};                ///< m, of a rectified camera in the frame of its camera_info
  Refused info_error{Outcome::kBadCameraInfo, ""};  ///< why there is no id
  std::optional<Isometry> last_kept;
  std::optional<double> resumed_at;  ///< s, newest stamp that an earlier program recorded; until the first image
  std::deque<ImageMessage> queue;
};

/// A tenth of what makes a new keyframe.
TransformBuffer::Stillness stillness(const RecordParams& record) {
  return {record.keyframe_distance / 10, record.keyframe_angle / 10};
}

std::string badStamp(ros::Time stamp) {
  return "the stamp of " + std::to_string(stamp.sec) + " s is out of range; look at the publisher's clock";
}

bool sameCamera(const sensor_msgs::CameraInfo& a, const sensor_msgs::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.distortion_model == b.distortion_model && a.D == b.D &&
         a.K == b.K && a.P == b.P && a.header.frame_id == b.header.frame_id && a.binning_x == b.binning_x &&
         a.binning_y == b.binning_y && a.roi == b.roi;
}

cv::Mat1b readMask(const std::string& file) {
  if (file.empty()) return {};
  cv::Mat mask = cv::imread(file, cv::IMREAD_GRAYSCALE);
  require(!mask.empty(), "the mask ", file, " cannot be read as an image");
  return mask;
}

}  // namespace

struct Collector::Impl {
  Impl(Recorder& recorder_in, const CollectorParams& params_in, CollectorEvents events_in)
      : recorder(&recorder_in),
        params(params_in),
        events(std::move(events_in)),
        map_frame(withoutSlash(params_in.map_frame)),
        sensor_frame(withoutSlash(params_in.sensor_frame)),
        transforms(std::max(kTfCache, 2 * params_in.tf_wait), params_in.tf_max_gap, stillness(params_in.record)),
        writer(params_in.encode_threads, params_in.raw_image_format,
               [this](const PendingView& view) { viewKept(view); }) {
    params.check();
    stats.cameras.resize(params.cameras.size());
    cameras.resize(params.cameras.size());
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      cameras[i].params = params.cameras[i];
      cameras[i].name = "camera_" + std::to_string(i);
      cameras[i].mask = readMask(params.cameras[i].mask);
    }
    restoreKeyframes();
  }

  /// So that a continued recording does not keep the same view again.
  void restoreKeyframes() {
    if (recorder->numViews() == 0) return;
    const Recording recording = recorder->snapshot();
    for (const View& view : recording.views()) {
      for (CameraState& camera : cameras) {
        const std::string& name = recording.cameras()[view.camera].name;  // with new intrinsics, camera_0_2
        if (name != camera.name && name.rfind(camera.name + '_', 0) != 0) continue;
        Isometry pose = view.map_from_camera;
        pose.translation() += recording.origin();
        camera.last_kept = pose;
        camera.resumed_at = std::max(view.stamp, camera.resumed_at.value_or(view.stamp));
      }
    }
  }

  // ---- warnings and counters ----

  void warn(const std::string& stream, const char* kind, const std::string& text) {
    if (!events.log) return;
    const auto suffix = throttle.pass(stream + kind);
    if (suffix) events.log(LogLevel::kWarning, stream + ": " + text + *suffix);
  }

  void count(const std::string& stream, StreamStats& of, const Refused& refused) {
    ++of.outcomes[static_cast<std::size_t>(refused.outcome)];
    if (refused.outcome <= Outcome::kRecordedBefore) return;
    of.last_error = refused.reason;
    if (refused.outcome == Outcome::kNoTransform) stats.last_tf_error = refused.reason;
    warn(stream, toString(refused.outcome), refused.reason);
  }

  // ---- time ----

  /// Keeps track of a stream's stamps. A step back means that a bag was looped or a simulation restarted.
  void noticeStamp(const std::string& stream, double stamp) {
    const auto last = last_stamps.find(stream);
    if (last != last_stamps.end() && stamp < last->second - kJumpBack) {
      std::ostringstream text;
      text.precision(3);
      text << std::fixed << "time jumped back by " << last->second - stamp
           << " s (a looped bag, a restarted simulation, or two publishers of one topic); transforms and waiting "
           << "messages are cleared, the recording goes on";
      warn(stream, "jump", text.str());
      startAnew();
    }
    last_stamps[stream] = stamp;
  }

  void startAnew() {
    ++stats.time_jumps;
    process();  // what can still be used
    clearQueues();
    transforms.clear();
    last_stamps.clear();
    newest = 0;
  }

  void clearQueues() {
    const auto drop = [](StreamStats& of, auto& queue) {
      of.outcomes[static_cast<std::size_t>(Outcome::kTimeJump)] += queue.size();
      queue.clear();
    };
    drop(stats.cloud, clouds);
    for (std::size_t i = 0; i < cameras.size(); ++i) drop(stats.cameras[i], cameras[i].queue);
  }

  bool waitedEnough(double stamp) const { return giving_up || newest - stamp > params.tf_wait; }

  // ---- transforms ----

  /// In integers: a double of today's seconds is 0.2 us coarse, and the last transform is at the message's exact stamp.
  static ros::Time shifted(ros::Time stamp, double offset) {
    if (stamp.toSec() + offset <= 0) {
      throw Refused{Outcome::kNoStamp, "the stamp with the time offset is before time 0"};
    }
    if (stamp.toSec() + offset > kLastSecond) {
      throw Refused{Outcome::kBadStamp, "the stamp with the time offset is out of range"};
    }
    return stamp + ros::Duration(offset);
  }

  static void checkHeader(const std_msgs::Header& header) {
    if (header.stamp.isZero()) throw Refused{Outcome::kNoStamp, "the header's stamp is zero"};
    if (header.stamp.sec > kLastSecond) throw Refused{Outcome::kBadStamp, badStamp(header.stamp)};
  }

  // ---- clouds ----

  /// Of clouds that are in the map frame already, as mapping programs publish them: the frame that is the scanner's by
  /// its name, else the first camera's, which is near it.
  std::string scannerFrame() const {
    std::string named = transforms.scannerFrame();
    if (!named.empty()) return named;
    for (const CameraState& camera : cameras) {
      if (camera.info && transforms.has(withoutSlash(camera.info->header.frame_id))) {
        return withoutSlash(camera.info->header.frame_id);
      }
    }
    return {};
  }

  std::string sensorOf(const std::string& frame) {
    std::string sensor = sensor_frame.empty() ? frame : sensor_frame;
    if (sensor != map_frame) return sensor;
    std::string scanner = scannerFrame();
    if (scanner.empty()) return sensor;
    warn("clouds", "range",
         "the clouds are in the map frame already; they are taken as measured from the frame " + scanner +
             "; set sensor_frame where the scanner has another");
    return scanner;
  }

  Outcome recordCloud(const sensor_msgs::PointCloud2& message) {
    checkHeader(message.header);
    const ros::Time stamp = shifted(message.header.stamp, params.cloud_time_offset);
    const std::string frame = withoutSlash(message.header.frame_id);
    if (frame.empty()) throw Refused{Outcome::kMalformed, "the header's frame_id is empty"};
    const std::string sensor = sensorOf(frame);
    const Isometry map_from_sensor = transforms.lookUp(map_frame, sensor, stamp);
    const Isometry sensor_from_cloud = transforms.lookUp(sensor, frame, stamp);
    Cloud cloud;
    try {
      cloud = cloudFromMessage(message);
    } catch (const Invalid& error) {
      throw Refused{Outcome::kMalformed, error.what()};
    }
    if (frame != map_frame) dropZeroReturns(cloud);
    if (sensor != frame) cloud.positions = sensor_from_cloud * cloud.positions;
    const CloudSource source = {frame, stamp.toSec()};
    const bool recorded_before = recorder->recognizeCloud(source);
    if (!recorded_before) countPoints(recorder->addCloud(cloud, map_from_sensor, source));
    // Where only the neighbourhood of the scanner is known, its rays are not.
    const bool is_scanner =
        sensor != map_frame && (frame != map_frame || sensor == sensor_frame || sensor == transforms.scannerFrame());
    if (is_scanner) recorder->addScan(frame, source.stamp, cloud.positions, map_from_sensor);
    if (events.cloud_kept) events.cloud_kept(cloud, map_from_sensor, source.stamp);
    return recorded_before ? Outcome::kRecordedBefore : Outcome::kKept;
  }

  /// Many drivers give a beam without a return as (0, 0, 0).
  static void dropZeroReturns(Cloud& cloud) {
    for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
      if ((cloud.positions.col(i).array() == 0).all()) {
        cloud.positions.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
      }
    }
  }

  void countPoints(const Recorder::InsertCounts& counts) {
    stats.points.added += counts.added;
    stats.points.not_finite += counts.not_finite;
    stats.points.too_near += counts.too_near;
    stats.points.too_far += counts.too_far;
    stats.points.voxel_taken += counts.voxel_taken;
    if (!counts.fields_dropped.empty()) {
      warn("clouds", "fields",
           "field " + counts.fields_dropped.front() +
               " is not recorded: the first cloud of the "
               "recording had no such field");
    }
  }

  // ---- images ----

  void takeCameraInfo(CameraState& camera, const sensor_msgs::CameraInfoConstPtr& message) {
    if (camera.info && sameCamera(*camera.info, *message)) return;
    camera.info = message;
    readCameraInfo(camera, *recorder);
  }

  void readCameraInfo(CameraState& camera, Recorder& into) {
    camera.id.reset();
    camera.info_error.outcome = Outcome::kBadCameraInfo;
    try {
      const CameraFromInfo result = cameraFromMessage(*camera.info, camera.params.rectified);
      if (!result.warning.empty()) warn(camera.name, "info", result.warning);
      camera.intrinsics = result.intrinsics;
      camera.baseline = result.baseline;
      const double size = 1e-6 * camera.intrinsics.width * camera.intrinsics.height;
      if (size > params.max_image_size) camera.info_error.outcome = Outcome::kTooLarge;
      require<Invalid>(size <= params.max_image_size, "camera_info: an image of ", camera.intrinsics.width, " x ",
                       camera.intrinsics.height, " px is larger than ~max_image_size = ", params.max_image_size,
                       " Mpx; raise it if the camera has so many pixels");
      require<Invalid>(
          camera.mask.empty() || camera.mask.size() == cv::Size(camera.intrinsics.width, camera.intrinsics.height),
          "the mask ", camera.params.mask, " is ", camera.mask.cols, " x ", camera.mask.rows, ", but the images are ",
          camera.intrinsics.width, " x ", camera.intrinsics.height);
    } catch (const Invalid& error) {
      camera.info_error.reason = error.what();
      return;
    }
    camera.id = into.setCamera(camera.name, camera.intrinsics);
    if (!camera.mask.empty()) into.setMask(*camera.id, camera.mask);
  }

  bool isKeyframe(const CameraState& camera, const Isometry& pose) const {
    if (!camera.last_kept) return true;
    const Isometry moved = camera.last_kept->inverse() * pose;
    const double angle = Eigen::AngleAxisd(moved.linear()).angle() * 180 / M_PI;
    return moved.translation().norm() >= params.record.keyframe_distance || angle >= params.record.keyframe_angle;
  }

  /// A bag that is read again chooses the keyframes that it chose the first time: by what lies before them in the bag.
  bool isRecorded(CameraState& camera, const PendingView& view) {
    if (camera.resumed_at && view.stamp <= *camera.resumed_at) camera.last_kept.reset();
    camera.resumed_at.reset();
    if (!recorder->recognizeView(view.id, view.stamp)) return false;
    camera.last_kept = view.map_from_camera;
    return true;
  }

  /// P of the right camera of a stereo pair says how far it is from the frame that both cameras name. Most drivers give
  /// each camera a frame of its own instead, which tells the same.
  Eigen::Translation3d offsetInFrame(const CameraState& camera) {
    Eigen::Translation3d none(0, 0, 0);
    if (camera.baseline.isZero()) return none;
    const std::string frame = camera.info->header.frame_id;
    const bool is_shared = std::any_of(cameras.begin(), cameras.end(), [&](const CameraState& other) {
      return &other != &camera && other.info && other.info->header.frame_id == frame;
    });
    if (is_shared) return Eigen::Translation3d(camera.baseline);
    std::ostringstream text;
    text << "P of camera_info places the camera " << camera.baseline.norm() << " m beside the frame " << frame
         << ", which no other camera has; the frame is taken as this camera's own";
    warn(camera.name, "baseline", text.str());
    return none;
  }

  /// Size of the image; throws Refused when it cannot be decoded.
  static cv::Size inspect(const ImageMessage& image, PendingView& view) {
    try {
      if (image.raw) {
        checkImage(*image.raw);
        return {static_cast<int>(image.raw->width), static_cast<int>(image.raw->height)};
      }
      const EncodedInfo info = inspectCompressed(*image.compressed);
      view.extension = info.extension;
      view.is_decoded = info.is_mosaic || info.depth == 16;
      return info.size;
    } catch (const Invalid& error) {
      throw Refused{Outcome::kUndecodable, error.what()};
    }
  }

  /// Cameras of 10, 12 and 14 bits come in 16, where nothing says how many are filled.
  int bitsOfCamera(CameraState& camera, const ImageMessage& image) {
    if (camera.params.bits != 0) return camera.params.bits;
    cv::Mat pixels;
    try {
      pixels = image.raw ? imageFromMessage(*image.raw) : imageFromMessage(*image.compressed);
    } catch (const Invalid& error) {
      throw Refused{Outcome::kUndecodable, error.what()};
    }
    if (pixels.depth() != CV_16U) return 16;
    const int bits = bitsOf(pixels);
    if (bits <= camera.bits) return camera.bits;
    if (events.log) {
      const std::string param = camera.name + "/bits=" + std::to_string(bits);
      if (camera.bits != 0) {
        events.log(LogLevel::kWarning, camera.name + ": an image has more than the " + std::to_string(camera.bits) +
                                           " bits of those before it, which are now too bright; record again with " +
                                           param);
      } else {
        events.log(LogLevel::kInfo, camera.name + ": of 16 bits a channel, the first image fills " +
                                        std::to_string(bits) + ", which is taken as full scale; else set " +
                                        camera.name + "/bits");
      }
    }
    return camera.bits = bits;
  }

  Outcome recordImage(CameraState& camera, const ImageMessage& image) {
    checkHeader(image.header);
    if (!camera.info) throw NotYet{{Outcome::kNoCameraInfo, "no camera_info has come"}};
    if (!camera.id) throw camera.info_error;
    PendingView view;
    view.camera = static_cast<std::size_t>(&camera - cameras.data());
    view.id = *camera.id;
    view.intrinsics = camera.intrinsics;
    const ros::Time stamp = shifted(image.header.stamp, camera.params.time_offset);
    view.stamp = stamp.toSec();
    std::string frame = withoutSlash(image.header.frame_id);
    if (frame.empty()) frame = withoutSlash(camera.info->header.frame_id);
    if (frame.empty()) throw Refused{Outcome::kMalformed, "neither the image nor its camera_info has a frame_id"};
    view.map_from_camera = transforms.lookUp(map_frame, frame, stamp) * offsetInFrame(camera);
    if (isRecorded(camera, view)) return Outcome::kRecordedBefore;
    if (!isKeyframe(camera, view.map_from_camera)) return Outcome::kNotKeyframe;

    const cv::Size size = inspect(image, view);
    if (size != cv::Size(camera.intrinsics.width, camera.intrinsics.height)) {
      std::ostringstream text;
      text << "the image is " << size.width << " x " << size.height << ", its camera_info says "
           << camera.intrinsics.width << " x " << camera.intrinsics.height;
      throw Refused{Outcome::kSizeMismatch, text.str()};
    }
    if (image.raw ? isWide(*image.raw) : view.is_decoded) view.bits = bitsOfCamera(camera, image);
    camera.last_kept = view.map_from_camera;
    if (image.raw) {
      writer.add(std::move(view), image.raw, *recorder);
    } else {
      writer.add(std::move(view), image.compressed, *recorder);
    }
    return Outcome::kKept;
  }

  // ---- queues ----

  /// Works off a queue up to the first message that has to wait. `record` returns or throws what became of it.
  template <class Queue, class Record>
  void workOff(const std::string& stream, StreamStats& of, Queue& queue, const Record& record) {
    while (!queue.empty()) {
      const auto message = queue.front();
      try {
        const Outcome outcome = record(message);
        queue.pop_front();
        count(stream, of, {outcome, ""});
      } catch (const NotYet& not_yet) {
        if (!waitedEnough(stampOf(message))) return;
        queue.pop_front();
        count(stream, of, not_yet);
      } catch (const Refused& refused) {
        queue.pop_front();
        count(stream, of, refused);
      } catch (...) {
        queue.pop_front();
        throw;
      }
    }
  }

  static double stampOf(const sensor_msgs::PointCloud2ConstPtr& cloud) { return cloud->header.stamp.toSec(); }
  static double stampOf(const ImageMessage& image) { return image.header.stamp.toSec(); }

  void process() {
    workOff("clouds", stats.cloud, clouds,
            [this](const sensor_msgs::PointCloud2ConstPtr& cloud) { return recordCloud(*cloud); });
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      CameraState& camera = cameras[i];
      workOff(camera.name, stats.cameras[i], camera.queue,
              [&](const ImageMessage& image) { return recordImage(camera, image); });
    }
    writer.writeReady(*recorder);
  }

  /// Tells of a view that was written.
  void viewKept(const PendingView& view) {
    if (!events.view_kept) return;
    View kept;
    kept.camera = view.id;
    kept.stamp = view.stamp;
    kept.map_from_camera = view.map_from_camera;
    events.view_kept(view.camera, kept, view.intrinsics, view.bytes);
  }

  template <class Message>
  void enqueue(const std::string& stream, StreamStats& of, std::deque<Message>& queue, const Message& message) {
    ++of.received;
    const double stamp = stampOf(message);
    if (stamp > 0 && stamp <= kLastSecond) {
      noticeStamp(stream, stamp);
      newest = std::max(newest, stamp);
      of.stamps.extend(stamp);
    }
    queue.push_back(message);
    if (queue.size() <= kMaxPending) return;
    queue.pop_front();
    count(stream, of, {Outcome::kOverflow, "too many messages wait for their transforms"});
  }

  Recorder* recorder;
  CollectorParams params;
  CollectorEvents events;
  std::string map_frame, sensor_frame;
  TransformBuffer transforms;
  CollectorStats stats;
  std::vector<CameraState> cameras;
  std::deque<sensor_msgs::PointCloud2ConstPtr> clouds;
  std::map<std::string, double> last_stamps;
  LineThrottle throttle;
  double newest = 0;  ///< s, of all clouds and images since time last jumped
  bool giving_up = false;
  ViewWriter writer;
};

Collector::Collector(Recorder& recorder, const CollectorParams& params, CollectorEvents events)
    : impl_(new Impl(recorder, params, std::move(events))) {}
Collector::~Collector() = default;

void Collector::addTransforms(const tf2_msgs::TFMessage& message, bool is_static) {
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    const std::string child = withoutSlash(transform.child_frame_id);
    if (transform.header.stamp.sec > kLastSecond && !is_static) {
      ++impl_->stats.bad_transforms;
      impl_->warn("tf of " + child, toString(Outcome::kBadStamp), badStamp(transform.header.stamp));
      continue;
    }
    if (!is_static && !transform.header.stamp.isZero()) {
      impl_->noticeStamp("tf of " + child, transform.header.stamp.toSec());
      impl_->stats.tf_stamps.extend(transform.header.stamp.toSec());
    }
    geometry_msgs::TransformStamped stripped = transform;
    stripped.child_frame_id = child;
    stripped.header.frame_id = withoutSlash(transform.header.frame_id);
    // An old node may send what is fixed again and again on /tf, with the stamp 0.
    const std::string warning = impl_->transforms.add(stripped, is_static || transform.header.stamp.isZero());
    if (!warning.empty()) impl_->warn("tf of " + child, "contradiction", warning);
  }
}

void Collector::addCloud(const sensor_msgs::PointCloud2ConstPtr& message) {
  impl_->enqueue("clouds", impl_->stats.cloud, impl_->clouds, message);
}

void Collector::addCameraInfo(std::size_t camera, const sensor_msgs::CameraInfoConstPtr& message) {
  impl_->takeCameraInfo(impl_->cameras.at(camera), message);
}

void Collector::addImage(std::size_t camera, const sensor_msgs::ImageConstPtr& message) {
  CameraState& state = impl_->cameras.at(camera);
  impl_->enqueue(state.name, impl_->stats.cameras[camera], state.queue,
                 ImageMessage{message->header, message, nullptr});
}

void Collector::addImage(std::size_t camera, const sensor_msgs::CompressedImageConstPtr& message) {
  CameraState& state = impl_->cameras.at(camera);
  impl_->enqueue(state.name, impl_->stats.cameras[camera], state.queue,
                 ImageMessage{message->header, nullptr, message});
}

void Collector::useRecorder(Recorder& recorder) {
  auto cameras = impl_->cameras;  // a copy, as the new recording's disk may be full
  for (CameraState& camera : cameras) {
    camera.last_kept.reset();
    camera.resumed_at.reset();
    if (camera.info) impl_->readCameraInfo(camera, recorder);
  }
  impl_->writer.clear();
  impl_->recorder = &recorder;
  impl_->cameras = std::move(cameras);
  impl_->stats = {};
  impl_->stats.cameras.resize(impl_->cameras.size());
  impl_->restoreKeyframes();
}

void Collector::process() {
  impl_->process();
}

void Collector::drain() {
  impl_->writer.writeAll(*impl_->recorder);
}

void Collector::finish() {
  impl_->giving_up = true;
  impl_->process();
  drain();
  impl_->giving_up = false;
}

std::size_t Collector::numPending() const {
  std::size_t pending = impl_->clouds.size() + impl_->writer.numPending();
  for (const CameraState& camera : impl_->cameras) pending += camera.queue.size();
  return pending;
}

const CollectorStats& Collector::stats() const {
  return impl_->stats;
}

}  // namespace cloud_colorizer
