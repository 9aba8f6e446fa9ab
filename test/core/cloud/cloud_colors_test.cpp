// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/cloud_colors.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cloud_colorizer {
namespace {

/// One point with these numbers in its fields.
Cloud onePoint(const std::vector<Field>& fields, const std::vector<double>& numbers) {
  Cloud cloud;
  cloud.positions = Eigen::Matrix3Xd::Zero(3, 1);
  cloud.fields = fields;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    withType(fields[f].type, [&](auto zero) {
      const auto number = static_cast<decltype(zero)>(numbers[f]);
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&number);
      cloud.records.insert(cloud.records.end(), bytes, bytes + sizeof number);
    });
  }
  return cloud;
}

Eigen::Vector3f colorOf(const Cloud& cloud) {
  const CloudColors colors(cloud.fields, "test.ply");
  const Values values = colors.read(cloud);
  return values.col(0) * colors.scale(values.maxCoeff());
}

Cloud separate(FieldType type, const Eigen::Vector3d& color) {
  return onePoint({{"blue", type}, {"ring", FieldType::kUint16}, {"red", type}, {"green", type}},
                  {color[2], 7, color[0], color[1]});
}

TEST(CloudColors, PackedInEitherNameAndAnyPlace) {
  const double packed = 0xFF0A141E;  // with an alpha of 255
  for (const char* name : {"rgb", "rgba"}) {
    const Cloud cloud = onePoint({{"intensity"}, {name, FieldType::kUint32}}, {1, packed});
    EXPECT_EQ(colorOf(cloud), Eigen::Vector3f(10, 20, 30)) << name;
  }
}

TEST(CloudColors, NumbersOfEveryTypeComeToTheSameScale) {
  const Eigen::Vector3d color(51, 102, 255);
  for (const FieldType type : {FieldType::kUint8, FieldType::kInt32, FieldType::kUint32, FieldType::kFloat32,
                               FieldType::kFloat64, FieldType::kUint16, FieldType::kInt16}) {
    EXPECT_EQ(colorOf(separate(type, color)), color.cast<float>()) << static_cast<int>(type);
  }
  EXPECT_TRUE(colorOf(separate(FieldType::kUint16, 257 * color)).isApprox(color.cast<float>(), 1e-6F));
  EXPECT_TRUE(colorOf(separate(FieldType::kFloat32, color / 255)).isApprox(color.cast<float>(), 1e-6F));
  EXPECT_TRUE(colorOf(separate(FieldType::kFloat64, color / 255)).isApprox(color.cast<float>(), 1e-6F));
  EXPECT_EQ(colorOf(separate(FieldType::kUint8, {1, 1, 1})), Eigen::Vector3f(1, 1, 1));
}

TEST(CloudColors, SayHowTheyWereTaken) {
  EXPECT_EQ(CloudColors(separate(FieldType::kFloat32, {0, 0, 0}).fields, "").describe(200), "");
  EXPECT_NE(CloudColors(separate(FieldType::kFloat32, {0, 0, 0}).fields, "").describe(0.9F).find("0 to 1"),
            std::string::npos);
  EXPECT_NE(CloudColors(separate(FieldType::kUint16, {0, 0, 0}).fields, "").describe(900).find("65535"),
            std::string::npos);
}

TEST(CloudColors, WhatTheCloudWasGivenCountsBeforeWhatItCameWith) {
  Cloud cloud = separate(FieldType::kUint8, {1, 2, 3});
  cloud.fields.push_back({"rgb", FieldType::kUint32});
  cloud.records.insert(cloud.records.end(), {30, 20, 10, 0});
  EXPECT_EQ(colorOf(cloud), Eigen::Vector3f(10, 20, 30));
}

TEST(CloudColors, NoNumberIsBlackAndNotEverything) {
  EXPECT_EQ(colorOf(separate(FieldType::kFloat32, {std::nan(""), 20, 30})), Eigen::Vector3f(0, 20, 30));
}

TEST(CloudColors, NoneOrHalfOnesAreRefusedWithTheFieldsThatAreThere) {
  const auto messageOf = [](const std::vector<Field>& fields) -> std::string {
    try {
      CloudColors(fields, "test.ply");
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  };
  EXPECT_NE(messageOf({{"intensity"}, {"red"}}).find("test.ply: the cloud has no colours"), std::string::npos);
  EXPECT_NE(messageOf({{"intensity"}, {"red"}}).find("intensity red"), std::string::npos);
  EXPECT_NE(messageOf({{"rgb", FieldType::kFloat64}}).find("4 bytes"), std::string::npos);
  EXPECT_NE(messageOf({{"red"}, {"green", FieldType::kUint8}, {"blue"}}).find("differ"), std::string::npos);
}

}  // namespace
}  // namespace cloud_colorizer
