// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Solid shapes with exact rays and exact nearest points: convex prisms, cylinders, spheres.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "simulation/material.hpp"

namespace cloud_colorizer::simulation {

enum class Shape { kPrism, kCylinder, kSphere };

/// How far something that moves is from its place, as a line between knots and beyond them.
struct Motion {
  struct Knot {
    double time;             ///< s, ascending
    Eigen::Vector3d offset;  ///< m
  };
  std::vector<Knot> knots;  ///< at least two

  Eigen::Vector3d at(double time) const;
};

/// A solid in its own frame. Its faces count 0, 1, ...: of a prism the edges of the profile and then the ends at
/// -y and +y; of a cylinder side, lower end, upper end.
struct Primitive {
  Shape shape = Shape::kPrism;
  Eigen::Isometry3d map_from_local = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector2d> profile;  ///< m, prism: convex, counter-clockwise in (x, z)
  double half_length = 0;                ///< m, prism: along y; cylinder: along z
  double radius = 0;                     ///< m, cylinder and sphere
  std::shared_ptr<const Motion> motion;  ///< null for all that stands
  Material material;
  int object = 0;  ///< parts of one car, tree or house share their object
};

/// Where a ray from outside enters a solid, or where the solid is nearest to a point; in the solid's frame.
struct LocalHit {
  double distance = 0;  ///< m; along the ray, or signed (negative inside)
  Eigen::Vector3d point{0, 0, 0}, normal{0, 0, 1};
  int face = 0;
};

/// A primitive made ready: planes of its faces and bounds.
class Solid {
 public:
  /// Throws std::invalid_argument when a size is not positive or the profile is not convex and counter-clockwise.
  explicit Solid(Primitive primitive);

  const Primitive& primitive() const { return primitive_; }
  bool isMoving() const { return primitive_.motion != nullptr; }
  Eigen::Vector3d offsetAt(double time) const {
    return isMoving() ? primitive_.motion->at(time) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  }
  const Eigen::AlignedBox3d& box() const { return box_; }                 ///< m, map, without its motion
  const Eigen::Vector3d& sphereCenter() const { return sphere_center_; }  ///< m, map, without its motion
  double sphereRadius() const { return sphere_radius_; }

  /// First entry at a distance in (0, max_distance) [m] of a ray of the map (unit direction) at `time` [s]. Rays that
  /// start inside do not hit.
  bool intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time, double max_distance,
                 LocalHit& hit) const;

  /// Nearest surface point to a point of the map at `time`.
  LocalHit closest(const Eigen::Vector3d& point, double time) const;

  /// For the material of a face.
  FacePoint facePoint(const LocalHit& hit, float footprint) const;

 private:
  bool intersectPrism(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double max_distance, LocalHit& hit) const;
  bool intersectCylinder(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double max_distance, LocalHit& hit) const;
  bool intersectSphere(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double max_distance, LocalHit& hit) const;
  LocalHit closestOnPrism(const Eigen::Vector3d& p) const;
  LocalHit closestOnCylinder(const Eigen::Vector3d& p) const;

  Primitive primitive_;
  std::vector<Eigen::Vector3d> planes_;  ///< of the profile: normal x, normal z, offset
  Eigen::Matrix3d local_from_map_rotation_;
  Eigen::AlignedBox3d local_box_, box_;
  Eigen::Vector3d sphere_center_;
  double sphere_radius_ = 0;
};

}  // namespace cloud_colorizer::simulation
