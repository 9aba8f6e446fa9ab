// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// conversions.hpp: camera_info, raw and compressed images.

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "base/text.hpp"
#include "camera/values.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"

namespace cloud_colorizer {
namespace {

using sensor_msgs::CameraInfo;
using Invalid = std::invalid_argument;
namespace enc = sensor_msgs::image_encodings;

/// The name that sensor_msgs has for a model which calibration tools and drivers call otherwise.
std::string standardModel(std::string name) {
  static const std::map<std::string, std::string> kOthers = {
      {"radtan", "plumb_bob"},           {"radial_tangential", "plumb_bob"},
      {"brown_conrady", "plumb_bob"},    {"rational", "rational_polynomial"},
      {"equi", "equidistant"},           {"fisheye", "equidistant"},
      {"kannala_brandt", "equidistant"}, {"kannala_brandt4", "equidistant"}};
  name = lowerCase(name);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '-' || c == ' '; }, '_');
  const auto found = kOthers.find(name);
  return found != kOthers.end() ? found->second : name;
}

bool saysNone(const std::string& model) {
  return model.empty() || model == "none" || model == "pinhole" || model == "no_distortion";
}

void readDistortion(const CameraInfo& message, CameraFromInfo& camera) {
  Intrinsics& intrinsics = camera.intrinsics;
  intrinsics.distortion.assign(message.D.begin(), message.D.end());
  while (!intrinsics.distortion.empty() && intrinsics.distortion.back() == 0) intrinsics.distortion.pop_back();
  const std::string model = standardModel(message.distortion_model);
  if (saysNone(model)) {
    require<Invalid>(intrinsics.distortion.empty(), "camera_info: D is given with the distortion_model \"",
                     message.distortion_model, "\", which says nothing of it; set it to plumb_bob, ",
                     "rational_polynomial or equidistant");
    camera.warning = "camera_info has no distortion_model; with D = 0 it is taken as plumb_bob";
    return;
  }
  try {
    intrinsics.model = distortionModelFromString(model);
  } catch (const Invalid& error) {
    throw Invalid(std::string("camera_info: ") + error.what());
  }
  if (intrinsics.model == DistortionModel::kPlumbBob && intrinsics.distortion.size() > 5) {
    intrinsics.model = DistortionModel::kRationalPolynomial;
    camera.warning = "camera_info calls " + std::to_string(intrinsics.distortion.size()) +
                     " coefficients plumb_bob; they are taken as rational_polynomial";
  }
}

/// Region of interest, then binning: a pixel is the mean of those that it is made of.
void applyRoiAndBinning(const CameraInfo& message, Intrinsics& intrinsics) {
  const std::uint32_t bin_x = std::max<std::uint32_t>(message.binning_x, 1);
  const std::uint32_t bin_y = std::max<std::uint32_t>(message.binning_y, 1);
  const auto& roi = message.roi;
  const std::uint32_t width = (roi.width != 0 ? roi.width : message.width) / bin_x;
  const std::uint32_t height = (roi.height != 0 ? roi.height : message.height) / bin_y;
  require<Invalid>(std::uint64_t{roi.x_offset} + roi.width <= message.width &&
                       std::uint64_t{roi.y_offset} + roi.height <= message.height,
                   "camera_info: the roi (", roi.x_offset, ", ", roi.y_offset, ") + ", roi.width, " x ", roi.height,
                   " is not inside the image of ", message.width, " x ", message.height);
  constexpr std::uint32_t kMost = std::numeric_limits<int>::max();
  require<Invalid>(width <= kMost && height <= kMost, "camera_info: the image size is ", width, " x ", height);
  intrinsics.width = static_cast<int>(width);
  intrinsics.height = static_cast<int>(height);
  // The centre of the first binned pixel lies between those that it is made of.
  intrinsics.cx = (intrinsics.cx - roi.x_offset + 0.5) / bin_x - 0.5;
  intrinsics.cy = (intrinsics.cy - roi.y_offset + 0.5) / bin_y - 0.5;
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
EncodedInfo inspectJpeg(const std::vector<std::uint8_t>& data) {
  std::size_t end = data.size();
  while (end > 0 && data[end - 1] == 0) --end;  // some cameras pad their buffers
  require<Invalid>(end >= 4 && data[end - 2] == 0xFF && data[end - 1] == 0xD9,
                   "the JPEG is truncated: no end marker after ", data.size(), " bytes");
  for (std::size_t at = 2; at + 10 < end;) {
    require<Invalid>(data[at] == 0xFF, "the JPEG is damaged at byte ", at);
    const std::uint8_t marker = data[at + 1];
    if (marker == 0xFF) {  // a fill byte
      ++at;
      continue;
    }
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) return {sizeFromBytes(&data[at + 7], &data[at + 5], 2), "jpg", data[at + 9], 8, false};
    at += 2 + bigEndian(&data[at + 2], 2);
  }
  throw Invalid("the JPEG is damaged: it has no frame header");
}

