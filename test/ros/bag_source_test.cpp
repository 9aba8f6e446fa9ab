// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/bag_source.hpp"

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

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

std::vector<std::string> camerasOf(const TopicTypes& topics, const std::map<std::string, std::string>& formats) {
  const Rig rig = guessRig(topics, [&](const std::string& topic) {
    const auto found = formats.find(topic);
    return found == formats.end() ? std::string() : found->second;
  });
  std::vector<std::string> cameras;
  for (const RigCamera& camera : rig.cameras) cameras.push_back(camera.image);
  return cameras;
}

TEST(GuessRig, OnlyCamerasWithColoursAreTaken) {
  TopicTypes topics = {{"/points", kCloud}};
  for (const char* name :
       {"/color", "/aligned_depth_to_color", "/zed", "/infra1", "/thermal", "/mono", "/front_mask"}) {
    topics[std::string(name) + "/image"] = kImage;
    topics[std::string(name) + "/camera_info"] = kInfo;
  }
  const std::map<std::string, std::string> formats = {
      {"/color/image", "rgb8"},     {"/aligned_depth_to_color/image", "16UC1"},
      {"/zed/image", "32FC1"},      {"/infra1/image", "mono8"},
      {"/thermal/image", "mono16"}, {"/mono/image", "mono8"},
      {"/front_mask/image", "rgb8"}};
  EXPECT_EQ(camerasOf(topics, formats), std::vector<std::string>{"/color/image"});
  const Rig rig = guessRig(topics, [&](const std::string& topic) { return formats.at(topic); });
  EXPECT_EQ(rig.left_out.size(), 6U);
  EXPECT_TRUE(contains(describeRig(rig), "left out: /zed/image holds depths"));
}

TEST(GuessRig, ACameraOfColoursMayHaveTheNameOfAnother) {
  const TopicTypes topics = {
      {"/points", kCloud}, {"/depth_camera/color/image_raw", kImage}, {"/depth_camera/color/camera_info", kInfo}};
  EXPECT_EQ(camerasOf(topics, {{"/depth_camera/color/image_raw", "rgb8"}}).size(), 1U);
}

TEST(GuessRig, GreyCamerasAreTakenWhereThereAreNoOthers) {
  const TopicTypes topics = {{"/points", kCloud}, {"/left/image", kImage}, {"/left/camera_info", kInfo}};
  EXPECT_EQ(camerasOf(topics, {{"/left/image", "mono8"}}), std::vector<std::string>{"/left/image"});
  EXPECT_TRUE(contains(errorOf([&] { camerasOf(topics, {{"/left/image", "16UC1"}}); }), "holds depths"));
}

TEST(GuessRig, OfSeveralTopicsOfOneCameraTheFirstIsTaken) {
  const TopicTypes topics = {
      {"/a", kCloud}, {"/c/image_color", kImage}, {"/c/image_raw", kImage}, {"/c/camera_info", kInfo}};
  EXPECT_EQ(camerasOf(topics, {}), std::vector<std::string>{"/c/image_color"});
}

