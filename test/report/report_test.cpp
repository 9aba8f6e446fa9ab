// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "base/file_io.hpp"
#include "cloud_colorizer/map/chunks.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"
#include "report/consistency.hpp"
#include "report/facts.hpp"
#include "report/map_sample.hpp"
#include "report/seams.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

/// A wall at z = 4 of 40 x 40 points, of which a camera at 0 sees the middle in one colour.
class Report : public ::testing::Test {
 protected:
  Report() {
    params_.record.min_range = 0;
    params_.colorize.method = Method::kMean;
    Recorder recorder(scratch_ / "drive", "map", params_.record);
    Cloud cloud;
    cloud.fields = {{"intensity", FieldType::kFloat32, 1}};
    cloud.positions.resize(3, 1600);
    for (int i = 0; i < 1600; ++i) cloud.positions.col(i) << 0.1 * (i % 40) - 2, 0.1 * static_cast<int>(i / 40) - 2, 4;
    cloud.records.resize(6400);
    recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
    const auto camera =
        recorder.setCamera("camera_0", {160, 120, 160, 160, 79.5, 59.5, DistortionModel::kPlumbBob, {}});
    std::vector<std::uint8_t> png;
    cv::imencode(".png", cv::Mat3b(120, 160, cv::Vec3b(40, 80, 200)), png);
    recorder.addView(camera, 1, Eigen::Isometry3d::Identity(), png, "png");
    run_.summary = colorize(recorder.snapshot(), params_, {});
    run_.warnings = {"the clock of <b>camera_0</b>", "the clock of <b>camera_0</b>"};
    run_.program = "test";
    run_.name = "drive<!--<script>";
  }

  json write() { return writeReport(Recording::open(scratch_ / "drive"), params_, run_, scratch_ / "report", {}); }
  std::string textOf(const std::string& name) const {
    const auto bytes = readFile(scratch_ / ("report/" + name));
    return {bytes.begin(), bytes.end()};
  }

  ScratchDirectory scratch_;
  Params params_;
  RunFacts run_;
};

TEST_F(Report, TellsTheNumbersOfTheMap) {
  const json report = write();
  EXPECT_EQ(json::parse(textOf("report.json")), report);
  EXPECT_EQ(report["map"]["points"], 1600);
  EXPECT_EQ(report["map"]["colored"], run_.summary.num_colored);
  EXPECT_GT(run_.summary.num_colored, 300U);
  EXPECT_EQ(report["uncolored"]["in_no_image"].get<std::size_t>() + run_.summary.num_colored, 1600U);
  EXPECT_EQ(report["cameras"][0]["views"], 1);
  EXPECT_EQ(report["parameters_changed"]["method"], "mean");
  EXPECT_EQ(report["warnings"].size(), 1U);  // each once
  EXPECT_EQ(report["name"], "drive<!--<script>");
}

TEST_F(Report, ThePageStandsAloneAndIsNotEndedByANameInIt) {
  write();
  const std::string page = textOf("report.html");
  EXPECT_EQ(page.find("http://www.w3.org/2000/svg"), page.find("http"));  // a name, no address
  EXPECT_EQ(page.find("https:"), std::string::npos);
  EXPECT_EQ(page.find("drive<!--<script>"), std::string::npos);
  EXPECT_EQ(page.find("<b>camera_0"), std::string::npos);
  EXPECT_EQ(page.find("@FACTS@"), std::string::npos);
  EXPECT_NE(page.find("data:image/jpeg;base64,"), std::string::npos);
  EXPECT_EQ(page.find(scratch_.path()), std::string::npos);
}

TEST_F(Report, LightsTurnRedByWhatIsWrong) {
  const auto stateOf = [](const json& facts, const std::string& name) -> std::string {
    for (const json& light : lightsOf(facts)) {
      if (light["name"] == name) return light["state"];
    }
    return "";
  };
  const Recording recording = Recording::open(scratch_ / "drive");
  json facts = collectFacts(recording, params_, run_, sampleMap(recording, params_, 1600, 1600, {}));
  EXPECT_EQ(stateOf(facts, "Calibration and clocks"), "red");
  EXPECT_EQ(stateOf(facts, "Coloured"), "green");
  EXPECT_EQ(stateOf(facts, "Held-out colour error"), "grey");  // no point has three views
  EXPECT_EQ(stateOf(facts, "Overlap"), "red");
  EXPECT_EQ(stateOf(facts, "Masks"), "grey");
  EXPECT_EQ(stateOf(facts, "What moved"), "grey");
  facts["warnings"] = json::array();
  facts["map"]["disagreement"] = 0.8;
  facts["map"]["colored_share_in_reach"] = 0.2;
  facts["heldout"]["error"] = 20;
  facts["heldout"]["points"] = 100;
  facts["alignment"]["gain_range"] = 12;
  facts["alignment"]["median_shift_of_width"] = 0.001;
  EXPECT_EQ(stateOf(facts, "Calibration and clocks"), "grey");
  EXPECT_EQ(stateOf(facts, "Coloured"), "red");
  EXPECT_EQ(stateOf(facts, "Agreement of the views"), "red");
  EXPECT_EQ(stateOf(facts, "Held-out colour error"), "yellow");
  EXPECT_EQ(stateOf(facts, "Exposure"), "red");
  EXPECT_EQ(stateOf(facts, "Poses"), "green");
}