EncodedInfo inspectPng(const std::vector<std::uint8_t>& data) {
  static const char kEnd[] = "IEND";
  const auto tail = data.size() > 64 ? data.end() - 64 : data.begin();
  require<Invalid>(data.size() > 32 && std::search(tail, data.end(), kEnd, kEnd + 4) != data.end(),
                   "the PNG is truncated: no IEND chunk after ", data.size(), " bytes");
  const bool has_colors = (data[25] & 2U) != 0;
  return {sizeFromBytes(&data[16], &data[20], 4), "png", has_colors ? 3 : 1, data[24] == 16 ? 16 : 8, false};
}

/// Bare numbers are colours in OpenCV's order, and some drivers have names of their own.
std::string namedEncoding(const std::string& encoding) {
  static const std::map<std::string, std::string> names = {
      {"8UC1", enc::MONO8},   {"8UC3", enc::BGR8},   {"8UC4", enc::BGRA8},   {"16UC3", enc::BGR16},
      {"16UC4", enc::BGRA16}, {"uyvy", enc::YUV422}, {"yuyv", "yuv422_yuy2"}};
  const auto found = names.find(encoding);
  return found == names.end() ? encoding : found->second;
}

/// NV24: the plane of brightness, then one of U and V for each pixel. Each pixel becomes a pair of UYVY.
cv::Mat bgrFromNv24(const cv::Mat& planes) {
  const cv::Mat y = planes.rowRange(0, planes.rows / 3);
  const cv::Mat uv(y.rows, y.cols, CV_8UC2, planes.data + planes.step * y.rows, 2 * planes.step);
  cv::Mat pairs(y.size(), CV_8UC4), wide, bgr;
  std::vector<cv::Mat> to = {pairs};
  cv::mixChannels(std::vector<cv::Mat>{uv, y}, to, {0, 0, 2, 1, 1, 2, 2, 3});
  cv::cvtColor(pairs.reshape(2), wide, cv::COLOR_YUV2BGR_UYVY);
  cv::resize(wide, bgr, y.size(), 0, 0, cv::INTER_NEAREST);
  return bgr;
}

template <int code>
cv::Mat bgrByOpenCv(const cv::Mat& image) {
  cv::Mat bgr;
  cv::cvtColor(image, bgr, code);
  return bgr;
}

/// How an encoding lies in memory.
struct PixelLayout {
  int type = CV_8UC1;
  std::uint64_t rows_a_pair = 2;  ///< rows of memory for two rows of the image: planes follow one another
  std::uint32_t width_unit = 1, height_unit = 1;  ///< px that share a colour
  cv::Mat (*to_bgr)(const cv::Mat&) = nullptr;    ///< of what cv_bridge does not know
};

/// Of numbers that are no colours.
PixelLayout valueLayout(const sensor_msgs::Image& message, ImageKind kind) {
  const std::string& encoding = message.encoding;
  const bool is_known = encoding == enc::MONO8 || encoding == enc::MONO16 || encoding.rfind("8UC", 0) == 0 ||
                        encoding.rfind("16UC", 0) == 0 || encoding.rfind("32FC", 0) == 0;
  require<Invalid>(is_known, "the image encoding is ", encoding,
                   "; numbers that are no colours are mono8, mono16, 8UC, 16UC or 32FC with the number of channels");
  PixelLayout layout;
  try {
    layout.type = cv_bridge::getCvType(encoding);
    requireValues(layout.type, kind, "an image of the encoding " + encoding);
  } catch (const std::runtime_error& error) {
    throw Invalid(error.what());
  }
  return layout;
}

