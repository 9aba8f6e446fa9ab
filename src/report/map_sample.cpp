// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/map_sample.hpp"

#include <algorithm>
#include <cmath>

#include "base/progress.hpp"
#include "cloud/cloud_layout.hpp"
#include "cloud/intensity.hpp"
#include "map/colored_tiles.hpp"
#include "report/seams.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::size_t kSteps = 65535;  // of a coordinate

std::uint8_t byteOf(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(std::isfinite(value) ? value : 0.0), 0L, 255L));
}

std::vector<float> coloredAxisOf(const MapSample& sample, std::size_t axis) {
  std::vector<float> values;
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (sample.counts[i] > 0) values.push_back(sample.positions[3 * i + axis]);
  }
  return values;
}

/// The `width` values of every `step`-th point.
template <class T>
void append(std::string& bytes, const std::vector<T>& values, std::size_t width, std::size_t step) {
  for (std::size_t i = 0; i < values.size(); i += width * step) {
    bytes.append(reinterpret_cast<const char*>(values.data() + i), width * sizeof(T));
  }
}

/// Every so many of `count` things are at most `most`.
std::size_t stepFor(std::size_t count, std::size_t most) {
  return std::max<std::size_t>(1, count / most + (count % most > 0 ? 1 : 0));
}

}  // namespace

float percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Eigen::AlignedBox3f MapSample::coloredBox() const {
  Eigen::Vector3f low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<float> values = coloredAxisOf(*this, axis);
    low[static_cast<Eigen::Index>(axis)] = percentile(values, 0.01);
    high[static_cast<Eigen::Index>(axis)] = percentile(values, 0.99);
  }
  return {low, high};
}

MapSample sampleMap(const Recording& recording, const Params& params, std::size_t num_points, std::size_t most,
                    const Callbacks& callbacks) {
  MapSample sample;
  std::vector<float> intensity;
  const std::size_t step = stepFor(num_points, most);
  std::size_t number = 0;
  const auto strength = findIntensity(recording.fields());
  const std::size_t record_size = recordSize(recording.fields());
  ColoredTiles tiles(recording, params);
  ProgressMeter progress(callbacks, "report", recording.numPoints());
  SeamMeter seams(recording, params);
  tiles.visitShown(allTiles(recording.tiles()), [&](const ShownTile& shown) {
    seams.add(shown);
    const std::vector<float> thicknesses = tiles.work().files().readThicknesses(shown.tile);
    std::vector<std::uint8_t> records;
    if (strength) records = recording.readRecords(shown.tile);
    for (std::size_t i = 0; i < shown.keep.size(); ++i) {
      if (!shown.keep[i] || number++ % step != 0) continue;
      const auto column = static_cast<Eigen::Index>(i);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        sample.positions.push_back(shown.points(axis, column));
        sample.colors.push_back(byteOf(shown.colors.values(axis, column)));
        sample.nearest.push_back(shown.colors.nearest[i][static_cast<std::size_t>(axis)]);
      }
      sample.counts.push_back(byteOf(shown.colors.count[i]));
      sample.deviations.push_back(byteOf(shown.colors.stddev[i]));
      sample.moving.push_back(shown.moving.empty() ? std::uint8_t{0} : shown.moving[i]);
      sample.cameras.push_back(shown.colors.camera[i]);
      sample.reasons.push_back(static_cast<std::uint8_t>(shown.colors.unseen[i]));
      sample.thicknesses.push_back(thicknesses[i]);
      if (!strength) continue;
      const double value = numberAt(records.data() + i * record_size + strength->offset, strength->field.type);
      intensity.push_back(static_cast<float>(value));
    }
    progress.add(shown.keep.size());
  });
  if (seams.numBorderCells() > 0) sample.seam = seams.excess();
  if (intensity.size() == sample.size()) {
    const float low = percentile(intensity, 0.01), range = percentile(intensity, 0.99) - low;
    for (const float value : intensity)
      sample.intensity.push_back(byteOf(255 * (value - low) / std::max(range, 1e-9F)));
  }
  return sample;
}

nlohmann::json packSample(const MapSample& sample, std::string& base64, std::size_t most) {
  const std::size_t step = stepFor(sample.size(), most);
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < sample.size(); i += step) box.extend(Eigen::Vector3f(sample.positions.data() + 3 * i));
  if (box.isEmpty()) box.extend(Eigen::Vector3f(0, 0, 0));
  const float grid = std::max(box.sizes().maxCoeff(), 1e-6F) / static_cast<float>(kSteps);
  std::vector<std::uint16_t> steps;
  for (std::size_t i = 0; i < sample.size(); i += step) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = box.min()[static_cast<Eigen::Index>(axis)];
      steps.push_back(static_cast<std::uint16_t>(std::lround((sample.positions[3 * i + axis] - low) / grid)));
    }
  }
  std::string bytes;
  append(bytes, steps, 3, 1);
  append(bytes, sample.colors, 3, step);
  append(bytes, sample.nearest, 3, step);
  const float scale = std::max(percentile(sample.thicknesses, 0.99), 1e-9F);
  std::vector<std::uint8_t> thicknesses;
  for (const float thickness : sample.thicknesses) thicknesses.push_back(byteOf(255 * thickness / scale));
  const std::initializer_list<const std::vector<std::uint8_t>*> columns = {
      &sample.counts,  &sample.deviations, &sample.moving,   &sample.reasons,
      &sample.cameras, &thicknesses,       &sample.intensity};
  for (const auto* values : columns) {
    append(bytes, *values, 1, step);
  }
  base64 = base64Of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  return {{"count", stepFor(sample.size(), step)},
          {"low", {box.min().x(), box.min().y(), box.min().z()}},
          {"step", grid},
          {"thickness_scale", scale},
          {"has_intensity", !sample.intensity.empty()}};
}

std::string base64Of(const std::uint8_t* bytes, std::size_t size) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((size + 2) / 3 * 4);
  for (std::size_t i = 0; i < size; i += 3) {
    std::uint32_t group = static_cast<std::uint32_t>(bytes[i]) << 16U;
    if (i + 1 < size) group |= static_cast<std::uint32_t>(bytes[i + 1]) << 8U;
    if (i + 2 < size) group |= bytes[i + 2];
    for (unsigned digit = 0; digit < 4; ++digit) {
      text += i + digit > size ? '=' : kDigits[group >> (18U - 6U * digit) & 63U];
    }
  }
  return text;
}

}  // namespace cloud_colorizer
