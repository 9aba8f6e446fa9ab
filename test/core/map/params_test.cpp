// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/params.hpp"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace cloud_colorizer {
namespace {

std::string messageOf(const std::string& name, const std::string& text) {
  Params params;
  try {
    setParam(params, name, text);
    params.check();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Params, DefaultsAreValid) {
  EXPECT_NO_THROW(Params{}.check());
}

TEST(Params, NamesAreUnique) {
  std::set<std::string> names;
  for (const auto& param : describeParams(Params{})) EXPECT_TRUE(names.insert(param.name).second) << param.name;
}

TEST(Params, EveryValueSurvivesTextAndBack) {
  for (const auto& param : describeParams(Params{})) {
    Params params;
    EXPECT_NO_THROW(setParam(params, param.name, param.value)) << param.name;
    for (const auto& again : describeParams(params)) {
      if (again.name == param.name) {
        EXPECT_EQ(again.value, param.value) << param.name;
      }
    }
  }
}

TEST(Params, SetsNumbersAndWords) {
  Params params;
  setParam(params, "voxel_size", "0.125");
  setParam(params, "passes", "2");
  setParam(params, "method", "closest");
  EXPECT_EQ(params.record.voxel_size, 0.125);
  EXPECT_EQ(params.graph.passes, 2);
  EXPECT_EQ(params.colorize.method, Method::kClosest);
}

TEST(Params, UnknownNameSuggestsTheNearest) {
  EXPECT_TRUE(mentions(messageOf("voxelsize", "1"), "did you mean 'voxel_size'"));
}

TEST(Params, RemovedNameSaysWhatIsDoneInstead) {
  EXPECT_TRUE(mentions(messageOf("use_scans", "false"), "use_scans is gone: scan_resolution=0"));
  EXPECT_TRUE(mentions(messageOf("edge_length_ratio", "2"), "is gone"));
  for (const auto& param : describeParams(Params{})) EXPECT_EQ(removedParam(param.name), "");
}

TEST(Params, UnknownWordListsTheAllowedOnes) {
  EXPECT_TRUE(mentions(messageOf("method", "best"), "default, paper, mean, median, closest"));
}

TEST(Params, RefusesWhatIsNoNumber) {
  EXPECT_TRUE(mentions(messageOf("voxel_size", "5cm"), "'5cm' is not a number"));
  EXPECT_TRUE(mentions(messageOf("voxel_size", ""), "is not a number"));
  EXPECT_TRUE(mentions(messageOf("passes", "1.5"), "not a whole number"));
  EXPECT_TRUE(mentions(messageOf("passes", "1e12"), "must lie in"));
}

TEST(Params, RefusesOutOfRangeWithNameValueAndRange) {
  const std::string message = messageOf("passes", "5");
  EXPECT_TRUE(mentions(message, "passes")) << message;
  EXPECT_TRUE(mentions(message, "5")) << message;
  EXPECT_NE(messageOf("voxel_size", "nan"), "accepted");
  EXPECT_NE(messageOf("voxel_size", "-1"), "accepted");
  EXPECT_NE(messageOf("overlap", "0.6"), "accepted");
  EXPECT_NE(messageOf("memory_limit", "inf"), "accepted");
}

}  // namespace
}  // namespace cloud_colorizer
