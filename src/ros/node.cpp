// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "ros/node.hpp"

#include <cloud_colorizer/SaveMap.h>
#include <image_transport/image_transport.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <topic_tools/shape_shifter.h>

#include <atomic>
#include <filesystem>
#include <future>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "ros/live_preview.hpp"
#include "ros/livox.hpp"
#include "ros/map_job.hpp"
#include "ros/node_log.hpp"
#include "ros/node_output.hpp"
#include "ros/recording_session.hpp"
#include "ros/save_place.hpp"
#include "ros/topic_monitor.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::chrono::seconds kSilence(5);
constexpr std::size_t kMaxTransforms = 100000;  // tf messages that wait to be recorded

}  // namespace

struct ColorizerNode::Impl {
  Impl(const ros::NodeHandle& node_in, const ros::NodeHandle& private_node_in, const AllParams& params_in)
      : node(node_in),
        private_node(private_node_in),
        sensor_node(node_in),
        params(params_in),
        output(node_in, private_node_in, params.node),
        preview(params, output, errors),
        job(
            params.core, [this](const Recording& map, const Params& core) { output.publishMap(map, core); },
            params.node.report),
        session(resolveRecordingDirectory(params.node.recording_dir), params.node.collector, collectorEvents(), errors),
        save_place(saveDirectory()),
        service_spinner(4, &service_queue),
        sensor_spinner(1, &sensor_queue) {
    if (!params.node.save_path.empty()) CloudWriter::checkPath(params.node.save_path);
    node.setCallbackQueue(&service_queue);
    private_node.setCallbackQueue(&service_queue);
    sensor_node.setCallbackQueue(&sensor_queue);
    const SessionState state = session.state();
    ROS_INFO_STREAM("recording into " << session.directory() << " (" << state.points << " points and " << state.views
                                      << " views so far)");
    subscribe();
    advertise();
    service_spinner.start();
    sensor_spinner.start();
  }

  ~Impl() { stopRecording(); }

  std::string saveDirectory() const {
    if (!params.node.save_dir.empty()) return params.node.save_dir;
    return std::filesystem::path(session.directory()).parent_path().string();
  }

  // ---- messages in ----

  template <class Message>
  using Add = std::function<void(Collector&, const boost::shared_ptr<const Message>&)>;

  /// What is called with each message of the topic `name`: puts it into the inbox.
  template <class Message>
  boost::function<void(const boost::shared_ptr<const Message>&)> receiver(const std::string& name, bool is_data,
                                                                          const Add<Message>& add) {
    if (is_data) monitor.watch(name);
    return [this, add, is_data, name](const boost::shared_ptr<const Message>& message) {
      errors.guard(name, [&] { take(name, is_data, [add, message](Collector& to) { add(to, message); }); });
    };
  }

