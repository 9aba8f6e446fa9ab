// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Fills a recording from files: a cloud, a folder of images and a COLMAP model.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/recording/recorder.hpp"

namespace cloud_colorizer {

struct ModelFiles {
  std::string cloud;       ///< .ply, .pcd or .las
  std::string images;      ///< folder
  std::string model;       ///< folder of a COLMAP model, see readColmapModel()
  std::string masks;       ///< folder of images that are black where NAME.png masks the image NAME; empty: none
  Quantity quantity = {};  ///< that the images show
  std::string labels =
      {};  ///< folder of images of classes, NAME.png or NAME.npy (scores) of the image NAME; empty: none
  std::string names = {};  ///< file that tells what the classes are; empty: none
};

/// Makes the recording in `directory`, which must not hold one already. `voxel_size` thins as usual; ranges do not
/// apply, since nobody knows where the points were measured from. A `tile_size` of 0 is chosen from the extent of the
/// cloud. Images that are larger or smaller than their camera by one factor get scaled intrinsics; what is transparent
/// in them colours nothing. Throws std::runtime_error: missing files or folders, an image of another shape than its
/// camera's, an empty cloud. A panorama (EQUIRECTANGULAR) becomes six views, the faces of a cube.
Recording importModel(const ModelFiles& files, const std::string& directory, const RecordParams& params,
                      const Callbacks& callbacks);

/// Of the views that importModel() makes of a model: those of its images, or of panoramas "NAME_front.png" and so on.
std::vector<std::string> namesOfViews(const ColmapModel& model);

}  // namespace cloud_colorizer
