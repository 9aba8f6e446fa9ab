// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/model_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "base/robust.hpp"
#include "cloud_colorizer/camera/camera.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Vectors = std::vector<Vector3d>;

constexpr std::size_t kMostViews = 200;  // of a long drive, some images
constexpr double kMuchMore = 1.3;        // of the cloud is seen with other rotations
constexpr std::size_t kFewest = 20;      // values that a statistic is made of
constexpr double kFarShare = 0.02;       // of the image's width: no reprojection error is that large
constexpr double kFarSpacings = 5;       // of the samples of the cloud: no point of a model is so far from a surface

/// Of every camera; none of a panorama.
std::vector<std::optional<Camera>> camerasOf(const ColmapModel& model) {
  std::vector<std::optional<Camera>> cameras(model.cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (!isPanorama(model.cameras[i])) cameras[i].emplace(model.cameras[i]);
  }
  return cameras;
}

/// How often the samples lie in an image, whatever hides them, with the poses changed by `change`.
template <class Change>
double countSeen(const ColmapModel& model, const Vectors& samples, const Change& change) {
  const auto cameras = camerasOf(model);
  const std::size_t stride = std::max<std::size_t>(1, model.images.size() / kMostViews);
  std::size_t count = 0;
  for (std::size_t i = 0; i < model.images.size(); i += stride) {
    const Isometry3d camera_from_map = change(model.images[i].map_from_camera.inverse());
    const std::optional<Camera>& camera = cameras[model.images[i].camera];
    for (const Vector3d& sample : samples) {
      if (!camera || camera->project((camera_from_map * sample).cast<float>())) ++count;
    }
  }
  return static_cast<double>(count);
}

/// Some converters write x y z w where COLMAP has w x y z, or the camera's pose in the map instead of its inverse. Then
/// the images look past the cloud.
std::string doubtOfRotations(const ColmapModel& model, const Vectors& samples) {
  const double seen = countSeen(model, samples, [](const Isometry3d& pose) { return pose; });
  const double reordered = countSeen(model, samples, [](const Isometry3d& pose) {
    const Eigen::Quaterniond q(pose.linear());
    Isometry3d result = pose;  // what was read as w x y z was x y z w
    result.linear() = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
    return result;
  });
  const double inverted = countSeen(model, samples, [](const Isometry3d& pose) { return pose.inverse(); });
  const double best = std::max(reordered, inverted);
  if (seen == 0 && best == 0) {
    return "no image looks at the cloud: do the model and the cloud belong together, in one frame and scale?";
  }
  if (seen * kMuchMore >= best) return {};
  std::ostringstream text;
  text << "the images would see " << best / std::max(seen, 1.0) << " times as much of the cloud if the poses in "
       << model.directory
       << (reordered > inverted ? " were x y z w: COLMAP's quaternions are w x y z"
                                : " were inverted: COLMAP's poses are camera from map")
       << "; look at the program that wrote them";
  return text.str();
}

double nearestOf(const Vector3d& point, const Vectors& samples) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector3d& sample : samples) {
    const double squared = (sample - point).squaredNorm();
    if (squared > 0) nearest = std::min(nearest, squared);
  }
  return std::sqrt(nearest);
}

/// A quarter of the model's points at least lies on the cloud where they belong together; the others may be farther
/// than the scanner reached.
std::string doubtOfPlace(const ColmapModel& model, const Vectors& samples) {
  if (model.points.size() < kFewest || samples.size() < kFewest) return {};
  std::vector<double> spacings, distances;
  for (const Vector3d& sample : samples) spacings.push_back(nearestOf(sample, samples));
  for (const ColmapPoint& point : model.points) distances.push_back(nearestOf(point.position, samples));
  const double spacing = median(spacings);
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 4),
                   distances.end());
  const double quarter = distances[distances.size() / 4];
  if (quarter <= kFarSpacings * spacing) return {};
  std::ostringstream text;
  text.precision(3);
  text << "three quarters of the 3D points in " << model.directory << " are farther than " << quarter
       << " from the cloud, whose samples are " << spacing
       << " apart: do they belong together, in one frame and scale? Align the model to the cloud, with model_aligner "
          "say";
  return text.str();
}

std::string doubtOfPoints(const ColmapModel& model) {
  if (!model.points_error.empty())
    return model.points_error + "; whether the model belongs to the cloud is not checked";
  const auto cameras = camerasOf(model);
  std::vector<double> errors;
  for (const ColmapPoint& point : model.points) {
    for (const ColmapPoint::Sight& sight : point.sights) {
      const ColmapImage& image = model.images[sight.image];
      const std::optional<Camera>& camera = cameras[image.camera];
      if (!camera) continue;
      const auto pixel = camera->projectUnbounded((image.map_from_camera.inverse() * point.position).cast<float>());
      const double width = camera->intrinsics().width;
      errors.push_back(pixel ? (pixel->cast<double>() - sight.pixel).norm() / width : 1);
    }
  }
  if (errors.size() < kFewest) return {};
  const double error = median(errors);
  if (error <= kFarShare) return {};
  std::ostringstream text;
  text.precision(3);
  text << "the 3D points in " << model.directory << " appear " << 100 * error
       << " % of the image's width beside the places where its images saw them: its files do not belong together; one "
       << "of cameras, images and points3D is of another reconstruction, or was changed";
  return text.str();
}

}  // namespace

std::vector<std::string> doubtsAbout(const ColmapModel& model, const Vectors& samples) {
  std::vector<std::string> doubts;
  for (std::string doubt : {doubtOfRotations(model, samples), doubtOfPoints(model), doubtOfPlace(model, samples)}) {
    if (!doubt.empty()) doubts.push_back(std::move(doubt));
  }
  return doubts;
}

}  // namespace cloud_colorizer
