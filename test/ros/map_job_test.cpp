// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/map_job.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <thread>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"
#include "core/scratch.hpp"
#include "ros/small_bag.hpp"

namespace cloud_colorizer {
namespace {

class MapJobTest : public testing::Test {
 protected:
  MapJobTest() {
    params_.record.voxel_size = 0.08;
    params_.colorize.num_threads = 1;
    record(4);
  }

  /// The first frames of a drive; recorded further when called again.
  void record(std::size_t num_frames) {
    drive_.num_frames = num_frames;
    drive_.write(scratch_ / "drive.bag");
    BagSource source({scratch_ / "drive.bag"});
    const Rig rig = guessRig(source.topics());
    CollectorParams params;
    params.cameras.resize(2);
    params.record = params_.record;
    Recorder recorder(scratch_ / "recording", "map", params.record);
    Collector collector(recorder, params, {});
    source.play(rig, 2, collector, {});
  }

  MapJob::Snapshot snapshot() {
    return [this] { return Recording::open(scratch_ / "recording"); };
  }
  JobResult save(const std::string& name, MapJob::Aborted aborted = {}) {
    return job_.save(
        snapshot(), [this, name] { return scratch_ / name; }, aborted);
  }

  ScratchDirectory scratch_;
  testing_ros::SmallDrive drive_;
  Params params_;
  std::atomic<int> num_published_{0};
  MapJob job_{params_, [this](const Recording&, const Params&) { ++num_published_; }};
};

TEST_F(MapJobTest, ColouringPublishesAndTellsTheResult) {
  const JobResult result = job_.colorize(snapshot(), {});
  EXPECT_TRUE(result.success) << result.message;
  EXPECT_EQ(num_published_, 1);
  EXPECT_GT(job_.status().num_colored, 500U);
  EXPECT_EQ(job_.status().message, result.message);
  EXPECT_FALSE(job_.status().running);
}

TEST_F(MapJobTest, SavingColoursOnlyWhatIsNew) {
  EXPECT_TRUE(save("a.ply").success);
  EXPECT_EQ(num_published_, 1);
  EXPECT_TRUE(save("b.ply").success);
  EXPECT_EQ(num_published_, 1);
  record(8);
  const JobResult result = save("c.ply");
  EXPECT_TRUE(result.success) << result.message;
  EXPECT_EQ(num_published_, 2);
  EXPECT_EQ(CloudReader(scratch_ / "c.ply").numPoints(), snapshot()().numPoints());
  EXPECT_GT(CloudReader(scratch_ / "c.ply").numPoints(), CloudReader(scratch_ / "b.ply").numPoints());
}

TEST_F(MapJobTest, AReportIsWrittenBesideTheMapWhereItIsAskedFor) {
  EXPECT_TRUE(save("plain.ply").success);
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "plain_report"));
  MapJob job(
      params_, [](const Recording&, const Params&) {}, true);
  const JobResult result = job.save(snapshot(), [this] { return scratch_ / "map.ply"; }, {});
  EXPECT_TRUE(result.success) << result.message;
  EXPECT_TRUE(std::filesystem::exists(scratch_ / "map_report/report.html"));
  EXPECT_TRUE(std::filesystem::exists(scratch_ / "map_report/report.json"));
  writeText(scratch_ / "other_report", "a file");
  const JobResult without = job.save(snapshot(), [this] { return scratch_ / "other.ply"; }, {});
  EXPECT_TRUE(without.success);
  EXPECT_NE(without.message.find("but no report"), std::string::npos) << without.message;
  EXPECT_EQ(MapJob::reportFolder("/a/b.c/map"), "/a/b.c/map_report");
}

TEST_F(MapJobTest, ForgottenMapIsColouredAgain) {
  EXPECT_TRUE(save("a.ply").success);
  job_.forget();
  EXPECT_EQ(job_.status().num_colored, 0U);
  EXPECT_TRUE(save("a.ply").success);
  EXPECT_EQ(num_published_, 2);
}

TEST_F(MapJobTest, SecondJobIsRefusedWhileOneRuns) {
  std::promise<void> started, go_on;
  auto first = std::async(std::launch::async, [&] {
    return job_.colorize(
        [&] {
          started.set_value();
          go_on.get_future().wait();
          return snapshot()();
        },
        {});
  });
  started.get_future().wait();
  EXPECT_TRUE(job_.status().running);
  const JobResult second = save("a.ply");
  EXPECT_FALSE(second.success);
  EXPECT_NE(second.message.find("try again"), std::string::npos) << second.message;
  EXPECT_FALSE(job_.reserve());
  go_on.set_value();
  EXPECT_TRUE(first.get().success);
  EXPECT_TRUE(job_.reserve());
}

TEST_F(MapJobTest, ReservationKeepsJobsAway) {
  const auto alone = job_.reserve();
  ASSERT_TRUE(alone);
  const JobResult result = std::async(std::launch::async, [&] { return job_.colorize(snapshot(), {}); }).get();
  EXPECT_FALSE(result.success);
}

TEST_F(MapJobTest, AbortedJobSaysSoAndTheNextOneWorks) {
  EXPECT_EQ(job_.colorize(snapshot(), [] { return true; }).message, "cancelled");
  EXPECT_EQ(num_published_, 0);
  EXPECT_TRUE(job_.colorize(snapshot(), {}).success);
}

TEST_F(MapJobTest, ErrorsBecomeTheMessage) {
  const JobResult result = job_.colorize([]() -> Recording { throw std::runtime_error("no luck"); }, {});
  EXPECT_FALSE(result.success);
  EXPECT_EQ(result.message, "no luck");
  EXPECT_FALSE(save("no/such/place.ply").success);
}

}  // namespace
}  // namespace cloud_colorizer
