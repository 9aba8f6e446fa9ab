// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "base/file_io.hpp"
#include "base/position_hash.hpp"
#include "cloud_colorizer/alignment/align.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "map/stages.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Views that see one sample point, at the least: so many points give every view its alignment_points.
constexpr double kViewsPerPoint = 8;

struct Sample {
  Surface surface;
  Eigen::VectorXf intensity;  ///< empty where the recording has none
};

/// The same points whatever the chunks and threads: a hash of the position decides.
Sample samplePoints(Workspace& work) {
  const Recording& recording = work.recording();
  const double wanted = work.params().alignment.alignment_points / kViewsPerPoint;
  const double share =
      wanted * static_cast<double>(recording.views().size()) / static_cast<double>(recording.numPoints());
  const std::vector<Field>& fields = recording.fields();
  const auto found = findField(fields, "intensity");
  const auto field = found ? found : findField(fields, "reflectivity");
  const std::size_t record_size = recordSize(fields);

  std::vector<Surface> taken;
  std::vector<float> intensity;
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
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
  Sample sample{concatenate(taken), {}};
  sample.intensity = Eigen::Map<const Eigen::VectorXf>(intensity.data(), static_cast<Index>(intensity.size()));
  return sample;
}

AlignmentInput makeInput(Workspace& work) {
  const Recording& recording = work.recording();
  Sample sample = samplePoints(work);
  AlignmentInput input;
  for (const auto& camera : recording.cameras()) input.cameras.emplace_back(camera.intrinsics);
  input.views = recording.views();
  input.images = [&work](std::size_t view) { return work.image(view); };
  input.masks = [&work](std::uint32_t camera) { return work.mask(camera); };
  input.points = std::move(sample.surface.points);
  input.surfels = std::move(sample.surface.surfels);
  input.intensity = std::move(sample.intensity);
  input.depth = [&work](std::size_t view, const Eigen::Isometry3d& pose) {
    return std::make_shared<const DepthImage>(renderDepth(work, view, pose));
  };
  input.depth_params = work.params().depth;
  input.num_threads = work.params().colorize.num_threads;
  input.memory_limit = 0.6 * work.params().colorize.memory_limit;
  return input;
}

/// Text, numbers and a picture of what was found.
void writeReport(const Workspace& work, const AlignmentResult& result) {
  const std::filesystem::path folder = std::filesystem::path(work.recording().directory()) / "alignment";
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const auto& bytes) {
    writeFileAtomically((folder / name).string(), bytes.data(), bytes.size());
  };
  std::string text = describe(result) + '\n';
  for (const std::string& warning : result.warnings) text += "Warning: " + warning + '\n';
  write("report.txt", text);
  write("views.csv", alignmentCsv(result, work.recording().views()));
  std::vector<std::uint8_t> png;
  cv::imencode(".png", alignmentPicture(result), png);
  write("report.png", png);
}

}  // namespace

void alignViews(Workspace& work, const Callbacks& callbacks) {
  const Params& params = work.params();
  const bool wanted = params.alignment.align_exposure || params.alignment.align_poses != AlignPoses::kNone;
  if (params.colorize.method != Method::kDefault || !wanted || work.restoreCorrections()) return;

  const AlignmentResult result = align(makeInput(work), params.alignment, callbacks);
  std::vector<CorrectedView> corrected;
  for (const ViewAlignment& view : result.views) {
    corrected.push_back({view.map_from_camera, view.exposure, view.weight});
  }
  writeReport(work, result);
  work.correctViews(std::move(corrected));
  if (callbacks.log) {
    callbacks.log(LogLevel::kInfo, describe(result));
    for (const std::string& warning : result.warnings) callbacks.log(LogLevel::kWarning, warning);
  }
}

}  // namespace cloud_colorizer
