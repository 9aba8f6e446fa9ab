// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/bag_source.hpp"

#include <rosbag/bag.h>
#include <rosbag/exceptions.h>
#include <rosbag/view.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/clock_watch.hpp"
#include "ros/fixed_frames.hpp"
#include "ros/livox.hpp"
#include "ros/moving_frame.hpp"
#include "ros/transform_buffer.hpp"
#include "ros/transform_reader.hpp"

namespace cloud_colorizer {
namespace {

using Strings = std::vector<std::string>;
const Strings kStaticTf = {"/tf_static", "tf_static"};
constexpr double kFirstSeconds = 10;  // of a bag, and its last, that are searched for transforms that come once

/// Runs `body`; what rosbag throws becomes an error with a remedy.
template <class Body>
auto guarded(const std::string& bag, const Body& body) {
  try {
    return body();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error("the bag " + bag + " is damaged or was not closed (" + error.what() +
                             "); try: rosbag reindex " + bag + ", then rosbag fix or rosbag filter");
  }
}

/// By the first bytes of the file, or by the folder around it.
bool isOfRos2(const std::string& path) {
  namespace fs = std::filesystem;
  if (fs::is_directory(path)) return fs::exists(fs::path(path) / "metadata.yaml");
  char head[16] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof(head));
  return std::string(head, 13) == "SQLite format" || std::string(head, 5) == "\x89MCAP";
}

void checkBag(const std::string& path) {
  require(!isOfRos2(path), path,
          " is a bag of ROS 2, which this package does not read; convert it: pip install rosbags, ",
          "then rosbags-convert --src ", path, " --dst converted.bag");
  require(std::filesystem::is_regular_file(path), "there is no bag ", path);
}

}  // namespace

struct BagSource::Impl {
  explicit Impl(const Strings& paths) {
    for (const std::string& path : paths) {
      checkBag(path);
      bags.push_back(std::make_unique<rosbag::Bag>());
      guarded(path, [&] { bags.back()->open(path, rosbag::bagmode::Read); });
      names += (names.empty() ? "" : " ") + path;
    }
    rosbag::View all;
    for (const auto& bag : bags) all.addQuery(*bag);
    for (const rosbag::ConnectionInfo* connection : all.getConnections())
      topics[connection->topic] = connection->datatype;
    if (all.size() > 0) begin = all.getBeginTime(), end = all.getEndTime();
  }

  /// rosbag::View cannot be copied.
  std::unique_ptr<rosbag::View> view(const Strings& of_topics, ros::Time from = ros::TIME_MIN,
                                     ros::Time to = ros::TIME_MAX) const {
    auto result = std::make_unique<rosbag::View>();
    for (const auto& bag : bags) result->addQuery(*bag, rosbag::TopicQuery(of_topics), from, to);
    return result;
  }

  /// What /tf gives once for all.
  std::vector<geometry_msgs::TransformStamped> transformsGivenOnce() const {
    const ros::Duration some(kFirstSeconds);
    if (begin >= ros::TIME_MAX - some || end <= ros::TIME_MIN + some) return {};  // no clock shows such times
    const ros::Time after = begin + some;
    return givenOnce(readTransforms(*view(kTfTopics, begin, after)),
                     readTransforms(*view(kTfTopics, std::max(after, end - some), end)));
  }

  std::vector<std::unique_ptr<rosbag::Bag>> bags;
  std::string names;
  TopicTypes topics;
  ros::Time begin, end;
};

