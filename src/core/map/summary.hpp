// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What a coloured map is like.
#pragma once

#include "cloud_colorizer/map/colorize.hpp"
#include "map/workspace.hpp"

namespace cloud_colorizer {

/// Counts the coloured points and why the others are not.
ColorizeSummary summarize(const Workspace& work);

}  // namespace cloud_colorizer
