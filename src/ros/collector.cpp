// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/collector.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <sstream>

#include "alignment/motion.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/camera_stream.hpp"
#include "ros/deskew.hpp"
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

/// A tenth of what makes a new keyframe.
TransformBuffer::Stillness stillness(const RecordParams& record) {
  return {record.keyframe_distance / 10, record.keyframe_angle / 10};
}

std::string badStamp(ros::Time stamp) {
  return "the stamp of " + std::to_string(stamp.sec) + " s is out of range; look at the publisher's clock";
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
        deskewer(params_in.deskew,
                 [this](LogLevel level, const std::string& text) {
                   if (events.log) events.log(level, text);
                 }),
        writer(params_in.encode_threads, params_in.raw_image_format,
               [this](const PendingView& view) { viewKept(view); }) {
    params.check();
    stats.cameras.resize(params.cameras.size());
    for (std::size_t i = 0; i < params.cameras.size(); ++i) cameras.emplace_back(params.cameras[i], i);
    restoreKeyframes();
  }

  /// So that a continued recording does not keep the same view again.
  void restoreKeyframes() {
    if (recorder->numViews() == 0) return;
    const Recording recording = recorder->snapshot();
    for (const View& view : recording.views()) {
      for (CameraStream& camera : cameras) {
        const std::string& name = recording.cameras()[view.camera].name;  // with new intrinsics, camera_0_2
        if (name != camera.name() && name.rfind(camera.name() + '_', 0) != 0) continue;
        Isometry pose = view.map_from_camera;
        pose.translation() += recording.origin();
        camera.resumeAt(pose, view.stamp);
      }
    }
  }

  // ---- warnings and counters ----

  void warn(const std::string& stream, const char* kind, const std::string& text) {
    if (!events.log) return;
    const auto suffix = throttle.pass(stream + kind);
    if (suffix) events.log(LogLevel::kWarning, stream + ": " + text + *suffix);
  }

  Say sayOf(const CameraStream& camera) {
    return [this, name = camera.name()](LogLevel level, const char* kind, const std::string& text) {
      if (level == LogLevel::kWarning) {
        warn(name, kind, text);
      } else if (events.log) {
        events.log(level, name + ": " + text);
      }
    };
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
    deskewer.startAnew();
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
    for (const CameraStream& camera : cameras) {
      if (camera.info() && transforms.has(withoutSlash(camera.info()->header.frame_id))) {
        return withoutSlash(camera.info()->header.frame_id);
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

  static std::string frameOf(const sensor_msgs::PointCloud2& message) {
    std::string frame = withoutSlash(message.header.frame_id);
    if (frame.empty()) throw Refused{Outcome::kMalformed, "the header's frame_id is empty"};
    return frame;
  }

  /// The message's cloud in its own frame. Throws Refused.
  Sweep readSweep(const sensor_msgs::PointCloud2& message) const {
    checkHeader(message.header);
    const ros::Time stamp = shifted(message.header.stamp, params.cloud_time_offset);
    const std::string frame = frameOf(message);
    Sweep sweep;
    sweep.stamp = message.header.stamp.toSec();
    sweep.pose = [this, frame, stamp](double seconds) {
      return transforms.lookUp(map_frame, frame, shifted(stamp, seconds));
    };
    try {
      sweep.cloud = cloudFromMessage(message);
    } catch (const Invalid& error) {
      throw Refused{Outcome::kMalformed, error.what()};
    }
    if (frame != map_frame) dropZeroReturns(sweep.cloud);
    return sweep;
  }

  WaitingSweeps waitingSweeps() const {
    return {clouds.size(), [this](std::size_t i) { return stampOf(clouds[i]); },
            [this](std::size_t i) { return readSweep(*clouds[i]); }};
  }

  Outcome recordCloud(const sensor_msgs::PointCloud2& message) {
    checkHeader(message.header);
    const bool may_wait = !settling && !waitedEnough(stampOf(message));
    if (may_wait && deskewer.waitsFor(stampOf(clouds.back()))) throw NotYet{{Outcome::kNoTransform, ""}};
    const ros::Time stamp = shifted(message.header.stamp, params.cloud_time_offset);
    const std::string frame = frameOf(message);
    const std::string sensor = sensorOf(frame);
    const Isometry map_from_sensor = transforms.lookUp(map_frame, sensor, stamp);
    const Isometry sensor_from_cloud = transforms.lookUp(sensor, frame, stamp);
    Sweep sweep = readSweep(message);
    if (frame != map_frame) deskewer.apply(sweep, waitingSweeps(), may_wait);
    Cloud& cloud = sweep.cloud;
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

  /// P of the right camera of a stereo pair says how far it is from the frame that both cameras name. Most drivers give
  /// each camera a frame of its own instead, which tells the same.
  Eigen::Translation3d offsetInFrame(const CameraStream& camera) {
    Eigen::Translation3d none(0, 0, 0);
    if (camera.baseline().isZero()) return none;
    const std::string frame = camera.info()->header.frame_id;
    const bool is_shared = std::any_of(cameras.begin(), cameras.end(), [&](const CameraStream& other) {
      return &other != &camera && other.info() && other.info()->header.frame_id == frame;
    });
    if (is_shared) return Eigen::Translation3d(camera.baseline());
    std::ostringstream text;
    text << "P of camera_info places the camera " << camera.baseline().norm() << " m beside the frame " << frame
         << ", which no other camera has; the frame is taken as this camera's own";
    warn(camera.name(), "baseline", text.str());
    return none;
  }

  /// Of a rolling shutter the pose of the middle row, and the motion from the first to the last.
  void setPose(const CameraStream& camera, const std::string& frame, ros::Time stamp, PendingView& view) {
    const Eigen::Translation3d offset = offsetInFrame(camera);
    const auto pose_after = [&](double seconds) -> Isometry {
      return transforms.lookUp(map_frame, frame, shifted(stamp, seconds)) * offset;
    };
    const double readout = camera.params().readout_time;
    view.map_from_camera = pose_after(readout / 2);
    if (readout > 0) view.readout_motion = alignment::twistOf(pose_after(0).inverse() * pose_after(readout));
  }

  Outcome recordImage(std::size_t number, const ImageMessage& image) {
    CameraStream& camera = cameras[number];
    checkHeader(image.header);
    camera.dropMasksBefore(image.header.stamp);
    PendingView view = camera.newView(image, params.max_image_size, *recorder);
    view.camera = number;
    const ros::Time stamp = shifted(image.header.stamp, camera.params().time_offset);
    view.stamp = stamp.toSec();
    setPose(camera, camera.frameOf(image), stamp, view);
    if (camera.isRecorded(view, *recorder)) return Outcome::kRecordedBefore;
    if (!camera.isKeyframe(view.map_from_camera, params.record)) return Outcome::kNotKeyframe;
    camera.inspect(image, view, sayOf(camera));
    camera.keep(view);
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

  static double stampOf(const sensor_msgs::PointCloud2& cloud) { return cloud.header.stamp.toSec(); }
  static double stampOf(const sensor_msgs::PointCloud2ConstPtr& cloud) { return stampOf(*cloud); }
  static double stampOf(const ImageMessage& image) { return image.header.stamp.toSec(); }

  void process() {
    workOff("clouds", stats.cloud, clouds,
            [this](const sensor_msgs::PointCloud2ConstPtr& cloud) { return recordCloud(*cloud); });
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      workOff(cameras[i].name(), stats.cameras[i], cameras[i].queue,
              [&](const ImageMessage& image) { return recordImage(i, image); });
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
    kept.readout_motion = view.readout_motion;
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

  void addImage(std::size_t camera, const ImageMessage& image) {
    enqueue(cameras.at(camera).name(), stats.cameras[camera], cameras[camera].queue, image);
  }

  Recorder* recorder;
  CollectorParams params;
  CollectorEvents events;
  std::string map_frame, sensor_frame;
  TransformBuffer transforms;
  Deskewer deskewer;
  CollectorStats stats;
  std::vector<CameraStream> cameras;
  std::deque<sensor_msgs::PointCloud2ConstPtr> clouds;
  std::map<std::string, double> last_stamps;
  LineThrottle throttle;
  double newest = 0;  ///< s, of all clouds and images since time last jumped
  bool giving_up = false, settling = false;
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
  CameraStream& stream = impl_->cameras.at(camera);
  stream.takeInfo(message, impl_->params.max_image_size, *impl_->recorder, impl_->sayOf(stream));
}

void Collector::addImage(std::size_t camera, const sensor_msgs::ImageConstPtr& message) {
  impl_->addImage(camera, ImageMessage::of(message));
}

void Collector::addImage(std::size_t camera, const sensor_msgs::CompressedImageConstPtr& message) {
  impl_->addImage(camera, ImageMessage::of(message));
}

void Collector::addMask(std::size_t camera, const sensor_msgs::ImageConstPtr& message) {
  impl_->cameras.at(camera).takeMask(ImageMessage::of(message));
}

void Collector::addMask(std::size_t camera, const sensor_msgs::CompressedImageConstPtr& message) {
  impl_->cameras.at(camera).takeMask(ImageMessage::of(message));
}

void Collector::useRecorder(Recorder& recorder) {
  auto cameras = impl_->cameras;  // a copy, as the new recording's disk may be full
  for (CameraStream& camera : cameras) camera.enter(recorder, impl_->params.max_image_size, impl_->sayOf(camera));
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

void Collector::settle() {
  struct Settling {
    explicit Settling(bool& is_on) : flag(is_on) { flag = true; }
    ~Settling() { flag = false; }
    bool& flag;
  } settling(impl_->settling);
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
  for (const CameraStream& camera : impl_->cameras) pending += camera.queue.size();
  return pending;
}

const CollectorStats& Collector::stats() const {
  return impl_->stats;
}

}  // namespace cloud_colorizer
