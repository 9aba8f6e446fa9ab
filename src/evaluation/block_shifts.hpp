// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// How far an image still lies from the map, block by block: what neither its pose nor its camera explains.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "evaluation/heldout_errors.hpp"

namespace cloud_colorizer {

struct BlockShift {
  float pixels = 0;  ///< px, length of the shift
  float error = 0;   ///< px, standard error of the shift, an axis
};

/// Of blocks of an eighth of the image's width that hold enough texture to tell: the shift by which the image, with a
/// gain and an offset of the block, shows best what the map has there. Gauss-Newton on grey levels with Huber weights;
/// blocks whose shift is uncertain by more than a third of a pixel, or leads beyond 8 px, are left out.
std::vector<BlockShift> blockShifts(const ColoredMap& map, const SeenImage& seen, const cv::Mat3b& image);

}  // namespace cloud_colorizer
