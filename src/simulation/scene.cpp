// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"
#include "simulation/random.hpp"

namespace cloud_colorizer::simulation {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kStackSize = 64;

/// Distance at which a ray enters a box; infinity when it misses or enters beyond `limit`.
double enterBox(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse,
                double limit) {
  double enter = 0;
  double leave = limit;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min()[axis] - origin[axis]) * inverse[axis];
    const double b = (box.max()[axis] - origin[axis]) * inverse[axis];
    enter = std::max(enter, std::min(a, b));  // min and max ignore the NaN of 0 * infinity in this order
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : kFar;
}

}  // namespace

Scene::Scene(std::vector<Primitive> primitives, const Lighting& lighting, int num_threads) : lighting_(lighting) {
  solids_.reserve(primitives.size());
  for (auto& primitive : primitives) solids_.emplace_back(std::move(primitive));
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    (solids_[i].isMoving() ? movers_ : order_).push_back(static_cast<int>(i));
  }
  if (!order_.empty()) build(0, static_cast<int>(order_.size()));
  if (lighting_.shadow_cell > 0 && !order_.empty()) buildShadows(num_threads);
}

int Scene::build(int first, int count) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box;
  Eigen::AlignedBox3d centers;
  for (int i = first; i < first + count; ++i) {
    const auto& solid = solids_[static_cast<std::size_t>(order_[static_cast<std::size_t>(i)])];
    box.extend(solid.box());
    centers.extend(solid.box().center());
  }
  // Slightly wider, so that rays along a face are not lost to rounding.
  box.min().array() -= 1e-6;
  box.max().array() += 1e-6;
  nodes_[static_cast<std::size_t>(index)].box = box;
  if (count <= 2) {
    nodes_[static_cast<std::size_t>(index)].first = first;
    nodes_[static_cast<std::size_t>(index)].count = count;
    return index;
  }
  int axis = 0;
  centers.sizes().maxCoeff(&axis);
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](int a, int b) {
    const double ca = solids_[static_cast<std::size_t>(a)].box().center()[axis];
    const double cb = solids_[static_cast<std::size_t>(b)].box().center()[axis];
    return ca < cb || (ca == cb && a < b);
  });
  build(first, count / 2);
  const int second = build(first + count / 2, count - count / 2);
  nodes_[static_cast<std::size_t>(index)].first = second;
  return index;
}

Hit Scene::completeHit(int solid, const LocalHit& local, double time) const {
  const Solid& of = solids_[static_cast<std::size_t>(solid)];
  const Primitive& primitive = of.primitive();
  Hit hit;
  hit.distance = std::abs(local.distance);
  hit.point = primitive.map_from_local * local.point + of.offsetAt(time);
  hit.normal = primitive.map_from_local.linear() * local.normal;
  hit.solid = solid;
  hit.object = primitive.object;
  hit.local = local;
  return hit;
}

std::optional<Hit> Scene::castRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
                                  double max_distance) const {
  LocalHit best;
  LocalHit hit;
  int best_solid = -1;
  double limit = max_distance;
  const auto test = [&](int index) {
    if (!solids_[static_cast<std::size_t>(index)].intersect(origin, direction, time, limit, hit)) return;
    limit = hit.distance;
    best = hit;
    best_solid = index;
  };
  if (time != kNothingMoves) {
    for (const int mover : movers_) test(mover);
  }
  const Eigen::Vector3d inverse = direction.cwiseInverse();
  std::array<std::pair<int, double>, kStackSize> stack;
  std::size_t size = 0;
  if (!nodes_.empty()) stack[size++] = {0, enterBox(nodes_[0].box, origin, inverse, limit)};
  while (size > 0) {
    const auto [index, enter] = stack[--size];
    if (enter >= limit) continue;
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    for (int i = 0; i < node.count; ++i) test(order_[static_cast<std::size_t>(node.first + i)]);
    if (node.count > 0) continue;
    std::pair<int, double> near{index + 1,
                                enterBox(nodes_[static_cast<std::size_t>(index + 1)].box, origin, inverse, limit)};
    std::pair<int, double> far{node.first,
                               enterBox(nodes_[static_cast<std::size_t>(node.first)].box, origin, inverse, limit)};
    if (far.second < near.second) std::swap(near, far);
    if (far.second < limit) stack[size++] = far;
    if (near.second < limit) stack[size++] = near;
  }
  if (best_solid < 0) return std::nullopt;
  return completeHit(best_solid, best, time);
}

