// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// evaluate visibility: a coloured map of the simulated street against the exact scene.
#include <algorithm>
#include <array>
#include <iostream>

#include "apps/command_line.hpp"
#include "apps/evaluate_commands.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "evaluation/clouds.hpp"
#include "evaluation/score.hpp"
#include "evaluation/table.hpp"
#include "simulation/street.hpp"
#include "simulation/truth.hpp"

namespace cloud_colorizer {
namespace {

/// The drive's views as they were really taken, for those that the recording kept.
std::vector<simulation::TrueView> trueViews(const simulation::Drive& drive, const Recording& recording) {
  std::vector<simulation::TrueView> views;
  for (const View& view : recording.views()) {
    if (recording.cameras()[view.camera].quantity.kind != ImageKind::kColor) continue;
    const std::string& name = recording.cameras()[view.camera].name;
    const auto& cameras = drive.cameras();
    const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const auto& c) { return c.name == name; });
    require(found != cameras.end(), "the drive has no camera '", name, "' of the recording");
    views.push_back(trueViewOfStamp(drive, static_cast<int>(found - cameras.begin()), view.stamp));
  }
  return views;
}

struct Counts {
  std::size_t visible = 0, visible_colored = 0, hidden = 0, hidden_colored = 0, other = 0;

  void add(const Counts& more) {
    visible += more.visible;
    visible_colored += more.visible_colored;
    hidden += more.hidden;
    hidden_colored += more.hidden_colored;
    other += more.other;
  }
};

/// Points by how far the map has them from the true surface: [0, 1), [1, 2), [2, 4), [4, 8) cm and beyond.
constexpr std::array<double, 4> kOffSurface = {0.01, 0.02, 0.04, 0.08};  // m
using CountsOffSurface = std::array<Counts, kOffSurface.size() + 1>;

Counts& countsAt(CountsOffSurface& counts, double distance) {
  return counts[static_cast<std::size_t>(std::upper_bound(kOffSurface.begin(), kOffSurface.end(), distance) -
                                         kOffSurface.begin())];
}

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

void reportOffSurface(const CountsOffSurface& counts) {
  std::cout << "by the distance from the true surface:";
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const Counts& of = counts[k];
    std::cout << (k == 0 ? " " : "; ") << (k < kOffSurface.size() ? "below " : "beyond ")
              << formatNumber(100 * kOffSurface[std::min(k, kOffSurface.size() - 1)], 0) << " cm "
              << formatNumber(percent(of.visible_colored, of.visible), 1) << " % of " << of.visible << " visible, "
              << formatNumber(percent(of.hidden_colored, of.hidden), 1) << " % of " << of.hidden << " hidden";
  }
  std::cout << "\n";
}

void report(const ColoredCloud& map, const std::vector<simulation::PointTruth>& truth) {
  CountsOffSurface off_surface;
  Values true_colors(3, map.colors.cols());
  std::vector<std::uint8_t> compared(truth.size(), 0);
  for (std::size_t p = 0; p < truth.size(); ++p) {
    const bool colored = map.count[p] > 0;
    Counts& counts = countsAt(off_surface, static_cast<double>(truth[p].surface_distance));
    true_colors.col(static_cast<Eigen::Index>(p)) = truth[p].color.matrix();
    if (truth[p].truth == simulation::Truth::kVisible) {
      ++counts.visible;
      counts.visible_colored += colored ? 1 : 0;
      compared[p] = colored ? 1 : 0;
    } else if (truth[p].truth == simulation::Truth::kHidden && !truth[p].is_near_edge) {
      ++counts.hidden;
      counts.hidden_colored += colored ? 1 : 0;
    } else {
      ++counts.other;
    }
  }
  Counts all;
  for (const Counts& counts : off_surface) all.add(counts);
  reportOffSurface(off_surface);
  std::cout << "truly visible points: " << all.visible << ", coloured "
            << formatNumber(percent(all.visible_colored, all.visible), 2) << " %\n"
            << "truly hidden points: " << all.hidden << ", coloured "
            << formatNumber(percent(all.hidden_colored, all.hidden), 2) << " %\n"
            << "others (out of view, near an edge, no surface): " << all.other << "\n"
            << "colours of visible points: " << scoreColors(true_colors, map.colors, compared).describe() << "\n";
}

}  // namespace

int runVisibility(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate visibility";
  spec.summary =
      "How many truly visible points of the simulated street have a colour, how many hidden ones, and how "
      "good the colours are.";
  spec.positionals = "RECORDING";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {{"scene", "FILE", "scene.yaml of `simulate`", true},
                  {"map", "FILE", "the coloured map of that recording, with all its points", true}};
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks&) {
    const simulation::Drive drive(simulation::readSceneFile(line.option("scene")));
    const Recording recording = Recording::open(line.positionals[0]);
    CloudReader reader(line.option("map"));
    const ColoredCloud map = coloredCloud(reader.read(reader.numPoints()), line.option("map"));
    simulation::TruthOptions options;
    options.max_view_distance = line.params.depth.reach(recording.maxRange());
    options.num_threads = line.params.colorize.num_threads;
    const simulation::Scene scene = makeStreet(simulation::streetOf(drive.options()));
    report(map, trueVisibility(scene, map.positions, trueViews(drive, recording), options));
  });
}

}  // namespace cloud_colorizer
