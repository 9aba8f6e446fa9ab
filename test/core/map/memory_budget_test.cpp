// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/memory_budget.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "base/parallel.hpp"

namespace cloud_colorizer {
namespace {

TEST(MemoryBudget, NeverGivesOutMoreThanItHasExceptToOneAlone) {
  MemoryBudget budget(100);
  std::atomic<int> used{0}, shares{0}, most{0}, finished{0};
  std::atomic<bool> exceeded{false};
  parallelFor(8, 2000, [&](std::size_t i) {
    const int bytes = i % 7 == 0 ? 300 : 40;  // of the small ones two fit
    const MemoryBudget::Share share(budget, bytes);
    const int now = used += bytes, count = ++shares;
    most = std::max(most.load(), count);
    if (now > 100 && count > 1) exceeded = true;
    --shares;
    used -= bytes;
    ++finished;
  });
  EXPECT_FALSE(exceeded);
  EXPECT_LE(most, 2);
  EXPECT_EQ(finished, 2000);
}

}  // namespace
}  // namespace cloud_colorizer