namespace {

/// Calls f with an image of either kind; not where the message is none.
template <class F>
void withImage(const rosbag::MessageInstance& message, const F& f) {
  if (const auto image = message.instantiate<sensor_msgs::Image>()) {
    f(image);
  } else if (const auto compressed = message.instantiate<sensor_msgs::CompressedImage>()) {
    f(compressed);
  }
}

/// Gives a message to the collector in the role that its topic has. Returns the stamp of a cloud; 0 of others.
ros::Time give(const rosbag::MessageInstance& message, const Rig& rig, Collector& collector, ClockWatch& clocks) {
  const std::string& topic = message.getTopic();
  const auto watch = [&](const auto& of) { clocks.add(topic, message.getTime(), of->header.stamp); };
  if (topic == rig.cloud) {
    if (const sensor_msgs::PointCloud2ConstPtr cloud = cloudOf(message)) {
      watch(cloud);
      collector.addCloud(cloud);
      return cloud->header.stamp;
    }
  }
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    if (topic == rig.cameras[i].camera_info) {
      if (const auto info = message.instantiate<sensor_msgs::CameraInfo>()) collector.addCameraInfo(i, info);
    } else if (topic == rig.cameras[i].image) {
      withImage(message, [&](const auto& image) {
        watch(image);
        collector.addImage(i, image);
      });
    } else if (topic == rig.cameras[i].masks) {
      withImage(message, [&](const auto& mask) { collector.addMask(i, mask); });
    }
  }
  return {};
}

Strings sensorTopics(const Rig& rig) {
  std::set<std::string> topics = {rig.cloud};
  for (const RigCamera& camera : rig.cameras) {
    topics.insert({camera.image, camera.camera_info});
    if (!camera.masks.empty()) topics.insert(camera.masks);
  }
  return {topics.begin(), topics.end()};
}

/// Tells how far reading has come, at most ten times a second.
class ReadProgress {
 public:
  ReadProgress(std::size_t total, const Callbacks& callbacks) : callbacks_(callbacks) {
    progress_.stage = "read";
    progress_.total = total;
  }

  void advance(std::size_t points) {
    ++progress_.done;
    if (callbacks_.cancelled && callbacks_.cancelled()) throw Cancelled();
    const auto now = std::chrono::steady_clock::now();
    if (!callbacks_.progress || (now - last_ < std::chrono::milliseconds(100) && progress_.done < progress_.total))
      return;
    last_ = now;
    const double seconds = std::chrono::duration<double>(now - start_).count();
    progress_.points_per_second = seconds > 0 ? static_cast<double>(points) / seconds : 0;
    progress_.seconds_left =
        seconds * static_cast<double>(progress_.total - progress_.done) / static_cast<double>(progress_.done);
    callbacks_.progress(progress_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  const Callbacks& callbacks_;
  Progress progress_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_{};
};

std::size_t pointsSeen(const CollectorStats& stats) {
  const auto& points = stats.points;
  return points.added + points.not_finite + points.too_far + points.too_near + points.voxel_taken;
}

/// A camera_info that comes once, or late, holds for the images before it.
void giveFirstInfos(const Rig& rig, const std::function<std::unique_ptr<rosbag::View>(const Strings&)>& view,
                    Collector& collector) {
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const auto infos = view({rig.cameras[i].camera_info});
    if (infos->begin() == infos->end()) continue;
    if (const auto info = infos->begin()->instantiate<sensor_msgs::CameraInfo>()) collector.addCameraInfo(i, info);
  }
}

}  // namespace

BagSource::BagSource(const Strings& bags) : impl_(new Impl(bags)) {}
BagSource::~BagSource() = default;
const TopicTypes& BagSource::topics() const {
  return impl_->topics;
}
double BagSource::duration() const {
  return impl_->end.toSec() - impl_->begin.toSec();
}

std::string BagSource::formatOf(const std::string& topic) const {
  return guarded(impl_->names, [&]() -> std::string {
    const auto view = impl_->view({topic});
    if (view->begin() == view->end()) return {};
    if (const auto image = view->begin()->instantiate<sensor_msgs::Image>()) return image->encoding;
    const auto compressed = view->begin()->instantiate<sensor_msgs::CompressedImage>();
    if (!compressed) return {};
    if (!encodingOfFormat(compressed->format).empty()) return compressed->format;
    try {
      return inspectCompressed(*compressed).channels == 1 ? "mono8; " + compressed->format : compressed->format;
    } catch (const std::invalid_argument&) {
      return compressed->format;  // it is told when it is read
    }
  });
}

