// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tells whether a coloured map is good.

#include <filesystem>

#include "apps/color_and_save.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/map/colorize.hpp"

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  CommandSpec spec;
  spec.program = "report";
  spec.summary =
      "Makes the report of a recording: of its colours with these parameters, which are made first where they are not.";
  spec.positionals = "RECORDING";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {{"output", "DIR", "report.html, to look at in a browser, and report.json", true},
                  {"points", "N", "of the map in the page, up to 2000000; without it 400000", false},
                  kFailIfOption};
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    const Recording recording = Recording::open(line.positionals[0]);
    RunFacts run;
    const int points = line.value<int>("points", static_cast<int>(run.max_points));
    require<UsageError>(points >= 1 && points <= 2'000'000, "option --points = ", points, " must be from 1 to 2000000");
    run.max_points = static_cast<std::size_t>(points);
    const auto path = std::filesystem::absolute(recording.directory()).lexically_normal();
    run.name = (path.has_filename() ? path : path.parent_path()).filename().string();  // "drive/" as well
    run.summary = colorize(recording, line.params, callbacks);
    saveReport(recording, line, line.option("output"), run, callbacks);
    requireColored(run.summary);
  });
}
