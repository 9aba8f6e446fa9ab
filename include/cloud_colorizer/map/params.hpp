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
/// What is done with points of what moved: nothing; a field tells of them; they are left out of the map.
enum class Moving { kKeep, kMark, kDrop };

struct ColorizeParams {
  Method method = Method::kDefault;
  Uncolored uncolored = Uncolored::kKeep;
  Moving moving = Moving::kMark;
  Tone tone = Tone::kDisplay;
  Appearance appearance = Appearance::kNone;
  double fill_distance = 0.3;  ///< m; `uncolored: fill` takes the colour of the nearest coloured point within it
  std::string crs;             ///< of a saved .las: a code such as EPSG:25832, or WKT; empty: as the input's
  int num_threads = 0;         ///< 0: one a core
  double memory_limit = 0;     ///< MB for chunks in work, images and depth images together; 0: half of the machine's
                               ///< memory, at most 4000

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
  ChunkParams chunks;
  ColorizeParams colorize;

  void check() const;   ///< of every member; throws std::invalid_argument with name, value and what is allowed
  bool aligns() const;  ///< whether they ask for an alignment
};

/// Names of an enumeration's values, in order.
std::vector<std::string> enumNames(Method);
std::vector<std::string> enumNames(Uncolored);
std::vector<std::string> enumNames(Moving);
std::vector<std::string> enumNames(Tone);
std::vector<std::string> enumNames(Appearance);
std::vector<std::string> enumNames(SolverKind);
std::vector<std::string> enumNames(AnchorKind);
std::vector<std::string> enumNames(PassGrids);
std::vector<std::string> enumNames(AlignPoses);

template <class AlignmentParamsT, class F>
void visitAlignmentParams(AlignmentParamsT& p, F&& f) {
  f("align_exposure", p.align_exposure, "estimate a gain for every view and channel (method default)");
  f("align_vignetting", p.align_vignetting, "and a darkening outwards for every camera, where the data ask for it");
  f("align_time_offset", p.align_time_offset, "apply the cameras' estimated time offsets, not only report them");
  f("align_to_intensity", p.align_to_intensity, "tie the images to the LiDAR intensity where the cloud has it");
  f("alignment_points", p.alignment_points, "sample points that one view uses at most");
  f("pose_rotation_prior", p.pose_rotation_prior,
    "deg an axis, expected error of a view's pose; of its place: as many pixels");
  f("extrinsic_rotation_prior", p.extrinsic_rotation_prior,
    "deg an axis, expected error of a camera's extrinsics; of its place: as many pixels");
  f("time_offset_prior", p.time_offset_prior, "s, expected error of a camera's clock");
}

/// Those that matter most.
constexpr int kNumMainParams = 10;
template <class ParamsT, class F>
void visitMainParams(ParamsT& p, F&& f) {
  f("method", p.colorize.method, "default, paper, mean, median or closest");
  f("voxel_size", p.record.voxel_size, "m; one point a voxel is kept; 0 keeps all");
  f("max_range", p.record.max_range, "m from the sensor; farther points are dropped");
  f("keyframe_distance", p.record.keyframe_distance, "m that a camera moves before its next view is kept");
  f("max_view_distance", p.depth.max_view_distance,
    "m; views farther away do not colour a point; 0: two thirds of max_range, or of a model no limit");
  f("align_poses", p.alignment.align_poses, "none, cameras (their extrinsics) or views (each pose as well)");
  f("tone", p.colorize.tone,
    "display (each place as bright as its images) or radiance (one exposure; fields radiance_...)");
  f("uncolored", p.colorize.uncolored, "keep, drop or fill the points that no view sees");
  f("num_threads", p.colorize.num_threads, "0: one a core");
  f("memory_limit", p.colorize.memory_limit,
    "MB for chunks, images and depth images together; 0: half of the memory, at most 4000");
}

/// The main ones first.
template <class ParamsT, class F>
void visitParams(ParamsT& p, F&& f) {
  visitMainParams(p, f);
  f("min_range", p.record.min_range, "m from the sensor; nearer points are dropped");
  f("keyframe_angle", p.record.keyframe_angle, "deg that a camera turns before its next view is kept");
  f("tile_size", p.record.tile_size, "m, side of a tile of the recording; 0: 200 voxels");
  f("scan_resolution", p.record.scan_resolution,
    "deg a cell of the scans that tell empty space; 0: none are kept, and none used");
  f("depth_cell_size", p.depth.depth_cell_size,
    "px of the image to a cell of the depth image; 0: 1/640 of its longer side, 2 at least");
  f("depth_tolerance", p.depth.depth_tolerance, "share of the depth by which a visible point may lie behind");
  f("depth_edge_guard", p.depth.depth_edge_guard, "px beside a depth edge, used only where no view sees better");
  f("clear_radius", p.depth.clear_radius,
    "m around the places of the cameras that were free: points there hide nothing");
  visitAlignmentParams(p.alignment, f);
  f("max_views", p.observe.max_views, "a point keeps its best views up to this number");
  f("passes", p.graph.passes, "1 to 4 Z-order passes");
  f("pass_grids", p.graph.grids, "auto, own (a grid for each pass: cg) or shared (one, mirrored: cholmod and spqr)");
  f("lambda", p.system.lambda, "weight of the gradients against the data, eq. (1)");
  f("anchors", p.system.anchors, "random or consistent: which points are held to their data");
  f("anchor_share", p.system.anchor_share, "share of the points that are anchors");
  f("gradient_distance", p.system.gradient_distance, "m; views within it give gradients, eq. (4); 0: all");
  f("min_data_weight", p.system.min_data_weight, "data weight of the points that are no anchors");
  f("solver", p.system.solver, "cg (conjugate gradients), cholmod or spqr (factorisations)");
  f("max_chunk_points", p.chunks.max_chunk_points, "points of a chunk's core");
  f("overlap", p.chunks.overlap, "halo of a chunk as a share of its side");
  f("moving", p.colorize.moving, "keep, mark (field moving) or drop the points of what moved, as the scans tell it");
  f("appearance", p.colorize.appearance,
    "none, sh1 or sh2: take what changes with the direction of the view out of the colours (fields diffuse_..., "
    "specular)");
  f("fill_distance", p.colorize.fill_distance, "m within which an unseen point takes a neighbour's colour");
  f("crs", p.colorize.crs,
    "coordinate reference system that a saved .las names: EPSG:25832, say, or WKT; empty: as the input's");
}

/// Sets one parameter from text. Throws std::invalid_argument: unknown name (with the nearest known one, or what is
/// done instead of one that was removed), no number, unknown word (with the allowed ones).
void setParam(Params& params, const std::string& name, const std::string& text);

/// What is done instead of a parameter of older versions, as a sentence; empty for a name that never was one.
std::string removedParam(const std::string& name);

/// Every parameter, in the order of visitParams.
std::vector<ParamText> describeParams(const Params& params);

}  // namespace cloud_colorizer
