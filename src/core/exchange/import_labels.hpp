// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Images of classes that belong to the photos of a model.
#pragma once

#include <vector>

#include "exchange/photos.hpp"

namespace cloud_colorizer {

/// After the views of the photos, one view for each photo that has such an image, at the same place and time. Throws
/// std::runtime_error where no photo has one, and where one is no image of classes.
void importLabels(const ModelFiles& files, const ColmapModel& model, const std::vector<Photo>& photos,
                  Recorder& recorder, const Callbacks& callbacks);

}  // namespace cloud_colorizer
