// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/workspace.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "map/fingerprint.hpp"
#include "map/memory_plan.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kThinning = 0.5;  // of a depth image's cell: what lies nearer together is one point to it
constexpr std::size_t kMaxLevels = 64;

std::size_t bytesOf(const Surface& s) {
  return sizeof(float) *
         static_cast<std::size_t>(s.points.size() + s.surfels.normals.size() + 3 * s.surfels.radii.size());
}
std::size_t bytesOf(const cv::Mat& image) {
  return image.total() * image.elemSize();
}
std::size_t bytesOf(const DepthImage& image) {
  return bytesOf(image.depth) + bytesOf(image.edge) + (image.empty_space ? image.empty_space->numBytes() : 0);
}

}  // namespace

Workspace::Workspace(const Recording& recording, const Params& params, bool alone)
    : recording_(recording),
      params_(params),
      memory_(params),
      files_(recording, params.colorize.appearance != Appearance::kNone),
      scan_times_(recording.scans()),
      scans_(
          memory_.scans(), [this](std::size_t scan) { return scanRanges(recording_.readScan(scan)); },
          [](const ScanRanges& ranges) { return ranges.numBytes(); }),
      surfaces_(
          memory_.surfaces(),
          [this](std::size_t tile) {
            return Surface{recording_.readPoints(tile), files_.readSurfels(tile)};
          },
          [](const Surface& surface) { return bytesOf(surface); }),
      thinned_levels_(
          memory_.thinnedSurfaces(), [this](std::size_t tile) { return files_.thinnedLevels(tile); },
          [](const std::vector<ThinnedLevel>& levels) { return levels.size() * sizeof(ThinnedLevel); }),
      thinned_(
          memory_.thinnedSurfaces(),
          [this](std::size_t key) {
            const std::size_t tile = key / kMaxLevels;
            return files_.readThinned(tile, thinned_levels_.get(tile)->at(key % kMaxLevels));
          },
          [](const Surface& surface) { return bytesOf(surface); }),
      images_(recording, memory_.images(), shortName(imageFilesKey(recording)), alone),
      depths_(
          memory_.depthImages(),
          [this](std::size_t view) {
            DepthImage image = files_.readDepth(view);
            image.empty_space = emptySpace(view, corrections_[view].map_from_camera);
            return image;
          },
          [](const DepthImage& image) { return bytesOf(image); }) {
  params_.depth.max_view_distance = params_.depth.reach(recording_.maxRange());
  std::vector<Camera> cameras;
  for (const RecordedCamera& camera : recording_.cameras()) cameras.emplace_back(camera.intrinsics);
  std::vector<CorrectedView> as_recorded;
  for (const View& view : recording_.views()) {
    cameras_.push_back(cameras[view.camera].whileMoving(view.readout_motion));
    as_recorded.push_back({view.map_from_camera, {}, 1});
  }
  correctViews(std::move(as_recorded));
  leaveOut({});
}

std::shared_ptr<const EmptySpace> Workspace::emptySpace(std::size_t view, const Eigen::Isometry3d& map_from_camera) {
  if (params_.record.scan_resolution == 0) return nullptr;
  const double stamp = recording_.views()[view].stamp;
  return emptySpaceAt(recording_, scan_times_, stamp, map_from_camera,
                      [this](std::size_t scan) { return scans_.get(scan); });
}

std::shared_ptr<const Surface> Workspace::surfaceSeenFrom(std::size_t tile, std::size_t view,
                                                          const Eigen::Vector3d& eye) {
  const double nearest = recording_.tileBox(tile).cast<double>().exteriorDistance(eye);
  const Camera& camera = cameraOf(view);
  const double cell = kThinning * params_.depth.cellSize(camera.intrinsics()) * camera.pixelAngle() * nearest;
  const auto levels = thinned_levels_.get(tile);
  std::size_t level = levels->size();
  while (level > 0 && levels->at(level - 1).cell > cell) --level;
  return level == 0 ? surfaces_.get(tile) : thinned_.get(tile * kMaxLevels + level - 1);
}

ObservedView Workspace::observedView(std::size_t view) {
  const CorrectedView& corrected = corrections_[view];
  ObservedView observed;
  observed.id = static_cast<std::uint32_t>(view);
  observed.camera = &cameraOf(view);
  observed.map_from_camera = corrected.map_from_camera;
  observed.exposure = corrected.exposure;
  observed.weight = corrected.weight;
  const Quantity& quantity = recording_.quantityOf(view);
  observed.kind = quantity.kind;
  if (quantity.kind == ImageKind::kRadiometric) {
    observed.exposure.gain = Eigen::ArrayXf::Constant(1, static_cast<float>(quantity.scale));
    observed.exposure.offset = Eigen::ArrayXf::Constant(1, static_cast<float>(quantity.offset));
  }
  const auto pixels = images_.get(view);
  observed.image = imageOf(pixels);
  observed.mask = maskOf(pixels);
  observed.depth = depths_.get(view);
  return observed;
}

void Workspace::leaveOut(ViewList damaged) {
  damaged_views_ = std::move(damaged);
  usable_views_.clear();
  for (std::uint32_t view = 0; view < recording_.views().size(); ++view) {
    if (!std::binary_search(damaged_views_.begin(), damaged_views_.end(), view)) usable_views_.push_back(view);
  }
}

std::vector<std::size_t> Workspace::colorViews() const {
  std::vector<std::size_t> views;
  std::copy_if(usable_views_.begin(), usable_views_.end(), std::back_inserter(views),
               [&](std::size_t view) { return recording_.quantityOf(view).kind == ImageKind::kColor; });
  return views;
}

std::vector<std::size_t> Workspace::viewsOf(const Eigen::AlignedBox3f& box, const Quantity& quantity) const {
  std::vector<std::size_t> views;
  for (const std::size_t view : usable_views_) {
    if (isSame(recording_.quantityOf(view), quantity) && cones_[view].mayShow(box)) views.push_back(view);
  }
  return views;
}

void Workspace::correctViews(std::vector<CorrectedView> corrections) {
  corrections_ = std::move(corrections);
  cones_.clear();
  for (std::size_t view = 0; view < corrections_.size(); ++view) {
    cones_.emplace_back(cameraOf(view), corrections_[view].map_from_camera, params_.depth.reach());
  }
}

bool Workspace::restoreDamagedViews() {
  if (!files_.holds(kImageCheckFolder, imageFilesKey(recording_))) return false;
  ViewList all;
  for (std::size_t block = 0; block < files_.numViewBlocks(); ++block) {
    const auto damaged = files_.readDamagedViews(block);
    if (!damaged) return false;
    all.insert(all.end(), damaged->begin(), damaged->end());
  }
  leaveOut(std::move(all));
  return true;
}

bool Workspace::restoreCorrections() {
  if (!params_.aligns() || !files_.holds(kAlignmentFolder, alignmentKey(recording_, params_, damaged_views_)))
    return false;
  auto corrections = files_.readCorrections();
  if (!corrections) return false;
  correctViews(*std::move(corrections));
  return true;
}

}  // namespace cloud_colorizer
