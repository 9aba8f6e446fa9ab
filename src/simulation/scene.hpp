// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A scene of solids under one sun, exact for rays, nearest points and colours.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "simulation/solid.hpp"

namespace cloud_colorizer::simulation {

/// Fixed light. Without a gloss it does not depend on the viewer: a surface point has one true colour.
struct Lighting {
  Eigen::Vector3d to_sun = Eigen::Vector3d(-0.35, -0.62, 0.8).normalized();
  Color sun{0.44F, 0.42F, 0.38F};  ///< share of the albedo that a face turned to the sun gains
  Color sky{0.62F, 0.63F, 0.66F};  ///< share that every face gets
  double shadow_cell = 0.06;       ///< m, of the map of the sun's shadows; 0: no shadows
  double gloss = 0;                ///< Blinn and Phong's exponent of the wet road and the car bodies; 0: all is matte
};

struct Hit {
  double distance = 0;                              ///< m; along the ray, or from the query point (>= 0)
  Eigen::Vector3d point{0, 0, 0}, normal{0, 0, 1};  ///< map; the normal is unit and points outwards
  int solid = 0;                                    ///< index of the solid
  int object = 0;                                   ///< of the solid's primitive
  LocalHit local;                                   ///< in the solid's frame
};

/// Immutable and safe to use from several threads. Rays cost O(log n) in the number of solids that stand.
class Scene {
 public:
  /// A time at which only what stands is there: what throws shadows.
  static constexpr double kNothingMoves = -std::numeric_limits<double>::infinity();

  Scene(std::vector<Primitive> primitives, const Lighting& lighting, int num_threads = 0);

  /// The first surface of a ray (unit direction) at `time` [s], nearer than max_distance [m].
  std::optional<Hit> castRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time = 0,
                             double max_distance = std::numeric_limits<double>::infinity()) const;

  /// Whether anything lies between two points at `time`.
  bool isBlocked(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double time = 0) const;

  /// Nearest point of the surface of all that stands, at most max_distance [m] away. Surfaces that lie inside another
  /// solid do not count: nobody can see them.
  std::optional<Hit> closestPoint(const Eigen::Vector3d& point, double max_distance) const;

  /// Albedo times light, 0 to 255, averaged over `footprint` [m] of texture.
  Color trueColor(const Hit& hit, float footprint = kTrueFootprint) const;
  /// What the sun's sheen adds to the true colour, seen along a ray of that direction.
  float sheen(const Hit& hit, const Eigen::Vector3d& direction) const;
  Color skyColor(const Eigen::Vector3d& direction) const;

  const std::vector<Solid>& solids() const { return solids_; }
  Hit completeHit(int solid, const LocalHit& local, double time) const;

  /// Texture finer than this [m] is below what a map of 5 cm voxels and pixels of 1 cm can tell.
  static constexpr float kTrueFootprint = 0.03F;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int first = 0;  ///< leaf: first of `order_`; inner node: index of its second child (the first follows it)
    int count = 0;  ///< leaf: solids; inner node: 0
  };
  struct ShadowMap {
    Eigen::Matrix3d sun_from_map;  ///< z towards the sun
    Eigen::Vector2d corner{0, 0};  ///< m
    double cell = 1;               ///< m
    int width = 0, height = 0;
    std::vector<float> highest;  ///< m, along z
  };

  int build(int first, int count);
  /// Whether test(solid) is true for one that stands, of those in boxes that enters(box) lets through.
  template <class Enters, class Test>
  bool anySolid(const Enters& enters, const Test& test) const;
  int buriedIn(const Eigen::Vector3d& point, int except) const;  ///< index of a solid around it, or -1
  std::optional<Hit> surfaceNear(const Eigen::Vector3d& point, int solid, LocalHit local) const;
  void buildShadows(int num_threads);
  float sunlit(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

  std::vector<Solid> solids_;
  std::vector<int> movers_;
  std::vector<int> order_;  ///< of the solids that stand
  std::vector<Node> nodes_;
  Lighting lighting_;
  ShadowMap shadows_;
};

}  // namespace cloud_colorizer::simulation