PixelLayout pixelLayout(const sensor_msgs::Image& message) {
  static const std::map<std::string, PixelLayout> newer = {
      {"yuv422_yuy2", {CV_8UC2, 2, 2, 1, bgrByOpenCv<cv::COLOR_YUV2BGR_YUY2>}},
      {"nv12", {CV_8UC1, 3, 2, 2, bgrByOpenCv<cv::COLOR_YUV2BGR_NV12>}},
      {"nv21", {CV_8UC1, 3, 2, 2, bgrByOpenCv<cv::COLOR_YUV2BGR_NV21>}},
      {"nv24", {CV_8UC1, 6, 1, 1, bgrFromNv24}}};
  const std::string name = namedEncoding(message.encoding);
  const auto found = newer.find(name);
  if (found != newer.end()) return found->second;
  if (name == enc::YUV422) return {CV_8UC2, 2, 2, 1};
  require<Invalid>(!isOfValues(name), "the image encoding is ", message.encoding,
                   ": depths or other values, no colours; a grey camera of 16 bits is mono16");
  require<Invalid>(enc::isColor(name) || enc::isMono(name) || enc::isBayer(name), "unknown image encoding \"",
                   message.encoding,
                   "\"; known are mono, rgb, rgba, bgr, bgra and bayer_* of 8 or 16 bits, 8UC1, 8UC3, ",
                   "8UC4, 16UC3, 16UC4, yuv422 (uyvy), yuv422_yuy2 (yuyv), nv12, nv21, nv24");
  return {cv_bridge::getCvType(name)};
}

/// 16-bit numbers of a message with the other byte order, as a copy. cv_bridge 1.16 makes pairs of bytes of them.
cv::Mat swapBytes(const cv::Mat& image) {
  cv::Mat result(image.size(), image.type());
  const cv::Size size(image.cols * image.channels(), image.rows);
  const std::vector<cv::Mat> from = {cv::Mat(size, CV_8UC2, image.data, image.step)};
  std::vector<cv::Mat> to = {cv::Mat(size, CV_8UC2, result.data, result.step)};
  cv::mixChannels(from, to, {0, 1, 1, 0});
  return result;
}

/// The Mat is only read from; OpenCV has no constructor for constant data. It is made here because cv_bridge's own
/// conversion refuses rows that follow the image and a last row without padding.
cv::Mat pixelsOf(const sensor_msgs::Image& message, const PixelLayout& layout) {
  const cv::Mat image(static_cast<int>(message.height * layout.rows_a_pair / 2), static_cast<int>(message.width),
                      layout.type, const_cast<std::uint8_t*>(message.data.data()), message.step);  // NOLINT
  return image.depth() == CV_16U && message.is_bigendian != 0 ? swapBytes(image) : image;
}

}  // namespace

