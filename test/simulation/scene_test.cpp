// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulation/random.hpp"
#include "simulation/street.hpp"

namespace cloud_colorizer::simulation {
namespace {

Eigen::Isometry3d somePose(std::uint64_t key) {
  const Eigen::Vector3d axis(gaussian(keyOf(key, 1)), gaussian(keyOf(key, 2)), gaussian(keyOf(key, 3)));
  return Eigen::Translation3d(uniform(keyOf(key, 4), -1, 1), uniform(keyOf(key, 5), -1, 1), 0.3) *
         Eigen::AngleAxisd(uniform(keyOf(key, 6), -3, 3), axis.normalized());
}

Primitive prism() {
  Primitive p;
  p.profile = {{-1, -0.5}, {1, -0.5}, {1.3, 0}, {0.2, 0.6}, {-1, 0.3}};
  p.half_length = 0.7;
  return p;
}

Primitive cylinder() {
  Primitive p;
  p.shape = Shape::kCylinder;
  p.radius = 0.4;
  p.half_length = 0.9;
  return p;
}

Primitive sphere() {
  Primitive p;
  p.shape = Shape::kSphere;
  p.radius = 0.8;
  return p;
}

Primitive wall(double x, double half_width, double height) {
  Primitive p;
  p.profile = {{-0.1, 0}, {0.1, 0}, {0.1, height}, {-0.1, height}};
  p.half_length = half_width;
  p.map_from_local.translation().x() = x;
  return p;
}

Lighting noShadows() {
  Lighting lighting;
  lighting.shadow_cell = 0;
  return lighting;
}

Eigen::Vector3d randomVector(std::uint64_t key) {
  return {gaussian(keyOf(key, 1)), gaussian(keyOf(key, 2)), gaussian(keyOf(key, 3))};
}

class EverySolid : public ::testing::TestWithParam<int> {
 protected:
  Solid solid() const {
    Primitive p = GetParam() == 0 ? prism() : (GetParam() == 1 ? cylinder() : sphere());
    p.map_from_local = somePose(static_cast<std::uint64_t>(GetParam()) + 10);
    return Solid(p);
  }
};

/// The sign of the distance tells inside from outside, so marching along a ray is an oracle for the first hit.
TEST_P(EverySolid, RayHitsWhereMarchingEnters) {
  const Solid s = solid();
  int num_hits = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Eigen::Vector3d origin = 4 * randomVector(keyOf(i, 1)).normalized();
    const Eigen::Vector3d direction = (1.2 * randomVector(keyOf(i, 2)).normalized() - origin).normalized();
    double marched = -1;
    for (double t = 0; t < 8 && marched < 0; t += 0.002) {
      if (s.closest(origin + t * direction, 0).distance < 0) marched = t;
    }
    LocalHit hit;
    const bool is_hit = s.intersect(origin, direction, 0, 100, hit);
    if (marched < 0) {
      // Marching may step over a thin corner, but not over more.
      if (is_hit) {
        EXPECT_GT(s.closest(origin + (hit.distance + 0.003) * direction, 0).distance, -0.003);
      }
      continue;
    }
    ++num_hits;
    ASSERT_TRUE(is_hit);
    EXPECT_NEAR(hit.distance, marched, 0.0021);
    EXPECT_LT(hit.normal.dot(s.primitive().map_from_local.linear().transpose() * direction), 0);
    EXPECT_NEAR(s.closest(origin + hit.distance * direction, 0).distance, 0, 1e-9);
  }
  EXPECT_GT(num_hits, 50);
}

TEST_P(EverySolid, NearestPointIsNearerThanAllSampledOnes) {
  const Solid s = solid();
  std::vector<Eigen::Vector3d> samples;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const Eigen::Vector3d origin = 4 * randomVector(keyOf(i, 3)).normalized();
    LocalHit hit;
    const Eigen::Vector3d direction = (0.6 * randomVector(keyOf(i, 4)) - origin).normalized();
    if (s.intersect(origin, direction, 0, 100, hit)) samples.push_back(origin + hit.distance * direction);
  }
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Eigen::Vector3d p = 1.3 * randomVector(keyOf(i, 5));
    double sampled = 1e9;
    for (const auto& sample : samples) sampled = std::min(sampled, (sample - p).norm());
    const LocalHit hit = s.closest(p, 0);
    EXPECT_LE(std::abs(hit.distance), sampled + 1e-9);
    EXPECT_GT(std::abs(hit.distance), sampled - 0.15);
    EXPECT_NEAR((s.primitive().map_from_local * hit.point - p).norm(), std::abs(hit.distance), 1e-9);
  }
}

