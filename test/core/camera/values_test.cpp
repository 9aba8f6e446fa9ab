// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/values.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "camera/npy.hpp"

namespace cloud_colorizer {
namespace {

std::vector<std::uint8_t> withHeader(const std::string& text, std::size_t num_bytes) {
  std::string file("\x93NUMPY\x01\x00", 8);
  file += static_cast<char>(text.size());
  file += '\0';
  file += text + std::string(num_bytes, '\1');
  return {file.begin(), file.end()};
}

std::string errorOf(const std::vector<std::uint8_t>& bytes) {
  try {
    (void)matOfNpy(bytes);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Npy, KeepsEveryNumberOfAnyNumberOfChannels) {
  for (const int type : {CV_8UC1, CV_16UC3, CV_32FC(19)}) {
    cv::Mat image(5, 7, type);
    cv::randu(image, 0, 200);
    const cv::Mat read = matOfNpy(npyOf(image));
    ASSERT_EQ(read.type(), type);
    EXPECT_EQ(cv::norm(read.reshape(1), image.reshape(1), cv::NORM_INF), 0);
  }
}

TEST(Npy, ReadsWhatNumpyWrites) {
  const cv::Mat image =
      matOfNpy(withHeader("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3), }          \n", 6));
  EXPECT_EQ(image.size(), cv::Size(3, 2));
  EXPECT_EQ(image.type(), CV_8UC1);
  EXPECT_EQ(matOfNpy(withHeader("{'descr': '<f2', 'fortran_order': False, 'shape': (1, 2, 4), }\n", 16)).type(),
            CV_32FC4);
}

TEST(Npy, SaysWhyAFileIsRefused) {
  const auto of = [](const std::string& type, const std::string& order, const std::string& shape, std::size_t bytes) {
    return errorOf(
        withHeader("{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': (" + shape + "), }\n", bytes));
  };
  EXPECT_NE(of("<f8", "False", "2, 3", 48).find("astype"), std::string::npos);
  EXPECT_NE(of("|u1", "True", "2, 3", 6).find("Fortran"), std::string::npos);
  EXPECT_NE(of("|u1", "False", "2, 3", 5).find("5 bytes"), std::string::npos);
  EXPECT_NE(of("|u1", "False", "6,", 6).find("1 dimensions"), std::string::npos);
  EXPECT_NE(of("|u1", "False", "2, 0", 0).find("shape"), std::string::npos);
  EXPECT_NE(of("|u1", "False", "99999999, 3", 6).find("side"), std::string::npos);
  EXPECT_NE(of("|u1", "False", "9999999, 9999999", 6).find("bytes"), std::string::npos);
  EXPECT_NE(errorOf({1, 2, 3}).find("no .npy"), std::string::npos);
  std::vector<std::uint8_t> cut = npyOf(cv::Mat1b(3, 3, std::uint8_t{1}));
  cut.resize(20);
  EXPECT_NE(errorOf(cut).find("cut off"), std::string::npos);
}

TEST(Values, EachKindHasItsTypes) {
  for (const int type : {CV_8UC1, CV_16UC1, CV_32FC1})
    EXPECT_NO_THROW(requireValues(type, ImageKind::kRadiometric, ""));
  for (const int type : {CV_8UC3, CV_32SC1}) {
    EXPECT_THROW(requireValues(type, ImageKind::kRadiometric, ""), std::runtime_error);
  }
  EXPECT_NO_THROW(requireValues(CV_16UC1, ImageKind::kLabels, ""));
  EXPECT_THROW(requireValues(CV_32FC1, ImageKind::kLabels, ""), std::runtime_error);
  EXPECT_THROW(requireValues(CV_8UC3, ImageKind::kLabels, ""), std::runtime_error);  // a palette became colours
  EXPECT_NO_THROW(requireValues(CV_32FC(20), ImageKind::kLogits, ""));
  EXPECT_THROW(requireValues(CV_8UC1, ImageKind::kLogits, ""), std::runtime_error);
}

TEST(Values, ProbabilitiesBecomeLogarithmsAndScoresStay) {
  const cv::Mat probabilities(2, 2, CV_32FC2, cv::Scalar(0.25, 0.75)), scores(2, 2, CV_32FC2, cv::Scalar(-3, 4));
  EXPECT_NEAR(shownValues(probabilities, ImageKind::kLogits).at<cv::Vec2f>(1, 1)[0], std::log(0.25), 1e-4);
  EXPECT_EQ(shownValues(scores, ImageKind::kLogits).at<cv::Vec2f>(1, 1)[1], 4);
  const cv::Mat bytes(2, 2, CV_8UC2, cv::Scalar(0, 255));
  EXPECT_NEAR(shownValues(bytes, ImageKind::kLogits).at<cv::Vec2f>(0, 0)[1], 0, 0.01);
  EXPECT_LT(shownValues(bytes, ImageKind::kLogits).at<cv::Vec2f>(0, 0)[0], -6);
}

TEST(Values, FilesKeepEveryNumber) {
  EXPECT_EQ(encodeValues(cv::Mat1w(4, 4, std::uint16_t{700}), "ppm").extension, "pgm");
  EXPECT_EQ(encodeValues(cv::Mat1b(4, 4, std::uint8_t{7}), "jpg").extension, "png");  // without loss
  EXPECT_EQ(encodeValues(cv::Mat1f(4, 4, 0.5F), "ppm").extension, "npy");
}

}  // namespace
}  // namespace cloud_colorizer