CameraFromInfo cameraFromMessage(const CameraInfo& message, bool rectified) {
  require<Invalid>(rectified || message.K[0] != 0,
                   "camera_info: the camera is uncalibrated (K[0] = 0); calibrate it, or give its ",
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
  // P projects a point of the first camera's frame: [x y z] + baseline' is it in this camera's, P[3] = fx * baseline'.
  if (rectified) camera.baseline = {-message.P[3] / message.P[0], -message.P[7] / message.P[5], 0};
  require<Invalid>(camera.baseline.allFinite(), "camera_info: P[3] or P[7] is not finite");
  applyRoiAndBinning(message, intrinsics);
  (void)Camera(intrinsics);  // checks the numbers
  return camera;
}

EncodedInfo inspectCompressed(const sensor_msgs::CompressedImage& message, ImageKind kind) {
  static const std::uint8_t kPng[] = {0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
  const auto& data = message.data;
  const std::string encoding = encodingOfFormat(message.format);
  require<Invalid>(message.format.find("compressedDepth") == std::string::npos &&
                       (kind != ImageKind::kColor || !isOfValues(encoding)),
                   "the compressed image has the format \"", message.format, "\": depths or other values, no colours");
  EncodedInfo info;
  if (data.size() >= 2 && data[0] == 0xFF && data[1] == 0xD8) {
    info = inspectJpeg(data);
  } else if (data.size() >= 8 && std::equal(kPng, kPng + 8, data.begin())) {
    info = inspectPng(data);
  } else {
    throw Invalid(
        "the compressed image (format \"" + message.format + "\", " + std::to_string(data.size()) +
        " bytes) is neither JPEG nor PNG, and no others are read; publish it as one of them, or as a raw image");
  }
  require<Invalid>(info.size.width > 0 && info.size.height > 0, "the compressed image has the size ", info.size.width,
                   " x ", info.size.height);
  info.is_mosaic = info.channels == 1 && enc::isBayer(encoding);
  return info;
}

std::string encodingOfFormat(const std::string& format) {
  const auto end = format.find(';');
  return end == std::string::npos ? std::string() : format.substr(0, format.find_last_not_of(' ', end - 1) + 1);
}

bool isOfValues(const std::string& encoding) {
  static const std::set<std::string> values = {"8SC1", "16UC1", "16SC1", "32SC1", "32FC1", "64FC1"};
  return values.count(encoding) != 0;
}

void checkImage(const sensor_msgs::Image& message, ImageKind kind) {
  const PixelLayout layout = kind == ImageKind::kColor ? pixelLayout(message) : valueLayout(message, kind);
  require<Invalid>(message.width > 0 && message.height > 0 && message.width % layout.width_unit == 0 &&
                       message.height % layout.height_unit == 0,
                   "the image has the size ", message.width, " x ", message.height, ", which ", message.encoding,
                   " cannot have");
  const std::uint64_t row = std::uint64_t{message.width} * CV_ELEM_SIZE(layout.type);
  require<Invalid>(message.step >= row, "image: step ", message.step, " is less than a row of ", row, " bytes (",
                   message.encoding, ", width ", message.width, ")");
  require<Invalid>(message.step % CV_ELEM_SIZE1(layout.type) == 0, "image: step ", message.step,
                   " cuts the numbers of ", message.encoding, " in two");
  // The last row needs no padding. Divided, because the product may not fit into 64 bits.
  const std::uint64_t rows = message.height * layout.rows_a_pair / 2;
  require<Invalid>(message.data.size() >= row && (message.data.size() - row) / message.step >= rows - 1 &&
                       rows <= std::uint64_t{std::numeric_limits<int>::max()},
                   "image: data has ", message.data.size(), " bytes, but ", message.width, " x ", message.height, " ",
                   message.encoding, " needs ", rows, " rows of ", message.step);
}

cv::Mat imageFromMessage(const sensor_msgs::Image& message) {
  checkImage(message);
  const PixelLayout layout = pixelLayout(message);
  cv::Mat image = pixelsOf(message, layout);
  const std::string encoding = namedEncoding(message.encoding);
  if (enc::isMono(encoding) || encoding == enc::BGR8) return image;
  try {
    if (layout.to_bgr != nullptr) return layout.to_bgr(image);
    return cv_bridge::cvtColor(boost::make_shared<cv_bridge::CvImage>(message.header, encoding, image), enc::BGR8)
        ->image;
  } catch (const cv_bridge::Exception& error) {
    throw Invalid(std::string("image: ") + error.what());
  } catch (const cv::Exception& error) {
    throw Invalid("image: " + error.err);
  }
}

cv::Mat valuesFromMessage(const sensor_msgs::Image& message, ImageKind kind) {
  checkImage(message, kind);
  return pixelsOf(message, valueLayout(message, kind));
}

bool isGrey(const std::string& encoding) {
  const std::string name = namedEncoding(encoding);
  return name == enc::MONO8 || name == enc::MONO16;
}

bool isWide(const sensor_msgs::Image& message) {
  return CV_MAT_DEPTH(pixelLayout(message).type) == CV_16U;
}

cv::Mat opaquePixels(const sensor_msgs::Image& message) {
  const PixelLayout layout = pixelLayout(message);
  if (CV_MAT_CN(layout.type) != 4) return {};
  return opaquePixels(pixelsOf(message, layout));
}

cv::Mat imageFromMessage(const sensor_msgs::CompressedImage& message) {
  const EncodedInfo info = inspectCompressed(message);
  const int flags = info.is_mosaic ? cv::IMREAD_UNCHANGED : cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH;
  cv::Mat image = cv::imdecode(message.data, flags | cv::IMREAD_IGNORE_ORIENTATION);
  require<Invalid>(!image.empty(), "the compressed image (format \"", message.format, "\") cannot be decoded");
  if (!info.is_mosaic) return image;
  std::string encoding = encodingOfFormat(message.format);
  // A mosaic of 16 bits in a JPEG has 8.
  if (image.depth() == CV_8U) encoding = encoding.substr(0, encoding.find_first_of("0123456789")) + "8";
  return cv_bridge::cvtColor(boost::make_shared<cv_bridge::CvImage>(message.header, encoding, image), enc::BGR8)->image;
}

}  // namespace cloud_colorizer
