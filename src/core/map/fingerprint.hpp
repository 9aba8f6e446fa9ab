// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Texts that tell what derived files were made from. Files with another text beside them are out of date.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"

namespace cloud_colorizer {

std::string surfelsKey(const Recording& recording, const Params& params);
std::string alignmentKey(const Recording& recording, const Params& params);
std::string depthKey(const Recording& recording, const Params& params);
std::string colorsKey(const Recording& recording, const Params& params);
std::string posesKey(const std::vector<CorrectedView>& views);
std::string exposuresKey(const std::vector<CorrectedView>& views);

}  // namespace cloud_colorizer
