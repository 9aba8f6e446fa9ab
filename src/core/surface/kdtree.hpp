// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// nanoflann over columns of points. Holds a reference to them.
#pragma once

#include <cstdint>
#include <nanoflann.hpp>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

class KdTree {
 public:
  explicit KdTree(const Points& points)
      : columns_{points}, tree_(3, columns_, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {
#if NANOFLANN_VERSION < 0x143  // later ones build in their constructor
    tree_.buildIndex();
#endif
  }
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  /// The nearest `count` points, nearest first, and their squared distances [m^2]. There must be as many.
  void nearest(const Eigen::Vector3f& point, std::size_t count, std::uint32_t* indices, float* squared) const {
    tree_.knnSearch(point.data(), count, indices, squared);
  }

 private:
  static constexpr std::size_t kLeafSize = 12;

  struct Columns {
    const Points& points;
    std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.cols()); }
    float kdtree_get_pt(std::size_t i, std::size_t axis) const {
      return points(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(i));
    }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };

  Columns columns_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Columns>, Columns, 3, std::uint32_t> tree_;
};

}  // namespace cloud_colorizer
