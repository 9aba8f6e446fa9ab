// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "apps/drive_bag.hpp"

#include <geometry_msgs/TransformStamped.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <cstring>

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
  const Eigen::Quaterniond q(pose.linear());
  geometry_msgs::TransformStamped t;
  t.header.frame_id = parent;
  t.header.stamp = stamp;
  t.child_frame_id = child;
  t.transform.translation.x = pose.translation().x();
  t.transform.translation.y = pose.translation().y();
  t.transform.translation.z = pose.translation().z();
  t.transform.rotation.x = q.x();
  t.transform.rotation.y = q.y();
  t.transform.rotation.z = q.z();
  t.transform.rotation.w = q.w();
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
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2 cloud;
  const auto addField = [&](const char* name, std::uint32_t offset, std::uint8_t type) {
    PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = type;
    field.count = 1;
    cloud.fields.push_back(field);
  };
  addField("x", 0, PointField::FLOAT32);
  addField("y", 4, PointField::FLOAT32);
  addField("z", 8, PointField::FLOAT32);
  addField("intensity", 12, PointField::FLOAT32);
  addField("ring", 16, PointField::UINT16);
  addField("time", 18, PointField::FLOAT32);
  cloud.point_step = 22;
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(returns.size());
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.is_bigendian = 0;
  cloud.is_dense = 1;
  cloud.data.resize(cloud.row_step);
  std::uint8_t* out = cloud.data.data();
  for (const Return& r : returns) {
    std::memcpy(out, r.point.data(), 12);
    std::memcpy(out + 12, &r.intensity, 4);
    std::memcpy(out + 16, &r.ring, 2);
    std::memcpy(out + 18, &r.time, 4);
    out += cloud.point_step;
  }
  return cloud;
}

}  // namespace

struct DriveBag::Impl {
  explicit Impl(const Drive& d) : drive(d) {}
  const Drive& drive;
  rosbag::Bag bag;
  int next_pose = 0;

  template <class Message>
  void write(const std::string& topic, double received, const Message& message) {
    bag.write(topic, timeOf(drive.stamp(received)), message);
  }
};

std::string imageTopic(const Drive& drive, int camera) {
  const std::string topic = "/" + drive.cameras().at(static_cast<std::size_t>(camera)).name + "/image";
  return drive.options().image_transport == "raw" ? topic : topic + "/compressed";
}

DriveBag::DriveBag(const std::string& path, const Drive& drive) : impl_(std::make_unique<Impl>(drive)) {
  impl_->bag.open(path, rosbag::bagmode::Write);
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

DriveBag::~DriveBag() = default;

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

void DriveBag::writeImage(int camera, int frame, const EncodedImage& image) {
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
    message.data = image.bytes;
    impl_->write(imageTopic(impl_->drive, camera), received, message);
  } else {
    sensor_msgs::CompressedImage message;
    message.header = info.header;
    message.format = "rgb8; jpeg compressed bgr8";
    message.data = image.bytes;
    impl_->write(imageTopic(impl_->drive, camera), received, message);
  }
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
}

}  // namespace cloud_colorizer::simulation