TEST_P(EverySolid, RayFromInsideDoesNotHit) {
  const Solid s = solid();
  LocalHit hit;
  EXPECT_FALSE(s.intersect(s.primitive().map_from_local.translation(), Eigen::Vector3d::UnitX(), 0, 100, hit));
}

INSTANTIATE_TEST_SUITE_P(Shapes, EverySolid, ::testing::Values(0, 1, 2));

TEST(Solid, BadSizesAreRefused) {
  Primitive clockwise = prism();
  std::reverse(clockwise.profile.begin(), clockwise.profile.end());
  EXPECT_THROW(Solid{clockwise}, std::invalid_argument);
  Primitive flat = cylinder();
  flat.half_length = 0;
  EXPECT_THROW(Solid{flat}, std::invalid_argument);
  Primitive point = sphere();
  point.radius = 0;
  EXPECT_THROW(Solid{point}, std::invalid_argument);
  Primitive line = prism();
  line.profile.resize(2);
  EXPECT_THROW(Solid{line}, std::invalid_argument);
}

TEST(Solid, MovingSolidIsHitWhereItIs) {
  Primitive p = sphere();
  p.motion = std::make_shared<const Motion>(Motion{{{0, {0, 0, 0}}, {1, {2, 0, 0}}}});
  const Solid s(p);
  LocalHit hit;
  ASSERT_TRUE(s.intersect({0, -5, 0}, {0, 1, 0}, 0, 100, hit));
  EXPECT_FALSE(s.intersect({0, -5, 0}, {0, 1, 0}, 1, 100, hit));
  ASSERT_TRUE(s.intersect({2, -5, 0}, {0, 1, 0}, 1, 100, hit));
  EXPECT_NEAR(hit.distance, 4.2, 1e-12);
}

TEST(FacePoint, LettersReadFromLeftToRightFromOutside) {
  const Solid s(wall(0, 2, 3));
  for (const double side : {-1.0, 1.0}) {
    // Seen along +x the right hand is -y; seen along -x it is +y.
    LocalHit left, right;
    ASSERT_TRUE(s.intersect({-5 * side, side, 1}, {side, 0, 0}, 0, 100, left));
    ASSERT_TRUE(s.intersect({-5 * side, -side, 1}, {side, 0, 0}, 0, 100, right));
    EXPECT_NEAR(s.facePoint(right, 0.01F).u - s.facePoint(left, 0.01F).u, 2, 1e-5);
    EXPECT_NEAR(s.facePoint(left, 0.01F).v, 1, 1e-5);
  }
}

class StreetScene : public ::testing::Test {
 protected:
  static StreetOptions options() {
    StreetOptions o;
    o.from = -10;
    o.to = 20;
    o.moving_car = true;
    o.lighting.shadow_cell = 0.5;
    return o;
  }
  Scene scene_ = makeStreet(options());
};

TEST_F(StreetScene, TreeOfBoxesFindsWhatALoopOverAllSolidsFinds) {
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const Eigen::Vector3d origin(uniform(keyOf(i, 1), -8, 18), uniform(keyOf(i, 2), -4, 4), 1.7);
    const Eigen::Vector3d direction = randomVector(keyOf(i, 3)).normalized();
    LocalHit hit;
    double nearest = 1e9;
    for (const Solid& solid : scene_.solids()) {
      if (solid.intersect(origin, direction, 1.5, nearest, hit)) nearest = hit.distance;
    }
    const auto found = scene_.castRay(origin, direction, 1.5);
    ASSERT_EQ(found.has_value(), nearest < 1e9);
    if (!found) continue;
    EXPECT_EQ(found->distance, nearest);
    EXPECT_FALSE(scene_.isBlocked(origin, origin + (nearest - 1e-6) * direction, 1.5));
    EXPECT_TRUE(scene_.isBlocked(origin, origin + (nearest + 1e-6) * direction, 1.5));
  }
}

TEST_F(StreetScene, NearestPointOfAHitIsTheHit) {
  int num_checked = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin(uniform(keyOf(i, 1), -8, 18), uniform(keyOf(i, 2), -4, 4), 1.9);
    const auto hit = scene_.castRay(origin, randomVector(keyOf(i, 3)).normalized());
    if (!hit || scene_.solids()[static_cast<std::size_t>(hit->solid)].isMoving()) continue;
    const auto nearest = scene_.closestPoint(hit->point + 0.001 * hit->normal, 0.1);
    ASSERT_TRUE(nearest);
    EXPECT_LT((nearest->point - hit->point).norm(), 0.0021);
    ++num_checked;
  }
  EXPECT_GT(num_checked, 1000);
}