template <class Enters, class Test>
bool Scene::anySolid(const Enters& enters, const Test& test) const {
  std::array<int, kStackSize> stack;
  std::size_t size = 0;
  if (!nodes_.empty()) stack[size++] = 0;
  while (size > 0) {
    const int index = stack[--size];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (!enters(node.box)) continue;
    for (int i = 0; i < node.count; ++i) {
      if (test(order_[static_cast<std::size_t>(node.first + i)])) return true;
    }
    if (node.count > 0) continue;
    stack[size++] = node.first;
    stack[size++] = index + 1;
  }
  return false;
}

bool Scene::isBlocked(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double time) const {
  const Eigen::Vector3d way = to - from;
  const double distance = way.norm();
  if (distance <= 0) return false;
  const Eigen::Vector3d direction = way / distance;
  const Eigen::Vector3d inverse = direction.cwiseInverse();
  LocalHit hit;
  const auto blocks = [&](int index) {
    return solids_[static_cast<std::size_t>(index)].intersect(from, direction, time, distance, hit);
  };
  const auto enters = [&](const Eigen::AlignedBox3d& box) { return enterBox(box, from, inverse, distance) != kFar; };
  return std::any_of(movers_.begin(), movers_.end(), blocks) || anySolid(enters, blocks);
}

int Scene::buriedIn(const Eigen::Vector3d& point, int except) const {
  constexpr double kDepth = 1e-3;  // m; solids that only touch do not bury each other's faces
  int around = -1;
  anySolid([&](const Eigen::AlignedBox3d& box) { return box.contains(point); },
           [&](int solid) {
             if (solid == except || solids_[static_cast<std::size_t>(solid)].closest(point, 0).distance >= -kDepth) {
               return false;
             }
             around = solid;
             return true;
           });
  return around;
}

std::optional<Hit> Scene::surfaceNear(const Eigen::Vector3d& point, int solid, LocalHit local) const {
  // From a buried place on to the nearest face of the solid around it, and so on: this ends in the crease of the two.
  constexpr int kMaxSteps = 30;
  for (int step = 0; step < kMaxSteps; ++step) {
    Hit hit = completeHit(solid, local, 0);
    const int around = buriedIn(hit.point, solid);
    if (around < 0) {
      hit.distance = (hit.point - point).norm();
      return hit;
    }
    solid = around;
    local = solids_[static_cast<std::size_t>(solid)].closest(hit.point, 0);
  }
  return std::nullopt;
}

std::optional<Hit> Scene::closestPoint(const Eigen::Vector3d& point, double max_distance) const {
  std::vector<std::pair<int, LocalHit>> found;
  anySolid(
      [&](const Eigen::AlignedBox3d& box) { return box.squaredExteriorDistance(point) <= max_distance * max_distance; },
      [&](int solid) {
        const LocalHit hit = solids_[static_cast<std::size_t>(solid)].closest(point, 0);
        if (std::abs(hit.distance) <= max_distance) found.emplace_back(solid, hit);
        return false;
      });
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    const double da = std::abs(a.second.distance);
    const double db = std::abs(b.second.distance);
    return da < db || (da == db && a.first < b.first);
  });
  std::optional<Hit> best;
  double limit = max_distance;
  for (const auto& [solid, local] : found) {
    if (std::abs(local.distance) > limit) break;
    const auto hit = surfaceNear(point, solid, local);
    if (!hit || hit->distance > limit) continue;
    best = hit;
    limit = std::nextafter(hit->distance, 0.0);
  }
  return best;
}

void Scene::buildShadows(int num_threads) {
  constexpr double kMaxCells = 48e6;
  const Eigen::Vector3d z = lighting_.to_sun;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX().cross(z).cross(z).normalized();
  shadows_.sun_from_map.row(0) = x;
  shadows_.sun_from_map.row(1) = z.cross(x);
  shadows_.sun_from_map.row(2) = z;
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    box.extend(shadows_.sun_from_map * nodes_[0].box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
  }
  const Eigen::Vector3d size = box.sizes();
  shadows_.cell = std::max(lighting_.shadow_cell, std::sqrt(size.x() * size.y() / kMaxCells));
  shadows_.corner = box.min().head<2>();
  shadows_.width = static_cast<int>(size.x() / shadows_.cell) + 2;
  shadows_.height = static_cast<int>(size.y() / shadows_.cell) + 2;
  shadows_.highest.assign(static_cast<std::size_t>(shadows_.width) * static_cast<std::size_t>(shadows_.height), 0);
  const double top = box.max().z() + 1;
  parallelFor(num_threads, static_cast<std::size_t>(shadows_.height), [&](std::size_t row) {
    for (int column = 0; column < shadows_.width; ++column) {
      const Eigen::Vector3d start(shadows_.corner.x() + column * shadows_.cell,
                                  shadows_.corner.y() + static_cast<double>(row) * shadows_.cell, top);
      const auto hit = castRay(shadows_.sun_from_map.transpose() * start, -lighting_.to_sun, kNothingMoves);
      const double highest = hit ? top - hit->distance : box.min().z();
      shadows_.highest[row * static_cast<std::size_t>(shadows_.width) + static_cast<std::size_t>(column)] =
          static_cast<float>(highest);
    }
  });
}

