// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/city.hpp"

#include <algorithm>
#include <cmath>

#include "cloud_colorizer/base/check.hpp"
#include "evaluation/score.hpp"
#include "evaluation/table.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

constexpr std::size_t kSample = 4000000;  // points
constexpr double kCellsOfTile = 32;       // a side; cells of a plane are as wide and as deep
constexpr double kSamePlace = 1e-3;       // m
constexpr std::array<const char*, 3> kTrueColor = {"true_red", "true_green", "true_blue"};
constexpr std::uint32_t kLeastPoints = 8;  // of a cell's side

LocatedField fieldOf(const std::vector<Field>& fields, const std::string& name, const std::string& source) {
  const auto found = findField(fields, name);
  require(found.has_value(), source, ": has no field ", name,
          "; only what `simulate city` wrote has it, and maps that keep all "
          "fields; else give --cloud");
  return *found;
}

}  // namespace

CitySeams::CitySeams(const Recording& recording, const ChunkParams& params)
    : origin_(recording.origin()), tile_size_(recording.tileSize()), width_(tile_size_ / kCellsOfTile) {
  for (const Chunk& chunk : planChunks(recording.tiles(), tile_size_, params)) {
    for (const std::size_t tile : chunk.core_tiles) {
      box_of_tile_[recording.tiles()[tile].index] = {chunk.low, chunk.high};
    }
  }
}

void CitySeams::add(const Eigen::Vector3d& point, double error) {
  const Eigen::Vector3d at = point - origin_;
  TileIndex tile{};
  for (int axis = 0; axis < 3; ++axis) {
    tile[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(std::floor(at[axis] / tile_size_));
  }
  const auto box = box_of_tile_.find(tile);
  if (box == box_of_tile_.end()) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    addToPlane(axis, box->second.low[axis], at, error);
    addToPlane(axis, box->second.high[axis], at, error);
  }
}

void CitySeams::addToPlane(std::size_t axis, std::int32_t plane, const Eigen::Vector3d& point, double error) {
  const auto along = static_cast<Index>(axis);
  const double strip = std::floor((point[along] - plane * tile_size_) / width_) + 2;
  if (strip < 0 || strip > 3) return;
  const auto cell = [&](Index other) {
    return static_cast<std::int32_t>(std::floor(point[(along + other) % 3] / width_));
  };
  Strips& strips = places_[{static_cast<std::int32_t>(axis), plane, cell(1), cell(2)}];
  strips.sum[static_cast<std::size_t>(strip)] += error;
  ++strips.count[static_cast<std::size_t>(strip)];
}

CitySeams::Steps CitySeams::steps() const {
  Steps steps;
  double count = 0;
  for (const auto& [place, strips] : places_) {
    if (*std::min_element(strips.count.begin(), strips.count.end()) < kLeastPoints) continue;
    std::array<double, 4> mean{};
    for (std::size_t k = 0; k < 4; ++k) mean[k] = strips.sum[k] / strips.count[k];
    steps.at_borders += std::abs(mean[2] - mean[1]);
    steps.beside += (std::abs(mean[1] - mean[0]) + std::abs(mean[3] - mean[2])) / 2;
    count += 1;
  }
  if (count == 0) return {};
  return {steps.at_borders / count, steps.beside / count};
}

CityScore::CityScore(const std::vector<Field>& truth_fields, const std::string& truth_source, std::size_t num_points,
                     std::string map_source)
    : source_(std::move(map_source)), step_(std::max<std::size_t>(1, num_points / kSample)) {
  for (std::size_t c = 0; c < 3; ++c) true_color_[c] = fieldOf(truth_fields, kTrueColor[c], truth_source);
  seen_ = fieldOf(truth_fields, "seen", truth_source);
  hidden_ = fieldOf(truth_fields, "hidden", truth_source);
}

void CityScore::add(const Cloud& map, const Cloud& truth, CitySeams* seams) {
  const bool same = map.positions.cols() == truth.positions.cols() &&
                    (map.positions.cols() == 0 || (map.positions - truth.positions).cwiseAbs().maxCoeff() < kSamePlace);
  require(same, source_, ": its points are not those of the cloud with the truth, in their order");
  const ColoredCloud colored = coloredCloud(map, source_);
  const std::size_t size = recordSize(truth.fields);
  for (std::size_t p = 0; p < colored.count.size(); ++p) {
    const std::uint8_t* const record = truth.records.data() + p * size;
    const auto number = [&](const LocatedField& field) { return numberAt(record + field.offset, field.field.type); };
    const bool has_color = colored.count[p] > 0, is_seen = number(seen_) > 0;
    const auto count = [&](Share& share) { ++share.all, share.colored += has_color ? 1 : 0; };
    if (is_seen) count(visible_);
    if (number(hidden_) > 0) count(hidden_share_);
    const bool in_sample = next_++ % step_ == 0 && is_seen;
    if (!has_color || (!in_sample && seams == nullptr)) continue;
    const auto column = static_cast<Index>(p);
    double error = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double true_value = number(true_color_[c]), color = colored.colors(static_cast<Index>(c), column);
      error += (color - true_value) / 3;
      if (!in_sample) continue;
      truth_.push_back(static_cast<float>(true_value));
      colors_.push_back(static_cast<float>(color));
    }
    if (seams != nullptr) seams->add(colored.positions.col(column), error);
  }
}

std::string CityScore::Share::describe() const {
  if (all == 0) return "none";
  return formatNumber(100 * static_cast<double>(colored) / static_cast<double>(all), 2) + " % of " +
         std::to_string(all);
}

std::string CityScore::describe() const {
  require(!colors_.empty(), source_, ": no point that a camera sees is coloured");
  const auto num = static_cast<Index>(colors_.size() / 3);
  const Score score =
      scoreColors(Eigen::Map<const Values>(truth_.data(), 3, num), Eigen::Map<const Values>(colors_.data(), 3, num),
                  std::vector<std::uint8_t>(static_cast<std::size_t>(num), 1));
  return "visible points coloured: " + visible_.describe() + "\nhidden points coloured: " + hidden_share_.describe() +
         "\nerrors of " + std::to_string(num) + " visible ones: AEP " + formatNumber(score.aep, 2) +
         ", after one gain " + formatNumber(score.aep_gain, 2);
}

}  // namespace cloud_colorizer
