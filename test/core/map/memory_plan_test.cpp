// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/memory_plan.hpp"

#include <gtest/gtest.h>

namespace cloud_colorizer {
namespace {

TEST(MemoryPlan, WhatIsHeldAtOnceFitsTheLimit) {
  for (const double megabytes : {50.0, 1500.0, 1e6}) {
    const MemoryPlan plan(megabytes);
    const std::size_t kept = plan.surfaces() + plan.images() + plan.scans();
    const auto limit = static_cast<std::size_t>(megabytes * 1e6);
    EXPECT_LE(kept + plan.alignment(), limit);
    EXPECT_LE(kept + plan.depthImages() + plan.chunks(), limit);
    EXPECT_GT(kept + plan.depthImages() + plan.chunks(), limit * 9 / 10);
  }
}

TEST(MemoryPlan, AChunkOfTheDefaultSizeFits) {
  EXPECT_LT(MemoryPlan::chunkBytes(300000), static_cast<double>(MemoryPlan(1500).chunks()));
}

TEST(MemoryPlan, ZeroIsHalfOfTheMemoryButNotMoreThanFourGigabytes) {
  const double limit = MemoryPlan(0).limit;
  EXPECT_GE(limit, 1e8);
  EXPECT_LE(limit, 4e9);
}

}  // namespace
}  // namespace cloud_colorizer
