// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colorize RECORDING --output map.ply [name=value ...], or in parts, on as many machines as there are:
/// colorize RECORDING --stage surfels --part 1/8
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/color_and_save.hpp"
#include "map/parts.hpp"

namespace cloud_colorizer {
namespace {

constexpr const char* kMerge = "merge";

/// The stages as JSON, for whoever spreads them.
std::string describePlan(const Recording& recording, const Params& params, const Callbacks& callbacks) {
  nlohmann::ordered_json stages = nlohmann::json::array();
  std::vector<std::string> all;
  for (const PlannedStage& stage : planStages(recording, params, callbacks)) {
    stages.push_back({{"name", stage.name},
                      {"unit", stage.unit},
                      {"units", stage.num_units},
                      {"done", stage.num_done},
                      {"work", stage.work},
                      {"after", stage.after}});
    all.push_back(stage.name);
  }
  stages.push_back(
      {{"name", kMerge}, {"unit", "map"}, {"units", 1}, {"done", 0}, {"work", recording.numPoints()}, {"after", all}});
  const nlohmann::ordered_json plan = {{"points", recording.numPoints()},
                                       {"tiles", recording.tiles().size()},
                                       {"views", recording.views().size()},
                                       {"stages", stages}};
  return plan.dump(2);
}

void checkOptions(const CommandLine& line) {
  const bool plans = line.has("plan"), in_parts = line.has("stage");
  const bool saves = !plans && (!in_parts || line.option("stage") == kMerge);
  require<UsageError>(!plans || !in_parts, "--plan and --stage are not given together");
  require<UsageError>(in_parts || !line.has("part"), "--part needs --stage");
  require<UsageError>(!saves || line.has("output"), "--output FILE is missing (the coloured map, .ply, .pcd or .las)");
  if (saves) checkOutputs(line);
}

void run(const CommandLine& line, const Callbacks& callbacks) {
  checkOptions(line);
  const Recording recording = Recording::open(line.positionals[0]);
  const std::string stage = line.option("stage");
  if (line.has("plan")) {
    std::cout << describePlan(recording, line.params, callbacks) << std::endl;
  } else if (stage.empty() || stage == kMerge) {
    requireColored(colorAndSave(recording, line, callbacks, {}, stage.empty() ? colorize : mergeParts));
  } else {
    try {
      runPart(recording, line.params, stage, parsePart(line.option("part", "1/1")), callbacks);
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
  }
}

}  // namespace
}  // namespace cloud_colorizer

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  CommandSpec spec;
  spec.program = "colorize";
  spec.summary =
      "Colours a recording and saves the map. What an interrupted run finished is used again. With --stage, a part of "
      "the "
      "work, for programs that spread it: all parts of each stage of --plan, and then --stage merge --output FILE.";
  spec.positionals = "RECORDING";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {{"output", "FILE", "the coloured map, .ply, .pcd or .las; needed but with --plan and --stage", false},
                  {"plan", "", "print the stages and their units as JSON, and colour nothing", false},
                  {"stage", "NAME", "do this stage only", false},
                  {"part", "I/N", "with --stage: the I-th of N parts of its units, from 1 to N", false}};
  addOutputOptions(spec);
  return runMain(argc, argv, spec, run);
}
