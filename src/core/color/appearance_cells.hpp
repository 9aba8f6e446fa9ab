// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Strengths of the functions of an appearance, cell by cell.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "color/light.hpp"

namespace cloud_colorizer {

using Strengths = Eigen::Matrix<float, AppearanceBasis::kMost, 3>;

/// What functions of these strengths add to a colour.
inline Eigen::Vector3f addedBy(const Strengths& strengths, const AppearanceBasis::Functions& functions) {
  return {strengths.col(0).dot(functions), strengths.col(1).dot(functions), strengths.col(2).dot(functions)};
}

/// Of the observations of a part of a cell, each less the mean of its point.
struct AppearanceMoments {
  using Square = Eigen::Matrix<float, AppearanceBasis::kMost, AppearanceBasis::kMost>;
  Square functions = Square::Zero();       ///< sum w B' B'^T
  Strengths products = Strengths::Zero();  ///< sum w B' v'^T
  float squares = 0;                       ///< sum w |v'|^2
  float weight = 0;

  void add(const AppearanceMoments& more, float factor);
};

/// A cell and a direction of the normal.
struct AppearanceCell {
  static constexpr int kParts = 4;
  std::array<AppearanceMoments, kParts> parts;
  Strengths strengths = Strengths::Zero();
  float noise = 0;  ///< variance of a value that the strengths leave
  bool is_proved = false;
};

class AppearanceCells {
 public:
  explicit AppearanceCells(float side) : side_(side) {}

  /// The part of a cell that a point belongs to.
  AppearanceMoments& momentsAt(const Eigen::Vector3f& point, const Eigen::Vector3f& normal);
  const AppearanceCell* cellAt(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

  /// Finds the strengths of every cell; returns whether any is proved.
  bool solve();

  float usualNoise() const;  ///< median over the cells

  /// Between the cells around a point, and the directions that its normal lies between.
  struct Blend {
    Strengths strengths = Strengths::Zero();
    bool is_zero = true;
  };
  Blend blendAt(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;

 private:
  using Index3 = std::array<std::int32_t, 3>;
  static std::uint64_t keyOf(const Index3& cell, int direction);
  const AppearanceCell* find(const Index3& cell, int direction) const;
  AppearanceCell solved(const AppearanceCell& own, const Index3& cell, int direction) const;

  struct Place {
    Index3 cell;
    int direction;
  };
  float side_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_;
  std::vector<AppearanceCell> cells_;
  std::vector<Place> places_;
};

}  // namespace cloud_colorizer
