// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize_bag's reader is killed and reads the same bag again into the same recording.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>

#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"
#include "core/scratch.hpp"
#include "ros/small_bag.hpp"

namespace cloud_colorizer {
namespace {

using testing_ros::SmallDrive;

class ResumedBag : public testing::TestWithParam<double> {
 protected:
  std::string write(const std::string& name) {
    drive_.write(scratch_ / name);
    return scratch_ / name;
  }

  /// Kills itself before message `kill_at`; then there is time for some flushes.
  CollectorStats read(const std::vector<std::string>& bags, const std::string& directory, int kill_at = -1) {
    CollectorParams params;
    params.record.voxel_size = GetParam();
    params.record.keyframe_distance = 1;  // exactly what the drive moves in a frame: rounding must not decide
    params.raw_image_format = "png";
    BagSource source(bags);
    const Rig rig = guessRig(source.topics());
    params.cameras.resize(rig.cameras.size());
    Recorder recorder(directory, "map", params.record);
    Collector collector(recorder, params, {});
    Callbacks callbacks;
    int num_messages = 0;
    callbacks.cancelled = [&] {
      if (kill_at >= 0) usleep(25000);
      if (++num_messages == kill_at) raise(SIGKILL);
      return false;
    };
    source.play(rig, 2, collector, callbacks);
    return collector.stats();
  }

  void readAndDie(const std::vector<std::string>& bags, const std::string& directory, int kill_at) {
    const pid_t child = fork();
    if (child == 0) {
      read(bags, directory, kill_at);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
  }

  void expectSame(const std::string& name, const std::string& expected_name) {
    const auto content = [&](const std::string& directory) {
      std::map<std::string, std::string> files;
      for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch_ / directory)) {
        if (!entry.is_regular_file() || entry.path().extension() == ".tmp") continue;
        files[std::filesystem::relative(entry.path(), scratch_ / directory)] = readText(entry.path());
      }
      return files;
    };
    const auto files = content(name), expected = content(expected_name);
    EXPECT_EQ(files.size(), expected.size());
    for (const auto& [file, bytes] : expected) {
      EXPECT_TRUE(files.count(file) > 0 && files.at(file) == bytes) << file << " of " << name << " differs";
    }
  }

  ScratchDirectory scratch_;
  SmallDrive drive_;
};

TEST_P(ResumedBag, GivesTheRecordingOfAnUndisturbedRun) {
  const std::string bag = write("drive.bag");
  const CollectorStats stats = read({bag}, scratch_ / "whole");
  EXPECT_EQ(stats.cameras[0].count(Outcome::kKept), drive_.num_frames);
  for (const int kill_at : {1, 22, 31, 40}) {
    const std::string name = "killed_at_" + std::to_string(kill_at);
    readAndDie({bag}, scratch_ / name, kill_at);
    read({bag}, scratch_ / name);
    expectSame(name, "whole");
  }
}

TEST_P(ResumedBag, ReadTwiceIsReadOnce) {
  const std::string bag = write("drive.bag");
  read({bag}, scratch_ / "once");
  read({bag}, scratch_ / "twice");
  const CollectorStats stats = read({bag}, scratch_ / "twice");
  EXPECT_EQ(stats.cloud.count(Outcome::kRecordedBefore), drive_.num_frames);
  EXPECT_EQ(stats.cameras[1].count(Outcome::kRecordedBefore), drive_.num_frames);
  EXPECT_TRUE(stats.cloud.last_error.empty());
  expectSame("twice", "once");
}

TEST_P(ResumedBag, ALaterBagIsAppended) {
  const std::string first = write("first.bag");
  drive_.first_stamp += 100;
  const std::string second = write("second.bag");
  read({first}, scratch_ / "whole");
  read({second}, scratch_ / "whole");
  readAndDie({first}, scratch_ / "parts", 30);
  read({first}, scratch_ / "parts");
  readAndDie({second}, scratch_ / "parts", 35);
  read({second}, scratch_ / "parts");
  expectSame("parts", "whole");
}

TEST_P(ResumedBag, ALoopedDriveIsRecordedAsOften) {
  drive_.loops = 2;
  drive_.num_frames = 4;
  const std::string bag = write("looped.bag");
  const CollectorStats stats = read({bag}, scratch_ / "whole");
  EXPECT_EQ(stats.cloud.count(Outcome::kKept), 8U);
  for (const int kill_at : {15, 36}) {
    const std::string name = "killed_at_" + std::to_string(kill_at);
    readAndDie({bag}, scratch_ / name, kill_at);
    read({bag}, scratch_ / name);
    expectSame(name, "whole");
  }
}

INSTANTIATE_TEST_SUITE_P(VoxelSizes, ResumedBag, testing::Values(0.0, 0.08));

}  // namespace
}  // namespace cloud_colorizer
