// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/scan_times.hpp"

#include <gtest/gtest.h>

namespace cloud_colorizer {
namespace {

TEST(ScanTimes, AreTheNearestOnEitherSide) {
  std::vector<Scan> scans(4);
  scans[0].stamp = 10.2;
  scans[1].stamp = 10;
  scans[2].stamp = 10.1;
  scans[3].stamp = 12;
  const ScanTimes times(scans);
  EXPECT_EQ(times.around(10.14), (std::vector<std::size_t>{2, 0}));
  EXPECT_EQ(times.around(10.1), (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(times.around(9.9), (std::vector<std::size_t>{1}));
  EXPECT_EQ(times.around(11.9), (std::vector<std::size_t>{3}));
  EXPECT_TRUE(times.around(11).empty());
  EXPECT_TRUE(ScanTimes({}).around(0).empty());
}

}  // namespace
}  // namespace cloud_colorizer
