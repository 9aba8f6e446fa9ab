// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The rasteriser of the test bed: a depth buffer of face indices at twice the resolution, shaded afterwards.
#include <algorithm>
#include <cmath>
#include <limits>

#include "evaluation/test_bed.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kSupersampling = 2;

/// Corners of every face in sample coordinates; z is the inverse depth, which is linear in the image.
struct Projected {
  Points corners;  ///< (x, y, 1 / depth) of the vertices
};

Projected projectVertices(const Mesh& mesh, const Intrinsics& k, const Eigen::Isometry3d& map_from_camera) {
  const Eigen::Isometry3f camera_from_map = map_from_camera.inverse().cast<float>();
  Projected projected{Points(3, mesh.vertices.cols())};
  const auto scale = static_cast<float>(kSupersampling);
  const auto fx = static_cast<float>(k.fx), fy = static_cast<float>(k.fy);
  const auto cx = static_cast<float>(k.cx), cy = static_cast<float>(k.cy);
  for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v) {
    const Eigen::Vector3f p = camera_from_map * mesh.vertices.col(v);
    const float inverse = p.z() > 1e-3F ? 1 / p.z() : -1;
    // A pixel spans [-0.5, 0.5); sample s of it has its centre at (s + 0.5) / scale - 0.5.
    projected.corners.col(v) << (fx * p.x() * inverse + cx + 0.5F) * scale - 0.5F,
        (fy * p.y() * inverse + cy + 0.5F) * scale - 0.5F, inverse;
  }
  return projected;
}

float cross2(const Eigen::Vector3f& a, const Eigen::Vector3f& b, float x, float y) {
  return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
}

/// Barycentric coordinates in the image of sample (x, y); `area` is twice the signed area.
Eigen::Vector3f barycentric(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c, float area,
                            float x, float y) {
  return Eigen::Vector3f(cross2(b, c, x, y), cross2(c, a, x, y), cross2(a, b, x, y)) / area;
}

void rasterizeFace(const Points& corners, const Eigen::Vector3i& face, int index, cv::Mat1f& inverse_depth,
                   cv::Mat1i& faces) {
  const Eigen::Vector3f a = corners.col(face[0]), b = corners.col(face[1]), c = corners.col(face[2]);
  if (a.z() <= 0 || b.z() <= 0 || c.z() <= 0) return;
  const float area = cross2(a, b, c.x(), c.y());
  if (!(std::abs(area) > 1e-12F)) return;
  const Eigen::Vector3f low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const int x0 = std::max(0, static_cast<int>(std::ceil(low.x())));
  const int x1 = std::min(faces.cols - 1, static_cast<int>(std::floor(high.x())));
  const int y0 = std::max(0, static_cast<int>(std::ceil(low.y())));
  const int y1 = std::min(faces.rows - 1, static_cast<int>(std::floor(high.y())));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector3f weights = barycentric(a, b, c, area, static_cast<float>(x), static_cast<float>(y));
      if (weights.minCoeff() < -1e-6F) continue;
      const float inverse = weights.dot(Eigen::Vector3f(a.z(), b.z(), c.z()));
      if (inverse <= inverse_depth(y, x)) continue;
      inverse_depth(y, x) = inverse;
      faces(y, x) = index;
    }
  }
}

Eigen::Vector3f shadeSample(const Mesh& mesh, const Points& corners, int index, int x, int y, float frequency) {
  const Eigen::Vector3i face = mesh.faces.col(index);
  const Eigen::Vector3f a = corners.col(face[0]), b = corners.col(face[1]), c = corners.col(face[2]);
  Eigen::Vector3f weights =
      barycentric(a, b, c, cross2(a, b, c.x(), c.y()), static_cast<float>(x), static_cast<float>(y));
  weights = weights.cwiseProduct(Eigen::Vector3f(a.z(), b.z(), c.z()));
  weights /= weights.sum();
  Eigen::Vector3f point = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    point += weights[corner] * mesh.vertices.col(face[corner]);
    normal += weights[corner] * mesh.normals.col(face[corner]);
  }
  return shadedColor(point, normal.stableNormalized(), frequency);
}

}  // namespace

cv::Mat renderMesh(const Mesh& mesh, const Intrinsics& intrinsics, const Eigen::Isometry3d& map_from_camera,
                   float texture_frequency) {
  const cv::Size samples(intrinsics.width * kSupersampling, intrinsics.height * kSupersampling);
  const Points corners = projectVertices(mesh, intrinsics, map_from_camera).corners;
  cv::Mat1f inverse_depth(samples, 0.F);
  cv::Mat1i faces(samples, -1);
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    rasterizeFace(corners, mesh.faces.col(f), static_cast<int>(f), inverse_depth, faces);
  }
  cv::Mat3b image(intrinsics.height, intrinsics.width, cv::Vec3b(0, 0, 0));
  constexpr float kShare = 1.F / (kSupersampling * kSupersampling);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int s = 0; s < kSupersampling * kSupersampling; ++s) {
        const int sx = x * kSupersampling + s % kSupersampling, sy = y * kSupersampling + s / kSupersampling;
        const int face = faces(sy, sx);
        if (face >= 0) sum += shadeSample(mesh, corners, face, sx, sy, texture_frequency);
      }
      for (int c = 0; c < 3; ++c) image(y, x)[c] = cv::saturate_cast<std::uint8_t>(sum[c] * kShare);
    }
  }
  return image;
}

}  // namespace cloud_colorizer
