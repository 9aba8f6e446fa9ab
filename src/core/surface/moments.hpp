// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Moments of points up to the second: what a plane is fitted to, without looking at the points again.
#pragma once

#include <Eigen/Core>

namespace cloud_colorizer {

/// Count, sum and sum of products of points about a centre.
struct Moments {
  float count = 0;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f products = Eigen::Matrix3f::Zero();

  void add(const Eigen::Vector3f& d) {
    count += 1;
    sum += d;
    products.noalias() += d * d.transpose();
  }
  /// Those of another centre, which lies at `d` from this one.
  void add(const Moments& other, const Eigen::Vector3f& d) {
    count += other.count;
    sum += other.sum + other.count * d;
    const Eigen::Matrix3f cross = (other.sum + 0.5F * other.count * d) * d.transpose();
    products += other.products + cross + cross.transpose();
  }
  /// In units twice as large.
  Moments halved() const { return {count, 0.5F * sum, 0.25F * products}; }

  Eigen::Vector3f mean() const { return sum / count; }
  Eigen::Matrix3f covariance() const { return products / count - mean() * mean().transpose(); }
};

}  // namespace cloud_colorizer
