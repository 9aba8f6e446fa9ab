// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "ros/node.hpp"

#include <cloud_colorizer/SaveMap.h>
#include <image_transport/image_transport.h>
#include <nav_msgs/Path.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <thread>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/inbox.hpp"
#include "ros/map_job.hpp"
#include "ros/node_output.hpp"
#include "ros/preview.hpp"
#include "ros/topic_monitor.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::chrono::seconds kSilence(5);
constexpr std::size_t kMaxTransforms = 100000;  // tf messages that wait to be recorded
constexpr std::size_t kMaxPathPoses = 100000;

/// The newest view of a camera, for the preview.
struct NewestView {
  View view;
  Intrinsics intrinsics;
  SharedBytes bytes;
  bool used = false;
};

}  // namespace

struct ColorizerNode::Impl {
  Impl(const ros::NodeHandle& node_in, const ros::NodeHandle& private_node_in, const AllParams& params_in)
      : node(node_in),
        private_node(private_node_in),
        sensor_node(node_in),
        params(params_in),
        directory(resolveRecordingDirectory(params.node.recording_dir)),
        output(node_in, private_node_in, params.node),
        preview(params.node.preview_voxel_size, static_cast<std::size_t>(params.node.max_preview_points)),
        newest_views(params.node.collector.cameras.size()),
        job(params, output),
        service_spinner(4, &service_queue),
        sensor_spinner(1, &sensor_queue) {
    if (!params.node.save_path.empty()) CloudWriter::checkPath(params.node.save_path);
    node.setCallbackQueue(&service_queue);
    private_node.setCallbackQueue(&service_queue);
    sensor_node.setCallbackQueue(&sensor_queue);
    recorder = std::make_unique<Recorder>(directory, params.node.collector.map_frame, params.core.record);
    collector = std::make_unique<Collector>(*recorder, params.node.collector, collectorEvents());
    ROS_INFO_STREAM("recording into " << directory << " (" << recorder->numPoints() << " points and "
                                      << recorder->numViews() << " views so far)");
    subscribe();
    advertise();
    recording_thread = std::thread([this] { recordMessages(); });
    service_spinner.start();
    sensor_spinner.start();
  }

  ~Impl() { stopRecording(); }

  // ---- messages in ----

  template <class Message>
  using Add = std::function<void(Collector&, const boost::shared_ptr<const Message>&)>;

  /// What is called with each message of the topic `name`: puts it into the inbox.
  template <class Message>
  boost::function<void(const boost::shared_ptr<const Message>&)> receiver(const std::string& name, bool is_data,
                                                                          const Add<Message>& add) {
    if (is_data) monitor.watch(name);
    return [this, add, is_data, name](const boost::shared_ptr<const Message>& message) {
      if (is_data) monitor.count(name);
      if (is_data && paused) return;
      // Transforms are small and must not get lost.
      const std::size_t limit = is_data ? static_cast<std::size_t>(params.node.queue_size) : kMaxTransforms;
      if (inbox.push(name, limit, [add, message](Collector& to) { add(to, message); })) return;
      monitor.countDropped(name);
      ROS_WARN_STREAM_THROTTLE_NAMED(10, "dropped",
                                     "recording is too slow: messages of "
                                         << name << " are dropped; compress images, use a larger "
                                         << "~voxel_size, or raise ~queue_size (see /diagnostics)");
    };
  }

