// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/collector.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <sstream>

#include "alignment/motion.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "ros/camera_stream.hpp"
#include "ros/cloud_stream.hpp"
#include "ros/message_stamps.hpp"
#include "ros/node_log.hpp"
#include "ros/transform_buffer.hpp"
#include "ros/view_writer.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kJumpBack = 1;            // s; a stream whose stamps step back by more was restarted
constexpr std::size_t kMaxPending = 2000;  // messages of a topic; a guard for stamps that stand still
constexpr double kTfCache = 30;            // s of transforms that are kept, if tf_wait is well below it

using Isometry = Eigen::Isometry3d;

/// A tenth of what makes a new keyframe.
TransformBuffer::Stillness stillness(const RecordParams& record) {
  return {record.keyframe_distance / 10, record.keyframe_angle / 10};
}

}  // namespace

struct Collector::Impl {
  Impl(Recorder& recorder_in, const CollectorParams& params_in, CollectorEvents events_in)
      : recorder(&recorder_in),
        params(params_in),
        events(std::move(events_in)),
        map_frame(withoutSlash(params_in.map_frame)),
        transforms(std::max(kTfCache, 2 * params_in.tf_wait), params_in.tf_max_gap, stillness(params_in.record)),
        clouds(
            params, transforms, [this] { return cameraFrame(); }, sayOf("clouds"), events.cloud_kept),
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

  Say sayOf(const std::string& stream) {
    return [this, name = stream](LogLevel level, const char* kind, const std::string& text) {
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
    clouds.startAnew();
    last_stamps.clear();
    newest = 0;
  }

  void clearQueues() {
    const auto drop = [](StreamStats& of, auto& queue) {
      of.outcomes[static_cast<std::size_t>(Outcome::kTimeJump)] += queue.size();
      queue.clear();
    };
    drop(stats.cloud, clouds.queue);
    for (std::size_t i = 0; i < cameras.size(); ++i) drop(stats.cameras[i], cameras[i].queue);
  }

  bool waitedEnough(double stamp) const { return giving_up || newest - stamp > params.tf_wait; }

  // ---- clouds ----

  /// The first camera's frame: cameras and scanner are on one vehicle.
  std::string cameraFrame() const {
    for (const CameraStream& camera : cameras) {
      if (!camera.info()) continue;
      std::string frame = withoutSlash(camera.info()->header.frame_id);
      if (transforms.has(frame)) return frame;
    }
    return {};
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
      return transforms.lookUp(map_frame, frame, shiftedStamp(stamp, seconds)) * offset;
    };
    const double readout = camera.params().readout_time;
    view.map_from_camera = pose_after(readout / 2);
    if (readout > 0) view.readout_motion = alignment::twistOf(pose_after(0).inverse() * pose_after(readout));
  }

  Outcome recordImage(std::size_t number, const ImageMessage& image) {
    CameraStream& camera = cameras[number];
    checkStamp(image.header);
    camera.dropMasksBefore(image.header.stamp);
    PendingView view = camera.newView(image, params.max_image_size, *recorder);
    view.camera = number;
    const ros::Time stamp = shiftedStamp(image.header.stamp, camera.params().time_offset);
    view.stamp = stamp.toSec();
    setPose(camera, camera.frameOf(image), stamp, view);
    if (camera.isRecorded(view, *recorder)) return Outcome::kRecordedBefore;
    if (!camera.isKeyframe(view.map_from_camera, params.record)) return Outcome::kNotKeyframe;
    camera.inspect(image, view, sayOf(camera.name()));
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

  static double stampOf(const sensor_msgs::PointCloud2ConstPtr& cloud) { return cloud->header.stamp.toSec(); }
  static double stampOf(const ImageMessage& image) { return image.header.stamp.toSec(); }

  void process() {
    workOff("clouds", stats.cloud, clouds.queue, [this](const sensor_msgs::PointCloud2ConstPtr& cloud) {
      return clouds.record(!settling && !waitedEnough(stampOf(cloud)), *recorder, stats.points);
    });
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      workOff(cameras[i].name(), stats.cameras[i], cameras[i].queue,
              [&](const ImageMessage& image) { return recordImage(i, image); });
    }
    writer.writeReady(*recorder);
  }

  /// Tells of a view that was written.
  void viewKept(const PendingView& view) {
    if (!events.view_kept || view.kind != ImageKind::kColor) return;
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
  std::string map_frame;
  TransformBuffer transforms;
  CloudStream clouds;
  CollectorStats stats;
  std::vector<CameraStream> cameras;
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
  impl_->enqueue("clouds", impl_->stats.cloud, impl_->clouds.queue, message);
}

void Collector::addCameraInfo(std::size_t camera, const sensor_msgs::CameraInfoConstPtr& message) {
  CameraStream& stream = impl_->cameras.at(camera);
  stream.takeInfo(message, impl_->params.max_image_size, *impl_->recorder, impl_->sayOf(stream.name()));
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
  for (CameraStream& camera : cameras)
    camera.enter(recorder, impl_->params.max_image_size, impl_->sayOf(camera.name()));
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
  std::size_t pending = impl_->clouds.queue.size() + impl_->writer.numPending();
  for (const CameraStream& camera : impl_->cameras) pending += camera.queue.size();
  return pending;
}

const CollectorStats& Collector::stats() const {
  return impl_->stats;
}

}  // namespace cloud_colorizer
