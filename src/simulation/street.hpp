// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A street along +x: houses with side alleys, kerbs, parked cars, lamps, signs, trees, and what moves.
#pragma once

#include "simulation/scene.hpp"

namespace cloud_colorizer::simulation {

struct StreetOptions {
  int seed = 1;
  double from = -30, to = 85;  ///< m along x; both ends are closed by a house
  int leaves = 0;              ///< of a tree; 0: closed crowns
  bool moving_car = false;
  double car_start = 45, car_speed = -6;  ///< m and m/s along x, of the moving car at time 0
  int pedestrians = 0;
  std::shared_ptr<const Motion> van;  ///< of a van from x = 0 in the lane of the vehicle; null: none
  Lighting lighting;
};

std::vector<Primitive> streetPrimitives(const StreetOptions& options);

/// The same options give the same street. Throws std::invalid_argument when it is shorter than 20 m.
Scene makeStreet(const StreetOptions& options, int num_threads = 0);

}  // namespace cloud_colorizer::simulation
