// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A tiny drive for tests: a vehicle goes along x past two walls; the walls are of one colour each.
#pragma once

#include <rosbag/bag.h>

#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ros/messages.hpp"

namespace cloud_colorizer {
namespace testing_ros {

/// Topics: /points; /camera_0/image/compressed (JPEG) and /camera_1/image (bgr8), each with camera_info; /tf,
/// /tf_static. Camera 0 looks to the left at a red wall (y = 4), camera 1 to the right at a blue one (y = -4).
struct SmallDrive {
  std::size_t num_frames = 8;
  double first_stamp = 1000;  ///< s
  double period = 1;          ///< s
  double step = 1;            ///< m between frames
  double tf_delay = 0;        ///< s between a transform's stamp and its arrival
  int loops = 1;              ///< how often it is driven with the same stamps
  int width = 64, height = 48;
  std::string fixed_topic = "/tf_static";
  bool noisy = false;  ///< raw images of noise, which take long as PNG

  void write(const std::string& file) const {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    const ros::Time start(first_stamp);
    bag.write(fixed_topic, start, fixedFrames());
    for (int loop = 0; loop < loops; ++loop) {
      for (std::size_t i = 0; i < num_frames; ++i) writeFrame(bag, i, loop);
    }
    bag.close();
  }

  double stampOf(std::size_t frame) const { return first_stamp + period * static_cast<double>(frame); }
  double positionOf(std::size_t frame) const { return step * static_cast<double>(frame); }

  sensor_msgs::PointCloud2 cloud(std::size_t frame) const {
    auto message = PointWriter().field("x", 7).field("y", 7).field("z", 7).field("intensity", 7).done(41 * 21 * 2, 1);
    std::uint8_t* out = message.data.data();
    for (const float y : {4.F, -4.F}) {
      for (int ix = -20; ix <= 20; ++ix) {
        for (int iz = -10; iz <= 10; ++iz, out += message.point_step) {
          const float point[4] = {0.1F * static_cast<float>(ix), y, 0.1F * static_cast<float>(iz), 7};
          std::memcpy(out, point, sizeof(point));
        }
      }
    }
    stamp(message, frame, "lidar");
    return message;
  }

  cv::Mat3b picture(int camera) const {
    return cv::Mat3b(height, width, camera == 0 ? cv::Vec3b(20, 30, 200) : cv::Vec3b(200, 30, 20));
  }

  sensor_msgs::CompressedImage compressedImage(std::size_t frame) const {
    auto message = encoded(picture(0), "jpg");
    stamp(message, frame, "camera_0");
    return message;
  }

  sensor_msgs::Image rawImage(std::size_t frame, int camera) const {
    const cv::Mat3b image = picture(camera);
    sensor_msgs::Image message;
    message.encoding = "bgr8";
    message.width = static_cast<std::uint32_t>(width);
    message.height = static_cast<std::uint32_t>(height);
    message.step = message.width * 3;
    message.data.assign(image.data, image.data + message.step * message.height);
    if (noisy) {
      cv::Mat pixels(1, static_cast<int>(message.data.size()), CV_8UC1, message.data.data());
      cv::randu(pixels, 0, 255);
    }
    stamp(message, frame, "camera_" + std::to_string(camera));
    return message;
  }

  sensor_msgs::CameraInfo cameraInfo(std::size_t frame, int camera) const {
    auto message = infoMessage(static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
    message.D.assign(5, 0.0);
    message.K[0] = message.K[4] = width;
    stamp(message, frame, "camera_" + std::to_string(camera));
    return message;
  }

  tf2_msgs::TFMessage pose(std::size_t frame) const {
    return transformMessage("map", "lidar", stampOf(frame), positionOf(frame));
  }

  static tf2_msgs::TFMessage fixedFrames() {
    tf2_msgs::TFMessage message;
    for (const double side : {1.0, -1.0}) {
      auto transform = transformMessage("lidar", side > 0 ? "camera_0" : "camera_1", 0, 0).transforms[0];
      // Optical frame: z along +-y of the lidar, y down.
      auto& q = transform.transform.rotation;
      q.w = side > 0 ? std::sqrt(0.5) : 0;
      q.x = side > 0 ? -std::sqrt(0.5) : 0;
      q.y = side > 0 ? 0 : std::sqrt(0.5);
      q.z = side > 0 ? 0 : -std::sqrt(0.5);
      message.transforms.push_back(transform);
    }
    return message;
  }

 private:
  template <class Message>
  void stamp(Message& message, std::size_t frame, const std::string& frame_id) const {
    message.header.stamp.fromSec(stampOf(frame));
    message.header.frame_id = frame_id;
  }

  void writeFrame(rosbag::Bag& bag, std::size_t i, int loop) const {
    const ros::Time time(stampOf(i) + loop * 1000.0 + 0.01);
    bag.write("/tf", time + ros::Duration(tf_delay - 0.005), pose(i));
    bag.write("/points", time, cloud(i));
    bag.write("/camera_0/camera_info", time, cameraInfo(i, 0));
    bag.write("/camera_0/image/compressed", time, compressedImage(i));
    bag.write("/camera_1/camera_info", time, cameraInfo(i, 1));
    bag.write("/camera_1/image", time, rawImage(i, 1));
  }
};

}  // namespace testing_ros
}  // namespace cloud_colorizer
