// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/conversions.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "camera/pixels.hpp"
#include "core/scratch.hpp"
#include "ros/messages.hpp"

namespace cloud_colorizer {
namespace {

using testing_ros::encoded;
using testing_ros::imageMessage;
using testing_ros::infoMessage;
using testing_ros::PointWriter;

/// Nothing but std::invalid_argument tells that a message is bad.
#define EXPECT_REFUSED(statement, text)                                            \
  do {                                                                             \
    EXPECT_THROW((void)(statement), std::invalid_argument);                        \
    EXPECT_NE(messageOf([&] { (void)(statement); }).find(text), std::string::npos) \
        << messageOf([&] { (void)(statement); });                                  \
  } while (false)

TEST(CloudFromMessage, EmptyCloudHasNoPointsButFields) {
  const Cloud cloud =
      cloudFromMessage(PointWriter().field("x", 7).field("y", 7).field("z", 7).field("ring", 4).done(0, 1));
  EXPECT_EQ(cloud.positions.cols(), 0);
  ASSERT_EQ(cloud.fields.size(), 1U);
  EXPECT_EQ(cloud.fields[0].name, "ring");
}

/// Every layout must give the same points: any order, padding, type and byte order.
TEST(CloudFromMessage, LayoutDoesNotMatter) {
  for (const bool big : {false, true}) {
    for (const std::uint8_t type : std::vector<std::uint8_t>{7, 8, 5}) {  // FLOAT32, FLOAT64, INT32
      PointWriter writer;
      writer.big_endian = big;
      writer.row_padding = 5;
      writer.field("ring", 4).pad(3).field("z", type).field("x", type).pad(1).field("time", 8).field("y", type).pad(2);
      const Cloud cloud = cloudFromMessage(writer.done(3, 2));
      ASSERT_EQ(cloud.positions.cols(), 6);
      ASSERT_EQ(cloud.fields.size(), 2U);
      const std::size_t record = recordSize(cloud.fields);
      ASSERT_EQ(record, 10U);
      for (int i = 0; i < 6; ++i) {
        EXPECT_EQ(cloud.positions(0, i), PointWriter::value("x", i));
        EXPECT_EQ(cloud.positions(1, i), PointWriter::value("y", i));
        EXPECT_EQ(cloud.positions(2, i), PointWriter::value("z", i));
        std::uint16_t ring;
        double time;
        std::memcpy(&ring, &cloud.records[record * static_cast<std::size_t>(i)], 2);
        std::memcpy(&time, &cloud.records[record * static_cast<std::size_t>(i) + 2], 8);
        EXPECT_EQ(ring, PointWriter::value("ring", i));
        EXPECT_EQ(time, PointWriter::value("time", i));
      }
    }
  }
}

TEST(CloudFromMessage, DoublesKeepTheirDigits) {
  sensor_msgs::PointCloud2 message = PointWriter().field("x", 8).field("y", 8).field("z", 8).done(1, 1);
  const double utm = 5500000.123;
  std::memcpy(message.data.data() + 8, &utm, 8);
  EXPECT_EQ(cloudFromMessage(message).positions(1, 0), utm);
}

TEST(CloudFromMessage, NanPassesThrough) {
  sensor_msgs::PointCloud2 message = PointWriter().field("x", 7).field("y", 7).field("z", 7).done(2, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(message.data.data() + 16, &nan, 4);
  EXPECT_TRUE(std::isnan(cloudFromMessage(message).positions(1, 1)));
}

TEST(CloudFromMessage, WhatDoesNotFitIsRefused) {
  const sensor_msgs::PointCloud2 good =
      PointWriter().field("x", 7).field("y", 7).field("z", 7).field("i", 7).done(4, 2);
  auto message = good;
  message.fields[1].name = "yy";
  EXPECT_REFUSED(cloudFromMessage(message), "no field y");
  message = good;
  message.fields[3].offset = 14;
  EXPECT_REFUSED(cloudFromMessage(message), "point_step");
  message = good;
  message.row_step = 32;
  message.data.push_back(0);
  EXPECT_REFUSED(cloudFromMessage(message), "row_step");
  message = good;
  message.data.pop_back();
  EXPECT_REFUSED(cloudFromMessage(message), "data has");
  message = good;
  message.width = std::numeric_limits<std::uint32_t>::max();
  EXPECT_REFUSED(cloudFromMessage(message), "row_step");
  message = good;
  message.fields[3].datatype = 9;
  EXPECT_REFUSED(cloudFromMessage(message), "datatype 9");
  message = good;
  message.fields[3].name = "x";
  EXPECT_REFUSED(cloudFromMessage(message), "twice");
  message = good;
  message.fields[3].count = 1000000000;
  EXPECT_REFUSED(cloudFromMessage(message), "point_step");
}

/// Each of the fields fits into the point, and a record of them all would be 5,000 times as large.
TEST(CloudFromMessage, FieldsThatOverlapAreRefused) {
  auto message = PointWriter().field("x", 7).field("y", 7).field("z", 7).field("i", 7).done(4, 2);
  for (int i = 0; i < 5000; ++i) {
    message.fields.push_back(message.fields[3]);
    message.fields.back().name += std::to_string(i);
  }
  EXPECT_REFUSED(cloudFromMessage(message), "the fields up to i0 take 20 bytes, but point_step is 16: they overlap");
}

TEST(CloudFromMessage, RowsWithoutPointsTakeNoTime) {
  auto message = PointWriter().field("x", 7).field("y", 7).field("z", 7).done(0, 0);
  message.height = std::numeric_limits<std::uint32_t>::max();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(cloudFromMessage(message).positions.cols(), 0);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(500));
}

TEST(CloudFromMessage, CountOfZeroIsOne) {
  auto message = PointWriter().field("x", 7).field("y", 7).field("z", 7).field("i", 7).done(1, 1);
  message.fields[3].count = 0;
  EXPECT_EQ(cloudFromMessage(message).fields[0].count, 1U);
}

TEST(AppendToMessage, RoundTripOfTwoClouds) {
  PointWriter writer;
  writer.row_padding = 4;
  writer.field("ring", 4).field("x", 7).field("y", 7).field("z", 7).field("time", 8);
  const Cloud cloud = cloudFromMessage(writer.done(5, 2));
  sensor_msgs::PointCloud2 message;
  appendToMessage(cloud, message);
  appendToMessage(cloud, message);
  EXPECT_EQ(message.width, 20U);
  EXPECT_EQ(message.point_step, 22U);
  const Cloud back = cloudFromMessage(message);
  EXPECT_EQ(back.fields, cloud.fields);
  EXPECT_EQ(back.positions.leftCols(10), cloud.positions);
  EXPECT_EQ(back.positions.rightCols(10), cloud.positions);
  EXPECT_TRUE(std::equal(cloud.records.begin(), cloud.records.end(), back.records.begin() + 100));
  Cloud other = cloud;
  other.fields[0].name = "beam";
  EXPECT_REFUSED((appendToMessage(other, message), 0), "other fields");
}

TEST(CameraFromMessage, PlumbBobAsCalibrated) {
  const CameraFromInfo camera = cameraFromMessage(infoMessage(640, 480), false);
  EXPECT_EQ(camera.intrinsics.width, 640);
  EXPECT_EQ(camera.intrinsics.fx, 400);
  EXPECT_EQ(camera.intrinsics.cy, 240);
  EXPECT_EQ(camera.intrinsics.model, DistortionModel::kPlumbBob);
  EXPECT_EQ(camera.intrinsics.distortion, (std::vector<double>{-0.1, 0.01}));
  EXPECT_TRUE(camera.warning.empty());
}

TEST(CameraFromMessage, RectifiedImagesHaveTheProjectionOfP) {
  sensor_msgs::CameraInfo info = infoMessage(640, 480);
  info.P[0] = info.P[5] = 380;
  info.P[2] = 300;
  info.P[6] = 200;
  const Intrinsics intrinsics = cameraFromMessage(info, true).intrinsics;
  EXPECT_EQ(intrinsics.fx, 380);
  EXPECT_EQ(intrinsics.cx, 300);
  EXPECT_TRUE(intrinsics.distortion.empty());
  info.P[0] = 0;
  EXPECT_REFUSED(cameraFromMessage(info, true), "P[0]");
}

TEST(CameraFromMessage, RegionAndBinningMoveThePixels) {
  sensor_msgs::CameraInfo info = infoMessage(640, 480);
  info.D.clear();
  info.roi.x_offset = 100;
  info.roi.y_offset = 40;
  info.roi.width = 400;
  info.roi.height = 300;
  info.binning_x = 2;
  info.binning_y = 4;
  const Intrinsics binned = cameraFromMessage(info, false).intrinsics;
  EXPECT_EQ(binned.width, 200);
  EXPECT_EQ(binned.height, 75);
  // The first pixel of this image is the mean of 2 x 4: its centre is at (0.5, 1.5) of those.
  const double x = (300.0 - 320) / 400, y = (200.0 - 240) / 400;
  EXPECT_DOUBLE_EQ(binned.fx * x + binned.cx, (300 - 100 - 0.5) / 2);
  EXPECT_DOUBLE_EQ(binned.fy * y + binned.cy, (200 - 40 - 1.5) / 4);
  info.roi.width = 600;
  EXPECT_REFUSED(cameraFromMessage(info, false), "roi");
}

TEST(CameraFromMessage, NumbersThatAreNoSizesOfImagesAreRefused) {
  sensor_msgs::CameraInfo info = infoMessage(4294967295U, 4294967295U);
  EXPECT_REFUSED(cameraFromMessage(info, false), "4294967295 x 4294967295");
  info.binning_x = info.binning_y = 4294967295U;
  EXPECT_EQ(cameraFromMessage(info, false).intrinsics.width, 1);
  info.binning_x = 5;
  info.width = 4;
  EXPECT_REFUSED(cameraFromMessage(info, false), "0 x 1");
}

TEST(CameraFromMessage, BadCalibrationIsRefused) {
  sensor_msgs::CameraInfo info = infoMessage(640, 480);
  info.K[0] = 0;
  EXPECT_REFUSED(cameraFromMessage(info, false), "uncalibrated");
  info = infoMessage(640, 480);
  info.distortion_model = "ocam";
  EXPECT_REFUSED(cameraFromMessage(info, false), "ocam");
  info = infoMessage(640, 480);
  info.distortion_model = "";
  EXPECT_REFUSED(cameraFromMessage(info, false), "set it to plumb_bob");
  info = infoMessage(0, 480);
  EXPECT_REFUSED(cameraFromMessage(info, false), "0 x 480");
  info = infoMessage(640, 480);
  info.K[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_REFUSED(cameraFromMessage(info, false), "finite");
}

TEST(CameraFromMessage, WhatIsAssumedIsSaid) {
  sensor_msgs::CameraInfo info = infoMessage(640, 480);
  info.distortion_model = "";
  info.D = {0, 0, 0, 0, 0};
  EXPECT_NE(cameraFromMessage(info, false).warning.find("plumb_bob"), std::string::npos);
  info.distortion_model = "plumb_bob";
  info.D = {0.1, 0.1, 0, 0, 0.1, 0.1, 0.1, 0.1};
  const CameraFromInfo camera = cameraFromMessage(info, false);
  EXPECT_EQ(camera.intrinsics.model, DistortionModel::kRationalPolynomial);
  EXPECT_NE(camera.warning.find("rational_polynomial"), std::string::npos);
}

TEST(CameraFromMessage, ModelsMayHaveTheNamesOfOtherTools) {
  sensor_msgs::CameraInfo info = infoMessage(640, 480);
  info.D = {0.1, 0.01, 0, 0};
  info.distortion_model = "radtan";
  EXPECT_EQ(cameraFromMessage(info, false).intrinsics.model, DistortionModel::kPlumbBob);
  for (const char* name : {"fisheye", "Kannala-Brandt", "equi"}) {
    info.distortion_model = name;
    EXPECT_EQ(cameraFromMessage(info, false).intrinsics.model, DistortionModel::kEquidistant) << name;
  }
  info.distortion_model = "none";
  EXPECT_REFUSED(cameraFromMessage(info, false), "none");
  info.D = {};
  EXPECT_TRUE(cameraFromMessage(info, false).intrinsics.distortion.empty());
}

TEST(CloudFromMessage, NamesOfCoordinatesMayBeCapitals) {
  auto message = PointWriter().field("X", 7).field("Y", 7).field("Z", 7).done(1, 1);
  const float position[3] = {1, 2, 3};
  std::memcpy(message.data.data(), position, 12);
  EXPECT_EQ(cloudFromMessage(message).positions.col(0), Eigen::Vector3d(1, 2, 3));
}

TEST(InspectCompressed, SizeAndKindFromTheBytes) {
  const cv::Mat image(30, 50, CV_8UC3, cv::Scalar(10, 20, 30));
  for (const char* extension : {"jpg", "png"}) {
    const sensor_msgs::CompressedImage message = encoded(image, extension);
    const EncodedInfo info = inspectCompressed(message);
    EXPECT_EQ(info.size, cv::Size(50, 30));
    EXPECT_EQ(info.extension, extension);
  }
}

TEST(CloudFromMessage, RowStepsThatAreNotNeededAreNotLookedAt) {
  const sensor_msgs::PointCloud2 good = PointWriter().field("x", 7).field("y", 7).field("z", 7).done(4, 2);
  const Cloud expected = cloudFromMessage(good);
  for (const std::uint32_t row_step : {0U, good.row_step * good.height}) {
    sensor_msgs::PointCloud2 message = good;
    message.row_step = row_step;
    EXPECT_EQ(cloudFromMessage(message).positions, expected.positions) << row_step;
  }
}

/// image_transport compresses a mosaic as it is, and says so in the format.
TEST(ImageFromCompressed, AMosaicBecomesColours) {
  cv::Mat1b mosaic(32, 32);
  for (int row = 0; row < 32; ++row) {
    for (int col = 0; col < 32; ++col)
      mosaic(row, col) = row % 2 == 0 ? (col % 2 == 0 ? 200 : 100) : (col % 2 == 0 ? 100 : 50);
  }
  for (const char* extension : {"png", "jpg"}) {
    sensor_msgs::CompressedImage message = encoded(mosaic, extension);
    EXPECT_FALSE(inspectCompressed(message).is_mosaic);
    message.format = "bayer_rggb8; " + message.format + " compressed ";
    EXPECT_TRUE(inspectCompressed(message).is_mosaic);
    const cv::Mat colors = imageFromMessage(message);
    ASSERT_EQ(colors.type(), CV_8UC3);
    const auto pixel = colors.at<cv::Vec3b>(16, 16);
    EXPECT_NEAR(pixel[0], 50, 6) << extension;
    EXPECT_NEAR(pixel[1], 100, 6) << extension;
    EXPECT_NEAR(pixel[2], 200, 6) << extension;
  }
}

TEST(ImageFromCompressed, ColoursAreNoMosaicWhateverTheFormatSays) {
  sensor_msgs::CompressedImage message = encoded(cv::Mat3b(8, 8, cv::Vec3b(1, 2, 3)), "png");
  message.format = "bayer_rggb8; png compressed bgr8";
  EXPECT_FALSE(inspectCompressed(message).is_mosaic);
  EXPECT_EQ(imageFromMessage(message).at<cv::Vec3b>(4, 4), cv::Vec3b(1, 2, 3));
}

TEST(InspectCompressed, DepthsAreNoColours) {
  sensor_msgs::CompressedImage message = encoded(cv::Mat1w(8, 8, std::uint16_t{700}), "png");
  for (const char* format : {"16UC1; png compressed ", "32FC1; compressedDepth png", "16UC1; compressedDepth"}) {
    message.format = format;
    EXPECT_REFUSED(inspectCompressed(message), "no colours");
  }
  message.format = "mono16; png compressed ";
  EXPECT_EQ(inspectCompressed(message).channels, 1);
}

TEST(InspectCompressed, TruncatedOrForeignDataIsRefused) {
  const cv::Mat image(300, 500, CV_8UC3, cv::Scalar(10, 20, 30));
  for (const char* extension : {"jpg", "png"}) {
    const sensor_msgs::CompressedImage whole = encoded(image, extension);
    for (std::size_t size = 0; size < whole.data.size(); size += size < 700 ? 1 : 97) {
      sensor_msgs::CompressedImage part = whole;
      part.data.resize(size);
      EXPECT_THROW(inspectCompressed(part), std::invalid_argument) << extension << ' ' << size;
    }
  }
  sensor_msgs::CompressedImage text;
  text.format = "jpeg";
  text.data = {'h', 'e', 'l', 'l', 'o', '!', '!', '!', '!', '!'};
  EXPECT_REFUSED(inspectCompressed(text), "neither JPEG nor PNG");
  text.data = {0xFF, 0xD8, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xD9};
  EXPECT_THROW(inspectCompressed(text), std::invalid_argument);
}

TEST(InspectCompressed, PaddedJpegIsWhole) {
  sensor_msgs::CompressedImage message = encoded(cv::Mat(30, 50, CV_8UC1, cv::Scalar(9)), "jpg");
  message.data.resize(message.data.size() + 100, 0);
  EXPECT_EQ(inspectCompressed(message).size, cv::Size(50, 30));
}

/// Y, U and V of a colour (BT.601, limited range).
struct Yuv {
  Yuv(int r, int g, int b)
      : y(byte(16.5 + 0.257 * r + 0.504 * g + 0.098 * b)),
        u(byte(128.5 - 0.148 * r - 0.291 * g + 0.439 * b)),
        v(byte(128.5 + 0.439 * r - 0.368 * g - 0.071 * b)) {}
  static std::uint8_t byte(double value) { return static_cast<std::uint8_t>(value); }
  std::uint8_t y, u, v;
};

void expectColor(const sensor_msgs::Image& message, const cv::Point& at, const cv::Vec3i& bgr, int tolerance) {
  const cv::Mat image = imageFromMessage(message);
  ASSERT_EQ(image.type(), CV_8UC3) << message.encoding;
  ASSERT_EQ(image.size(), cv::Size(static_cast<int>(message.width), static_cast<int>(message.height)));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(image.at<cv::Vec3b>(at)[i], bgr[i], tolerance) << message.encoding << at;
}

/// A picture of one colour, written in each encoding by hand, comes back as that colour.
struct Encoding {
  const char* name;
  std::vector<std::uint8_t> pixel_pair;  ///< bytes of two neighbouring pixels
  int tolerance;
};

TEST(ImageFromMessage, EveryEncodingGivesTheSameColour) {
  const int r = 200, g = 100, b = 50;
  const auto u8 = [](int v) { return static_cast<std::uint8_t>(v); };
  const auto [y, u, v] = Yuv(r, g, b);
  const std::vector<Encoding> encodings = {
      {"rgb8", {u8(r), u8(g), u8(b), u8(r), u8(g), u8(b)}, 0},
      {"bgr8", {u8(b), u8(g), u8(r), u8(b), u8(g), u8(r)}, 0},
      {"rgba8", {u8(r), u8(g), u8(b), 7, u8(r), u8(g), u8(b), 7}, 0},
      {"bgra8", {u8(b), u8(g), u8(r), 7, u8(b), u8(g), u8(r), 7}, 0},
      {"rgb16", {1, u8(r), 1, u8(g), 1, u8(b), 1, u8(r), 1, u8(g), 1, u8(b)}, 1},
      {"bgr16", {1, u8(b), 1, u8(g), 1, u8(r), 1, u8(b), 1, u8(g), 1, u8(r)}, 1},
      {"rgba16", {1, u8(r), 1, u8(g), 1, u8(b), 7, 7, 1, u8(r), 1, u8(g), 1, u8(b), 7, 7}, 1},
      {"8UC3", {u8(b), u8(g), u8(r), u8(b), u8(g), u8(r)}, 0},
      {"8UC4", {u8(b), u8(g), u8(r), 7, u8(b), u8(g), u8(r), 7}, 0},
      {"16UC3", {1, u8(b), 1, u8(g), 1, u8(r), 1, u8(b), 1, u8(g), 1, u8(r)}, 1},
      {"yuv422", {u, y, v, y}, 3},
      {"uyvy", {u, y, v, y}, 3},
      {"yuv422_yuy2", {y, u, y, v}, 3},
      {"yuyv", {y, u, y, v}, 3},
  };
  for (const Encoding& encoding : encodings) {
    expectColor(imageMessage(encoding.name, 8, 6, encoding.pixel_pair), {4, 3}, {b, g, r}, encoding.tolerance);
  }
}

/// The left half has one colour and the right half another, in planes whose rows have padding.
TEST(ImageFromMessage, PlanesFollowOneAnother) {
  const Yuv left(200, 100, 50), right(30, 60, 220);
  const std::uint32_t width = 8, height = 4, step = 11;
  const auto plane = [&](sensor_msgs::Image& message, std::uint32_t rows, std::uint32_t row_step,
                         const std::vector<std::uint8_t>& l, const std::vector<std::uint8_t>& r, std::uint32_t count) {
    for (std::uint32_t row = 0; row < rows; ++row) {
      for (std::uint32_t i = 0; i < count; ++i) {
        const auto& values = i < count / 2 ? l : r;
        message.data.insert(message.data.end(), values.begin(), values.end());
      }
      message.data.resize(message.data.size() + row_step - count * l.size(), 99);
    }
  };
  for (const std::string encoding : {"nv12", "nv21", "nv24"}) {
    sensor_msgs::Image message = imageMessage(encoding, 0, 0, {});
    message.width = width;
    message.height = height;
    message.step = step;
    plane(message, height, step, {left.y}, {right.y}, width);
    const bool v_first = encoding == "nv21", whole = encoding == "nv24";
    plane(message, whole ? height : height / 2, whole ? 2 * step : step,
          v_first ? std::vector<std::uint8_t>{left.v, left.u} : std::vector<std::uint8_t>{left.u, left.v},
          v_first ? std::vector<std::uint8_t>{right.v, right.u} : std::vector<std::uint8_t>{right.u, right.v},
          whole ? width : width / 2);
    expectColor(message, {1, 1}, {50, 100, 200}, 3);
    expectColor(message, {6, 3}, {220, 60, 30}, 3);
    message.data.resize(message.data.size() - step);
    EXPECT_REFUSED(imageFromMessage(message), "data has");
  }
}

TEST(ImageFromMessage, BayerPatternsByTheirFirstTwoRows) {
  const std::map<char, int> value = {{'r', 200}, {'g', 100}, {'b', 50}};
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    for (const int bits : {8, 16}) {
      sensor_msgs::Image message;
      message.encoding = "bayer_" + pattern + std::to_string(bits);
      message.width = message.height = 10;
      message.step = static_cast<std::uint32_t>(10 * bits / 8);
      for (int row = 0; row < 10; ++row) {
        for (int col = 0; col < 10; ++col) {
          const int v = value.at(pattern[static_cast<std::size_t>((row % 2) * 2 + col % 2)]);
          if (bits == 16) message.data.push_back(0);
          message.data.push_back(static_cast<std::uint8_t>(v));
        }
      }
      const cv::Vec3b color = imageFromMessage(message).at<cv::Vec3b>(5, 5);
      EXPECT_NEAR(color[0], 50, 1) << message.encoding;
      EXPECT_NEAR(color[1], 100, 1) << message.encoding;
      EXPECT_NEAR(color[2], 200, 1) << message.encoding;
    }
  }
}

TEST(ImageFromMessage, GreyKeepsItsDepthInEitherByteOrder) {
  EXPECT_EQ(imageFromMessage(imageMessage("mono8", 4, 2, {10, 20})).at<std::uint8_t>(1, 1), 20);
  sensor_msgs::Image deep = imageMessage("mono16", 4, 2, {0x34, 0x12, 0x78, 0x56});
  EXPECT_EQ(imageFromMessage(deep).at<std::uint16_t>(1, 1), 0x5678);
  deep.is_bigendian = 1;
  EXPECT_EQ(imageFromMessage(deep).at<std::uint16_t>(1, 1), 0x7856);
}

TEST(ImageFromMessage, RowPaddingIsSkipped) {
  sensor_msgs::Image message = imageMessage("mono8", 2, 2, {1, 2});
  message.step = 3;
  message.data = {1, 2, 99, 3, 4};  // the last row needs no padding
  EXPECT_EQ(imageFromMessage(message).at<std::uint8_t>(1, 0), 3);
  message.data.resize(100);  // what follows the image does not matter
  EXPECT_EQ(imageFromMessage(message).at<std::uint8_t>(1, 0), 3);
}

TEST(ImageFromMessage, ColoursOfSixteenBitsInEitherByteOrder) {
  for (const bool big : {false, true}) {
    sensor_msgs::Image message = imageMessage("rgb16", 2, 2, {200, 100, 100, 50, 50, 25, 200, 100, 100, 50, 50, 25});
    message.is_bigendian = big;  // the high bytes are 200, 100, 50, or half of it
    const int share = big ? 1 : 2;
    expectColor(message, {1, 1}, {50 / share, 100 / share, 200 / share}, 1);
  }
}

TEST(ImageFromMessage, WhatDoesNotFitIsRefused) {
  const sensor_msgs::Image good = imageMessage("rgb8", 4, 2, {1, 2, 3, 4, 5, 6});
  auto message = good;
  message.encoding = "jpegxl";
  EXPECT_REFUSED(checkImage(message), "unknown image encoding \"jpegxl\"");
  message = good;
  message.data.pop_back();
  EXPECT_REFUSED(checkImage(message), "data has");
  message = good;
  message.step = 8;
  EXPECT_REFUSED(checkImage(message), "step");
  message = good;
  message.width = 0;
  EXPECT_REFUSED(checkImage(message), "0 x 2");
  message = imageMessage("mono16", 4, 2, {1, 2, 3, 4});
  message.step = 9;
  message.data.resize(18);
  EXPECT_REFUSED(checkImage(message), "step 9 cuts the numbers of mono16 in two");
  message.width = message.height = message.step = std::numeric_limits<std::uint32_t>::max();
  message.encoding = "8UC1";
  EXPECT_REFUSED(checkImage(message), "data has");
  message.encoding = "nv24";  // the product of its rows and their length does not fit into 64 bits
  EXPECT_REFUSED(checkImage(message), "data has");
  for (const char* encoding : {"16UC1", "32FC1", "16SC1"}) {
    message.encoding = encoding;
    EXPECT_REFUSED(imageFromMessage(message), "depths or other values");
  }
  for (const char* encoding : {"8UC2", "8UC999999999", "8UC0", ""}) {
    message.encoding = encoding;
    EXPECT_REFUSED(imageFromMessage(message), "unknown image encoding");
  }
  EXPECT_REFUSED(imageFromMessage(imageMessage("yuv422", 3, 2, {1, 2, 3, 4})), "yuv422 cannot have");
}

TEST(EncodeImage, IsLossless) {
  cv::Mat color(20, 30, CV_8UC3), grey(20, 30, CV_8UC1), deep(20, 30, CV_16UC1);
  cv::RNG rng(1);
  for (cv::Mat* image : {&color, &grey, &deep}) {
    rng.fill(*image, cv::RNG::UNIFORM, 0, image->depth() == CV_16U ? 65536 : 256);
    for (const char* format : {"png", "ppm"}) {
      const EncodedImage result = encodeImage(*image, format);
      const cv::Mat back = cv::imdecode(result.bytes, cv::IMREAD_UNCHANGED);
      EXPECT_EQ(back.type(), image->type());
      EXPECT_EQ(cv::norm(back, *image, cv::NORM_INF), 0) << result.extension;
    }
  }
  EXPECT_EQ(encodeImage(grey, "ppm").extension, "pgm");
  EXPECT_EQ(encodeImage(grey, "jpg").extension, "jpg");
  EXPECT_EQ(encodeImage(deep, "jpg").extension, "png");
}

}  // namespace
}  // namespace cloud_colorizer
