// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/memory_plan.hpp"

#include <gtest/gtest.h>

namespace cloud_colorizer {
namespace {

MemoryPlan planOf(double megabytes, Method method, int num_threads) {
  Params params;
  params.colorize.memory_limit = megabytes;
  params.colorize.method = method;
  params.colorize.num_threads = num_threads;
  return MemoryPlan(params);
}

TEST(MemoryPlan, WhatIsHeldAtOnceFitsTheLimit) {
  for (const double megabytes : {50.0, 1500.0, 1e6}) {
    for (const Method method : {Method::kPaper, Method::kDefault}) {
      const MemoryPlan plan = planOf(megabytes, method, 2);
      const std::size_t kept = plan.surfaces() + plan.thinnedSurfaces() + plan.images() + plan.scans();
      const auto limit = static_cast<std::size_t>(megabytes * 1e6);
      const std::size_t aligning = method == Method::kDefault ? plan.alignment() : 0;
      const std::size_t coloring = plan.depthImages() + plan.chunks();
      EXPECT_LE(kept + aligning, limit);
      EXPECT_LE(kept + coloring, limit);
      EXPECT_GT(kept + std::max(aligning, coloring), limit * 9 / 10);
      EXPECT_GE(plan.images(), limit / 5);
    }
  }
}

TEST(MemoryPlan, WhatChunksDoNotNeedIsForImages) {
  EXPECT_EQ(planOf(1e5, Method::kPaper, 2).chunks(), 2 * planOf(1e5, Method::kPaper, 1).chunks());
  EXPECT_GT(planOf(4000, Method::kPaper, 2).images(), 2200000000U);
}

TEST(MemoryPlan, AChunkOfTheDefaultSizeFits) {
  EXPECT_LT(MemoryPlan::chunkBytes(300000), static_cast<double>(planOf(1500, Method::kDefault, 2).chunks()));
}

TEST(MemoryPlan, ZeroIsHalfOfTheMemoryButNotMoreThanFourGigabytes) {
  const double limit = planOf(0, Method::kDefault, 0).limit();
  EXPECT_GE(limit, 1e8);
  EXPECT_LE(limit, 4e9);
}

}  // namespace
}  // namespace cloud_colorizer
