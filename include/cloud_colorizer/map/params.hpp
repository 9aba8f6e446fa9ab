// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// All parameters, each name written once: the ROS loader, the command line, the printer and the tests walk
/// visitParams(params, f), which calls f(name, field, help).
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cloud_colorizer/alignment/align.hpp"
#include "cloud_colorizer/color/graph.hpp"
#include "cloud_colorizer/color/point_colors.hpp"
#include "cloud_colorizer/color/system.hpp"
#include "cloud_colorizer/color/tone.hpp"
#include "cloud_colorizer/map/chunks.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"
#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

enum class Uncolored { kKeep, kDrop, kFill };

struct ColorizeParams {
  Method method = Method::kDefault;
  Uncolored uncolored = Uncolored::kKeep;
  double fill_distance = 0.3;  ///< m; `uncolored: fill` takes the colour of the nearest coloured point within it
  int num_threads = 0;         ///< 0: one a core
  double memory_limit = 1500;  ///< MB for chunks in work, images and depth images together

  void check() const;
};

struct Params {
  RecordParams record;
  SurfelParams surfels;
  DepthParams depth;
  AlignmentParams alignment;
  ObserveParams observe;
  GraphParams graph;
  SystemParams system;
  ToneParams tone;
  ChunkParams chunks;
  ColorizeParams colorize;

  void check() const;  ///< of every member; throws std::invalid_argument with name, value and what is allowed
};

/// Names of an enumeration's values, in order.
std::vector<std::string> enumNames(Method);
std::vector<std::string> enumNames(Uncolored);
std::vector<std::string> enumNames(SolverKind);
std::vector<std::string> enumNames(AnchorKind);
std::vector<std::string> enumNames(PassGrids);
std::vector<std::string> enumNames(AlignPoses);

template <class AlignmentParamsT, class F>
void visitAlignmentParams(AlignmentParamsT& p, F&& f) {
  f("align_exposure", p.align_exposure, "estimate a gain for every view and channel (method default)");
  f("align_vignetting", p.align_vignetting, "and a darkening outwards for every camera, where the data ask for it");
  f("align_poses", p.align_poses, "none, cameras (their extrinsics) or views (each pose as well)");
  f("align_time_offset", p.align_time_offset, "apply the cameras' estimated time offsets, not only report them");
  f("align_to_intensity", p.align_to_intensity, "tie the images to the LiDAR intensity where the cloud has it");
  f("alignment_points", p.alignment_points, "sample points that one view uses at most");
  f("alignment_rounds", p.alignment_rounds, "Gauss-Newton rounds at each blur");
  f("alignment_blur", p.alignment_blur, "px, blur of the first round; 0: from the priors");
  f("pose_rotation_prior", p.pose_rotation_prior, "deg an axis, expected error of a view's pose");
  f("pose_translation_prior", p.pose_translation_prior, "m an axis; 0: as many pixels as the rotation");
  f("extrinsic_rotation_prior", p.extrinsic_rotation_prior, "deg an axis, expected error of a camera's extrinsics");
  f("extrinsic_translation_prior", p.extrinsic_translation_prior, "m an axis; 0: as many pixels as the rotation");
  f("time_offset_prior", p.time_offset_prior, "s, expected error of a camera's clock");
  f("max_gain", p.max_gain, "gains stay within [1 / max_gain, max_gain]");
}

template <class ParamsT, class F>
void visitParams(ParamsT& p, F&& f) {
  f("method", p.colorize.method, "default, paper, mean, median or closest");
  f("voxel_size", p.record.voxel_size, "m; one point a voxel is kept; 0 keeps all");
  f("min_range", p.record.min_range, "m from the sensor; nearer points are dropped");
  f("max_range", p.record.max_range, "m from the sensor; farther points are dropped");
  f("keyframe_distance", p.record.keyframe_distance, "m that a camera moves before its next view is kept");
  f("keyframe_angle", p.record.keyframe_angle, "deg that a camera turns before its next view is kept");
  f("tile_size", p.record.tile_size, "m, side of a tile of the recording; 0: 200 voxels");
  f("scan_resolution", p.record.scan_resolution, "deg a cell of the scans that tell empty space; 0 keeps none");
  f("max_open_tiles", p.record.max_open_tiles, "tiles whose voxels are held in memory while recording");
  f("num_neighbors", p.surfels.num_neighbors, "points that give a surfel's normal and radius");
  f("depth_cell_size", p.depth.depth_cell_size, "px of the image to a cell of the depth image");
  f("depth_tolerance", p.depth.depth_tolerance, "share of the depth by which a visible point may lie behind");
  f("depth_edge_guard", p.depth.depth_edge_guard, "px beside a depth edge, used only where no view sees better");
  f("clear_radius", p.depth.clear_radius,
    "m around the places of the cameras that were free: points there hide nothing");
  f("use_scans", p.depth.use_scans, "what the scan of a view's moment saw through hides nothing and is not coloured");
  f("max_view_distance", p.depth.max_view_distance, "m; views farther away do not colour a point");
  visitAlignmentParams(p.alignment, f);
  f("max_views", p.observe.max_views, "a point keeps its best views up to this number");
  f("image_border", p.observe.image_border, "px at the border of an image that are not used");
  f("passes", p.graph.passes, "1 to 4 Z-order passes");
  f("pass_grids", p.graph.grids, "own grid of each pass, or shared: mirrored, blocks alike; suits solver cholmod");
  f("edge_length_ratio", p.graph.edge_length_ratio, "local spacings beyond which an edge counts less; 0: all alike");
  f("lambda", p.system.lambda, "weight of the gradients against the data, eq. (1)");
  f("anchors", p.system.anchors, "random or consistent: which points are held to their data");
  f("anchor_share", p.system.anchor_share, "share of the points that are anchors");
  f("gradient_distance", p.system.gradient_distance, "m; views within it give gradients, eq. (4); 0: all");
  f("min_data_weight", p.system.min_data_weight, "data weight of the points that are no anchors");
  f("no_evidence_weight", p.system.no_evidence_weight, "weight of edges that no view sees whole; 0 drops them");
  f("solver", p.system.solver, "cg (conjugate gradients), cholmod or spqr (factorisations)");
  f("exposure_range", p.tone.exposure_range, "factor that a place's brightness may differ from what its cameras saw");
  f("max_chunk_points", p.chunks.max_chunk_points, "points of a chunk's core");
  f("overlap", p.chunks.overlap, "halo of a chunk as a share of its side");
  f("uncolored", p.colorize.uncolored, "keep, drop or fill the points that no view sees");
  f("fill_distance", p.colorize.fill_distance, "m within which an unseen point takes a neighbour's colour");
  f("num_threads", p.colorize.num_threads, "0: one a core");
  f("memory_limit", p.colorize.memory_limit, "MB for chunks, images and depth images together");
}

/// Sets one parameter from text. Throws std::invalid_argument: unknown name (with the nearest known one), no number,
/// unknown word (with the allowed ones).
void setParam(Params& params, const std::string& name, const std::string& text);

/// Every parameter, in the order of visitParams.
std::vector<ParamText> describeParams(const Params& params);

}  // namespace cloud_colorizer
