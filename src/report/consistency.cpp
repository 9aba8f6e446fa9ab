// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/consistency.hpp"

#include <algorithm>
#include <numeric>

#include "base/robust.hpp"
#include "map/derived_files.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

constexpr std::size_t kBinWidth = 4;        // grey levels of the histogram
constexpr std::uint64_t kLeastSights = 30;  // of a cell
constexpr std::size_t kLeastCells = 24;     // of a camera

/// The cells of an image whose error stands out, as those that touch each other make parts.
std::vector<std::vector<std::size_t>> partsOf(const std::vector<bool>& is_bad) {
  std::vector<std::vector<std::size_t>> parts;
  std::vector<bool> taken(is_bad.size(), false);
  for (std::size_t start = 0; start < is_bad.size(); ++start) {
    if (!is_bad[start] || taken[start]) continue;
    std::vector<std::size_t> part = {start};
    taken[start] = true;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const int column = static_cast<int>(part[k]) % kHeldOutColumns, row = static_cast<int>(part[k]) / kHeldOutColumns;
      for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
        const int x = column + dx, y = row + dy;
        if (x < 0 || y < 0 || x >= kHeldOutColumns || y >= kHeldOutRows) continue;
        const auto cell = static_cast<std::size_t>(y * kHeldOutColumns + x);
        if (!is_bad[cell] || taken[cell]) continue;
        taken[cell] = true;
        part.push_back(cell);
      }
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

BadPart describePart(const CameraErrors& errors, std::size_t camera, const std::vector<std::size_t>& cells,
                     double usual) {
  BadPart part{camera, 0, 0, 1, 1, 0, 0};
  std::uint64_t sum = 0, count = 0;
  for (const std::size_t cell : cells) {
    const std::size_t column = cell % kHeldOutColumns, row = cell / kHeldOutColumns;
    const auto x = static_cast<double>(column), y = static_cast<double>(row);
    part.left = std::min(part.left, x / kHeldOutColumns), part.right = std::max(part.right, (x + 1) / kHeldOutColumns);
    part.top = std::min(part.top, y / kHeldOutRows), part.bottom = std::max(part.bottom, (y + 1) / kHeldOutRows);
    sum += errors.sums[cell], count += errors.counts[cell];
  }
  part.error_ratio = static_cast<double>(sum) / static_cast<double>(count) / usual;
  part.share = static_cast<double>(count) / static_cast<double>(errors.count());
  return part;
}

}  // namespace

void CameraErrors::add(const HeldOut& sight) {
  ++by_error[sight.error];
  sums[sight.cell] += sight.error;
  ++counts[sight.cell];
}

std::uint64_t CameraErrors::count() const {
  return std::accumulate(by_error.begin(), by_error.end(), std::uint64_t{0});
}

double CameraErrors::mean() const {
  const double sum = static_cast<double>(std::accumulate(sums.begin(), sums.end(), std::uint64_t{0}));
  return count() > 0 ? sum / static_cast<double>(count()) : 0;
}

double CameraErrors::median() const {
  std::uint64_t below = 0;
  for (std::size_t error = 0; error < by_error.size(); ++error) {
    below += by_error[error];
    if (2 * below > count()) return static_cast<double>(error);
  }
  return 0;
}

std::vector<CameraErrors> readErrors(const Recording& recording) {
  const DerivedFiles files(recording);
  std::vector<CameraErrors> cameras(recording.cameras().size());
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
    for (const HeldOut& sight : files.readViews(tile).held_out) {
      if (sight.camera < cameras.size()) cameras[sight.camera].add(sight);
    }
  }
  return cameras;
}

BadPart worstPart(const std::vector<CameraErrors>& cameras) {
  constexpr double kStandsOut = 2.5;  // times the median of the camera's cells
  constexpr double kLeastError = 10;  // grey levels of 255: a quarter of the contrast of a street
  BadPart worst;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const CameraErrors& errors = cameras[camera];
    std::vector<double> means(CameraErrors::kCells, 0);
    std::vector<double> known;
    for (std::size_t cell = 0; cell < means.size(); ++cell) {
      if (errors.counts[cell] < kLeastSights) continue;
      means[cell] = static_cast<double>(errors.sums[cell]) / static_cast<double>(errors.counts[cell]);
      known.push_back(means[cell]);
    }
    if (known.size() < kLeastCells) continue;
    const double usual = std::max(median(std::move(known)), 1.0);
    std::vector<bool> is_bad(means.size());
    for (std::size_t cell = 0; cell < means.size(); ++cell) {
      is_bad[cell] = means[cell] > std::max(kStandsOut * usual, kLeastError);
    }
    for (const auto& cells : partsOf(is_bad)) {
      if (cells.size() < 2) continue;  // one is a chance
      const BadPart part = describePart(errors, camera, cells, usual);
      if (part.error_ratio * part.share > worst.error_ratio * worst.share) worst = part;
    }
  }
  return worst;
}

json describeErrors(const std::vector<CameraErrors>& cameras) {
  json by_camera = json::array();
  CameraErrors all;
  for (const CameraErrors& errors : cameras) {
    std::vector<std::uint64_t> histogram(errors.by_error.size() / kBinWidth);
    for (std::size_t error = 0; error < errors.by_error.size(); ++error) {
      histogram[error / kBinWidth] += errors.by_error[error];
      all.by_error[error] += errors.by_error[error];
    }
    for (std::size_t cell = 0; cell < CameraErrors::kCells; ++cell) all.sums[cell] += errors.sums[cell];
    by_camera.push_back(
        {{"error", errors.mean()}, {"median", errors.median()}, {"points", errors.count()}, {"histogram", histogram}});
  }
  const BadPart part = worstPart(cameras);
  return {{"error", all.mean()},
          {"median", all.median()},
          {"points", all.count()},
          {"bin_width", kBinWidth},
          {"cameras", by_camera},
          {"worst_part",
           {{"camera", part.camera},
            {"error_ratio", part.error_ratio},
            {"share", part.share},
            {"left", part.left},
            {"top", part.top},
            {"right", part.right},
            {"bottom", part.bottom}}}};
}

}  // namespace cloud_colorizer
