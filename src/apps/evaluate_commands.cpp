// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/evaluate_commands.hpp"

#include <algorithm>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "apps/command_line.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "evaluation/appearance.hpp"
#include "evaluation/clouds.hpp"
#include "evaluation/heldout.hpp"
#include "evaluation/quantities.hpp"
#include "evaluation/score.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

/// As a CSV file, and on the screen.
void save(const ResultTable& table, const std::string& directory, const std::string& name) {
  if (table.rows.empty()) return;
  writeText(directory + "/" + name + ".csv", csv(table));
  std::cout << markdown(table) << std::flush;
}

const std::vector<OptionSpec> kBedOptions = {
    {"meshes", "DIR", "meshes (*.ply with faces); without it, built-in shapes"},
    {"output", "DIR", "where the CSV files and pictures go", true},
    {"quick", "", "65,000 points, the first mesh, two sizes, short limits"},
    {"points", "N", "points on a mesh (300000)"},
    {"views", "N", "images around it (48)"},
    {"rotation", "DEG", "noise of the poses about each axis (0.15)"},
    {"centre", "SHARE", "noise of the camera centres, of the diameter (0.002)"},
    {"gain", "SHARE", "noise of the brightness of a view (0.1)"},
    {"pixel", "SIGMA", "noise of a pixel, of 255 (5)"},
    {"seed", "N", "of points and noise (1)"},
    {"sizes", "N,N,...", "numbers of points of table 2 (65000,...,5980000)"},
    {"time-limit", "S", "processor time of one row (60; with --quick 20)"},
    {"memory-limit", "MB", "memory of one row (8000)"}};

TablesParams tablesParams(const CommandLine& line) {
  TablesParams params = line.has("quick") ? TablesParams::quick() : TablesParams{};
  params.method = line.params;
  params.bed.num_points = line.value("points", params.bed.num_points);
  params.bed.num_views = line.value("views", params.bed.num_views);
  params.bed.seed = line.value("seed", params.bed.seed);
  params.bed.num_threads = line.params.colorize.num_threads;
  params.noise.rotation = line.value("rotation", params.noise.rotation);
  params.noise.centre = line.value("centre", params.noise.centre);
  params.noise.gain = line.value("gain", params.noise.gain);
  params.noise.pixel = line.value("pixel", params.noise.pixel);
  params.limits.seconds = line.value("time-limit", params.limits.seconds);
  params.limits.megabytes = line.value("memory-limit", params.limits.megabytes);
  if (line.has("sizes")) params.table2_sizes = line.list<std::size_t>("sizes", "", ',', 0);
  for (const std::size_t size : params.table2_sizes) require<UsageError>(size > 0, "option --sizes holds a 0");
  params.bed.check();
  params.noise.check();
  return params;
}

std::vector<Mesh> meshesOf(const CommandLine& line) {
  std::vector<Mesh> meshes = loadMeshes(line.option("meshes"));
  if (line.has("quick")) meshes.resize(1);
  return meshes;
}

std::set<std::string> partsOption(const CommandLine& line) {
  const std::vector<std::string> all = {"table1", "table2", "isolated", "density"};
  std::set<std::string> parts(all.begin(), all.end());
  if (!line.has("only")) return parts;
  parts.clear();
  for (const auto& part : line.list<std::string>("only", "", ',', 0)) {
    require<UsageError>(std::count(all.begin(), all.end(), part) > 0, "option --only knows ", join(all, ", "),
                        ", not '", part, "'");
    parts.insert(part);
  }
  return parts;
}

Eigen::Matrix3Xf relative(const Eigen::Matrix3Xd& positions, const Eigen::Vector3d& origin) {
  return (positions.colwise() - origin).cast<float>();
}

}  // namespace