float Scene::sunlit(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  if (shadows_.highest.empty()) return 1;
  const double cosine = std::max(0.1, normal.dot(lighting_.to_sun));
  const double slope = std::sqrt(1 - std::min(1.0, cosine * cosine)) / cosine;
  const Eigen::Vector3d p = shadows_.sun_from_map * (point + 0.02 * normal);
  const double bias = 0.03 + 1.5 * shadows_.cell * std::min(slope, 8.0);
  const double column = (p.x() - shadows_.corner.x()) / shadows_.cell;
  const double row = (p.y() - shadows_.corner.y()) / shadows_.cell;
  const int i = static_cast<int>(std::floor(column));
  const int j = static_cast<int>(std::floor(row));
  if (i < 1 || j < 1 || i + 2 >= shadows_.width || j + 2 >= shadows_.height) return 1;
  // A box of 3 x 3 cells around the point, so that shadows have soft edges and no steps.
  const double a = column - i;
  const double b = row - j;
  const std::array<double, 4> weights_x = {1 - a, 1, 1, a};
  const std::array<double, 4> weights_y = {1 - b, 1, 1, b};
  double lit = 0;
  for (int y = 0; y < 4; ++y) {
    const float* cells =
        &shadows_.highest[static_cast<std::size_t>(j - 1 + y) * static_cast<std::size_t>(shadows_.width) +
                          static_cast<std::size_t>(i - 1)];
    for (int x = 0; x < 4; ++x) {
      const bool is_lit = p.z() + bias >= static_cast<double>(cells[x]);
      if (is_lit) lit += weights_x[static_cast<std::size_t>(x)] * weights_y[static_cast<std::size_t>(y)];
    }
  }
  return static_cast<float>(lit / 9);
}

Color Scene::trueColor(const Hit& hit, float footprint) const {
  const Solid& solid = solids_[static_cast<std::size_t>(hit.solid)];
  const Color base = albedo(solid.primitive().material, solid.facePoint(hit.local, footprint));
  const auto cosine = static_cast<float>(hit.normal.dot(lighting_.to_sun));
  // The sky is above: faces that look down get half of its light.
  Color light = lighting_.sky * (0.86F + 0.14F * static_cast<float>(hit.normal.z()));
  if (cosine > 0) light += lighting_.sun * (cosine * (solid.isMoving() ? 1.F : sunlit(hit.point, hit.normal)));
  return (base * light).min(255.F).max(0.F);
}

float Scene::sheen(const Hit& hit, const Eigen::Vector3d& direction) const {
  constexpr double kStrength = 110;
  const Solid& solid = solids_[static_cast<std::size_t>(hit.solid)];
  const Pattern pattern = solid.primitive().material.pattern;
  const bool is_glossy = pattern == Pattern::kGround || pattern == Pattern::kCarBody;
  if (lighting_.gloss == 0 || !is_glossy || hit.normal.dot(lighting_.to_sun) <= 0) return 0;
  const double half_way = hit.normal.dot((lighting_.to_sun - direction).normalized());
  const float sun = solid.isMoving() ? 1.F : sunlit(hit.point, hit.normal);
  return sun * static_cast<float>(kStrength * std::pow(std::max(0.0, half_way), lighting_.gloss));
}

Color Scene::skyColor(const Eigen::Vector3d& direction) const {
  const auto up = static_cast<float>(std::max(0.0, direction.z()));
  Color color = Color(214, 224, 232) + (Color(104, 152, 208) - Color(214, 224, 232)) * std::sqrt(up);
  const float scale = 2.2F / (up + 0.18F);
  const float x = static_cast<float>(direction.x()) * scale;
  const float y = static_cast<float>(direction.y()) * scale;
  const float cloud = 0.6F * valueNoise(x, y, 11) + 0.28F * valueNoise(2.3F * x, 2.3F * y, 12) +
                      0.12F * valueNoise(5.1F * x, 5.1F * y, 13);
  const float share = std::min(1.F, std::max(0.F, (cloud - 0.5F) * 4));
  return color + (Color(238, 240, 242) - color) * (0.85F * share);
}

}  // namespace cloud_colorizer::simulation
