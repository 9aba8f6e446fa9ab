// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How memory_limit is handed out. One place, so that the shares can be seen to fit.
#pragma once

#include <cstddef>

namespace cloud_colorizer {

struct MemoryPlan {
  /// 0: half of the memory that there is, at most 4 GB.
  explicit MemoryPlan(double memory_limit_mb);

  double limit;  ///< bytes, of all together

  // Caches, kept from stage to stage.
  std::size_t surfaces() const { return share(0.08); }
  std::size_t images() const { return share(0.25); }
  std::size_t depthImages() const { return share(0.12); }
  std::size_t scans() const { return share(0.02); }

  // In work, one stage after the other. The alignment needs no depth images beforehand.
  std::size_t chunks() const { return share(0.53); }
  std::size_t alignment() const { return share(0.6); }

  /// What a chunk takes at most while it is coloured, its points seen from 20 views; measured, rounded up.
  static double chunkBytes(double num_points) { return 1400 * num_points; }

 private:
  std::size_t share(double of_limit) const { return static_cast<std::size_t>(limit * of_limit); }
};

}  // namespace cloud_colorizer
