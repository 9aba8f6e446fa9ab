// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// conversions.hpp: camera_info, raw and compressed images.

#include <algorithm>
#include <cstring>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"

namespace cloud_colorizer {
namespace {

using sensor_msgs::CameraInfo;
using Invalid = std::invalid_argument;

void readDistortion(const CameraInfo& message, CameraFromInfo& camera) {
  Intrinsics& intrinsics = camera.intrinsics;
  intrinsics.distortion.assign(message.D.begin(), message.D.end());
  while (!intrinsics.distortion.empty() && intrinsics.distortion.back() == 0) intrinsics.distortion.pop_back();
  if (message.distortion_model.empty()) {
    require<Invalid>(intrinsics.distortion.empty(), "camera_info: D is given without a distortion_model");
    camera.warning = "camera_info has no distortion_model; with D = 0 it is taken as plumb_bob";
    return;
  }
  try {
    intrinsics.model = distortionModelFromString(message.distortion_model);
  } catch (const Invalid& error) {
    throw Invalid(std::string("camera_info: ") + error.what());
  }
  if (intrinsics.model == DistortionModel::kPlumbBob && intrinsics.distortion.size() > 5) {
    intrinsics.model = DistortionModel::kRationalPolynomial;
    camera.warning = "camera_info calls " + std::to_string(intrinsics.distortion.size()) +
                     " coefficients plumb_bob; they are taken as rational_polynomial";
  }
}

/// Region of interest, then binning, as image_geometry does: drivers bin by taking every n-th pixel from the first.
void applyRoiAndBinning(const CameraInfo& message, Intrinsics& intrinsics) {
  const int bin_x = static_cast<int>(std::max<std::uint32_t>(message.binning_x, 1));
  const int bin_y = static_cast<int>(std::max<std::uint32_t>(message.binning_y, 1));
  const auto& roi = message.roi;
  const std::uint32_t width = roi.width != 0 ? roi.width : message.width;
  const std::uint32_t height = roi.height != 0 ? roi.height : message.height;
  require<Invalid>(std::uint64_t{roi.x_offset} + roi.width <= message.width &&
                       std::uint64_t{roi.y_offset} + roi.height <= message.height,
                   "camera_info: the roi (", roi.x_offset, ", ", roi.y_offset, ") + ", roi.width, " x ", roi.height,
                   " is not inside the image of ", message.width, " x ", message.height);
  intrinsics.width = static_cast<int>(width) / bin_x;
  intrinsics.height = static_cast<int>(height) / bin_y;
  intrinsics.cx = (intrinsics.cx - roi.x_offset) / bin_x;
  intrinsics.cy = (intrinsics.cy - roi.y_offset) / bin_y;
  intrinsics.fx /= bin_x;
  intrinsics.fy /= bin_y;
}

std::size_t bigEndian(const std::uint8_t* bytes, int count) {
  std::size_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8U | bytes[i];
  return value;
}

cv::Size sizeFromBytes(const std::uint8_t* width, const std::uint8_t* height, int count) {
  return {static_cast<int>(bigEndian(width, count)), static_cast<int>(bigEndian(height, count))};
}

/// Walks the segments to the frame header (SOF), then looks for the end marker.
cv::Size inspectJpeg(const std::vector<std::uint8_t>& data) {
  std::size_t end = data.size();
  while (end > 0 && data[end - 1] == 0) --end;  // some cameras pad their buffers
  require<Invalid>(end >= 4 && data[end - 2] == 0xFF && data[end - 1] == 0xD9,
                   "the JPEG is truncated: no end marker after ", data.size(), " bytes");
  for (std::size_t at = 2; at + 9 < end;) {
    require<Invalid>(data[at] == 0xFF, "the JPEG is damaged at byte ", at);
    const std::uint8_t marker = data[at + 1];
    if (marker == 0xFF) {  // a fill byte
      ++at;
      continue;
    }
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) return sizeFromBytes(&data[at + 7], &data[at + 5], 2);
    at += 2 + bigEndian(&data[at + 2], 2);
  }
  throw Invalid("the JPEG is damaged: it has no frame header");
}

cv::Size inspectPng(const std::vector<std::uint8_t>& data) {
  static const char kEnd[] = "IEND";
  const auto tail = data.size() > 64 ? data.end() - 64 : data.begin();
  require<Invalid>(data.size() > 32 && std::search(tail, data.end(), kEnd, kEnd + 4) != data.end(),
                   "the PNG is truncated: no IEND chunk after ", data.size(), " bytes");
  return sizeFromBytes(&data[16], &data[20], 4);
}

/// How the pixels of an encoding lie in memory, and the conversion to BGR or grey (-1: none).
struct PixelFormat {
  int type = CV_8UC1;
  int code = -1;
};

const std::map<std::string, PixelFormat>& pixelFormats() {
  // OpenCV names a Bayer pattern by its second row and column, ROS by its first.
  static const std::map<std::string, PixelFormat> formats = {
      {"mono8", {CV_8UC1, -1}},
      {"8UC1", {CV_8UC1, -1}},
      {"mono16", {CV_16UC1, -1}},
      {"16UC1", {CV_16UC1, -1}},
      {"bgr8", {CV_8UC3, -1}},
      {"8UC3", {CV_8UC3, -1}},
      {"rgb8", {CV_8UC3, cv::COLOR_RGB2BGR}},
      {"bgra8", {CV_8UC4, cv::COLOR_BGRA2BGR}},
      {"8UC4", {CV_8UC4, cv::COLOR_BGRA2BGR}},
      {"rgba8", {CV_8UC4, cv::COLOR_RGBA2BGR}},
      {"bgr16", {CV_16UC3, -1}},
      {"rgb16", {CV_16UC3, cv::COLOR_RGB2BGR}},
      {"yuv422", {CV_8UC2, cv::COLOR_YUV2BGR_UYVY}},
      {"yuv422_yuy2", {CV_8UC2, cv::COLOR_YUV2BGR_YUY2}},
      {"bayer_rggb8", {CV_8UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr8", {CV_8UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg8", {CV_8UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg8", {CV_8UC1, cv::COLOR_BayerGB2BGR}},
      {"bayer_rggb16", {CV_16UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr16", {CV_16UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg16", {CV_16UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg16", {CV_16UC1, cv::COLOR_BayerGB2BGR}},
  };
  return formats;
}

const PixelFormat& pixelFormat(const sensor_msgs::Image& message) {
  const auto found = pixelFormats().find(message.encoding);
  if (found != pixelFormats().end()) return found->second;
  std::string known;
  for (const auto& [name, format] : pixelFormats()) known += (known.empty() ? "" : ", ") + name;
  throw Invalid("unknown image encoding \"" + message.encoding + "\"; known are " + known);
}

/// 16-bit numbers of a message with the other byte order, as a copy.
cv::Mat swapBytes(const cv::Mat& image) {
  cv::Mat result = image.clone();
  for (int row = 0; row < result.rows; ++row) {
    std::uint16_t* values = result.ptr<std::uint16_t>(row);
    const int count = result.cols * result.channels();
    for (int i = 0; i < count; ++i) values[i] = static_cast<std::uint16_t>(values[i] << 8U | values[i] >> 8U);
  }
  return result;
}

}  // namespace

CameraFromInfo cameraFromMessage(const CameraInfo& message, bool rectified) {
  require<Invalid>(message.K[0] != 0, "camera_info: the camera is uncalibrated (K[0] = 0); calibrate it, or give its ",
                   "driver the calibration file");
  require<Invalid>(message.width > 0 && message.height > 0, "camera_info: the image size is ", message.width, " x ",
                   message.height);
  require<Invalid>(!rectified || message.P[0] != 0, "camera_info: P[0] = 0, but the images are said to be rectified");
  CameraFromInfo camera;
  Intrinsics& intrinsics = camera.intrinsics;
  intrinsics.fx = rectified ? message.P[0] : message.K[0];
  intrinsics.fy = rectified ? message.P[5] : message.K[4];
  intrinsics.cx = rectified ? message.P[2] : message.K[2];
  intrinsics.cy = rectified ? message.P[6] : message.K[5];
  if (!rectified) readDistortion(message, camera);
  applyRoiAndBinning(message, intrinsics);
  (void)Camera(intrinsics);  // checks the numbers
  return camera;
}

EncodedInfo inspectCompressed(const sensor_msgs::CompressedImage& message) {
  static const std::uint8_t kPng[] = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  const auto& data = message.data;
  EncodedInfo info;
  if (data.size() >= 2 && data[0] == 0xFF && data[1] == 0xD8) {
    info = {inspectJpeg(data), "jpg"};
  } else if (data.size() >= 8 && std::equal(kPng, kPng + 8, data.begin())) {
    info = {inspectPng(data), "png"};
  } else {
    throw Invalid("the compressed image (format \"" + message.format + "\", " + std::to_string(data.size()) +
                  " bytes) is neither JPEG nor PNG");
  }
  require<Invalid>(info.size.width > 0 && info.size.height > 0, "the compressed image has the size ", info.size.width,
                   " x ", info.size.height);
  return info;
}

void checkImage(const sensor_msgs::Image& message) {
  const PixelFormat& format = pixelFormat(message);
  require<Invalid>(message.width > 0 && message.height > 0, "the image has the size ", message.width, " x ",
                   message.height);
  const std::uint64_t row = std::uint64_t{message.width} * CV_ELEM_SIZE(format.type);
  require<Invalid>(message.step >= row, "image: step ", message.step, " is less than a row of ", row, " bytes (",
                   message.encoding, ", width ", message.width, ")");
  const std::uint64_t need = std::uint64_t{message.step} * (message.height - 1) + row;
  require<Invalid>(message.data.size() >= need, "image: data has ", message.data.size(), " bytes, but ", message.width,
                   " x ", message.height, " ", message.encoding, " needs ", need);
}

cv::Mat imageFromMessage(const sensor_msgs::Image& message) {
  checkImage(message);
  const PixelFormat& format = pixelFormat(message);
  // The Mat is only read from; OpenCV has no constructor for constant data.
  cv::Mat image(static_cast<int>(message.height), static_cast<int>(message.width), format.type,
                const_cast<std::uint8_t*>(message.data.data()), message.step);  // NOLINT
  if (image.depth() == CV_16U && message.is_bigendian != 0) image = swapBytes(image);
  if (format.code >= 0) {
    cv::Mat converted;
    cv::cvtColor(image, converted, format.code);
    image = converted;
  }
  if (image.type() == CV_16UC3) {
    cv::Mat bytes;
    image.convertTo(bytes, CV_8U, 1.0 / 257);
    image = bytes;
  }
  return image;
}

EncodedImage encodeImage(const cv::Mat& image, const std::string& format) {
  EncodedImage result;
  result.extension = format;
  if (format == "ppm" && image.channels() == 1) result.extension = "pgm";
  if (format == "jpg" && image.depth() == CV_16U) result.extension = "png";
  const std::vector<int> options = {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_JPEG_QUALITY, 95};
  require(cv::imencode("." + result.extension, image, result.bytes, options), "OpenCV cannot encode a ", image.cols,
          " x ", image.rows, " image as ", result.extension);
  return result;
}

}  // namespace cloud_colorizer
