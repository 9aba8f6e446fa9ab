// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The numbers of the report, and what they say about the map.
#pragma once

#include <nlohmann/json.hpp>

#include "report/map_sample.hpp"
#include "report/report.hpp"

namespace cloud_colorizer {

/// All of report.json but its lights.
nlohmann::json collectFacts(const Recording& recording, const Params& params, const RunFacts& run,
                            const MapSample& sample);

/// One light for each question that a user has: {"name", "state": green, yellow, red or grey, "value", "thresholds",
/// "meaning", "remedy"}. Grey where the run cannot tell.
nlohmann::json lightsOf(const nlohmann::json& facts);

}  // namespace cloud_colorizer
