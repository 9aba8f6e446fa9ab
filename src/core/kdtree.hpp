// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// nanoflann over columns of points. Holds a reference to them.
#pragma once

#include <cstdint>
#include <nanoflann.hpp>
#include <vector>

#include "cloud_colorizer/types.hpp"

namespace cloud_colorizer {

class KdTree {
 public:
  explicit KdTree(const Points& points) : columns_{points}, tree_(3, columns_, {kLeafSize}) { tree_.buildIndex(); }
  KdTree(const KdTree&) = delete;
  KdTree& operator=(const KdTree&) = delete;

  /// The nearest indices.size() points, nearest first, and their squared distances [m^2]. There must be as many.
  void nearest(const Eigen::Vector3f& point, std::vector<std::uint32_t>& indices,
               std::vector<float>& squared_distances) const {
    squared_distances.resize(indices.size());
    tree_.knnSearch(point.data(), indices.size(), indices.data(), squared_distances.data());
  }

 private:
  static constexpr std::size_t kLeafSize = 16;

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
