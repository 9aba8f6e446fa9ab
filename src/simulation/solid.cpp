// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/solid.hpp"

#include <algorithm>
#include <cmath>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer::simulation {
namespace {

Eigen::Vector2d flat(const Eigen::Vector3d& p) {
  return {p.x(), p.z()};
}

/// The interval of a ray inside a convex solid, cut by one half-space after the other.
struct Interval {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  int face = -1;

  /// Half-space `height + t * slope <= 0`.
  void cut(double height, double slope, int with_face) {
    if (slope < 0) {
      const double t = -height / slope;
      if (t > enter) {
        enter = t;
        face = with_face;
      }
    } else if (slope > 0) {
      leave = std::min(leave, -height / slope);
    } else if (height > 0) {
      leave = -std::numeric_limits<double>::infinity();
    }
  }

  bool entersWithin(double max_distance) const {
    return face >= 0 && enter > 0 && enter < max_distance && enter < leave;
  }
};

Eigen::AlignedBox3d boxOf(const Primitive& p) {
  Eigen::AlignedBox3d box;
  if (p.shape == Shape::kPrism) {
    for (const auto& corner : p.profile) {
      box.extend(Eigen::Vector3d(corner.x(), -p.half_length, corner.y()));
      box.extend(Eigen::Vector3d(corner.x(), p.half_length, corner.y()));
    }
    return box;
  }
  const double half_height = p.shape == Shape::kCylinder ? p.half_length : p.radius;
  const Eigen::Vector3d half(p.radius, p.radius, half_height);
  return {-half, half};
}

void checkPrimitive(const Primitive& p) {
  require<std::invalid_argument>(p.shape == Shape::kPrism || p.radius > 0, "radius of a solid = ", p.radius,
                                 " must be positive");
  require<std::invalid_argument>(p.shape == Shape::kSphere || p.half_length > 0,
                                 "half length of a solid = ", p.half_length, " must be positive");
  if (p.shape != Shape::kPrism) return;
  const std::size_t n = p.profile.size();
  require<std::invalid_argument>(n >= 3, "profile of a prism has ", n, " corners, needs 3");
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d a = p.profile[(i + 1) % n] - p.profile[i];
    const Eigen::Vector2d b = p.profile[(i + 2) % n] - p.profile[(i + 1) % n];
    require<std::invalid_argument>(a.x() * b.y() - a.y() * b.x() > 0, "profile of a prism is not convex and ",
                                   "counter-clockwise at corner ", (i + 1) % n);
  }
}

}  // namespace

Solid::Solid(Primitive primitive) : primitive_(std::move(primitive)) {
  checkPrimitive(primitive_);
  const std::size_t n = primitive_.profile.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d edge = primitive_.profile[(i + 1) % n] - primitive_.profile[i];
    const Eigen::Vector2d normal = Eigen::Vector2d(edge.y(), -edge.x()).normalized();
    planes_.emplace_back(normal.x(), normal.y(), -normal.dot(primitive_.profile[i]));
  }
  local_from_map_rotation_ = primitive_.map_from_local.linear().transpose();
  local_box_ = boxOf(primitive_);
  for (int corner = 0; corner < 8; ++corner) {
    box_.extend(primitive_.map_from_local * local_box_.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  sphere_center_ = primitive_.map_from_local * local_box_.center();
  sphere_radius_ = primitive_.shape == Shape::kSphere ? primitive_.radius : local_box_.diagonal().norm() / 2;
}

Eigen::Vector3d Motion::at(double time) const {
  const auto after =
      std::find_if(knots.begin() + 1, knots.end() - 1, [&](const Knot& knot) { return time < knot.time; });
  const Knot &a = *(after - 1), &b = *after;
  return a.offset + (time - a.time) / (b.time - a.time) * (b.offset - a.offset);
}

bool Solid::intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time, double max_distance,
                      LocalHit& hit) const {
  const Eigen::Vector3d offset = origin - primitive_.map_from_local.translation() - offsetAt(time);
  const Eigen::Vector3d o = local_from_map_rotation_ * offset;
  const Eigen::Vector3d d = local_from_map_rotation_ * direction;
  switch (primitive_.shape) {
    case Shape::kPrism:
      return intersectPrism(o, d, max_distance, hit);
    case Shape::kCylinder:
      return intersectCylinder(o, d, max_distance, hit);
    case Shape::kSphere:
      return intersectSphere(o, d, max_distance, hit);
  }
  return false;
}

