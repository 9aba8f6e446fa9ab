// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/bag_source.hpp"

#include <gtest/gtest.h>
#include <rosbag/bag.h>

#include <filesystem>

#include "cloud_colorizer/base/check.hpp"
#include "core/scratch.hpp"
#include "ros/messages.hpp"
#include "ros/small_bag.hpp"

namespace cloud_colorizer {
namespace {

const char* const kCloud = "sensor_msgs/PointCloud2";
const char* const kImage = "sensor_msgs/Image";
const char* const kCompressed = "sensor_msgs/CompressedImage";
const char* const kInfo = "sensor_msgs/CameraInfo";

std::string errorOf(const std::function<void()>& body) {
  try {
    body();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class BagTest : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    writeText(scratch_ / name, text);
    return scratch_ / name;
  }

  ScratchDirectory scratch_;
};

TEST(GuessRig, OneCloudAndItsCameras) {
  const Rig rig = guessRig({{"/velodyne_points", kCloud},
                            {"/camera/image/compressed", kCompressed},
                            {"/camera/camera_info", kInfo},
                            {"/left/image_rect", kImage},
                            {"/left/camera_info", kInfo},
                            {"/logo/image", kImage},
                            {"/tf", "tf2_msgs/TFMessage"}});
  EXPECT_EQ(rig.cloud, "/velodyne_points");
  ASSERT_EQ(rig.cameras.size(), 2U);
  EXPECT_EQ(rig.cameras[0].image, "/camera/image/compressed");
  EXPECT_EQ(rig.cameras[0].camera_info, "/camera/camera_info");
  EXPECT_FALSE(rig.cameras[0].params.rectified);
  EXPECT_TRUE(rig.cameras[1].params.rectified);
}

TEST(GuessRig, RawIsTakenBeforeItsCompressedCopy) {
  const Rig rig = guessRig({{"/points", kCloud},
                            {"/c/image_raw", kImage},
                            {"/c/image_raw/compressed", kCompressed},
                            {"/c/image_raw/compressedDepth", kCompressed},
                            {"/c/camera_info", kInfo}});
  ASSERT_EQ(rig.cameras.size(), 1U);
  EXPECT_EQ(rig.cameras[0].image, "/c/image_raw");
}

TEST(GuessRig, AmbiguousBagsAreRefusedWithTopicsAndExample) {
  const TopicTypes two_clouds = {{"/a", kCloud}, {"/b", kCloud}, {"/c/image", kImage}, {"/c/camera_info", kInfo}};
  const std::string error = errorOf([&] { guessRig(two_clouds); });
  EXPECT_TRUE(contains(error, "more than one cloud"));
  EXPECT_TRUE(contains(error, "/b (sensor_msgs/PointCloud2)"));
  EXPECT_TRUE(contains(error, "cloud_in:"));
  EXPECT_TRUE(contains(
      errorOf([] {
        guessRig({{"/a", kCloud}, {"/c/image", kImage}, {"/c/image_color", kImage}, {"/c/camera_info", kInfo}});
      }),
      "Both /c/image and /c/image_color"));
  EXPECT_TRUE(contains(errorOf([] { guessRig({{"/a", kCloud}, {"/c/image", kImage}}); }), "no image topic"));
  EXPECT_TRUE(contains(errorOf([] { guessRig({}); }), "no cloud topic"));
}

TEST_F(BagTest, RigFileIsRead) {
  const TopicTypes topics = {{"/points", kCloud},
                             {"/front/image_raw/compressed", kCompressed},
                             {"/front/camera_info", kInfo},
                             {"/left/image_rect", kImage},
                             {"/left/camera_info", kInfo}};
  const Rig example = readRig(write("example.yaml", exampleRig()), topics);
  EXPECT_EQ(example.cameras.at(0).params.mask, scratch_ / "front_mask.png");
  EXPECT_EQ(example.map_frame, "map");
  const Rig rig = readRig(
      write("rig.yaml", "cloud_in: /points\ncameras:\n  - {image: /left/image_rect, time_offset: 0.1}\n"), topics);
  EXPECT_EQ(rig.cloud, "/points");
  ASSERT_EQ(rig.cameras.size(), 1U);
  EXPECT_EQ(rig.cameras[0].camera_info, "/left/camera_info");
  EXPECT_EQ(rig.cameras[0].params.time_offset, 0.1);
  EXPECT_TRUE(rig.cameras[0].params.rectified);
}

TEST_F(BagTest, MistakesInARigFileAreNamed) {
  const TopicTypes topics = {{"/points", kCloud}, {"/c/image", kImage}, {"/c/camera_info", kInfo}};
  const auto error = [&](const std::string& text) {
    return errorOf([&] { readRig(write("rig.yaml", text), topics); });
  };
  EXPECT_TRUE(contains(error("cloud_in: /points\ncamera: []\n"), "unknown key camera"));
  EXPECT_TRUE(contains(error("cloud_in: /points\ncameras: [{image: /c/image, offset: 1}]\n"), "unknown key offset"));
  EXPECT_TRUE(contains(error("cloud_in: /lidar\ncameras: []\n"), "no topic /lidar"));
  EXPECT_TRUE(contains(error("cloud_in: /c/image\ncameras: []\n"), "is a sensor_msgs/Image"));
  EXPECT_TRUE(contains(error("cameras: []\n"), "cloud_in"));
  EXPECT_TRUE(contains(error("cloud_in: [\n"), "rig.yaml"));
  EXPECT_TRUE(contains(error("just words"), "no rig file"));
  EXPECT_TRUE(contains(errorOf([&] { readRig(scratch_ / "none.yaml", topics); }), "does not exist"));
}

TEST_F(BagTest, MissingAndDamagedBagsAreRefusedWithRemedy) {
  EXPECT_TRUE(contains(errorOf([&] { BagSource({scratch_ / "none.bag"}); }), "no bag"));
  EXPECT_TRUE(contains(errorOf([&] { BagSource({write("text.bag", "no bag at all")}); }), "rosbag reindex"));
  const std::string bag = scratch_ / "small.bag";
  testing_ros::SmallDrive().write(bag);
  std::filesystem::resize_file(bag, std::filesystem::file_size(bag) / 2);
  EXPECT_TRUE(contains(errorOf([&] { BagSource({bag}); }), "rosbag reindex"));
}

/// What is recorded from a bag, or from several as if they were one.
CollectorStats play(const std::vector<std::string>& bags, const std::string& directory, double tf_lead,
                    const Callbacks& callbacks = {}) {
  BagSource source(bags);
  const Rig rig = guessRig(source.topics());
  CollectorParams params;
  params.record.min_range = 0;
  params.cameras.resize(rig.cameras.size());
  Recorder recorder(directory, "map", params.record);
  Collector collector(recorder, params, {});
  source.play(rig, tf_lead, collector, callbacks);
  return collector.stats();
}

TEST_F(BagTest, EveryMessageOfTheBagIsRecordedOrCounted) {
  const testing_ros::SmallDrive drive;
  drive.write(scratch_ / "small.bag");
  std::size_t last_done = 0, total = 0;
  Callbacks callbacks;
  callbacks.progress = [&](const Progress& progress) {
    EXPECT_GE(progress.done, last_done);
    last_done = progress.done;
    total = progress.total;
  };
  const CollectorStats stats = play({scratch_ / "small.bag"}, scratch_ / "recording", 2, callbacks);
  EXPECT_EQ(stats.cloud.count(Outcome::kKept), drive.num_frames);
  EXPECT_EQ(stats.cameras[0].received, drive.num_frames);
  EXPECT_EQ(stats.cameras[1].received, drive.num_frames);
  EXPECT_EQ(stats.cameras[0].count(Outcome::kKept), drive.num_frames);  // 1 m between frames
  EXPECT_EQ(stats.cameras[1].count(Outcome::kKept), drive.num_frames);
  EXPECT_EQ(last_done, total);
  EXPECT_EQ(total, drive.num_frames * 5);
}

TEST_F(BagTest, TransformsMayComeLateInTheBag) {
  testing_ros::SmallDrive drive;
  drive.tf_delay = 5;
  drive.write(scratch_ / "late.bag");
  EXPECT_EQ(play({scratch_ / "late.bag"}, scratch_ / "a", 6).cloud.count(Outcome::kKept), drive.num_frames);
  // Without reading ahead only the last clouds have waited less than tf_wait (2 s) when the rest of tf comes.
  EXPECT_EQ(play({scratch_ / "late.bag"}, scratch_ / "b", 0).cloud.count(Outcome::kKept), 3U);
}

TEST_F(BagTest, LoopedRecordingIsReadToItsEnd) {
  testing_ros::SmallDrive drive;
  drive.loops = 2;
  drive.write(scratch_ / "looped.bag");
  const CollectorStats stats = play({scratch_ / "looped.bag"}, scratch_ / "recording", 2);
  EXPECT_GE(stats.time_jumps, 1U);
  EXPECT_EQ(stats.cloud.count(Outcome::kKept), 2 * drive.num_frames);
}

/// In the messages, and as the time when the bag received them.
TEST_F(BagTest, StampsOutOfRangeCostTheirMessagesOnly) {
  const testing_ros::SmallDrive drive;
  drive.write(scratch_ / "bad.bag");
  rosbag::Bag bag(scratch_ / "bad.bag", rosbag::bagmode::Append);
  const ros::Time last(4294967295U, 999999999U);
  auto cloud = drive.cloud(3);
  auto transform = drive.pose(3);
  cloud.header.stamp = transform.transforms[0].header.stamp = last;
  bag.write("/tf", ros::Time(drive.stampOf(3) + 0.5), transform);
  bag.write("/points", ros::Time(drive.stampOf(3) + 0.5), cloud);
  bag.write("/tf", last, transform);
  bag.write("/points", last, cloud);
  bag.close();
  const CollectorStats stats = play({scratch_ / "bad.bag"}, scratch_ / "recording", 2);
  EXPECT_EQ(stats.cloud.count(Outcome::kKept), drive.num_frames);
  EXPECT_EQ(stats.cloud.count(Outcome::kBadStamp), 2U);
  EXPECT_EQ(stats.cameras[0].count(Outcome::kKept), drive.num_frames);
  EXPECT_EQ(stats.bad_transforms, 2U);
}

TEST_F(BagTest, SeveralBagsAreReadAsOne) {
  testing_ros::SmallDrive first, second;
  second.first_stamp = first.first_stamp + 60;
  first.write(scratch_ / "1.bag");
  second.write(scratch_ / "2.bag");
  const CollectorStats stats = play({scratch_ / "2.bag", scratch_ / "1.bag"}, scratch_ / "recording", 2);
  EXPECT_EQ(stats.cloud.count(Outcome::kKept), first.num_frames + second.num_frames);
  EXPECT_EQ(stats.time_jumps, 0U);
}

TEST_F(BagTest, CanBeCancelled) {
  testing_ros::SmallDrive().write(scratch_ / "small.bag");
  Callbacks callbacks;
  callbacks.cancelled = [] { return true; };
  EXPECT_THROW(play({scratch_ / "small.bag"}, scratch_ / "recording", 2, callbacks), Cancelled);
}

}  // namespace
}  // namespace cloud_colorizer
