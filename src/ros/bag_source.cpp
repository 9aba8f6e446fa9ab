// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/bag_source.hpp"

#include <rosbag/bag.h>
#include <rosbag/exceptions.h>
#include <rosbag/view.h>

#include <chrono>
#include <filesystem>
#include <set>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

using Strings = std::vector<std::string>;
const Strings kTf = {"/tf", "tf"};
const Strings kStaticTf = {"/tf_static", "tf_static"};

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

}  // namespace

struct BagSource::Impl {
  explicit Impl(const Strings& paths) {
    for (const std::string& path : paths) {
      require(std::filesystem::is_regular_file(path), "there is no bag ", path);
      bags.push_back(std::make_unique<rosbag::Bag>());
      guarded(path, [&] { bags.back()->open(path, rosbag::bagmode::Read); });
      names += (names.empty() ? "" : " ") + path;
    }
    rosbag::View all;
    for (const auto& bag : bags) all.addQuery(*bag);
    for (const rosbag::ConnectionInfo* connection : all.getConnections())
      topics[connection->topic] = connection->datatype;
    if (all.size() > 0) duration = all.getEndTime().toSec() - all.getBeginTime().toSec();
  }

  /// rosbag::View cannot be copied.
  std::unique_ptr<rosbag::View> view(const Strings& of_topics) const {
    auto result = std::make_unique<rosbag::View>();
    for (const auto& bag : bags) result->addQuery(*bag, rosbag::TopicQuery(of_topics));
    return result;
  }

  std::vector<std::unique_ptr<rosbag::Bag>> bags;
  std::string names;
  TopicTypes topics;
  double duration = 0;
};

namespace {

/// Gives transforms to the collector, ahead of the other messages.
class TransformReader {
 public:
  TransformReader(std::unique_ptr<rosbag::View> view, double lead, Collector& collector)
      : view_(std::move(view)), next_(view_->begin()), lead_(lead), collector_(collector) {}

  /// All that were received up to `lead` after `time`, but not past a step back of their stamps.
  void readTo(ros::Time time) {
    if (time > ros::TIME_MAX - lead_) time = ros::TIME_MAX - lead_;
    for (; next_ != view_->end() && next_->getTime() <= time + lead_; ++next_) {
      const auto message = next_->instantiate<tf2_msgs::TFMessage>();
      if (!message) continue;
      if (next_->getTime() > time && stepsBack(*message)) return;
      for (const auto& transform : message->transforms) last_[transform.child_frame_id] = transform.header.stamp;
      collector_.addTransforms(*message, false);
    }
  }

 private:
  bool stepsBack(const tf2_msgs::TFMessage& message) const {
    for (const auto& transform : message.transforms) {
      const auto last = last_.find(transform.child_frame_id);
      if (last != last_.end() && transform.header.stamp < last->second) return true;
    }
    return false;
  }

  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator next_;
  ros::Duration lead_;
  Collector& collector_;
  std::map<std::string, ros::Time> last_;
};

/// Gives a message to the collector in the role that its topic has.
void give(const rosbag::MessageInstance& message, const Rig& rig, Collector& collector) {
  const std::string& topic = message.getTopic();
  if (topic == rig.cloud) {
    if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>()) collector.addCloud(cloud);
    return;
  }
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    if (topic == rig.cameras[i].camera_info) {
      if (const auto info = message.instantiate<sensor_msgs::CameraInfo>()) collector.addCameraInfo(i, info);
    } else if (topic == rig.cameras[i].image) {
      if (const auto image = message.instantiate<sensor_msgs::Image>()) {
        collector.addImage(i, image);
      } else if (const auto compressed = message.instantiate<sensor_msgs::CompressedImage>()) {
        collector.addImage(i, compressed);
      }
    }
  }
}

Strings sensorTopics(const Rig& rig) {
  std::set<std::string> topics = {rig.cloud};
  for (const RigCamera& camera : rig.cameras) topics.insert({camera.image, camera.camera_info});
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

}  // namespace

BagSource::BagSource(const Strings& bags) : impl_(new Impl(bags)) {}
BagSource::~BagSource() = default;
const TopicTypes& BagSource::topics() const {
  return impl_->topics;
}
double BagSource::duration() const {
  return impl_->duration;
}

void BagSource::play(const Rig& rig, double tf_lead, Collector& collector, const Callbacks& callbacks) {
  guarded(impl_->names, [&] {
    const auto static_tf = impl_->view(kStaticTf);
    for (const rosbag::MessageInstance& message : *static_tf) {
      if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>())
        collector.addTransforms(*transforms, true);
    }
    TransformReader tf(impl_->view(kTf), tf_lead, collector);
    const auto sensors = impl_->view(sensorTopics(rig));
    ReadProgress progress(sensors->size(), callbacks);
    for (const rosbag::MessageInstance& message : *sensors) {
      tf.readTo(message.getTime());
      give(message, rig, collector);
      collector.process();
      progress.advance(pointsSeen(collector.stats()));
    }
    tf.readTo(ros::TIME_MAX);
  });
  collector.finish();
}

}  // namespace cloud_colorizer
