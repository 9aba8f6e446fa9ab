// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/appearance.hpp"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "base/stop_watch.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "color/appearance.hpp"
#include "evaluation/random.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;
using Eigen::Vector3f;

constexpr int kViewsOfBall = 24, kLeaveOut = 6;  // every sixth view is left out
constexpr float kGrazing = 0.15F;                // cosine, from which on a view sees a point
constexpr float kSheen = 110, kNoiseOfBall = 2;  // of 255
constexpr float kCellOfBall = 20;                // spacings
constexpr std::uint64_t kSeedOfBall = 7;

struct Ball {
  Points points, normals;
  Eigen::Matrix3Xf diffuse;
  std::vector<std::uint8_t> is_glossy;
  std::vector<Vector3f> eyes;
  Observations observations;
  std::vector<std::uint8_t> left_out;  ///< one an observation
};

Vector3f lightOfBall() {
  return Vector3f(-0.35F, -0.62F, 0.8F).normalized();
}

Vector3f albedoAt(const Vector3f& p) {
  const float t = 110 + 60 * std::sin(9 * p.x() + 2) * std::sin(8 * p.y()) + 25 * std::sin(31 * p.z() + 17 * p.y());
  return {t, 0.8F * t + 15, 0.6F * t + 30};
}

std::vector<Vector3f> eyesOf(bool around) {
  std::vector<Vector3f> eyes;
  for (int i = 0; i < kViewsOfBall; ++i) {
    const float angle = 6.2832F * static_cast<float>(i) / kViewsOfBall,
                along = -5 + 10 * static_cast<float>(i) / (kViewsOfBall - 1);
    const float height = 1 + 1.5F * static_cast<float>(i % 3);
    eyes.push_back(around ? Vector3f(4 * std::cos(angle), 4 * std::sin(angle), height) : Vector3f(along, -3.5F, 1));
  }
  return eyes;
}

float sheenAt(const Vector3f& normal, const Vector3f& to_view, float exponent) {
  const Vector3f h = (to_view + lightOfBall()).normalized();
  return normal.dot(lightOfBall()) > 0 ? kSheen * std::pow(std::max(0.F, normal.dot(h)), exponent) : 0;
}

Ball makeBall(bool around, float exponent, int num_points) {
  Ball ball;
  ball.eyes = eyesOf(around);
  ball.points.resize(3, num_points);
  ball.diffuse.resize(3, num_points);
  std::vector<float> values;
  ball.observations.offsets.push_back(0);
  for (int i = 0; i < num_points; ++i) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(num_points),
                angle = 2.39996F * static_cast<float>(i);
    const Vector3f p(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    ball.points.col(i) = p;
    ball.diffuse.col(i) = albedoAt(p) * (0.45F + 0.45F * std::max(0.F, p.dot(lightOfBall())));
    ball.is_glossy.push_back(p.z() > 0);
    for (std::uint32_t view = 0; view < kViewsOfBall; ++view) {
      const Vector3f to_view = (ball.eyes[view] - p).normalized();
      if (p.dot(to_view) < kGrazing) continue;
      const float sheen = ball.is_glossy.back() != 0 ? sheenAt(p, to_view, exponent) : 0;
      for (int c = 0; c < 3; ++c) {
        values.push_back(ball.diffuse(c, i) + sheen +
                         kNoiseOfBall * static_cast<float>(gaussian(kSeedOfBall, values.size())));
      }
      const bool is_left_out = view % kLeaveOut == kLeaveOut / 2;
      ball.left_out.push_back(is_left_out ? 1 : 0);
      ball.observations.views.push_back(view);
      ball.observations.distances.push_back((ball.eyes[view] - p).norm());
      ball.observations.weights.push_back(is_left_out ? 0 : p.dot(to_view));
    }
    ball.observations.offsets.push_back(static_cast<std::uint32_t>(ball.observations.views.size()));
  }
  ball.normals = ball.points;
  ball.observations.values = Eigen::Map<const Values>(values.data(), 3, static_cast<Index>(values.size() / 3));
  return ball;
}

struct Errors {
  double glossy = 0, matte = 0, diffuse = 0, microseconds = 0;
};

Errors errorsOf(const Ball& ball, Appearance appearance) {
  Observations observations = ball.observations;
  const Sights sights{ball.points, ball.normals, observations, ball.eyes};
  const float spacing = std::sqrt(4 * 3.14159F / static_cast<float>(ball.points.cols()));
  ProcessorWatch watch;
  const Sheen sheen = takeOutSheen(sights, appearance, kCellOfBall * spacing, observations);
  Errors errors;
  errors.microseconds = 1e6 * watch.lap() / static_cast<double>(ball.points.cols());
  ZOrderGrid grid;
  grid.origin = Vector3f::Constant(-2);
  grid.cell = 1e-3F;
  const Fused fused = colorPoints(ball.points, observations, grid, Method::kDefault, {}, {});
  std::array<double, 2> sums{}, counts{};
  double num_diffuse = 0;
  for (Index p = 0; p < ball.points.cols(); ++p) {
    const std::uint32_t first = sights.begin(p), last = sights.end(p);
    std::uint32_t used = 0;
    for (std::uint32_t k = first; k < last; ++k) used += ball.left_out[k] != 0 ? 0 : 1;
    if (used < 3) continue;
    const auto glossy = static_cast<std::size_t>(ball.is_glossy[static_cast<std::size_t>(p)]);
    for (std::uint32_t k = first; k < last; ++k) {
      if (ball.left_out[k] == 0) continue;
      sums.at(glossy) += static_cast<double>((observations.values.col(k) - fused.values.col(p)).cwiseAbs().mean());
      counts.at(glossy) += 1;
    }
    if (glossy == 0) continue;
    const Vector3f diffuse = fused.values.col(p) + sheen.least.col(p);
    errors.diffuse += static_cast<double>((diffuse - ball.diffuse.col(p)).cwiseAbs().mean());
    num_diffuse += 1;
  }
  errors.matte = sums[0] / counts[0];
  errors.glossy = sums[1] / counts[1];
  errors.diffuse /= num_diffuse;
  return errors;
}

}  // namespace

ResultTable makeAppearanceTable(int num_points) {
  ResultTable table{{"views", "exponent", "appearance", "glossy", "matte", "diffuse", "us_per_point"}, {}};
  for (const bool around : {true, false}) {
    for (const float exponent : {8.F, 40.F, 200.F}) {
      const Ball ball = makeBall(around, exponent, num_points);
      for (const auto& [appearance, name] : {std::pair<Appearance, const char*>{Appearance::kNone, "none"},
                                             {Appearance::kSh1, "sh1"},
                                             {Appearance::kSh2, "sh2"}}) {
        const Errors errors = errorsOf(ball, appearance);
        table.add({around ? "around" : "drive-by", formatNumber(static_cast<double>(exponent), 0), name,
                   formatNumber(errors.glossy, 2), formatNumber(errors.matte, 2), formatNumber(errors.diffuse, 2),
                   formatNumber(errors.microseconds, 2)});
      }
    }
  }
  return table;
}

}  // namespace cloud_colorizer