bool Solid::intersectPrism(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double max_distance,
                           LocalHit& hit) const {
  Interval interval;
  const int n = static_cast<int>(planes_.size());
  interval.cut(-o.y() - primitive_.half_length, -d.y(), n);
  interval.cut(o.y() - primitive_.half_length, d.y(), n + 1);
  for (int i = 0; i < n && interval.enter < interval.leave; ++i) {
    const Eigen::Vector3d& plane = planes_[static_cast<std::size_t>(i)];
    interval.cut(plane.x() * o.x() + plane.y() * o.z() + plane.z(), plane.x() * d.x() + plane.y() * d.z(), i);
  }
  if (!interval.entersWithin(max_distance)) return false;
  Eigen::Vector3d normal(0, interval.face == n ? -1 : 1, 0);
  if (interval.face < n) {
    const Eigen::Vector3d& plane = planes_[static_cast<std::size_t>(interval.face)];
    normal = {plane.x(), 0, plane.y()};
  }
  hit = {interval.enter, o + interval.enter * d, normal, interval.face};
  return true;
}

bool Solid::intersectCylinder(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double max_distance,
                              LocalHit& hit) const {
  Interval interval;
  interval.cut(-o.z() - primitive_.half_length, -d.z(), 1);
  interval.cut(o.z() - primitive_.half_length, d.z(), 2);
  const double a = d.x() * d.x() + d.y() * d.y();
  const double c = o.x() * o.x() + o.y() * o.y() - primitive_.radius * primitive_.radius;
  if (a > 1e-18) {
    const double b = o.x() * d.x() + o.y() * d.y();
    const double discriminant = b * b - a * c;
    if (discriminant <= 0) return false;
    const double root = std::sqrt(discriminant);
    if ((-b - root) / a > interval.enter) {
      interval.enter = (-b - root) / a;
      interval.face = 0;
    }
    interval.leave = std::min(interval.leave, (-b + root) / a);
  } else if (c > 0) {
    return false;
  }
  if (!interval.entersWithin(max_distance)) return false;
  const Eigen::Vector3d point = o + interval.enter * d;
  const Eigen::Vector3d normal = interval.face == 0 ? Eigen::Vector3d(point.x(), point.y(), 0).normalized()
                                                    : Eigen::Vector3d(0, 0, interval.face == 1 ? -1 : 1);
  hit = {interval.enter, point, normal, interval.face};
  return true;
}

bool Solid::intersectSphere(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double max_distance,
                            LocalHit& hit) const {
  const double b = o.dot(d);
  const double c = o.squaredNorm() - primitive_.radius * primitive_.radius;
  const double discriminant = b * b - c;
  if (discriminant <= 0 || c <= 0) return false;
  const double t = -b - std::sqrt(discriminant);
  if (t <= 0 || t >= max_distance) return false;
  const Eigen::Vector3d point = o + t * d;
  hit = {t, point, point.normalized(), 0};
  return true;
}

LocalHit Solid::closest(const Eigen::Vector3d& point, double time) const {
  const Eigen::Vector3d offset = point - primitive_.map_from_local.translation() - offsetAt(time);
  const Eigen::Vector3d p = local_from_map_rotation_ * offset;
  if (primitive_.shape == Shape::kPrism) return closestOnPrism(p);
  if (primitive_.shape == Shape::kCylinder) return closestOnCylinder(p);
  const Eigen::Vector3d normal = p.norm() > 0 ? p.normalized() : Eigen::Vector3d::UnitZ();
  return {p.norm() - primitive_.radius, primitive_.radius * normal, normal, 0};
}

