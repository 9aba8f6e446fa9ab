// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How well are appearances that depend on the view told from colours?
#pragma once

#include "evaluation/table.hpp"

namespace cloud_colorizer {

/// A sphere, half of it glossy (Blinn and Phong), the other half matte, with texture and a known light: seen from all
/// around, and by a camera that drives by. By the exponent: mean errors of views that were left out, on glossy and on
/// matte points, and of the colours without sheen, for each kind of appearance; microseconds a point.
ResultTable makeAppearanceTable(int num_points);

}  // namespace cloud_colorizer
