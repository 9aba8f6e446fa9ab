// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/parts.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <set>

#include "base/param_text.hpp"
#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "map/summary.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;

std::set<std::string> namesIn(const std::string& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    names.insert(it->path().filename().string());
  }
  return names;
}

/// Units whose files are there.
std::size_t countDone(const Stage& stage, const Workspace& work) {
  if (!work.files().holds(stage.folder, stage.key(work))) return 0;
  const std::set<std::string> present = namesIn(work.files().pathOf(stage.folder));
  const auto files = stage.files(work);
  return static_cast<std::size_t>(std::count_if(files.begin(), files.end(), [&](const auto& names) {
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) { return present.count(name) != 0; });
  }));
}

const Stage& stageNamed(const std::string& name) {
  const std::vector<Stage>& stages = allStages();
  const auto found = std::find_if(stages.begin(), stages.end(), [&](const Stage& s) { return name == s.name; });
  if (found != stages.end()) return *found;
  std::string known;
  for (const Stage& stage : stages) known += std::string(stage.name) + ", ";
  throw std::invalid_argument("unknown stage '" + name + "'; known are " + known + "merge");
}

bool isAmong(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Takes over what the stages of these names found.
void useStages(Workspace& work, const std::vector<std::string>& names, const Callbacks& callbacks) {
  for (const Stage& stage : allStages()) {
    if (!isAmong(names, stage.name)) continue;
    const std::size_t num_units = stage.units(work).size();
    const std::size_t num_done = num_units == 0 ? 0 : countDone(stage, work);
    require(num_done == num_units, "of the stage ", stage.name, ", ", num_units - num_done, " of ", num_units,
            " units are not done with these parameters; first: colorize ", work.recording().directory(), " --stage ",
            stage.name);
    if (num_units > 0 && stage.handOn) stage.handOn(work, callbacks);
  }
}

std::vector<std::string> common(const std::vector<std::string>& names, const std::vector<std::string>& others) {
  std::vector<std::string> both;
  std::copy_if(names.begin(), names.end(), std::back_inserter(both),
               [&](const std::string& name) { return isAmong(others, name); });
  return both;
}

std::vector<std::string> namesOf(const std::vector<Stage>& stages) {
  std::vector<std::string> names(stages.size());
  std::transform(stages.begin(), stages.end(), names.begin(), [](const Stage& stage) { return stage.name; });
  return names;
}

Callbacks withoutLog(Callbacks callbacks) {
  callbacks.log = {};
  return callbacks;
}

}  // namespace

Part parsePart(const std::string& text) {
  const std::size_t slash = text.find('/');
  Part part{0, 0};
  try {
    if (slash != std::string::npos) {
      part = {parseValue<std::size_t>("part", text.substr(0, slash)),
              parseValue<std::size_t>("part", text.substr(slash + 1))};
    }
  } catch (const std::invalid_argument&) {
    part = {0, 0};
  }
  require<std::invalid_argument>(part.index >= 1 && part.index <= part.count, "part '", text,
                                 "' must be i/n with i from 1 to n, such as 2/8");
  return part;
}

UnitRange unitsOfPart(const std::vector<double>& units, Part part) {
  const double all = std::accumulate(units.begin(), units.end(), 0.0);
  const auto count = static_cast<double>(part.count);
  // A unit belongs to the part that its middle falls into.
  const auto before = [&](std::size_t index) {
    const double border = all * static_cast<double>(index) / count;
    double sum = 0;
    std::size_t unit = 0;
    while (unit < units.size() && (index == part.count || sum + units[unit] / 2 < border)) sum += units[unit++];
    return unit;
  };
  return {before(part.index - 1), before(part.index)};
}

std::vector<PlannedStage> planStages(const Recording& recording, const Params& params, const Callbacks& callbacks) {
  params.check();
  requireColorable(recording);
  const FolderLock lock(recording.directory(), false, callbacks);
  Workspace work(recording, params);
  std::vector<PlannedStage> plan;
  std::vector<std::string> asked, whole;
  for (const Stage& stage : allStages()) {
    const std::vector<double> units = stage.units(work);
    if (units.empty()) continue;
    const std::vector<std::string> after = common(stage.after, asked);
    asked.emplace_back(stage.name);
    // Of what follows on something unfinished, not even the key is known.
    const std::size_t num_done = common(after, whole).size() == after.size() ? countDone(stage, work) : 0;
    plan.push_back(
        {stage.name, stage.unit, after, units.size(), num_done, std::accumulate(units.begin(), units.end(), 0.0)});
    if (num_done < units.size()) continue;
    whole.emplace_back(stage.name);
    if (stage.handOn) stage.handOn(work, {});
  }
  return plan;
}

void runPart(const Recording& recording, const Params& params, const std::string& name, Part part,
             const Callbacks& callbacks) {
  params.check();
  requireColorable(recording);
  const Stage& stage = stageNamed(name);
  for (;;) {
    {
      const FolderLock lock(recording.directory(), false, callbacks);
      Workspace work(recording, params);
      useStages(work, stage.after, withoutLog(callbacks));
      const std::vector<double> units = stage.units(work);
      if (units.empty()) return;
      if (work.files().holds(stage.folder, stage.key(work))) {
        stage.run(work, unitsOfPart(units, part), callbacks);
        return;
      }
    }
    // The first part of a stage empties its folder. Then it looks again: a program of other parameters may be quicker.
    const FolderLock lock(recording.directory(), true, callbacks);
    Workspace work(recording, params);
    useStages(work, stage.after, withoutLog(callbacks));
    work.files().claim(stage.folder, stage.key(work));
  }
}

ColorizeSummary mergeParts(const Recording& recording, const Params& params, const Callbacks& callbacks) {
  StopWatch watch;
  params.check();
  requireColorable(recording);
  const FolderLock lock(recording.directory(), true, callbacks);
  std::error_code ignored;
  fs::remove_all(DecodedImages::folderOf(recording), ignored);
  Workspace work(recording, params, true);
  useStages(work, namesOf(allStages()), callbacks);
  ColorizeSummary summary = summarize(work);
  summary.seconds = watch.lap();
  return summary;
}

}  // namespace cloud_colorizer
