// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/limited.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <stdexcept>
#include <vector>

#include "evaluation/methods.hpp"
#include "evaluation/neighbors.hpp"
#include "evaluation/one_view.hpp"
#include "evaluation/table.hpp"

namespace cloud_colorizer {
namespace {

TEST(LimitedRun, BytesAndPeakMemoryComeBack) {
  const LimitedRun run = runLimited(
      [] {
        std::vector<char> block(100 << 20);
        for (std::size_t i = 0; i < block.size(); i += 4096) block[i] = static_cast<char>(i >> 12);
        return std::string(200000, block[4096] == 1 ? 'x' : 'y');
      },
      {60, 4000});
  EXPECT_EQ(run.status, "ok");
  EXPECT_EQ(run.bytes, std::string(200000, 'x'));
  EXPECT_GT(run.peak_megabytes, 100);
  EXPECT_LT(run.peak_megabytes, 1000);
}

TEST(LimitedRun, SolvesEvenWhereTheCallerSolvedBefore) {
  // Dense enough for supernodes, whose code leaves threads of OpenMP behind that a fork does not copy.
  std::srand(3);
  const Points points = Points::Random(3, 4000);
  const Observations observations = seenByOneView(4000);
  const auto solve = [&] {
    const GraphSolution solution =
        solveOnGraph("20-NN", points, observations, fuseMean(observations), SystemParams{}, Unanchored::kAnchored);
    return formatNumber(solution.values.mean(), 1);
  };
  EXPECT_EQ(solve(), "120.0");
  const LimitedRun run = runLimited(solve, {2, 4000});
  EXPECT_EQ(run.status, "ok");
  EXPECT_EQ(run.bytes, "120.0");
}

TEST(LimitedRun, TimeAndMemoryLimitsAndErrorsAreTold) {
  EXPECT_EQ(runLimited(
                [] {
                  sleep(20);
                  return std::string();
                },
                {0.02, 4000})
                .status,
            "time limit");
  const LimitedRun busy = runLimited(
      [] {
        for (volatile int i = 0;; i = i + 1) {
        }
        return std::string();
      },
      {0.1, 4000});
  EXPECT_EQ(busy.status, "time limit");
  EXPECT_GT(busy.seconds, 0.1);
#if !defined(__SANITIZE_ADDRESS__)  // the sanitiser reserves terabytes and aborts where others throw
  EXPECT_EQ(runLimited([] { return std::string(1UL << 31, 'x'); }, {60, 200}).status, "memory limit");
#endif
  EXPECT_EQ(runLimited([]() -> std::string { throw std::runtime_error("singular"); }, {60, 4000}).status, "singular");
  EXPECT_THROW(runLimited([] { return std::string(); }, {0, 100}), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
