// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Bags as a command line names them, into a recording.
#pragma once

#include <string>
#include <vector>

#include "apps/command_line.hpp"
#include "cloud_colorizer/ros/collector.hpp"

namespace cloud_colorizer {

extern const OptionSpec kConfigOption, kPosesOption, kPosesFrameOption;

/// Records the bags in a directory, by --config and the collector's parameters of the line (CommandLine::others).
/// `events.log` is set. Throws UsageError on a parameter that is unknown or refused; what BagSource throws.
void recordBags(const CommandLine& line, const std::vector<std::string>& bags, const std::string& directory,
                CollectorEvents events, const Callbacks& callbacks);

}  // namespace cloud_colorizer
