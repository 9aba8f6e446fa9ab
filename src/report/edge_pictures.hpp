// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Images with the depth edges of the map drawn over them: whether the map lies where the images show it.
#pragma once

#include <nlohmann/json.hpp>

#include "map/workspace.hpp"

namespace cloud_colorizer {

/// Of each camera, up to six, the views that the alignment moved least and most, or one from the middle of the drive
/// where nothing was aligned: [{"camera", "view", "which", "pixels", "before", "after"}], the pictures as data:
/// addresses, "before" only where the pose was corrected. `views`: of the alignment, {"rows": ...}, or null.
nlohmann::json edgePictures(Workspace& work, const nlohmann::json& views, const Callbacks& callbacks);

}  // namespace cloud_colorizer
