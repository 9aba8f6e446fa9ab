// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/recording_session.hpp"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "core/scratch.hpp"
#include "ros/small_bag.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;
using testing_ros::SmallDrive;

/// Raw images of noise, which take long as PNG.
class RecordingSessionTest : public testing::Test {
 protected:
  RecordingSessionTest() {
    drive_.width = 640;
    drive_.height = 480;
    drive_.noisy = true;
    params_.cameras.resize(2);
    params_.raw_image_format = "png";
    session_ = std::make_unique<RecordingSession>(directory_, params_, CollectorEvents{}, errors_);
  }

  template <class Message>
  static boost::shared_ptr<const Message> shared(Message message) {
    return boost::make_shared<Message>(std::move(message));
  }

  void push(Inbox::Task task) { ASSERT_TRUE(session_->push("all", 1000, std::move(task))); }

  void pushFrame(std::size_t i) {
    push([this, i](Collector& to) { to.addTransforms(drive_.pose(i), false); });
    push([message = shared(drive_.cloud(i))](Collector& to) { to.addCloud(message); });
    for (int camera = 0; camera < 2; ++camera) {
      const auto index = static_cast<std::size_t>(camera);
      push(
          [message = shared(drive_.cameraInfo(i, camera)), index](Collector& to) { to.addCameraInfo(index, message); });
      push([message = shared(drive_.rawImage(i, camera)), index](Collector& to) { to.addImage(index, message); });
    }
  }

  void pushFrames(std::size_t begin, std::size_t end) {
    if (begin == 0) push([](Collector& to) { to.addTransforms(SmallDrive::fixedFrames(), true); });
    for (std::size_t i = begin; i < end; ++i) pushFrame(i);
  }

  std::size_t numKept(const SessionState& state) const {
    return state.stats.cameras[0].count(Outcome::kKept) + state.stats.cameras[1].count(Outcome::kKept);
  }

  bool waitFor(const std::function<bool(const SessionState&)>& condition) {
    for (int i = 0; i < 12000; ++i) {
      if (condition(session_->state())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  ScratchDirectory scratch_;
  std::string directory_ = scratch_.path() + "/recording";
  SmallDrive drive_;
  CollectorParams params_;
  ErrorLog errors_;
  std::unique_ptr<RecordingSession> session_;
};

TEST_F(RecordingSessionTest, ResetWhileImagesAreEncodedKeepsThemInTheOldRecording) {
  pushFrames(0, 4);
  ASSERT_TRUE(waitFor([&](const auto& state) { return numKept(state) == 8; }));
  ASSERT_GT(session_->state().pending, 0U) << "the encoders were too fast for this test";
  const Recording old = Recording::open(session_->startAnew());
  EXPECT_EQ(old.views().size(), 8U);
  EXPECT_GT(old.numPoints(), 0U);
  EXPECT_EQ(session_->state().views, 0U);
  EXPECT_EQ(session_->state().points, 0U);

  pushFrames(4, 8);
  EXPECT_TRUE(session_->stop());
  const Recording fresh = Recording::open(directory_);
  EXPECT_EQ(fresh.views().size(), 8U);
  EXPECT_FALSE(fresh.fields().empty());
  for (std::size_t tile = 0; tile < fresh.tiles().size(); ++tile) {
    EXPECT_GT(fresh.readPoints(tile).colwise().norm().minCoeff(), 1.F) << "points that nobody measured";
  }
  EXPECT_TRUE(errors_.rows().empty());
}

/// The new recording cannot be made on a full disk.
TEST_F(RecordingSessionTest, ResetThatFailsChangesNothing) {
  ScratchDirectory disk;
  if (!disk.mountDisk("size=16m")) GTEST_SKIP() << "mounting a small disk needs root";
  directory_ = disk / "recording";
  session_ = std::make_unique<RecordingSession>(directory_, params_, CollectorEvents{}, errors_);
  pushFrames(0, 2);
  ASSERT_TRUE(waitFor([](const auto& state) { return state.views == 4; }));
  session_->snapshot();
  std::ofstream(disk / "filler") << std::string(16'000'000, 'x');
  EXPECT_ERROR(session_->startAnew(), "space");
  fs::remove(disk / "filler");
  EXPECT_EQ(session_->state().error, "");
  pushFrames(2, 4);
  EXPECT_TRUE(session_->stop());
  const auto entries = fs::directory_iterator(disk.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1) << "no other recording is left";
  EXPECT_EQ(Recording::open(directory_).views().size(), 8U);
  session_.reset();
}

TEST_F(RecordingSessionTest, DeletedDirectoryIsToldOnceAndResetBeginsAnew) {
  pushFrames(0, 2);
  ASSERT_TRUE(waitFor([](const auto& state) { return state.views == 4; }));
  EXPECT_EQ(session_->state().error, "");
  fs::remove_all(directory_);
  pushFrames(2, 4);
  ASSERT_TRUE(waitFor([](const auto& state) { return !state.error.empty(); }));
  EXPECT_NE(session_->state().error.find("~reset"), std::string::npos);
  EXPECT_THROW(session_->snapshot(), std::runtime_error);
  EXPECT_EQ(errors_.rows().at("recording").count, 1U);

  EXPECT_EQ(session_->startAnew(), "");
  EXPECT_EQ(session_->state().error, "");
  pushFrames(4, 6);
  EXPECT_TRUE(session_->stop());
  // And what still waited in the inbox when the new recording began.
  const std::size_t views = Recording::open(directory_).views().size();
  EXPECT_GE(views, 4U);
  EXPECT_LE(views, 8U);
}

TEST_F(RecordingSessionTest, WhatIsLostAtTheEndIsAFailure) {
  pushFrames(0, 2);
  ASSERT_TRUE(waitFor([](const auto& state) { return state.views == 4; }));
  fs::remove_all(directory_);
  EXPECT_FALSE(session_->stop());
}

TEST_F(RecordingSessionTest, TasksThatThrowAreCountedAndTheNextOnesAreRecorded) {
  push([](Collector&) { throw std::runtime_error("no luck"); });
  pushFrames(0, 1);
  EXPECT_TRUE(waitFor([](const auto& state) { return state.views == 2; }));
  EXPECT_EQ(errors_.rows().at("recording").last, "no luck");
}

}  // namespace
}  // namespace cloud_colorizer