TEST(GuessRig, AmbiguousBagsAreRefusedWithTopicsAndExample) {
  const TopicTypes two_clouds = {{"/a", kCloud}, {"/b", kCloud}, {"/c/image", kImage}, {"/c/camera_info", kInfo}};
  const std::string error = errorOf([&] { guessRig(two_clouds); });
  EXPECT_TRUE(contains(error, "more than one cloud"));
  EXPECT_TRUE(contains(error, "/b (sensor_msgs/PointCloud2)"));
  EXPECT_TRUE(contains(error, "cloud_in:"));
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

TEST_F(BagTest, ARigFileTellsWhatACameraShows) {
  const TopicTypes topics = {{"/points", kCloud}, {"/t/image", kImage}, {"/t/camera_info", kInfo}};
  const Rig rig = readRig(write("rig.yaml",
                                "cloud_in: /points\ncameras:\n"
                                "  - {image: /t/image, kind: radiometric, scale: 0.01, offset: -273.15}\n"
                                "  - {image: /t/image, kind: labels, quantity: class, names: classes.txt}\n"),
                          topics);
  EXPECT_EQ(rig.cameras.at(0).params.toldQuantity().name, "temperature");
  EXPECT_EQ(rig.cameras[0].params.offset, -273.15);
  EXPECT_EQ(rig.cameras.at(1).params.toldQuantity().name, "class");
  EXPECT_EQ(rig.cameras[1].params.names, scratch_ / "classes.txt");
}

TEST_F(BagTest, MistakesInARigFileAreNamed) {
  const TopicTypes topics = {{"/points", kCloud}, {"/c/image", kImage}, {"/c/camera_info", kInfo}};
  const auto error = [&](const std::string& text) {
    return errorOf([&] { readRig(write("rig.yaml", text), topics); });
  };
  EXPECT_TRUE(contains(error("cloud_in: /points\ncamera: []\n"), "unknown key camera"));
  EXPECT_TRUE(contains(error("cloud_in: /points\ncameras: [{image: /c/image, offset: 1}]\n"), "unknown key offset"));
  EXPECT_TRUE(contains(error("cloud_in: /points\ncameras: [{image: /c/image, kind: thermal}]\n"), "radiometric"));
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

TEST_F(BagTest, WhatComesOnceOnTfIsFixed) {
  testing_ros::SmallDrive drive;
  drive.num_frames = 20;
  drive.fixed_topic = "/tf";
  drive.write(scratch_ / "once.bag");
  const CollectorStats stats = play({scratch_ / "once.bag"}, scratch_ / "a", 2);
  for (const StreamStats& camera : stats.cameras) EXPECT_EQ(camera.count(Outcome::kKept), drive.num_frames);
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

/// Without what is on /tf; with what `add` writes.
template <class Add>
std::string rewritten(const std::string& from, const std::string& to, const std::string& without, const Add& add) {
  rosbag::Bag source(from, rosbag::bagmode::Read), target(to, rosbag::bagmode::Write);
  for (const rosbag::MessageInstance& message : rosbag::View(source)) {
    if (message.getTopic() != without) target.write(message.getTopic(), message.getTime(), message);
    add(target, message);
  }
  return to;
}

TEST_F(BagTest, OdometryStandsInForTf) {
  testing_ros::SmallDrive().write(scratch_ / "small.bag");
  const std::string bag = rewritten(scratch_ / "small.bag", scratch_ / "odometry.bag", "/tf",
                                    [](rosbag::Bag& target, const rosbag::MessageInstance& message) {
                                      if (message.getTopic() != "/tf") return;
                                      const auto tf = message.instantiate<tf2_msgs::TFMessage>();
                                      nav_msgs::Odometry odometry;
                                      odometry.header = tf->transforms[0].header;
                                      odometry.child_frame_id = tf->transforms[0].child_frame_id;
                                      odometry.pose.pose.position.x = tf->transforms[0].transform.translation.x;
                                      odometry.pose.pose.orientation = tf->transforms[0].transform.rotation;
                                      target.write("/odom", message.getTime(), odometry);
                                    });
  BagSource source({bag});
  Rig rig = guessRig(source.topics());
  source.addOdometry(rig);
  EXPECT_EQ(rig.odometry, "/odom");
  EXPECT_EQ(rig.map_frame, "map");
  CollectorParams params;
  params.record.min_range = 0;
  params.cameras.resize(rig.cameras.size());
  Recorder recorder(scratch_ / "recording", rig.map_frame, params.record);
  Collector collector(recorder, params, {});
  source.play(rig, 2, collector, {});
  EXPECT_EQ(collector.stats().cloud.count(Outcome::kKept), testing_ros::SmallDrive().num_frames);
}

TEST_F(BagTest, OdometryBesideTfIsLeftAlone) {
  testing_ros::SmallDrive().write(scratch_ / "small.bag");
  nav_msgs::Odometry odometry;
  odometry.header.frame_id = "odom";
  odometry.child_frame_id = "lidar";
  {
    rosbag::Bag bag(scratch_ / "small.bag", rosbag::bagmode::Append);
    bag.write("/odom", ros::Time(1000), odometry);
  }
  BagSource source({scratch_ / "small.bag"});
  Rig rig = guessRig(source.topics());
  source.addOdometry(rig);
  EXPECT_EQ(rig.odometry, "");
}

/// What is recorded with the poses of a file instead of tf's.
std::vector<View> viewsWithPoses(const std::string& bag, const std::string& poses, const std::string& frame,
                                 const std::string& directory) {
  BagSource source({bag});
  Rig rig = guessRig(source.topics());
  rig.base_frame = frame;
  source.addPoses(poses, "map", rig);
  CollectorParams params;
  params.record.min_range = 0;
  params.cameras.resize(rig.cameras.size());
  Recorder recorder(directory, "map", params.record);
  Collector collector(recorder, params, {});
  source.play(rig, 2, collector, {});
  return recorder.snapshot().views();
}

TEST_F(BagTest, PosesMayComeFromAFile) {
  const testing_ros::SmallDrive drive;
  drive.write(scratch_ / "small.bag");
  std::string tum = "# stamp x y z qx qy qz qw\n", kitti, of_camera;
  const auto fixed = testing_ros::SmallDrive::fixedFrames().transforms[0].transform;  // camera_0 on the lidar
  for (std::size_t i = 0; i < drive.num_frames; ++i) {
    const std::string stamp = std::to_string(drive.stampOf(i)), x = std::to_string(2 * drive.positionOf(i));
    tum += stamp + ' ' + x + " 0 0 0 0 0 1\n";
    kitti += "1 0 0 " + x + " 0 1 0 0 0 0 1 0\n";
    of_camera += stamp + ' ' + x + " 0 0 " + std::to_string(fixed.rotation.x) + ' ' + std::to_string(fixed.rotation.y) +
                 ' ' + std::to_string(fixed.rotation.z) + ' ' + std::to_string(fixed.rotation.w) + '\n';
  }
  int runs = 0;
  for (const auto& [text, frame] : std::vector<std::pair<std::string, std::string>>{
           {tum, ""}, {tum, "lidar"}, {kitti, ""}, {of_camera, "camera_0"}}) {
    const std::vector<View> views = viewsWithPoses(scratch_ / "small.bag", write("poses.txt", text), frame,
                                                   scratch_ / ("recording" + std::to_string(runs++)));
    ASSERT_EQ(views.size(), 2 * drive.num_frames) << runs;
    for (const View& view : views) {
      EXPECT_NEAR(view.map_from_camera.translation().x(),
                  2 * drive.positionOf(static_cast<std::size_t>(view.stamp - drive.first_stamp)), 1e-5);
      const Eigen::Vector3d ahead = view.map_from_camera.linear().col(2);
      EXPECT_NEAR(ahead.y(), view.camera == 0 ? 1 : -1, 1e-5) << runs;
    }
  }
}

TEST_F(BagTest, PosesThatAreNoneAreToldWithFileAndLine) {
  testing_ros::SmallDrive().write(scratch_ / "small.bag");
  const auto error = [&](const std::string& text) {
    return errorOf([&] { viewsWithPoses(scratch_ / "small.bag", write("p.txt", text), "", scratch_ / "r"); });
  };
  EXPECT_TRUE(contains(error("1 2 3\n"), "p.txt line 1: 3 numbers"));
  EXPECT_TRUE(contains(error("1 0 0 0 0 0 0 2\n"), "norm 2"));
  EXPECT_TRUE(contains(error("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"), "line 2: its stamp is not after"));
  EXPECT_TRUE(contains(error("1 0 0 0 0 1 0 0 0 0 1 0\n"), "1 poses without stamps"));
  EXPECT_TRUE(contains(error("1 0 0 0 0 2 0 0 0 0 1 0\n"), "no rotation"));
  EXPECT_TRUE(contains(error("# none\n"), "no poses"));
}

TEST_F(BagTest, AnInfoThatComesLateHoldsForTheImagesBeforeIt) {
  testing_ros::SmallDrive drive;
  drive.write(scratch_ / "small.bag");
  const std::string bag = rewritten(scratch_ / "small.bag", scratch_ / "late.bag", "/camera_0/camera_info",
                                    [](rosbag::Bag&, const rosbag::MessageInstance&) {});
  {
    rosbag::Bag append(bag, rosbag::bagmode::Append);
    append.write("/camera_0/camera_info", ros::Time(drive.stampOf(7) + 1), drive.cameraInfo(7, 0));
  }
  EXPECT_EQ(play({bag}, scratch_ / "recording", 2).cameras[0].count(Outcome::kKept), drive.num_frames);
}

TEST_F(BagTest, BagsOfRos2AreToldAsSuch) {
  EXPECT_TRUE(contains(errorOf([&] { BagSource({write("a.db3", "SQLite format 3 and more")}); }), "rosbags-convert"));
  EXPECT_TRUE(contains(errorOf([&] { BagSource({write("a.mcap", "\x89MCAP0\r\n and more")}); }), "ROS 2"));
  std::filesystem::create_directory(scratch_ / "folder");
  write("folder/metadata.yaml", "rosbag2_bagfile_information:\n");
  EXPECT_TRUE(contains(errorOf([&] { BagSource({scratch_ / "folder"}); }), "ROS 2"));
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
