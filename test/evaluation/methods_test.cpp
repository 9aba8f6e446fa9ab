// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/methods.hpp"

#include <gtest/gtest.h>

#include "evaluation/neighbors.hpp"
#include "evaluation/one_view.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

const TestBed& cleanBed() {
  static const TestBed bed = [] {
    TestBedParams params;
    params.num_points = 6000;
    params.num_views = 12;
    params.width = 320;
    params.height = 240;
    params.focal_length = 375;
    params.texture_frequency = 0.3;  // the points are few
    return renderTestBed(bumpySphere(60), params);
  }();
  return bed;
}

Score scoreOf(const TestBed& bed, const std::string& method) {
  const ObservedBed observed = observeBed(bed, bed.poses, {}, Params{});
  const MethodResult result = colorizeArrays(bed, observed, method, Params{});
  return scoreColors(bed.truth, result.values, result.colored);
}

TEST(Methods, EveryRowColoursTheCleanBedNearlyRight) {
  for (const std::string& method : methodNames()) {
    if (method == "default") continue;  // its alignment has its own tests
    if (method.rfind("DT", 0) == 0 && !hasDelaunay()) continue;
    const Score score = scoreOf(cleanBed(), method);
    EXPECT_GT(score.coverage, 0.98) << method;
    EXPECT_LT(score.aep, 3) << method;
  }
}

TEST(Methods, FourPassRowIsThePreset) {
  const TestBed bed = addNoise(cleanBed(), NoiseParams{}, 1);
  const ObservedBed observed = observeBed(bed, bed.poses, {}, Params{});
  const Values a = colorizeArrays(bed, observed, "4-pass", Params{}).values;
  const Values b = colorizeArrays(bed, observed, "paper", Params{}).values;
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-2);
}

TEST(Methods, PartWithoutAnchorIsWrongAsPlainAndRightWithOurRule) {
  // Two clusters of four points far apart: 2-NN does not link them, and no random anchor falls on either.
  Points points(3, 8);
  points << 0, .1F, 0, .1F, 9, 9.1F, 9, 9.1F, 0, 0, .1F, .1F, 0, 0, .1F, .1F, 0, 0, 0, 0, 0, 0, 0, 0;
  const Observations observations = seenByOneView(8);
  SystemParams params;
  params.min_data_weight = 0;
  params.anchor_share = 1e-9;
  const Fused mean = fuseMean(observations);
  const GraphSolution good = solveOnGraph("2-NN", points, observations, mean, params, Unanchored::kAnchored);
  const GraphSolution plain = solveOnGraph("2-NN", points, observations, mean, params, Unanchored::kPlain);
  EXPECT_LT((good.values.array() - 120).abs().maxCoeff(), 1e-3);
  EXPECT_NEAR(good.unanchored_share, plain.unanchored_share, 0);
  EXPECT_GE(plain.unanchored_share, 0.5);  // a chain gets one anchor, so at most one of the two parts has it
  EXPECT_GT((plain.values.array() - 120).abs().maxCoeff(), 100);
}

TEST(Methods, UnknownGraphIsRefused) {
  EXPECT_THROW(buildGraph("MST", Points(3, 0)), std::invalid_argument);
  EXPECT_THROW(buildGraph("5-pass", Points(3, 0)), std::invalid_argument);
  EXPECT_THROW(buildGraph("4-pass own", Points(3, 0)), std::invalid_argument);
}

TEST(Methods, NothingSeenGivesNothing) {
  const ObservedBed observed = observeBed(cleanBed(), {}, {}, Params{});
  EXPECT_TRUE(observed.seen.empty());
}

TEST(Table, CsvQuotesAndMarkdownLines) {
  ResultTable table{{"a", "b"}, {}};
  table.add({"1", "x, \"y\""});
  EXPECT_EQ(csv(table), "a,b\n1,\"x, \"\"y\"\"\"\n");
  EXPECT_EQ(markdown(table), "| a | b |\n|---|---|\n| 1 | x, \"y\" |\n");
  EXPECT_EQ(table.column("b"), 1U);
  EXPECT_THROW(table.add({"1"}), std::invalid_argument);
  EXPECT_THROW(table.column("c"), std::invalid_argument);
  EXPECT_EQ(formatNumber(std::nan(""), 2), "-");
}

TEST(Tables, MissingMeshesAreAnError) {
  EXPECT_THROW(loadMeshes("/nowhere"), std::runtime_error);
  EXPECT_THROW(loadMeshes("/proc/self/fd"), std::runtime_error);  // a directory without a mesh
  EXPECT_EQ(loadMeshes("").size(), 2U);
}

TEST(Tables, ScanLinesCutFiveNearestNeighboursIntoPartsAndFourPassesNot) {
  TablesParams params;
  params.bed.num_points = 3000;
  params.bed.num_views = 6;
  params.bed.width = 160;
  params.bed.height = 120;
  params.bed.focal_length = 190;
  const ResultTable table = makeIsolated(bumpySphere(60), params, Callbacks{});
  ASSERT_EQ(table.rows.size(), 9U);
  for (const auto& row : table.rows) {
    const int parts = std::stoi(row[table.column("parts")]);
    if (row[table.column("graph")] == "4-pass") {
      EXPECT_EQ(parts, 1);
    } else if (row[table.column("graph")] == "5-NN" && row[0] != "uniform") {
      EXPECT_GT(parts, 10) << row[0];
    }
  }
}

}  // namespace
}  // namespace cloud_colorizer
