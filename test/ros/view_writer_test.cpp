// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/view_writer.hpp"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

#include "core/scratch.hpp"
#include "ros/messages.hpp"

namespace cloud_colorizer {
namespace {

class ViewWriterTest : public testing::Test {
 protected:
  ViewWriterTest() {
    camera_ = recorder_.setCamera("camera_0", {8, 6, 10, 11, 3.5, 2.5, DistortionModel::kPlumbBob, {}});
  }

  PendingView view(double stamp) const {
    PendingView view;
    view.id = camera_;
    view.stamp = stamp;
    view.map_from_camera.setIdentity();
    view.extension = "jpg";
    return view;
  }
  void addRaw(ViewWriter& writer, double stamp, const std::string& encoding = "mono8") {
    writer.add(view(stamp), boost::make_shared<sensor_msgs::Image>(testing_ros::imageMessage(encoding, 8, 6, {1, 2})),
               recorder_);
  }
  void addCompressed(ViewWriter& writer, double stamp) {
    writer.add(view(stamp),
               boost::make_shared<sensor_msgs::CompressedImage>(testing_ros::encoded(cv::Mat(6, 8, CV_8UC3), "jpg")),
               recorder_);
  }
  std::vector<double> recordedStamps() {
    std::vector<double> stamps;
    const Recording recording = recorder_.snapshot();
    for (const View& view : recording.views()) stamps.push_back(view.stamp);
    return stamps;
  }

  ScratchDirectory scratch_;
  Recorder recorder_{scratch_.path(), "map", RecordParams()};
  std::uint32_t camera_ = 0;
  std::vector<double> kept_;
  ViewWriter::Kept noteKept_ = [this](const PendingView& view) { kept_.push_back(view.stamp); };
};

TEST_F(ViewWriterTest, ViewsKeepTheirOrderWhateverTheirImagesTake) {
  ViewWriter writer(4, "png", noteKept_);
  std::vector<double> expected;
  for (int i = 0; i < 40; ++i) {
    expected.push_back(i);
    i % 3 == 0 ? addCompressed(writer, i) : addRaw(writer, i);
  }
  writer.writeAll(recorder_);
  EXPECT_EQ(writer.numPending(), 0U);
  EXPECT_EQ(recordedStamps(), expected);
  EXPECT_EQ(kept_, expected);
  const Recording recording = recorder_.snapshot();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_FALSE(recording.readPixels(i).image.empty());
}

TEST_F(ViewWriterTest, FewImagesAreInWork) {
  ViewWriter writer(1, "png", noteKept_);
  for (int i = 0; i < 40; ++i) {
    addRaw(writer, i);
    EXPECT_LE(writer.numPending(), 8U);
  }
  writer.writeAll(recorder_);
}

TEST_F(ViewWriterTest, AnImageThatCannotBeEncodedCostsItsOwnViewOnly) {
  ViewWriter writer(1, "png", noteKept_);
  addRaw(writer, 1, "no such encoding");
  // The next one that is added may already meet it.
  EXPECT_THROW(
      {
        addRaw(writer, 2);
        writer.writeAll(recorder_);
      },
      std::exception);
  writer.writeAll(recorder_);
  EXPECT_EQ(recordedStamps(), std::vector<double>{2});
}

TEST_F(ViewWriterTest, ClearedViewsAreNotWritten) {
  ViewWriter writer(1, "png", noteKept_);
  for (int i = 0; i < 5; ++i) addRaw(writer, i);
  const std::size_t written = recorder_.numViews();
  writer.clear();
  writer.writeAll(recorder_);
  EXPECT_EQ(recorder_.numViews(), written);
  EXPECT_EQ(writer.numPending(), 0U);
}

}  // namespace
}  // namespace cloud_colorizer
