// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// A colouring in parts, which several programs do at the same time, on one machine or on several with a common disk.
/// Stage after stage, every part of a stage in any order; then mergeParts(). The bytes are those of one colorize().
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/colorize.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {

/// The i-th of n, from 1 on.
struct Part {
  std::size_t index = 1, count = 1;
};

/// "2/8". Throws std::invalid_argument.
Part parsePart(const std::string& text);

/// The units of a part: neighbours, with about as much to do as those of any other part; none where there are more
/// parts than units.
UnitRange unitsOfPart(const std::vector<double>& units, Part part);

struct PlannedStage {
  std::string name, unit;
  std::vector<std::string> after;  ///< stages that must be whole before
  std::size_t num_units = 0, num_done = 0;
  double work = 0;  ///< points or views, of all units
};

/// Those that the parameters ask for, in their order, without the last one, which saves the map. Damaged images that
/// nobody has looked for yet count as whole. Waits while a program works on the recording alone.
std::vector<PlannedStage> planStages(const Recording& recording, const Params& params, const Callbacks& callbacks);

/// What is done already is not done again. Throws std::invalid_argument on an unknown stage, and std::runtime_error
/// where a stage before it is not whole.
void runPart(const Recording& recording, const Params& params, const std::string& stage, Part part,
             const Callbacks& callbacks);

/// After all parts of all stages. Throws std::runtime_error where something is not done.
ColorizeSummary mergeParts(const Recording& recording, const Params& params, const Callbacks& callbacks);

/// Throws where there is nothing to colour, or nothing to colour it from.
void requireColorable(const Recording& recording);

}  // namespace cloud_colorizer
