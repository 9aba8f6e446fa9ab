// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// evaluate city: a map of what `simulate city` wrote, block by block, so that its size does not matter.
#include <iostream>
#include <optional>

#include "apps/command_line.hpp"
#include "apps/evaluate_commands.hpp"
#include "base/progress.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "evaluation/city.hpp"
#include "evaluation/table.hpp"

namespace cloud_colorizer {

int runCity(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "evaluate city";
  spec.summary =
      "Scores a map of what `simulate city` wrote, of any size: visible and hidden points coloured, errors, and the "
      "steps at the borders of chunks.";
  spec.positionals = "RESULT";
  spec.min_positionals = spec.max_positionals = 1;
  spec.options = {
      {"cloud", "FILE", "the city's cloud.ply, where RESULT has the same points without their other fields"},
      {"recording", "DIR", "of the map, for the steps at borders; with the parameters of the colouring"}};
  return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
    constexpr std::size_t kBlock = 1000000;  // points
    const std::string& file = line.positionals[0];
    CloudReader reader(file);
    std::optional<CloudReader> truth;
    if (line.has("cloud")) truth.emplace(line.option("cloud"));
    CityScore score(truth ? truth->fields() : reader.fields(), truth ? line.option("cloud") : file, reader.numPoints(),
                    file);
    std::optional<CitySeams> seams;
    if (line.has("recording")) seams.emplace(Recording::open(line.option("recording")), line.params.chunks);
    ProgressMeter progress(callbacks, "score", reader.numPoints());
    for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
      score.add(block, truth ? truth->read(kBlock) : block, seams ? &*seams : nullptr);
      progress.add(static_cast<std::size_t>(block.positions.cols()));
    }
    std::cout << score.describe() << "\n";
    if (!seams) return;
    const CitySeams::Steps steps = seams->steps();
    std::cout << "steps of the error at borders of chunks: " << formatNumber(steps.at_borders, 3)
              << ", beside them: " << formatNumber(steps.beside, 3) << "\n";
  });
}

}  // namespace cloud_colorizer