LocalHit Solid::closestOnPrism(const Eigen::Vector3d& p) const {
  const std::size_t n = planes_.size();
  const double half = primitive_.half_length;
  // The nearest place of the profile's outline, and how far outside of it the point lies.
  double outside = -std::numeric_limits<double>::infinity();
  double best = std::numeric_limits<double>::infinity();
  Eigen::Vector2d on_outline(0, 0);
  int edge = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d a = primitive_.profile[i];
    const Eigen::Vector2d ab = primitive_.profile[(i + 1) % n] - a;
    const double t = std::min(1.0, std::max(0.0, ab.dot(flat(p) - a) / ab.squaredNorm()));
    const double distance = (a + t * ab - flat(p)).norm();
    if (distance < best) {
      best = distance;
      on_outline = a + t * ab;
      edge = static_cast<int>(i);
    }
    outside = std::max(outside, planes_[i].x() * p.x() + planes_[i].y() * p.z() + planes_[i].z());
  }
  const double beyond_end = std::abs(p.y()) - half;
  const bool use_end = beyond_end > (outside > 0 ? best : outside);
  const bool is_inside = outside <= 0 && beyond_end <= 0;
  const Eigen::Vector2d xz = outside > 0 || (is_inside && !use_end) ? on_outline : flat(p);
  const double y =
      is_inside && !use_end ? p.y() : (use_end ? std::copysign(half, p.y()) : std::clamp(p.y(), -half, half));
  const Eigen::Vector3d point(xz.x(), y, xz.y());
  const Eigen::Vector3d& plane = planes_[static_cast<std::size_t>(edge)];
  const Eigen::Vector3d normal =
      use_end ? Eigen::Vector3d(0, std::copysign(1, p.y()), 0) : Eigen::Vector3d(plane.x(), 0, plane.y());
  return {(is_inside ? -1 : 1) * (point - p).norm(), point, normal,
          use_end ? static_cast<int>(n) + (p.y() > 0 ? 1 : 0) : edge};
}

LocalHit Solid::closestOnCylinder(const Eigen::Vector3d& p) const {
  const double from_axis = std::hypot(p.x(), p.y());
  const Eigen::Vector3d radial =
      from_axis > 0 ? Eigen::Vector3d(p.x() / from_axis, p.y() / from_axis, 0) : Eigen::Vector3d::UnitX();
  const double outside = from_axis - primitive_.radius;
  const double beyond_end = std::abs(p.z()) - primitive_.half_length;
  const bool use_end = beyond_end > outside;
  const bool is_inside = outside <= 0 && beyond_end <= 0;
  const double rho = outside > 0 || (is_inside && !use_end) ? primitive_.radius : from_axis;
  const double z = beyond_end > 0 || (is_inside && use_end) ? std::copysign(primitive_.half_length, p.z()) : p.z();
  const Eigen::Vector3d point = rho * radial + Eigen::Vector3d(0, 0, z);
  const Eigen::Vector3d normal = use_end ? Eigen::Vector3d(0, 0, std::copysign(1, p.z())) : radial;
  return {(is_inside ? -1 : 1) * (point - p).norm(), point, normal, !use_end ? 0 : (p.z() > 0 ? 2 : 1)};
}

FacePoint Solid::facePoint(const LocalHit& hit, float footprint) const {
  FacePoint face;
  face.local = hit.point.cast<float>();
  face.normal = hit.normal.cast<float>();
  face.footprint = footprint;
  const Eigen::Vector3f low = local_box_.min().cast<float>();
  const Eigen::Vector3f high = local_box_.max().cast<float>();
  const Eigen::Vector3f size = high - low;
  const Eigen::Vector3f& p = face.local;
  const Eigen::Vector3f& n = face.normal;
  if (std::abs(n.z()) > std::max(std::abs(n.x()), std::abs(n.y()))) {
    face.u = p.x() - low.x(), face.v = p.y() - low.y(), face.width = size.x(), face.height = size.y();
  } else if (std::abs(n.y()) >= std::abs(n.x())) {
    face.u = n.y() < 0 ? p.x() - low.x() : high.x() - p.x();
    face.v = p.z() - low.z(), face.width = size.x(), face.height = size.z();
  } else {
    face.u = n.x() > 0 ? p.y() - low.y() : high.y() - p.y();
    face.v = p.z() - low.z(), face.width = size.y(), face.height = size.z();
  }
  return face;
}

}  // namespace cloud_colorizer::simulation