void BagSource::addOdometry(Rig& rig) const {
  if (rig.odometry.empty()) {
    for (const auto& [topic, type] : impl_->topics) {
      if (type != "nav_msgs/Odometry") continue;
      if (!rig.odometry.empty()) {  // nobody knows which
        rig.odometry.clear();
        return;
      }
      rig.odometry = topic;
    }
    if (rig.odometry.empty()) return;
    if (movesFrame(*impl_->view({rig.odometry}), *impl_->view(kTfTopics), rig.base_frame)) rig.odometry.clear();
  }
  if (rig.odometry.empty()) return;
  const auto view = impl_->view({rig.odometry});
  if (view->begin() == view->end()) return;
  const auto transform = transformOf(*view->begin(), rig.base_frame);
  require(!transform.child_frame_id.empty(), "the messages of ", rig.odometry,
          " do not say whose pose they give; set base_frame in the rig file");
  if (rig.map_frame.empty()) rig.map_frame = transform.header.frame_id;
}

void BagSource::addPoses(const std::string& file, const std::string& map_frame, Rig& rig) const {
  std::vector<TrajectoryPose> poses = readTrajectory(file);
  std::vector<std_msgs::Header> clouds;
  const bool needs_stamps = !poses.front().stamp.has_value();
  guarded(impl_->names, [&] {
    const auto view = impl_->view({rig.cloud});
    for (const rosbag::MessageInstance& message : *view) {
      if (const auto cloud = cloudOf(message)) clouds.push_back(cloud->header);
      if (!needs_stamps && !clouds.empty()) break;
    }
  });
  require(!clouds.empty(), "the bag has no cloud on ", rig.cloud);
  if (needs_stamps) {
    require(clouds.size() == poses.size(), file, " has ", poses.size(), " poses without stamps, but ", rig.cloud,
            " has ", clouds.size(), " clouds; give a file of TUM's form, with stamps");
    for (std::size_t i = 0; i < poses.size(); ++i) poses[i].stamp = static_cast<std::int64_t>(clouds[i].stamp.toNSec());
  }
  if (rig.base_frame.empty()) rig.base_frame = withoutSlash(clouds.front().frame_id);
  for (const TrajectoryPose& pose : poses) rig.poses.push_back(transformOf(pose, map_frame, rig.base_frame));
  rig.odometry.clear();
}

void BagSource::play(const Rig& rig, double tf_lead, Collector& collector, const Callbacks& callbacks) {
  guarded(impl_->names, [&] {
    ClockWatch clocks;
    giveFirstInfos(
        rig, [&](const Strings& topics) { return impl_->view(topics); }, collector);
    Strings moving = kTfTopics;
    if (!rig.odometry.empty()) moving.push_back(rig.odometry);
    TransformReader tf(impl_->view(moving), rig, tf_lead, collector, clocks);
    const auto once = impl_->transformsGivenOnce();
    for (const auto& transform : once) {
      if (callbacks.log)
        callbacks.log(LogLevel::kInfo,
                      "tf of " + transform.child_frame_id + ": comes once on /tf, and is taken as fixed");
    }
    tf.giveFixed(readTransforms(*impl_->view(kStaticTf)), once);
    const auto sensors = impl_->view(sensorTopics(rig));
    ReadProgress progress(sensors->size(), callbacks);
    for (const rosbag::MessageInstance& message : *sensors) {
      tf.readTo(message.getTime());
      tf.givePosesTo(give(message, rig, collector, clocks));
      collector.process();
      progress.advance(pointsSeen(collector.stats()));
    }
    tf.readTo(ros::TIME_MAX);
    clocks.warn(kTfTopics.front(), callbacks);
  });
  collector.finish();
}

}  // namespace cloud_colorizer