TEST_F(StreetScene, ColorsAreFiniteAndInRange) {
  for (std::uint64_t i = 0; i < 3000; ++i) {
    const Eigen::Vector3d direction = randomVector(keyOf(i, 3)).normalized();
    const auto hit = scene_.castRay({uniform(keyOf(i, 1), -8, 18), -1.5, 1.9}, direction, 0.5);
    const Color color = hit ? scene_.trueColor(*hit) : scene_.skyColor(direction);
    EXPECT_TRUE(color.isFinite().all());
    EXPECT_GE(color.minCoeff(), 0);
    EXPECT_LE(color.maxCoeff(), 255);
  }
}

TEST_F(StreetScene, SameSeedSameStreetAndAnotherSeedAnother) {
  const auto describe = [](const std::vector<Primitive>& primitives) {
    double sum = 0;
    for (const auto& p : primitives) sum = sum * 1.0001 + p.map_from_local.translation().sum();
    return sum;
  };
  StreetOptions other = options();
  other.seed = 2;
  EXPECT_EQ(describe(streetPrimitives(options())), describe(streetPrimitives(options())));
  EXPECT_NE(describe(streetPrimitives(options())), describe(streetPrimitives(other)));
}

TEST_F(StreetScene, NumberOfThreadsDoesNotChangeTheShadows) {
  const Scene one = makeStreet(options(), 1);
  for (int x = -8; x < 18; ++x) {
    const auto hit = one.castRay({x + 0.3, 1.3, 1.5}, {0, 0, -1});
    ASSERT_TRUE(hit);
    EXPECT_TRUE((one.trueColor(*hit) == scene_.trueColor(*hit)).all());
  }
}

TEST(Street, TooShortIsRefused) {
  StreetOptions options;
  options.from = 0;
  options.to = 10;
  EXPECT_THROW(streetPrimitives(options), std::invalid_argument);
}

TEST(Scene, EmptySceneIsAllSky) {
  const Scene scene({}, Lighting{});
  EXPECT_FALSE(scene.castRay({0, 0, 1}, {1, 0, 0}));
  EXPECT_FALSE(scene.closestPoint({0, 0, 0}, 10));
  EXPECT_FALSE(scene.isBlocked({0, 0, 0}, {5, 0, 0}));
}

TEST(Scene, BuriedFaceIsNotTheNearestSurface) {
  // A small box stands 10 cm deep in a large one: its buried corner is no place where anything can be seen.
  Primitive small = wall(0, 0.2, 1);
  small.map_from_local.translation().z() = -0.1;
  Primitive ground;
  ground.profile = {{-5, -1}, {5, -1}, {5, 0}, {-5, 0}};
  ground.half_length = 5;
  const Scene scene({small, ground}, noShadows());
  const auto hit = scene.closestPoint({0.1, 0, -0.08}, 1);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->solid, 1);
  EXPECT_NEAR(hit->point.z(), 0, 1e-12);
}

TEST(Scene, PointInsideTwoSpheresFindsTheirOutside) {
  Primitive left = sphere();
  Primitive right = sphere();
  left.map_from_local.translation().x() = -0.5;
  right.map_from_local.translation().x() = 0.5;
  const Scene scene({left, right}, noShadows());
  const double crease = std::sqrt(0.8 * 0.8 - 0.5 * 0.5);
  const auto hit = scene.closestPoint({0, 0, crease - 0.05}, 0.4);  // both nearest points lie in the other sphere
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->point.z(), crease, 0.01);
  EXPECT_NEAR(hit->distance, 0.05, 0.01);
}

TEST(Scene, ShadowFallsAwayFromTheSun) {
  Lighting lighting;
  lighting.to_sun = Eigen::Vector3d(1, 0, 1).normalized();
  lighting.shadow_cell = 0.05;
  Primitive ground;
  ground.profile = {{-10, -1}, {10, -1}, {10, 0}, {-10, 0}};
  ground.half_length = 5;
  const Scene scene({wall(0, 2, 2), ground}, lighting);
  const auto brightness = [&](double x, double y) {
    return scene.trueColor(*scene.castRay({x, y, 5}, {0, 0, -1})).sum();
  };
  EXPECT_LT(brightness(-1, 0), 0.8F * brightness(1, 0));  // the wall's shadow reaches from -0.1 to -2.1
  EXPECT_FLOAT_EQ(brightness(-2.5, 0), brightness(1, 0));
  EXPECT_FLOAT_EQ(brightness(-1, 3), brightness(1, 0));
}

}  // namespace
}  // namespace cloud_colorizer::simulation