  template <class Message>
  void subscribeTo(const std::string& topic, bool is_data, const Add<Message>& add) {
    const std::uint32_t queue_size = is_data ? static_cast<std::uint32_t>(params.node.queue_size) : 1000;
    subscribers.push_back(sensor_node.subscribe<Message>(topic, queue_size,
                                                         receiver<Message>(node.resolveName(topic), is_data, add),
                                                         ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
  }

  void subscribe() {
    subscribeTo<tf2_msgs::TFMessage>("/tf", false,
                                     [](Collector& to, const auto& message) { to.addTransforms(*message, false); });
    subscribeTo<tf2_msgs::TFMessage>("/tf_static", false,
                                     [](Collector& to, const auto& message) { to.addTransforms(*message, true); });
    subscribeTo<sensor_msgs::PointCloud2>("cloud_in", true,
                                          [](Collector& to, const auto& message) { to.addCloud(message); });
    for (std::size_t i = 0; i < params.node.collector.cameras.size(); ++i) {
      const std::string camera = "camera_" + std::to_string(i);
      subscribeTo<sensor_msgs::CameraInfo>(camera + "/camera_info", true,
                                           [i](Collector& to, const auto& message) { to.addCameraInfo(i, message); });
      const std::string& own = params.node.camera_transports[i];
      subscribeToImages(i, camera, own.empty() ? params.node.image_transport : own);
    }
  }

  void subscribeToImages(std::size_t i, const std::string& camera, const std::string& transport) {
    // As image_transport does, so that remapping camera_i/image is enough for any transport.
    const std::string image = node.resolveName(camera + "/image");
    const auto add = [i](Collector& to, const auto& message) { to.addImage(i, message); };
    if (transport == "compressed") {  // not by its plugin: the bytes are kept as they come
      subscribeTo<sensor_msgs::CompressedImage>(image + "/compressed", true, add);
      return;
    }
    image_transport::ImageTransport images(sensor_node);
    // A plugin has parameters of its own; and beside them one "image_transport", which nobody sets there, beats ours.
    const image_transport::TransportHints hints(transport, ros::TransportHints().tcpNoDelay(),
                                                ros::NodeHandle(private_node, "plugins/" + camera));
    try {
      image_subscribers.push_back(images.subscribe(
          image, static_cast<std::uint32_t>(params.node.queue_size),
          receiver<sensor_msgs::Image>(transport == "raw" ? image : image + "/" + transport, true, add), {}, hints));
    } catch (const image_transport::TransportLoadException& error) {
      std::string known = "compressed";
      for (const std::string& name : images.getLoadableTransports()) known += ", " + name.substr(name.find('/') + 1);
      throw std::runtime_error("parameter image_transport = \"" + transport + "\" of " + camera + ": there are " +
                               known + "; install the plugin of that name for image_transport (" + error.what() + ")");
    }
  }

  void recordMessages() {
    while (!inbox.closed()) {
      const auto task = inbox.pop(std::chrono::milliseconds(100));
      const std::lock_guard<std::mutex> lock(recording_mutex);
      try {
        if (task) (*task)(*collector);
        collector->process();
      } catch (const std::exception& error) {
        ROS_ERROR_STREAM_THROTTLE_NAMED(10, "recording", "recording: " << error.what());
      }
    }
    const std::lock_guard<std::mutex> lock(recording_mutex);
    try {
      collector->finish();
      recorder->flush();
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM("recording: " << error.what());
    }
  }

  CollectorEvents collectorEvents() {
    CollectorEvents events;
    events.log = [](LogLevel level, const std::string& text) { logLine(level, text); };
    events.cloud_kept = [this](const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor) {
      if (params.node.preview_period <= 0) return;
      const std::lock_guard<std::mutex> lock(preview_mutex);
      preview.addCloud(cloud, map_from_sensor, params.core.record.min_range, params.core.record.max_range);
      preview_changed = true;
    };
    events.view_kept = [this](std::size_t camera, const View& view, const Intrinsics& intrinsics,
                              const SharedBytes& bytes) {
      const std::lock_guard<std::mutex> lock(preview_mutex);
      newest_views[camera] = {view, intrinsics, bytes, false};
      if (camera != 0) return;
      path.poses.emplace_back();
      path.poses.back().header.stamp.fromSec(view.stamp);
      path.poses.back().header.frame_id = params.node.collector.map_frame;
      path.poses.back().pose = tf2::toMsg(view.map_from_camera);
      if (path.poses.size() > kMaxPathPoses)
        path.poses.erase(path.poses.begin(), path.poses.begin() + kMaxPathPoses / 10);
    };
    return events;
  }

  void stopRecording() {
    for (ros::Subscriber& subscriber : subscribers) subscriber.shutdown();
    for (image_transport::Subscriber& subscriber : image_subscribers) subscriber.shutdown();
    sensor_spinner.stop();
    inbox.close();
    if (recording_thread.joinable()) recording_thread.join();
    service_spinner.stop();
  }

  // ---- services and timers ----

  void advertise() {
    services.push_back(private_node.advertiseService("colorize", &Impl::onColorize, this));
    services.push_back(private_node.advertiseService("save_map", &Impl::onSaveMap, this));
    services.push_back(private_node.advertiseService("reset", &Impl::onReset, this));
    services.push_back(private_node.advertiseService("pause", &Impl::onPause, this));
    services.push_back(private_node.advertiseService("resume", &Impl::onResume, this));
    timers.push_back(node.createWallTimer(ros::WallDuration(1), [this](const auto&) { tick(); }));
    if (params.node.preview_period > 0) {
      timers.push_back(node.createWallTimer(ros::WallDuration(params.node.preview_period),
                                            [this](const auto&) { publishPreview(); }));
    }
  }

  Recording snapshot() {
    const std::lock_guard<std::mutex> lock(recording_mutex);
    collector->process();
    return recorder->snapshot();
  }

  std::string describeCounters() {
    const std::lock_guard<std::mutex> lock(recording_mutex);
    return collector->stats().describe();
  }

  /// Colours what is recorded now. `aborted` may be empty.
  JobResult colorizeNow(const std::function<bool()>& aborted) {
    const auto newest = [this] {
      const Recording recording = snapshot();
      amount_when_colored = recording.numPoints() + recording.views().size();
      return recording;
    };
    const JobResult result = job.colorize(newest, aborted);
    if (!result.success || job.numColored() == 0) ROS_WARN_STREAM("what was received:\n" << describeCounters());
    return result;
  }

  bool onColorize(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    const JobResult result = colorizeNow([this] { return stopping.load(); });
    response.success = result.success;
    response.message = result.message;
    return true;
  }

  bool onSaveMap(SaveMap::Request& request, SaveMap::Response& response) {
    try {
      CloudWriter::checkPath(request.path);
    } catch (const std::exception& error) {
      response.message = error.what();
      return true;
    }
    JobResult result = {true, ""};
    if (!job.hasMap()) result = colorizeNow([this] { return stopping.load(); });
    if (result.success) result = job.save(request.path, [this] { return stopping.load(); });
    response.success = result.success;
    response.message = result.message;
    return true;
  }

  bool onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    const auto alone = job.reserve();
    if (!alone) {
      response.message = "the map is being coloured or saved; try again when that is done";
      return true;
    }
    const std::lock_guard<std::mutex> lock(recording_mutex);
    try {
      recorder->flush();
      const std::string kept = setAside(directory);
      auto fresh = std::make_unique<Recorder>(directory, params.node.collector.map_frame, params.core.record);
      collector->useRecorder(*fresh);
      recorder = std::move(fresh);
      known_origin.reset();
      job.forget();
      clearPreview();
      response.success = true;
      response.message = "a new recording begins in " + directory + "; the old one is kept in " + kept;
    } catch (const std::exception& error) {
      response.message = error.what();
    }
    ROS_INFO_STREAM("reset: " << response.message);
    return true;
  }

  bool onPause(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) { return setPaused(true, response); }
  bool onResume(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    return setPaused(false, response);
  }
  bool setPaused(bool value, std_srvs::Trigger::Response& response) {
    const bool before = paused.exchange(value);
    response.success = true;
    response.message = std::string(before == value ? "already " : "") + (value ? "paused" : "recording");
    return true;
  }

  void tick() {
    warnOfSilence();
    publishStatus();
    colorizeAfterSilence();
  }

  void warnOfSilence() {
    if (paused) return;
    std::string list;
    for (const std::string& topic : monitor.newlySilent(kSilence)) list += (list.empty() ? "" : ", ") + topic;
    if (!list.empty()) ROS_WARN_STREAM_NAMED("silence", "no message for " << kSilence.count() << " s on: " << list);
  }

  void publishStatus() {
    RecordingState state;
    {
      const std::lock_guard<std::mutex> lock(recording_mutex);
      state.points = recorder->numPoints();
      state.views = recorder->numViews();
      state.pending = collector->numPending();
      state.stats = collector->stats();
    }
    const double silence = monitor.secondsOfSilence();
    state.stage = paused ? "paused" : silence >= 0 && silence < 2 ? "recording" : "idle";
    state.directory = directory;
    state.topics = monitor.report();
    output.publishStatus(state, job.status());
  }

  void colorizeAfterSilence() {
    const double limit = params.node.colorize_after;
    if (limit <= 0 || monitor.secondsOfSilence() < limit) return;
    std::size_t amount = 0;
    {
      const std::lock_guard<std::mutex> lock(recording_mutex);
      amount = recorder->numPoints() + recorder->numViews();
    }
    if (amount == 0 || amount == amount_when_colored) return;
    ROS_INFO_STREAM("no message for " << limit << " s: colouring the map");
    colorizeNow([this] { return stopping.load(); });
    amount_when_colored = amount;  // also where it failed: once more only after something new
  }

  // ---- preview ----

  /// Fixed by the first point or view.
  std::optional<Eigen::Vector3d> recordingOrigin() {
    const std::lock_guard<std::mutex> lock(recording_mutex);
    if (!known_origin && recorder->numPoints() + recorder->numViews() > 0) known_origin = recorder->snapshot().origin();
    return known_origin;
  }

  void publishPreview() {
    const std::optional<Eigen::Vector3d> origin = recordingOrigin();
    const std::lock_guard<std::mutex> lock(preview_mutex);
    if (!preview_changed || !origin) return;
    preview_changed = false;
    for (NewestView& newest : newest_views) {
      if (newest.used || !newest.bytes) continue;
      newest.used = true;
      const cv::Mat3b image = cv::imdecode(*newest.bytes, cv::IMREAD_REDUCED_COLOR_4);
      if (image.empty()) continue;
      preview.addView(Camera(newest.intrinsics), newest.view.map_from_camera, image,
                      params.core.depth.max_view_distance);
    }
    output.publishPreview(preview.cloud(*origin), *origin);
    output.publishPath(path);
  }

  void clearPreview() {
    const std::lock_guard<std::mutex> lock(preview_mutex);
    preview.clear();
    path.poses.clear();
    for (NewestView& newest : newest_views) newest = {};
    preview_changed = true;
  }

  // Callback queues come before the handles and spinners that use them.
  ros::CallbackQueue service_queue, sensor_queue;
  ros::NodeHandle node, private_node, sensor_node;
  AllParams params;
  std::string directory;

  std::mutex recording_mutex;  ///< recorder, its origin, and collector
  std::unique_ptr<Recorder> recorder;
  std::optional<Eigen::Vector3d> known_origin;
  std::unique_ptr<Collector> collector;
  Inbox inbox;
  TopicMonitor monitor;
  std::atomic<bool> paused{false}, stopping{false};

  NodeOutput output;
  std::mutex preview_mutex;  ///< what follows, up to `path`
  RunningPreview preview;
  bool preview_changed = false;
  std::vector<NewestView> newest_views;
  nav_msgs::Path path;

  MapJob job;
  std::atomic<std::size_t> amount_when_colored{0};  ///< points and views
  std::thread recording_thread;
  std::vector<ros::Subscriber> subscribers;
  std::vector<image_transport::Subscriber> image_subscribers;
  std::vector<ros::ServiceServer> services;
  std::vector<ros::WallTimer> timers;
  ros::AsyncSpinner service_spinner, sensor_spinner;
};

ColorizerNode::ColorizerNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const AllParams& params)
    : impl_(new Impl(node, private_node, params)) {}
ColorizerNode::~ColorizerNode() = default;

const std::string& ColorizerNode::recordingDirectory() const {
  return impl_->directory;
}

bool ColorizerNode::finish(const std::function<bool()>& aborted) {
  impl_->stopping = true;  // ends what a service call is doing; finished units of work are used again
  impl_->stopRecording();
  const std::string& path = impl_->params.node.save_path;
  ROS_INFO_STREAM("the recording is in " << impl_->directory << "\n" << impl_->describeCounters());
  if (path.empty()) return true;
  ROS_INFO_STREAM("colouring the map to save it to " << path << "; another Ctrl-C gives up");
  JobResult result = impl_->colorizeNow(aborted);
  if (result.success) result = impl_->job.save(path, aborted);
  if (!result.success) {
    ROS_ERROR_STREAM("the map is not saved: " << result.message << ". Nothing recorded is lost; to go on: rosrun "
                                              << "cloud_colorizer colorize " << impl_->directory << " --output "
                                              << path);
  }
  return result.success;
}

}  // namespace cloud_colorizer
