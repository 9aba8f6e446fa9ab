// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What the programs that colour a recording share: --output, --tiles, --write-model, --splats and --report.
#pragma once

#include <string>
#include <vector>

#include "apps/command_line.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "report/report.hpp"

namespace cloud_colorizer {

extern const OptionSpec kWriteModelOption, kFailIfOption;

/// --tiles, --write-model, --undistort, --splats, --report and --fail-if.
void addOutputOptions(CommandSpec& spec);

/// Before the work, so that a path that cannot be written is told then and not after it. Makes the folders.
void checkOutputs(const CommandLine& line);

using Colorizer = ColorizeSummary(const Recording&, const Params&, const Callbacks&);

/// Colours the recording and writes what the options ask for. `image_names`: see exportModel(); `colorizer`: what
/// colours it, or takes what was coloured in parts.
ColorizeSummary colorAndSave(const Recording& recording, const CommandLine& line, const Callbacks& callbacks,
                             const std::vector<std::string>& image_names = {}, Colorizer& colorizer = colorize);

/// Writes the report of a coloured map, and asks it what --fail-if names. Throws ConditionHolds, or UsageError.
void saveReport(const Recording& recording, const CommandLine& line, const std::string& directory, RunFacts run,
                const Callbacks& callbacks);

/// The last word of a program: throws NothingColored, with the main reason and its remedy, when less than a hundredth
/// of the points could be coloured, or the views contradict each other too much for any colour to be right.
void requireColored(const ColorizeSummary& summary);

}  // namespace cloud_colorizer
