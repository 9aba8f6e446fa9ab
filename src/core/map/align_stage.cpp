// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "base/file_io.hpp"
#include "base/parallel.hpp"
#include "base/position_hash.hpp"
#include "cloud/intensity.hpp"
#include "cloud_colorizer/alignment/align.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "map/fingerprint.hpp"
#include "map/memory_plan.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Views that see one sample point, at the least: so many points give every view its alignment_points.
constexpr double kViewsPerPoint = 8;

struct MapSample {
  Surface surface;
  Eigen::VectorXf intensity;  ///< empty where the recording has none
};

/// The same points whatever the chunks and threads: a hash of the position decides.
MapSample samplePoints(Workspace& work, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  const std::size_t num_views = work.colorViews().size();
  const AlignmentParams& params = work.params().alignment;
  const double of_view =
      std::min(params.alignment_points / kViewsPerPoint, static_cast<double>(params.pointsPerView(num_views)));
  const double share = of_view * static_cast<double>(num_views) / static_cast<double>(recording.numPoints());
  const std::vector<Field>& fields = recording.fields();
  const auto field = findIntensity(fields);
  const std::size_t record_size = recordSize(fields);

  std::vector<Surface> taken;
  std::vector<float> intensity;
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
    throwIfCancelled(callbacks);
    const auto surface = work.surface(tile);
    const std::vector<Index> columns = hashedSample(surface->points, share);
    if (columns.empty()) continue;
    taken.push_back(gatherSurface(*surface, columns));
    if (!field) continue;
    const std::vector<std::uint8_t> records = recording.readRecords(tile);
    for (const Index i : columns) {
      const std::uint8_t* record = records.data() + static_cast<std::size_t>(i) * record_size;
      intensity.push_back(static_cast<float>(numberAt(record + field->offset, field->field.type)));
    }
  }
  MapSample sample{concatenate(taken), {}};
  sample.intensity = Eigen::Map<const Eigen::VectorXf>(intensity.data(), static_cast<Index>(intensity.size()));
  return sample;
}

/// `views`: those that take part.
AlignmentInput makeInput(Workspace& work, const std::vector<std::size_t>& views, const Callbacks& callbacks) {
  const Recording& recording = work.recording();
  MapSample sample = samplePoints(work, callbacks);
  AlignmentInput input;
  for (const auto& camera : recording.cameras()) input.cameras.emplace_back(camera.intrinsics);
  for (const std::size_t view : views) input.views.push_back(recording.views()[view]);
  input.images = [&work, &views](std::size_t k) { return work.image(views[k]); };
  input.masks = [&work, &views](std::size_t k) { return work.mask(views[k]); };
  input.points = std::move(sample.surface.points);
  input.surfels = std::move(sample.surface.surfels);
  input.intensity = std::move(sample.intensity);
  input.depth = [&work, &views, callbacks](std::size_t k, const Eigen::Isometry3d& pose) {
    return std::make_shared<const DepthImage>(renderDepth(work, views[k], pose, callbacks));
  };
  input.depth_params = work.params().depth;
  input.num_threads = work.params().colorize.num_threads;
  input.memory_limit = static_cast<double>(work.memory().alignment()) / 1e6;
  return input;
}

/// Text, numbers and a picture of what was found.
void writeReport(const DerivedFiles& files, const std::vector<View>& views, const std::vector<std::size_t>& ids,
                 const AlignmentResult& result) {
  const auto write = [&](const std::string& name, const auto& bytes) {
    writeFileAtomically(files.pathOf(kAlignmentFolder + ('/' + name)), bytes.data(), bytes.size());
  };
  std::string text = describe(result) + '\n';
  for (const std::string& warning : result.warnings) text += "Warning: " + warning + '\n';
  write("report.txt", text);
  write("views.csv", alignmentCsv(result, views));
  write(kAlignmentJson, alignmentJson(result, views, ids));
  std::vector<std::uint8_t> png;
  cv::imencode(".png", alignmentPicture(result), png);
  write("report.png", png);
}

/// An image of labels or scores is made from one of colours: what is found of the pose of that holds for both.
void takePosesOfTwins(const Recording& recording, const std::vector<std::size_t>& aligned,
                      std::vector<CorrectedView>& corrected) {
  std::map<double, std::vector<std::size_t>> by_stamp;
  for (const std::size_t view : aligned) by_stamp[recording.views()[view].stamp].push_back(view);
  for (std::size_t k = 0; k < corrected.size(); ++k) {
    const View& view = recording.views()[k];
    if (recording.quantityOf(k).kind == ImageKind::kColor) continue;
    for (const std::size_t twin : by_stamp[view.stamp]) {
      const bool is_same = recording.views()[twin].map_from_camera.matrix() == view.map_from_camera.matrix();
      if (is_same) corrected[k].map_from_camera = corrected[twin].map_from_camera;
    }
  }
}

void alignViews(Workspace& work, UnitRange units, const Callbacks& callbacks) {
  const DerivedFiles& files = work.files();
  if (units.size() == 0 || files.readCorrections()) return;
  const Callbacks turns = takingTurns(callbacks);
  const std::vector<std::size_t> views = work.colorViews();
  const AlignmentInput input = makeInput(work, views, turns);
  const AlignmentResult result = align(input, work.params().alignment, turns);
  std::vector<CorrectedView> corrected = work.corrections();
  for (std::size_t k = 0; k < result.views.size(); ++k) {
    const ViewAlignment& view = result.views[k];
    corrected[views[k]] = {view.map_from_camera, view.exposure, view.weight};
  }
  takePosesOfTwins(work.recording(), views, corrected);
  writeReport(files, input.views, views, result);
  files.writeCorrections(corrected);
  if (callbacks.log) {
    callbacks.log(LogLevel::kInfo, describe(result));
    for (const std::string& warning : result.warnings) callbacks.log(LogLevel::kWarning, warning);
  }
}

void useCorrections(Workspace& work, const Callbacks&) {
  require(work.restoreCorrections(), "the alignment in ", work.recording().directory(),
          " is not whole; colour it again");
}

}  // namespace

Stage alignmentStage() {
  return {"alignment",
          "map",
          kAlignmentFolder,
          {"images", "moving", "surfels"},
          [](const Workspace& work) {
            const auto num_views = static_cast<double>(work.colorViews().size());
            return work.params().aligns() && num_views > 0 ? std::vector<double>{num_views} : std::vector<double>{};
          },
          [](const Workspace& work) { return alignmentKey(work.recording(), work.params(), work.damagedViews()); },
          [](const Workspace&) { return UnitFiles{{kCorrectionsFile}}; },
          alignViews,
          useCorrections};
}

}  // namespace cloud_colorizer
