// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Messages for tests.
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace cloud_colorizer {
namespace testing_ros {

/// Makes clouds of any layout; the value of a field at a point follows from the names (see value()).
class PointWriter {
 public:
  bool big_endian = false;
  std::uint32_t row_padding = 0;

  PointWriter& field(const std::string& name, std::uint8_t datatype) {
    sensor_msgs::PointField f;
    f.name = name;
    f.datatype = datatype;
    f.offset = step_;
    f.count = 1;
    fields_.push_back(f);
    static const std::uint32_t kSizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    step_ += kSizes[datatype];
    return *this;
  }
  PointWriter& pad(std::uint32_t bytes) {
    step_ += bytes;
    return *this;
  }

  static double value(const std::string& name, int point) { return name[0] + 3 * point + 1; }

  sensor_msgs::PointCloud2 done(std::uint32_t width, std::uint32_t height) const {
    sensor_msgs::PointCloud2 message;
    message.fields = fields_;
    message.is_bigendian = big_endian;
    message.width = width;
    message.height = height;
    message.point_step = step_;
    message.row_step = width * step_ + row_padding;
    message.data.assign(std::size_t{message.row_step} * height, 0xAB);
    for (std::uint32_t row = 0; row < height; ++row) {
      for (std::uint32_t col = 0; col < width; ++col) {
        for (const auto& f : fields_) {
          write(&message.data[row * message.row_step + col * step_ + f.offset], f.datatype,
                value(f.name, static_cast<int>(row * width + col)));
        }
      }
    }
    return message;
  }

 private:
  template <class T>
  void writeAs(std::uint8_t* out, double value) const {
    const T typed = static_cast<T>(value);
    std::memcpy(out, &typed, sizeof(T));
    if (big_endian) std::reverse(out, out + sizeof(T));
  }
  void write(std::uint8_t* out, std::uint8_t datatype, double value) const {
    if (datatype == 4) writeAs<std::uint16_t>(out, value);
    if (datatype == 5) writeAs<std::int32_t>(out, value);
    if (datatype == 7) writeAs<float>(out, value);
    if (datatype == 8) writeAs<double>(out, value);
  }

  std::vector<sensor_msgs::PointField> fields_;
  std::uint32_t step_ = 0;
};

inline sensor_msgs::CameraInfo infoMessage(std::uint32_t width, std::uint32_t height) {
  sensor_msgs::CameraInfo info;
  info.width = width;
  info.height = height;
  info.distortion_model = "plumb_bob";
  info.D = {-0.1, 0.01, 0, 0, 0};
  info.K = {400, 0, width / 2.0, 0, 400, height / 2.0, 0, 0, 1};
  info.P = {400, 0, width / 2.0, 0, 0, 400, height / 2.0, 0, 0, 0, 1, 0};
  return info;
}

inline sensor_msgs::CompressedImage encoded(const cv::Mat& image, const std::string& extension) {
  sensor_msgs::CompressedImage message;
  message.format = extension == "jpg" ? "jpeg" : extension;
  cv::imencode("." + extension, image, message.data);
  return message;
}

/// Every two pixels of a row are `pixel_pair`.
inline sensor_msgs::Image imageMessage(const std::string& encoding, std::uint32_t width, std::uint32_t height,
                                       const std::vector<std::uint8_t>& pixel_pair) {
  sensor_msgs::Image message;
  message.encoding = encoding;
  message.width = width;
  message.height = height;
  message.step = static_cast<std::uint32_t>(pixel_pair.size()) * width / 2;
  for (std::uint32_t i = 0; i < width * height / 2; ++i) {
    message.data.insert(message.data.end(), pixel_pair.begin(), pixel_pair.end());
  }
  return message;
}

inline tf2_msgs::TFMessage transformMessage(const std::string& parent, const std::string& child, double stamp, double x,
                                            double y = 0, double z = 0) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = parent;
  transform.header.stamp.fromSec(stamp);
  transform.child_frame_id = child;
  transform.transform.translation.x = x;
  transform.transform.translation.y = y;
  transform.transform.translation.z = z;
  transform.transform.rotation.w = 1;
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  return message;
}

}  // namespace testing_ros
}  // namespace cloud_colorizer
