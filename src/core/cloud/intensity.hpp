// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Which field of a cloud is the intensity of its returns.
#pragma once

#include <optional>
#include <vector>

#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// Under the names that drivers, CloudCompare and PDAL give it.
std::optional<LocatedField> findIntensity(const std::vector<Field>& fields);

}  // namespace cloud_colorizer
