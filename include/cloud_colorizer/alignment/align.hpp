// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Alignment: exposure and camera poses, estimated from a sample of the map and the images themselves.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/camera/camera.hpp"
#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"

namespace cloud_colorizer {

/// Whose poses are corrected: none, each camera's on its vehicle, or each view's as well.
enum class AlignPoses { kNone, kCameras, kViews };

/// Priors are standard deviations of expected errors; the larger a correction, the more the images must gain by it.
struct AlignmentParams {
  bool align_exposure = true;  ///< a gain for every view and channel
  /// And a darkening outwards for every camera. Not by default: to a camera that drives ahead, points move outwards as
  /// they come near, and their sheen looks like it.
  bool align_vignetting = false;
  AlignPoses align_poses = AlignPoses::kViews;
  bool align_time_offset = false;         ///< apply the time offset of each camera, not only report it
  bool align_to_intensity = true;         ///< tie the images to the LiDAR intensity where the cloud has it
  int alignment_points = 10000;           ///< sample points that one view uses at most
  double pose_rotation_prior = 0.15;      ///< deg an axis, of one view; of its place: as many pixels
  double extrinsic_rotation_prior = 0.2;  ///< deg an axis, of a camera on its vehicle; of its place: as many pixels
  double time_offset_prior = 0.05;        ///< s, of a camera's clock

  void check() const;
  /// Sample points that each view uses at most: alignment_points, fewer of very many views to bound the memory.
  std::size_t pointsPerView(std::size_t num_views) const;
};

/// `points` with `surfels` are a sample of the map (a few times 10,000 points a view; any order). `depth` gives the
/// depth image of the whole map for a view at a pose; it is called from several threads at once.
struct AlignmentInput {
  std::vector<Camera> cameras;
  std::vector<View> views;
  Camera cameraOf(std::size_t view) const {
    return cameras[views[view].camera].whileMoving(views[view].readout_motion);
  }

  ImageSource images;  ///< CV_8U, RGB or grey; from several threads
  ImageSource masks;   ///< CV_8UC1, 0 = do not use; null where a view has none; may be empty
  Points points;
  Surfels surfels;
  Eigen::VectorXf intensity;  ///< of each point, any scale; empty: none
  std::function<std::shared_ptr<const DepthImage>(std::size_t view, const Eigen::Isometry3d& map_from_camera)> depth;
  DepthParams depth_params;
  int num_threads = 0;         ///< 0: one a core
  double memory_limit = 1000;  ///< MB; blurred images are kept between rounds in half of it. Changes no result
};

struct ViewAlignment {
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();  ///< corrected
  Exposure exposure;           ///< gain by channel of its image (empty where none was estimated), vignetting
  float weight = 1;            ///< 0.1 to 1: sharpness against the other views
  bool refused = false;        ///< keeps the pose it came with (but for its camera's correction)
  std::string reason;          ///< why it was refused
  std::size_t num_points = 0;  ///< sample points shared with other views
  double rotation = 0;         ///< deg
  double translation = 0;      ///< m
  double pixels = 0;           ///< median shift of its points in the image
  double residual_before = 0;  ///< grey levels, mean distance of held-back points to what the other views predict
  double residual_after = 0;
};

struct CameraAlignment {
  Eigen::Isometry3d corrected_from_camera = Eigen::Isometry3d::Identity();  ///< shared correction, in its own frame
  double rotation = 0;                                                      ///< deg
  double translation = 0;                                                   ///< m
  double rotation_error = 0;     ///< deg, standard error by the scatter of the corrections of the camera's views
  double translation_error = 0;  ///< m, likewise
  Eigen::Array2f vignetting = Eigen::Array2f::Zero();  ///< see Exposure::vignetting
  double time_offset = 0;                              ///< s to add to the stamps for the best agreement
  double time_offset_stddev = 0;                       ///< s; 0 when there is no motion to tell it from
  bool time_offset_suspect = false;  ///< this alone explains, at all moments, what held-back points show
  bool calibration_suspect = false;  ///< the shared correction alone explains it, at all moments and places
};

/// How well the images agree where all clocks are off by so much.
struct ClockTrial {
  double offset = 0;  ///< s
  double cost = 0;    ///< robust, per weight of the points; the least is the best
};

struct AlignmentResult {
  std::vector<ViewAlignment> views;
  std::vector<CameraAlignment> cameras;
  bool poses_aligned = false, exposure_aligned = false;
  std::vector<std::string> warnings;  ///< what looks wrong, or why nothing was done, one sentence each
  /// grey levels: mean distance of held-back points to what the other views predict, with the poses as they came and as
  /// they were corrected; standard error of the difference
  double residual_before = 0, residual_after = 0, residual_error = 0;
  bool corrections_kept = false;         ///< of poses; they are only if the second is proven to be better
  double pixels = 0;                     ///< median over the views of their median shift
  std::vector<ClockTrial> clock_trials;  ///< by offset; empty where nothing moves
  double thickness = 0;                  ///< m, of the slab that the points of a surface make: twice their scatter
  double seconds = 0;
};

/// Estimates what makes the images agree with each other and with the map. Cost grows with the views, not with the
/// map. The same result for any number of threads. Throws std::invalid_argument on inconsistent input.
AlignmentResult align(const AlignmentInput& input, const AlignmentParams& params, const Callbacks& callbacks);

std::string describe(const AlignmentResult& result);  ///< a paragraph without the warnings
std::string alignmentCsv(const AlignmentResult& result, const std::vector<View>& views);  ///< one line a view
/// All of it for programs; `ids`: what each view is called.
std::string alignmentJson(const AlignmentResult& result, const std::vector<View>& views,
                          const std::vector<std::size_t>& ids);
cv::Mat3b alignmentPicture(const AlignmentResult& result);  ///< BGR: corrections, gains and residuals by view

}  // namespace cloud_colorizer
