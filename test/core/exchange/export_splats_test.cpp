// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgcodecs.hpp>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/export_model.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kDistance = 3;  // m, of the wall

Eigen::Vector3d colorAt(double x, double y) {
  return {128 + 90 * std::sin(4 * x + y), 128 + 90 * std::sin(3 * y - x), 128 + 90 * std::cos(5 * x)};
}

/// A wall of 4 x 3 m across the view of one camera.
class ExportSplats : public testing::Test {
 protected:
  ExportSplats() {
    RecordParams record;
    record.voxel_size = 0;
    record.min_range = 0;
    Recorder recorder(scratch_ / "r", "map", record);
    Cloud cloud;
    cloud.positions.resize(3, 200 * 150);
    for (int i = 0; i < 200 * 150; ++i) {
      cloud.positions.col(i) << -2 + 0.02 * (i % 200), -1.5 + 0.02 * (i / 200), kDistance;
    }
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    cv::Mat3b image(k_.height, k_.width);
    for (int v = 0; v < k_.height; ++v) {
      for (int u = 0; u < k_.width; ++u) {
        const Eigen::Vector3d rgb = colorAt((u - k_.cx) / k_.fx * kDistance, (v - k_.cy) / k_.fy * kDistance);
        for (int c = 0; c < 3; ++c) image(v, u)[2 - c] = static_cast<std::uint8_t>(std::lround(rgb[c]));
      }
    }
    std::vector<std::uint8_t> png;
    cv::imencode(".png", image, png);
    recorder.addView(recorder.setCamera("camera_0", k_), 0, Eigen::Isometry3d::Identity(), png, "png");
    params_.colorize.method = Method::kClosest;
    params_.record = record;
    recording_.emplace(recorder.snapshot());
    colorize(*recording_, params_, {});
  }

  const Intrinsics k_{640, 480, 400, 400, 319.5, 239.5, DistortionModel::kPlumbBob, {}};
  ScratchDirectory scratch_;
  Params params_;
  std::optional<Recording> recording_;
};

/// The splats of a file.
struct Splats {
  explicit Splats(const std::string& path) {
    CloudReader reader(path);
    cloud = reader.read(reader.numPoints());
    values.resize(14, cloud.positions.cols());
    std::memcpy(values.data(), cloud.records.data(), cloud.records.size());
  }
  Cloud cloud;
  Eigen::MatrixXf values;  ///< nx ny nz f_dc opacity scale rot, a column each
};

/// Elliptical weighted averages (Zwicker et al. 2001), nearest first, over a black background; RGB 0 to 255.
cv::Mat3f render(const Splats& splats, const Intrinsics& k, const Eigen::Isometry3d& camera_from_map) {
  cv::Mat3f image(k.height, k.width, cv::Vec3f(0, 0, 0));
  cv::Mat1f left(k.height, k.width, 1.F);
  const Eigen::Matrix3Xd places = camera_from_map * splats.cloud.positions;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(places.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return places(2, a) < places(2, b); });
  for (const Eigen::Index i : order) {
    const auto v = splats.values.col(i).cast<double>();
    const Eigen::Vector3d at = places.col(i);
    const Eigen::Matrix3d turn =
        camera_from_map.linear() * Eigen::Quaterniond(v[10], v[11], v[12], v[13]).toRotationMatrix();
    const Eigen::Vector3d deviations = v.segment<3>(7).array().exp();
    const Eigen::Matrix3d covariance = turn * deviations.array().square().matrix().asDiagonal() * turn.transpose();
    Eigen::Matrix<double, 2, 3> jacobian;
    jacobian << k.fx / at.z(), 0, -k.fx * at.x() / (at.z() * at.z()), 0, k.fy / at.z(),
        -k.fy * at.y() / (at.z() * at.z());
    const Eigen::Matrix2d spread = jacobian * covariance * jacobian.transpose() + 0.3 * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d inverse = spread.inverse();
    const Eigen::Vector2d middle(k.fx * at.x() / at.z() + k.cx, k.fy * at.y() / at.z() + k.cy);
    const double reach = 3 * std::sqrt(spread.trace()), opacity = 1 / (1 + std::exp(-v[6]));
    for (int y = std::max(0, static_cast<int>(middle.y() - reach)); y <= std::min(k.height - 1.0, middle.y() + reach);
         ++y) {
      for (int x = std::max(0, static_cast<int>(middle.x() - reach)); x <= std::min(k.width - 1.0, middle.x() + reach);
           ++x) {
        const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - middle;
        const double alpha = opacity * std::exp(-0.5 * offset.dot(inverse * offset)) * static_cast<double>(left(y, x));
        for (int c = 0; c < 3; ++c) image(y, x)[c] += static_cast<float>(alpha * 255 * (0.5 + 0.28209479 * v[3 + c]));
        left(y, x) -= static_cast<float>(alpha);
      }
    }
  }
  return image;
}

TEST_F(ExportSplats, LookLikeTheMapFromAnotherPlace) {
  exportSplats(*recording_, params_, scratch_ / "s.ply");
  const Splats splats(scratch_ / "s.ply");
  EXPECT_GT(splats.cloud.positions.cols(), 28000);
  Eigen::Isometry3d camera_from_map = Eigen::Isometry3d::Identity();
  camera_from_map.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  camera_from_map.translation() << -0.8, 0.1, 0.3;
  const cv::Mat3f image = render(splats, k_, camera_from_map);
  const Eigen::Isometry3d map_from_camera = camera_from_map.inverse();
  double sum = 0;
  int count = 0;
  for (int v = 100; v < 380; v += 3) {
    for (int u = 150; u < 480; u += 3) {
      const Eigen::Vector3d ray =
          map_from_camera.linear() * Eigen::Vector3d((u - k_.cx) / k_.fx, (v - k_.cy) / k_.fy, 1);
      const Eigen::Vector3d eye = map_from_camera.translation(), hit = eye + (kDistance - eye.z()) / ray.z() * ray;
      if (std::abs(hit.x()) > 1.8 || std::abs(hit.y()) > 1.3) continue;
      const Eigen::Vector3d expected = colorAt(hit.x(), hit.y());
      for (int c = 0; c < 3; ++c) sum += std::abs(static_cast<double>(image(v, u)[c]) - expected[c]);
      count += 3;
    }
  }
  ASSERT_GT(count, 10000);
  EXPECT_LT(sum / count, 4);  // a hole would be black
}

TEST_F(ExportSplats, AreFlatWideAsThePointsAreApartAndBounded) {
  exportSplats(*recording_, params_, scratch_ / "s.ply", 5000);
  const Splats splats(scratch_ / "s.ply");
  EXPECT_LE(splats.cloud.positions.cols(), 5000);
  EXPECT_GT(splats.cloud.positions.cols(), 4000);
  const std::vector<std::string> names = {"nx",      "ny",      "nz",      "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                                          "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
  ASSERT_EQ(splats.cloud.fields.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(splats.cloud.fields[i].name, names[i]);
  EXPECT_TRUE(splats.values.allFinite());
  for (Eigen::Index i = 0; i < splats.values.cols(); ++i) {
    const Eigen::VectorXf v = splats.values.col(i);
    const Eigen::Vector3f axis = Eigen::Quaternionf(v[10], v[11], v[12], v[13]) * Eigen::Vector3f::UnitZ();
    ASSERT_GT(std::abs(axis.z()), 0.99F);  // the wall's normal
    ASSERT_LT(v[9], v[7] - 2);
  }
}

}  // namespace
}  // namespace cloud_colorizer