  template <class Message>
  void subscribeTo(const std::string& topic, bool is_data, const Add<Message>& add) {
    const std::uint32_t queue_size = is_data ? static_cast<std::uint32_t>(params.node.queue_size) : 1000;
    subscribers.push_back(sensor_node.subscribe<Message>(topic, queue_size,
                                                         receiver<Message>(node.resolveName(topic), is_data, add),
                                                         ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
  }

  void take(const std::string& topic, bool is_data, Inbox::Task task) {
    if (is_data) monitor.count(topic);
    if (is_data && paused) return;
    // Transforms are small and must not get lost.
    const std::size_t limit = is_data ? static_cast<std::size_t>(params.node.queue_size) : kMaxTransforms;
    if (session.push(topic, limit, std::move(task))) return;
    monitor.countDropped(topic);
    ROS_WARN_STREAM_THROTTLE_NAMED(10, "dropped",
                                   "recording is too slow: messages of "
                                       << topic << " are dropped; compress images, use a larger "
                                       << "~voxel_size, or raise ~queue_size (see /diagnostics)");
  }

  void subscribe() {
    subscribeTo<tf2_msgs::TFMessage>("/tf", false,
                                     [](Collector& to, const auto& message) { to.addTransforms(*message, false); });
    subscribeTo<tf2_msgs::TFMessage>("/tf_static", false,
                                     [](Collector& to, const auto& message) { to.addTransforms(*message, true); });
    subscribeTo<topic_tools::ShapeShifter>("cloud_in", true,
                                           [](Collector& to, const auto& message) { to.addCloud(cloudOf(*message)); });
    for (std::size_t i = 0; i < params.node.collector.cameras.size(); ++i) {
      const std::string camera = "camera_" + std::to_string(i);
      if (!params.node.collector.cameras[i].isPanorama()) {
        subscribeTo<sensor_msgs::CameraInfo>(camera + "/camera_info", true,
                                             [i](Collector& to, const auto& message) { to.addCameraInfo(i, message); });
      }
      if (params.node.collector.cameras[i].masks) {
        subscribeTo<sensor_msgs::Image>(camera + "/mask", true,
                                        [i](Collector& to, const auto& message) { to.addMask(i, message); });
      }
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

  CollectorEvents collectorEvents() {
    CollectorEvents events;
    events.log = logLine;
    if (params.node.preview_period > 0) {
      events.cloud_kept = [this](const Cloud& cloud, const Eigen::Isometry3d& map_from_sensor, double) {
        preview.addCloud(cloud, map_from_sensor);
      };
    }
    events.view_kept = [this](std::size_t camera, const View& view, const Intrinsics& intrinsics,
                              const SharedBytes& bytes) { preview.addView(camera, view, intrinsics, bytes); };
    return events;
  }

  /// False when something was not recorded.
  bool stopRecording() {
    stopping = true;  // ends what a service call is doing; finished units of work are used again
    for (ros::Subscriber& subscriber : subscribers) subscriber.shutdown();
    for (image_transport::Subscriber& subscriber : image_subscribers) subscriber.shutdown();
    sensor_spinner.stop();
    const bool complete = session.stop();
    service_spinner.stop();
    if (background.valid()) background.wait();
    return complete;
  }

  // ---- services ----

  void advertise() {
    using std_srvs::Trigger;
    serve<Trigger>("colorize", [this](const auto&) { return colorizeNow(); });
    serve<SaveMap>("save_map", [this](const SaveMap::Request& request) { return saveMap(request); });
    serve<Trigger>("reset", [this](const auto&) { return reset(); });
    serve<Trigger>("pause", [this](const auto&) { return setPaused(true); });
    serve<Trigger>("resume", [this](const auto&) { return setPaused(false); });
    repeat("status", 1, [this] {
      warnOfSilence();
      publishStatus();
      colorizeAfterSilence();
    });
    if (params.node.preview_period > 0) repeat("preview", params.node.preview_period, [this] { publishPreview(); });
  }

  template <class Service>
  void serve(const std::string& name, const std::function<JobResult(const typename Service::Request&)>& answer) {
    const boost::function<bool(typename Service::Request&, typename Service::Response&)> callback =
        [this, name, answer](auto& request, auto& response) {
          JobResult result;
          const auto error = errors.guard("~" + name, [&] { result = answer(request); });
          response.success = !error && result.success;
          response.message = error ? *error : result.message;
          return true;
        };
    services.push_back(private_node.advertiseService(name, callback));
  }

  void repeat(const std::string& name, double period, const std::function<void()>& action) {
    timers.push_back(node.createWallTimer(ros::WallDuration(period),
                                          [this, name, action](const auto&) { errors.guard(name, action); }));
  }

  MapJob::Aborted whenStopping() {
    return [this] { return stopping.load(); };
  }

  /// What the log says of a job that did not do what was hoped for.
  JobResult explained(const JobResult& result) {
    if (result.success && job.status().num_colored > 0) return result;
    ROS_WARN_STREAM("what was received:\n" << session.state().stats.describe());
    return result;
  }

  JobResult colorizeNow() {
    return explained(job.colorize([this] { return session.snapshot(); }, whenStopping()));
  }

  JobResult saveMap(const SaveMap::Request& request) {
    std::string file;
    const auto path = [&] { return file = save_place.resolve(request.path, request.overwrite != 0); };
    try {
      path();  // before the work
    } catch (const std::runtime_error& error) {
      return {false, error.what()};
    }
    const JobResult result = job.save([this] { return session.snapshot(); }, path, whenStopping());
    if (result.success) save_place.own(file);
    return explained(result);
  }

  JobResult reset() {
    const auto alone = job.reserve();
    if (!alone) return {false, "the map is being coloured or saved; try again when that is done"};
    const std::string kept = session.startAnew();
    job.forget();
    preview.clear();
    const std::string old = kept.empty() ? "the old one was gone" : "the old one is kept in " + kept;
    ROS_INFO_STREAM("reset: " << old);
    return {true, "a new recording begins in " + session.directory() + "; " + old};
  }

  JobResult setPaused(bool value) {
    const bool before = paused.exchange(value);
    return {true, std::string(before == value ? "already " : "") + (value ? "paused" : "recording")};
  }

  // ---- timers ----

  void warnOfSilence() {
    if (paused) return;
    std::string list;
    for (const std::string& topic : monitor.newlySilent(kSilence)) list += (list.empty() ? "" : ", ") + topic;
    if (!list.empty()) ROS_WARN_STREAM_NAMED("silence", "no message for " << kSilence.count() << " s on: " << list);
  }

  void publishStatus() {
    NodeState state;
    state.session = session.state();
    const double silence = monitor.secondsOfSilence();
    state.stage = paused ? "paused" : silence >= 0 && silence < 2 ? "recording" : "idle";
    if (!state.session.error.empty()) state.stage = "error";
    state.directory = session.directory();
    state.job = job.status();
    state.topics = monitor.report();
    state.errors = errors.rows();
    output.publishStatus(state);
  }

  /// In a thread of its own, as the timer's has the status to publish.
  void colorizeAfterSilence() {
    const double limit = params.node.colorize_after;
    if (limit <= 0 || stopping || monitor.secondsOfSilence() < limit) return;
    if (background.valid() && background.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    const SessionState state = session.state();
    const std::size_t amount = state.points + state.views;
    if (amount == 0 || amount == tried_amount || !state.error.empty()) return;
    tried_amount = amount;  // also where it fails: once more only after something new
    ROS_INFO_STREAM("no message for " << limit << " s: colouring the map");
    background = std::async(std::launch::async, [this] { errors.guard("colorize_after", [this] { colorizeNow(); }); });
  }

  void publishPreview() {
    const auto origin = session.origin();
    if (origin) preview.publish(*origin);
  }

  // Callback queues come before the handles and spinners that use them.
  ros::CallbackQueue service_queue, sensor_queue;
  ros::NodeHandle node, private_node, sensor_node;
  AllParams params;
  ErrorLog errors;
  TopicMonitor monitor;
  std::atomic<bool> paused{false}, stopping{false};
  NodeOutput output;
  LivePreview preview;
  MapJob job;
  RecordingSession session;
  SavePlace save_place;
  std::future<void> background;  ///< colouring after silence; used by the status timer only
  std::size_t tried_amount = 0;  ///< points and views that were coloured after silence
  std::vector<ros::Subscriber> subscribers;
  std::vector<image_transport::Subscriber> image_subscribers;
  std::vector<ros::ServiceServer> services;
  std::vector<ros::WallTimer> timers;
  ros::AsyncSpinner service_spinner, sensor_spinner;
};

ColorizerNode::ColorizerNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const AllParams& params)
    : impl_(new Impl(node, private_node, params)) {}
ColorizerNode::~ColorizerNode() = default;

bool ColorizerNode::finish(const std::function<bool()>& aborted) {
  const bool complete = impl_->stopRecording();
  const std::string& path = impl_->params.node.save_path;
  const std::string& directory = impl_->session.directory();
  ROS_INFO_STREAM("the recording is in " << directory << "\n" << impl_->session.state().stats.describe());
  if (path.empty()) return complete;
  ROS_INFO_STREAM("colouring the map to save it to " << path << "; another Ctrl-C gives up");
  const JobResult result =
      impl_->explained(impl_->job.save([this] { return impl_->session.snapshot(); }, [&] { return path; }, aborted));
  if (!result.success) {
    ROS_ERROR_STREAM("the map is not saved: " << result.message << ". Nothing recorded is lost; to go on: rosrun "
                                              << "cloud_colorizer colorize " << directory << " --output " << path);
  }
  return complete && result.success;
}

}  // namespace cloud_colorizer
