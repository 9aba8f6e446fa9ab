// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Texts that tell what derived files were made from. Files with another text beside them are out of date.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "map/derived_files.hpp"

namespace cloud_colorizer {

/// Whether the parameters ask for what moved, and the recording has scans that tell it.
bool findsMoving(const Recording& recording, const Params& params);

/// A short name for what is made from a key.
std::string shortName(const std::string& key);

// What the files in each folder were made from. `damaged`: the views that are left out; `views`: how each is used.
std::string imageFilesKey(const Recording& recording);
std::string movingKey(const Recording& recording, const Params& params);
std::string surfelsKey(const Recording& recording, const Params& params);
std::string alignmentKey(const Recording& recording, const Params& params, const ViewList& damaged);
std::string depthKey(const Recording& recording, const Params& params, const std::vector<CorrectedView>& views);
std::string colorsKey(const Recording& recording, const Params& params, const ViewList& damaged,
                      const std::vector<CorrectedView>& views);

}  // namespace cloud_colorizer