HeldOut sightAt(int column, int row, std::uint8_t error) {
  return {0, static_cast<std::uint8_t>(row * kHeldOutColumns + column), error};
}

TEST(WorstPart, IsWhereAllImagesContradictTheOthers) {
  std::vector<CameraErrors> cameras(1);
  for (int row = 0; row < kHeldOutRows; ++row) {
    for (int column = 0; column < kHeldOutColumns; ++column) {
      for (int i = 0; i < 40; ++i) cameras[0].add(sightAt(column, row, static_cast<std::uint8_t>(5 + i % 5)));
    }
  }
  EXPECT_EQ(worstPart(cameras).error_ratio, 0);
  for (int i = 0; i < 400; ++i) cameras[0].add(sightAt(3, 3, 60));  // one cell is a chance
  EXPECT_EQ(worstPart(cameras).error_ratio, 0);
  for (int column = 4; column < 12; ++column) {  // a bonnet
    for (int i = 0; i < 400; ++i) cameras[0].add(sightAt(column, kHeldOutRows - 1, 60));
  }
  const BadPart part = worstPart(cameras);
  EXPECT_GT(part.error_ratio, 5);
  EXPECT_EQ(part.left, 0.25);
  EXPECT_EQ(part.right, 0.75);
  EXPECT_EQ(part.bottom, 1);
  EXPECT_NEAR(cameras[0].median(), 60, 55);
  EXPECT_EQ(cameras[0].count(), 40U * 192 + 400 * 9);
}

TEST(SeamMeter, SeesAStepAtTheBorderOfChunksOnly) {
  ScratchDirectory scratch;
  RecordParams record;
  record.voxel_size = 0, record.min_range = 0, record.max_range = 100, record.tile_size = 1;
  Recorder recorder(scratch / "r", "map", record);
  Cloud cloud;
  cloud.positions = Eigen::Matrix3Xd::Random(3, 60000).cwiseAbs();
  cloud.positions.row(0) *= 8;
  cloud.positions.row(2) *= 0.01;
  recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
  const Recording recording = recorder.snapshot();
  Params params;
  params.chunks.max_chunk_points = 40000;  // of eight tiles
  const std::vector<Chunk> chunks = planChunks(recording.tiles(), recording.tileSize(), params.chunks);
  ASSERT_EQ(chunks.size(), 2U);
  float border = 0;  // along x
  for (const std::size_t tile : chunks[0].core_tiles) border = std::max(border, recording.tileBox(tile).max().x());
  if (border > 7.5F) border = recording.tileBox(chunks[0].core_tiles.front()).min().x();
  for (const auto& [step, slope] : {std::pair<float, float>{0, 0}, {6, 0}, {0, 100}, {6, 100}}) {
    SeamMeter meter(recording, params);
    for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
      ShownTile shown;
      shown.tile = tile;
      shown.points = recording.readPoints(tile);
      const auto& first = chunks[0].core_tiles;
      const bool is_first = std::find(first.begin(), first.end(), tile) != first.end();
      shown.colors.values = Values::Random(3, shown.points.cols()).array() * 3 + (is_first ? 100 : 100 + step);
      // What changes at a border by itself is no seam.
      const Eigen::RowVectorXf natural = slope * (shown.points.row(0).array() - border).cwiseMax(-0.3F).cwiseMin(0.3F);
      shown.colors.values.rowwise() += natural;
      shown.colors.count.assign(static_cast<std::size_t>(shown.points.cols()), 3);
      meter.add(shown);
    }
    EXPECT_GT(meter.numBorderCells(), 20U);
    EXPECT_LE(meter.excess(), step + 1) << meter.numBorderCells();
    EXPECT_GE(meter.excess(), step - 1.5F) << meter.numBorderCells();
  }
}

TEST_F(Report, ConditionsAskForItsNumbers) {
  const json report = write();
  EXPECT_TRUE(holds("map.points>1599", report));
  EXPECT_FALSE(holds("map.points<1600", report));
  EXPECT_EQ(holds("map.colored_share<0.9", report), run_.summary.num_colored < 1440);
  for (const char* bad : {"map.points", "map.nothing<1", "map<1", "name<1", "map.points<x", "<1"}) {
    EXPECT_THROW(holds(bad, report), std::invalid_argument) << bad;
  }
}

TEST_F(Report, TheMapIsThinnedToAsManyPointsAsAreAskedFor) {
  const Recording recording = Recording::open(scratch_ / "drive");
  const MapSample sample = sampleMap(recording, params_, 1600, 500, {});
  EXPECT_EQ(sample.size(), 400U);
  EXPECT_EQ(sample.intensity.size(), 400U);
  std::string base64;
  EXPECT_EQ(packSample(sample, base64)["count"], 400);
  EXPECT_EQ(base64.size(), (400U * 19 + 2) / 3 * 4);
}

TEST(Base64, IsThatOfOthers) {
  const auto of = [](const std::string& text) {
    return base64Of(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("M"), "TQ==");
  EXPECT_EQ(of("Ma"), "TWE=");
  EXPECT_EQ(of("Man"), "TWFu");
}

}  // namespace
}  // namespace cloud_colorizer