int runTables(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate tables";
  spec.summary =
      "The paper's tables 1 and 2 with all their rows, and its figure 4, as CSV and PNG. Of these scripts/report.py "
      "makes plots, Markdown and the bars they must meet.";
  spec.options = kBedOptions;
  spec.options.push_back({"only", "PARTS", "of table1,table2,isolated,density; the others stay as they are"});
  return runMain(argc, argv, spec, [&](const CommandLine& line, const Callbacks& callbacks) {
    const TablesParams params = tablesParams(line);
    const std::vector<Mesh> meshes = meshesOf(line);
    const std::string output = line.option("output");
    makeDirectory(output);
    const std::set<std::string> parts = partsOption(line);
    // Table 2 first: its processes measure memory, and inherit what this one has in use.
    if (parts.count("table2") != 0) save(makeTable2(meshes.front(), params, callbacks), output, "table2");
    if (parts.count("isolated") != 0) save(makeIsolated(meshes.front(), params, callbacks), output, "isolated");
    if (parts.count("density") != 0) save(makeDensity(meshes, params, callbacks), output, "density");
    if (parts.count("table1") == 0) return;
    const Table1 table1 = makeTable1(meshes, params, callbacks);
    save(table1.table, output, "table1");
    require(cv::imwrite(output + "/closeups.png", table1.closeup), "cannot write ", output, "/closeups.png");
  });
}

int runAblations(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate ablations";
  spec.summary = "What matters: the paper's method on the first mesh, one parameter at a time.";
  spec.options = kBedOptions;
  return runMain(argc, argv, spec, [&](const CommandLine& line, const Callbacks& callbacks) {
    makeDirectory(line.option("output"));
    const ResultTable table = makeAblations(meshesOf(line).front(), tablesParams(line), callbacks);
    save(table, line.option("output"), "ablations");
  });
}

int runHeldout(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate heldout";
  spec.summary = "Leaves every n-th view out, colours the map by each method, and predicts the images left out.";
  spec.positionals = "RECORDING";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {{"every", "N", "of the views of a camera, every n-th is left out (8)"},
                  {"moved", "ERROR", "of 255; beyond it a point moved or reflects (60)"},
                  {"output", "DIR", "tables and pictures; a working copy of the recording by links", true}};
  return runMain(argc, argv, spec, [&](const CommandLine& line, const Callbacks& callbacks) {
    HeldoutParams params;
    params.every = line.value("every", params.every);
    params.moved_error = line.value("moved", params.moved_error);
    params.params = line.params;
    const std::string output = line.option("output");
    makeDirectory(output);
    const Recording recording = Recording::open(line.positionals[0]);
    params.params.depth.max_view_distance = line.params.depth.reach(recording.maxRange());
    const HeldoutResult result = scoreHeldout(recording, params, output, callbacks);
    writeText(output + "/heldout_views.csv", csv(result.views));
    save(result.methods, output, "heldout");
  });
}

int runAppearance(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate appearance";
  spec.summary =
      "How well sheen is told from colours, on a ball with known colours, half of it glossy: mean errors of views "
      "that\n"
      "were left out, on glossy and matte points, and of the colours without sheen.";
  spec.takes_params = false;
  spec.options = {{"output", "DIR", "gets appearance.csv", true}, {"points", "N", "of the ball (40000)"}};
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks&) {
    makeDirectory(line.option("output"));
    save(makeAppearanceTable(line.value("points", 40000)), line.option("output"), "appearance");
  });
}

int runScore(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate score";
  spec.summary =
      "Compares two coloured clouds: each point of the truth with the nearest one of the result. Other quantities "
      "that\n"
      "both have (temperature, label) get a line each.";
  spec.takes_params = false;
  spec.options = {{"truth", "FILE", "coloured cloud, .ply, .pcd or .las", true},
                  {"result", "FILE", "coloured cloud; points with view_count 0 do not count", true},
                  {"max-distance", "M", "of points that are compared (0.1)"}};
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    const auto read = [&](const std::string& path) {
      ColoredCloud cloud = readColoredCloud(path);
      if (!cloud.note.empty()) callbacks.log(LogLevel::kInfo, path + ": " + cloud.note);
      return cloud;
    };
    const ColoredCloud truth = read(line.option("truth")), result = read(line.option("result"));
    const Eigen::Vector3d origin = truth.positions.col(0);  // float has half-metre steps at UTM coordinates
    const Score score = scoreClouds(relative(truth.positions, origin), truth.colors, relative(result.positions, origin),
                                    result.colors, line.value("max-distance", 0.1));
    std::cout << score.describe() << "\n";
    const auto whole = [&](const char* option) {
      CloudReader reader(line.option(option));
      return reader.read(reader.numPoints());
    };
    for (const QuantityScore& of : scoreQuantities(whole("truth"), whole("result"), line.value("max-distance", 0.1))) {
      std::cout << of.describe() << "\n";
    }
  });
}

}  // namespace cloud_colorizer
