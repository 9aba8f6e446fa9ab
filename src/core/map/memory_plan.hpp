// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How memory_limit is handed out. One place, so that the shares can be seen to fit.
#pragma once

#include <algorithm>
#include <cstddef>

#include "cloud_colorizer/map/params.hpp"

namespace cloud_colorizer {

class MemoryPlan {
 public:
  explicit MemoryPlan(const Params& params);

  /// What this program had resident at the most since it began.
  static double peakMegabytes();

  double limit() const { return limit_; }  ///< bytes, of all together

  // Caches, kept from stage to stage.
  std::size_t surfaces() const { return share(0.05); }
  std::size_t thinnedSurfaces() const { return share(0.03); }
  std::size_t depthImages() const { return share(0.12); }
  std::size_t scans() const { return share(0.02); }
  /// What the stages leave; an image that is not kept goes through a file.
  std::size_t images() const {
    const std::size_t of_chunks = share(0.78) - chunks();
    return aligns_ ? std::min(of_chunks, share(0.9) - alignment()) : of_chunks;
  }

  // In work, one stage after the other. The alignment needs no depth images beforehand.
  /// A chunk of the usual size for each thread, where there is room for so many.
  std::size_t chunks() const;
  std::size_t alignment() const { return share(0.6); }

  /// What a chunk takes at most while it is coloured, its points seen from 20 views; measured, rounded up.
  static double chunkBytes(double num_points) { return 1400 * num_points; }

 private:
  std::size_t share(double of_limit) const { return static_cast<std::size_t>(limit_ * of_limit); }

  double limit_, usual_chunks_;
  bool aligns_;
};

}  // namespace cloud_colorizer
