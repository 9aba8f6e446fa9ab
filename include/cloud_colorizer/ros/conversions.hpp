// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Messages to the core's types and back. Everything that cannot be converted throws std::invalid_argument with the
/// reason; nothing is guessed.
#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Any field order, padding between fields and rows, byte order and number types. NaN passes through. One pass.
/// Throws for a missing x, y or z, a field twice, or sizes that contradict each other.
Cloud cloudFromMessage(const sensor_msgs::PointCloud2& message);

/// Appends to a message that is empty or was made by this function from the same fields: packed, x y z as FLOAT32,
/// height 1, native byte order. Throws where the fields differ or the data would not fit into 4 GB.
void appendToMessage(const Cloud& cloud, sensor_msgs::PointCloud2& message);

/// The intrinsics of the images that belong to a camera_info, with region of interest and binning applied.
struct CameraFromInfo {
  Intrinsics intrinsics;
  Eigen::Vector3d baseline{0, 0, 0};  ///< m, where P places a rectified camera in the frame of its camera_info
  std::string warning;                ///< what had to be assumed; empty when nothing
};
/// `rectified`: the images are rectified, so P counts and there is no distortion. Throws: K[0] = 0 (uncalibrated), no
/// size, unknown model, coefficients that the model does not have.
CameraFromInfo cameraFromMessage(const sensor_msgs::CameraInfo& message, bool rectified);

struct EncodedInfo {
  cv::Size size;           ///< px
  std::string extension;   ///< "jpg" or "png"
  int channels = 3;        ///< 1: grey
  int depth = 8;           ///< bits a channel
  bool is_mosaic = false;  ///< one channel of a Bayer pattern, as the message's format says
};
/// Looks at the headers and at the end of a JPEG or PNG (not at the pixels). Throws: another format, truncated, or,
/// where colours are asked for, what has none (depths).
EncodedInfo inspectCompressed(const sensor_msgs::CompressedImage& message, ImageKind kind = ImageKind::kColor);

/// Throws when the encoding is unknown or the data is shorter than height * step. Costs nothing.
void checkImage(const sensor_msgs::Image& message, ImageKind kind = ImageKind::kColor);

/// The numbers of an image that shows no colours, as they are: mono, 8UC(k), 16UC(k) or 32FC(k). Throws on another
/// encoding.
cv::Mat valuesFromMessage(const sensor_msgs::Image& message, ImageKind kind);

/// CV_8UC1, CV_16UC1 or CV_8UC3 (BGR). May share the message's data. The colours that cv_bridge knows (mono, rgb, rgba,
/// bgr, bgra, bayer_* of 8 or 16 bits, yuv422), 8UC1, 8UC3, 8UC4, 16UC3, 16UC4 in OpenCV's order, and what newer
/// drivers send: uyvy, yuv422_yuy2 (yuyv), nv12, nv21, nv24 (planes one after another, each row of `step` bytes).
cv::Mat imageFromMessage(const sensor_msgs::Image& message);

/// Decodes, and makes colours of a Bayer mosaic. Throws as inspectCompressed does.
cv::Mat imageFromMessage(const sensor_msgs::CompressedImage& message);

/// Encoding of the pixels that an image_transport compressed, "bayer_rggb8" of "bayer_rggb8; jpeg compressed "; empty
/// where the format does not say it.
std::string encodingOfFormat(const std::string& format);
/// Whether the numbers of an encoding are depths or other values: 16UC1, 32FC1 and the like. A grey camera of 16 bits
/// is mono16.
bool isOfValues(const std::string& encoding);
bool isGrey(const std::string& encoding);  ///< mono8, mono16, 8UC1

bool isWide(const sensor_msgs::Image& message);  ///< 16 bits a channel
/// Where a good image with alpha is opaque: 0 elsewhere; empty where all of it is.
cv::Mat opaquePixels(const sensor_msgs::Image& message);

}  // namespace cloud_colorizer
