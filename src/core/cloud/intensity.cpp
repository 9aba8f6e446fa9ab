// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/intensity.hpp"

namespace cloud_colorizer {

std::optional<LocatedField> findIntensity(const std::vector<Field>& fields) {
  for (const char* name : {"intensity", "Intensity", "scalar_Intensity", "scalar_intensity", "reflectivity",
                           "Reflectivity", "scalar_Reflectivity", "i"}) {
    if (auto field = findField(fields, name)) return field;
  }
  return std::nullopt;
}

}  // namespace cloud_colorizer
