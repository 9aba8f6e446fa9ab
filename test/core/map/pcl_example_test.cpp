// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <pcl/point_types.h>

#include <opencv2/imgcodecs.hpp>

#include "cloud_colorizer/cloud/pcl.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

struct Image {
  double stamp;
  Eigen::Isometry3d map_from_camera;
  std::vector<std::uint8_t> bytes;
};

/// The lines between the marks are those of README.md; test/programs/readme.sh compares them.
pcl::PointCloud<pcl::PointXYZRGB> colorScan(const pcl::PointCloud<pcl::PointXYZI>& scan,
                                            const Eigen::Isometry3d& map_from_sensor, const std::vector<Image>& images,
                                            const Intrinsics& intrinsics, const std::string& directory) {
  // README begins
  Recorder recorder(directory, "map", RecordParams());
  recorder.addCloud(toCloud(scan), map_from_sensor);  // any number of them
  const auto camera = recorder.setCamera("front", intrinsics);
  for (const auto& image : images) {
    recorder.addView(camera, image.stamp, image.map_from_camera, image.bytes, "png");
  }
  const Recording recording = recorder.snapshot();
  colorize(recording, Params(), Callbacks());
  pcl::PointCloud<pcl::PointXYZRGB> map;
  forEachColoredTile(recording, Params(), false, [&](const Cloud& tile) { map += toPcl<pcl::PointXYZRGB>(tile); });
  // README ends
  return map;
}

/// A wall across the x axis of the map, green on the left and blue on the right of three cameras that look along x.
TEST(PclExample, WallHasTheColoursOfTheImages) {
  pcl::PointCloud<pcl::PointXYZI> scan;
  for (int column = -40; column < 40; ++column) {
    for (int row = -20; row < 20; ++row) {
      pcl::PointXYZI point;
      point.x = 5;
      point.y = 0.06F * (static_cast<float>(column) + 0.5F);
      point.z = 0.06F * (static_cast<float>(row) + 0.5F);
      scan.push_back(point);
    }
  }
  Eigen::Isometry3d map_from_sensor = Eigen::Isometry3d::Identity();
  map_from_sensor.translation() << 100, 200, 300;
  Eigen::Matrix3d optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Intrinsics intrinsics{160, 120, 100, 100, 79.5, 59.5, DistortionModel::kPlumbBob, {}};
  std::vector<Image> images;
  for (int i = 0; i < 3; ++i) {
    Image image{0.1 * i, map_from_sensor, {}};
    image.map_from_camera.linear() = optical;
    image.map_from_camera.translation().x() += 0.5 * i;
    cv::Mat3b picture(120, 160, cv::Vec3b(20, 200, 20));
    picture.colRange(80, 160) = cv::Vec3b(200, 20, 20);
    cv::imencode(".png", picture, image.bytes);
    images.push_back(image);
  }
  ScratchDirectory scratch;
  const auto map = colorScan(scan, map_from_sensor, images, intrinsics, scratch / "recording");
  ASSERT_GT(map.size(), scan.size() / 2);
  for (const auto& point : map) {
    EXPECT_NEAR(point.x, 105, 1e-3);
    if (std::abs(point.y - 200) < 0.3) continue;  // where the colours meet
    EXPECT_NEAR(point.g, point.y > 200 ? 200 : 20, 3);
    EXPECT_NEAR(point.b, point.y > 200 ? 20 : 200, 3);
  }
}

}  // namespace
}  // namespace cloud_colorizer
