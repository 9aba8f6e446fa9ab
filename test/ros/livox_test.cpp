// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/livox.hpp"

#include <gtest/gtest.h>

#include "cloud_colorizer/ros/conversions.hpp"
#include "ros/livox_messages.hpp"

namespace cloud_colorizer {
namespace {

std_msgs::Header header() {
  std_msgs::Header header;
  header.stamp = ros::Time(1700000000, 5000);
  header.frame_id = "livox_frame";
  return header;
}

TEST(Livox, AMessageIsReadWithoutItsPackage) {
  EXPECT_TRUE(isLivoxType("livox_ros_driver/CustomMsg"));
  EXPECT_TRUE(isLivoxType("livox_ros_driver2/CustomMsg"));
  EXPECT_FALSE(isLivoxType("sensor_msgs/PointCloud2"));
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 20);
  auto bytes = testing_ros::livoxMessage(header(), points);
  const auto message = cloudFromLivox(bytes);
  EXPECT_EQ(message->header.stamp, header().stamp);
  EXPECT_EQ(message->header.frame_id, "livox_frame");
  const Cloud cloud = cloudFromMessage(*message);
  ASSERT_EQ(cloud.positions.cols(), 20);
  EXPECT_LT((cloud.positions - points).cwiseAbs().maxCoeff(), 1e-6);
  const auto number = [&](const char* name, std::size_t i) {
    const auto field = findField(cloud.fields, name);
    return numberAt(&cloud.records[i * recordSize(cloud.fields) + field->offset], field->field.type);
  };
  EXPECT_EQ(number("intensity", 7), 7);
  EXPECT_EQ(number("tag", 7), 1);
  EXPECT_EQ(number("line", 7), 2);
  EXPECT_EQ(number("offset_time", 7), 7000);
}

TEST(Livox, OneThatIsCutOffHasNoPoints) {
  const auto whole = testing_ros::livoxMessage(header(), Eigen::Matrix3Xd::Random(3, 20));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::vector<std::uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(cloudFromLivox(cut)->width, 0U) << size;
  }
}

}  // namespace
}  // namespace cloud_colorizer
