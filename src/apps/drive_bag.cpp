// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "apps/drive_bag.hpp"

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kPoseRate = 100;   // Hz
constexpr double kLatency = 0.015;  // s from the shutter to the receiver

ros::Time timeOf(std::int64_t stamp) {
  ros::Time time;
  return time.fromNSec(static_cast<std::uint64_t>(stamp));
}

geometry_msgs::TransformStamped transformOf(const Eigen::Isometry3d& pose, const std::string& parent,
                                            const std::string& child, const ros::Time& stamp) {
  geometry_msgs::TransformStamped t = tf2::eigenToTransform(pose);
  t.header.frame_id = parent;
  t.header.stamp = stamp;
  t.child_frame_id = child;
  return t;
}

sensor_msgs::CameraInfo cameraInfoOf(const DriveCamera& camera) {
  const Intrinsics& k = camera.camera.intrinsics();
  sensor_msgs::CameraInfo info;
  info.width = static_cast<std::uint32_t>(k.width);
  info.height = static_cast<std::uint32_t>(k.height);
  info.distortion_model = toString(k.model);
  info.D = k.distortion;
  info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {k.fx, 0, k.cx, 0, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
  info.header.frame_id = camera.frame;
  return info;
}

/// Packed as the drivers of spinning LiDARs do: x y z intensity ring time, 22 bytes.
sensor_msgs::PointCloud2 cloudOf(const std::vector<Return>& returns) {
  Cloud cloud;
  cloud.fields = {{"intensity", FieldType::kFloat32}, {"ring", FieldType::kUint16}, {"time", FieldType::kFloat32}};
  cloud.positions.resize(3, static_cast<Eigen::Index>(returns.size()));
  cloud.records.resize(10 * returns.size());
  std::uint8_t* record = cloud.records.data();
  for (std::size_t i = 0; i < returns.size(); ++i, record += 10) {
    cloud.positions.col(static_cast<Eigen::Index>(i)) = returns[i].point.cast<double>();
    std::memcpy(record, &returns[i].intensity, 4);
    std::memcpy(record + 4, &returns[i].ring, 2);
    std::memcpy(record + 6, &returns[i].time, 4);
  }
  sensor_msgs::PointCloud2 message;
  appendToMessage(cloud, message);
  return message;
}

}  // namespace

struct DriveBag::Impl {
  const Drive& drive;
  std::string path;
  rosbag::Bag bag;
  int next_pose = 0;
  bool is_whole = false;

  std::string partial() const { return path + ".part"; }
  template <class Message>
  void write(const std::string& topic, double received, const Message& message) {
    bag.write(topic, timeOf(drive.stamp(received)), message);
  }
};

std::string imageTopic(const Drive& drive, int camera) {
  const std::string topic = "/" + drive.cameras().at(static_cast<std::size_t>(camera)).name + "/image";
  return drive.options().image_transport == "raw" ? topic : topic + "/compressed";
}

DriveBag::DriveBag(const std::string& path, const Drive& drive) : impl_(new Impl{drive, path, {}}) {
  impl_->bag.open(impl_->partial(), rosbag::bagmode::Write);
  tf2_msgs::TFMessage mounts;
  const ros::Time start = timeOf(drive.stamp(0));
  mounts.transforms.push_back(transformOf(drive.baseFromLidar(), "base_link", "lidar", start));
  for (const DriveCamera& camera : drive.cameras()) {
    mounts.transforms.push_back(transformOf(camera.base_from_camera_given, "base_link", camera.frame, start));
  }
  const auto latched = boost::make_shared<ros::M_string>();
  (*latched)["latching"] = "1";
  (*latched)["callerid"] = "/simulate";
  (*latched)["topic"] = "/tf_static";
  (*latched)["type"] = ros::message_traits::datatype(mounts);
  (*latched)["md5sum"] = ros::message_traits::md5sum(mounts);
  (*latched)["message_definition"] = ros::message_traits::definition(mounts);
  impl_->bag.write("/tf_static", start, mounts, latched);
}

DriveBag::~DriveBag() {
  std::error_code ignored;
  if (!impl_->is_whole) std::filesystem::remove(impl_->partial(), ignored);
}

void DriveBag::writePosesUntil(double time) {
  for (;; ++impl_->next_pose) {
    const double sample = impl_->next_pose / kPoseRate;
    if (sample > time) return;
    tf2_msgs::TFMessage message;
    message.transforms.push_back(
        transformOf(impl_->drive.mapFromBaseGiven(sample), "map", "base_link", timeOf(impl_->drive.stamp(sample))));
    impl_->write("/tf", sample, message);
  }
}

void DriveBag::writeImage(int camera, int frame, const ImageBytes& image) {
  const DriveCamera& c = impl_->drive.cameras().at(static_cast<std::size_t>(camera));
  const double received = impl_->drive.imageTime(camera, frame) + kLatency;
  sensor_msgs::CameraInfo info = cameraInfoOf(c);
  info.header.stamp = timeOf(impl_->drive.imageStamp(camera, frame));
  info.header.seq = static_cast<std::uint32_t>(frame);
  impl_->write("/" + c.name + "/camera_info", received, info);
  if (impl_->drive.options().image_transport == "raw") {
    sensor_msgs::Image message;
    message.header = info.header;
    message.width = info.width;
    message.height = info.height;
    message.encoding = "rgb8";
    message.step = 3 * info.width;
    message.data = image;
    impl_->write(imageTopic(impl_->drive, camera), received, message);
  } else {
    sensor_msgs::CompressedImage message;
    message.header = info.header;
    message.format = "rgb8; jpeg compressed bgr8";
    message.data = image;
    impl_->write(imageTopic(impl_->drive, camera), received, message);
  }
}

void DriveBag::writeQuantities(int camera, int frame, const QuantityImages& images) {
  const DriveCamera& c = impl_->drive.cameras().at(static_cast<std::size_t>(camera));
  const double received = impl_->drive.imageTime(camera, frame) + kLatency;
  sensor_msgs::CompressedImage labels;
  labels.header.frame_id = c.frame;
  labels.header.stamp = timeOf(impl_->drive.imageStamp(camera, frame));
  labels.header.seq = static_cast<std::uint32_t>(frame);
  labels.format = "mono8; png compressed ";
  require(cv::imencode(".png", images.labels, labels.data), "OpenCV cannot encode PNG images");
  impl_->write("/" + c.name + "/labels/compressed", received, labels);
  sensor_msgs::Image thermal;
  thermal.header = labels.header;
  thermal.width = static_cast<std::uint32_t>(images.thermal.cols);
  thermal.height = static_cast<std::uint32_t>(images.thermal.rows);
  thermal.encoding = "16UC1";
  thermal.step = 2 * thermal.width;
  const auto* const bytes = images.thermal.ptr<std::uint8_t>();
  thermal.data.assign(bytes, bytes + images.thermal.total() * 2);
  impl_->write("/" + c.name + "/thermal", received, thermal);
}

void DriveBag::writeScan(int frame, const std::vector<Return>& returns) {
  const double start = impl_->drive.scanTime(frame);
  sensor_msgs::PointCloud2 cloud = cloudOf(returns);
  cloud.header.frame_id = "lidar";
  cloud.header.stamp = timeOf(impl_->drive.stamp(start));
  cloud.header.seq = static_cast<std::uint32_t>(frame);
  impl_->write(kCloudTopic, start + 1 / impl_->drive.options().rate, cloud);
}

void DriveBag::close() {
  impl_->bag.close();
  std::filesystem::rename(impl_->partial(), impl_->path);
  impl_->is_whole = true;
}

}  // namespace cloud_colorizer::simulation
