// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/colored_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "cloud_colorizer/base/check.hpp"
#include "color/quantity.hpp"
#include "map/fill.hpp"
#include "map/fingerprint.hpp"
#include "map/stages.hpp"
#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// What is appended to a point's record.
const std::vector<Field> kColorFields = {
    {"rgb", FieldType::kFloat32, 1}, {"view_count", FieldType::kUint16, 1}, {"color_stddev", FieldType::kFloat32, 1}};

/// Appended with `tone: radiance`: in one exposure for the whole map, without a limit; 255 is white in that exposure.
const std::vector<Field> kRadianceFields = {{"radiance_red", FieldType::kFloat32, 1},
                                            {"radiance_green", FieldType::kFloat32, 1},
                                            {"radiance_blue", FieldType::kFloat32, 1}};

/// Appended with `appearance`: without sheen, 0 to 255, and the share of 255 of the brightness that is sheen at most.
const std::vector<Field> kSheenFields = {{"diffuse_red", FieldType::kFloat32, 1},
                                         {"diffuse_green", FieldType::kFloat32, 1},
                                         {"diffuse_blue", FieldType::kFloat32, 1},
                                         {"specular", FieldType::kUint8, 1}};

/// Appended where it is known: 0 to 255, from 128 on something that moved.
const Field kMovingField = {"moving", FieldType::kUint8, 1};

bool marksMoving(const Recording& recording, const Params& params) {
  return params.colorize.moving == Moving::kMark && findsMoving(recording, params);
}

/// Beside the colours.
std::vector<Field> quantityFields(const Recording& recording) {
  std::vector<Field> all;
  for (const Quantity& quantity : recording.quantities()) {
    const std::vector<Field> fields = fieldsOf(quantity);
    all.insert(all.end(), fields.begin(), fields.end());
  }
  return all;
}

/// Names that our files give a meaning to.
bool isOurs(const Recording& recording, const std::string& name) {
  static const std::set<std::string> kOurs = {"rgb",           "red",          "green",        "blue",
                                              "view_count",    "color_stddev", "radiance_red", "radiance_green",
                                              "radiance_blue", "moving",       "diffuse_red",  "diffuse_green",
                                              "diffuse_blue",  "specular"};
  return kOurs.count(name) != 0 || findField(quantityFields(recording), name);
}

/// Of point i. rgb is 0x00RRGGBB, which rviz and PCL read as FLOAT32.
std::uint8_t* writeColor(const ShownTile& tile, const std::vector<Field>& quantities, std::size_t i,
                         std::uint8_t* out) {
  const auto append = [&out](const void* data, std::size_t size) {
    out = std::copy_n(static_cast<const std::uint8_t*>(data), size, out);
  };
  const auto column = static_cast<Index>(i);
  std::uint32_t rgb = 0;
  for (Index channel = 0; channel < 3; ++channel) {
    const float value = std::clamp(tile.colors.values(channel, column), 0.F, 255.F);
    rgb = rgb << 8U | static_cast<std::uint32_t>(std::lround(value));
  }
  append(&rgb, sizeof(rgb));
  append(&tile.colors.count[i], sizeof(tile.colors.count[i]));
  append(&tile.colors.stddev[i], sizeof(tile.colors.stddev[i]));
  if (tile.radiance.cols() > 0) append(tile.radiance.col(column).data(), 3 * sizeof(float));
  if (tile.colors.diffuse.cols() > 0) {
    append(tile.colors.diffuse.col(column).data(), 3 * sizeof(float));
    append(&tile.colors.specular[i], 1);
  }
  if (!tile.moving.empty()) *out++ = tile.moving[i];
  for (std::size_t row = 0; row < quantities.size(); ++row) {
    const float value = tile.colors.quantities(static_cast<Index>(row), column);
    if (quantities[row].type == FieldType::kUint16) {
      const auto whole = static_cast<std::uint16_t>(std::min(value, 65535.F));
      append(&whole, sizeof whole);
    } else {
      append(&value, sizeof value);
    }
  }
  return out;
}

/// The fields of a recording that go into its coloured map. Not the colours that an earlier run of this program gave a
/// map which is coloured again: they are replaced.
std::vector<Field> keptFields(const Recording& recording) {
  const std::vector<Field>& fields = recording.fields();
  if (!findField(fields, "view_count") || !findField(fields, "color_stddev")) return fields;
  std::vector<Field> kept;
  std::copy_if(fields.begin(), fields.end(), std::back_inserter(kept),
               [&](const Field& field) { return !isOurs(recording, field.name); });
  return kept;
}

/// All fields of the coloured map.
std::vector<Field> mapFields(const Recording& recording, bool with_radiance, bool with_sheen, bool with_moving) {
  std::vector<Field> fields = keptFields(recording);
  std::set<std::string> given;
  for (const Field& field : fields) given.insert(field.name);
  for (Field& field : fields) {
    if (!isOurs(recording, field.name) && field.name != "rgba") continue;
    do field.name = "input_" + field.name;
    while (given.count(field.name) != 0);
    given.insert(field.name);
  }
  fields.insert(fields.end(), kColorFields.begin(), kColorFields.end());
  if (with_radiance) fields.insert(fields.end(), kRadianceFields.begin(), kRadianceFields.end());
  if (with_sheen) fields.insert(fields.end(), kSheenFields.begin(), kSheenFields.end());
  if (with_moving) fields.push_back(kMovingField);
  const std::vector<Field> quantities = quantityFields(recording);
  fields.insert(fields.end(), quantities.begin(), quantities.end());
  return fields;
}

Cloud makeCloud(const Recording& recording, const ShownTile& saved, bool relative) {
  const std::vector<std::uint8_t> records = recording.readRecords(saved.tile);
  const std::vector<Field> kept = keptFields(recording), quantities = quantityFields(recording);
  const RecordMap record_map(recording.fields(), kept);
  const std::size_t in_bytes = recordSize(recording.fields()), kept_bytes = recordSize(kept);
  const Eigen::Vector3d origin = relative ? Eigen::Vector3d::Zero() : recording.origin();

  Cloud cloud;
  cloud.fields =
      mapFields(recording, saved.radiance.cols() > 0, saved.colors.diffuse.cols() > 0, !saved.moving.empty());
  const auto num_kept = std::count(saved.keep.begin(), saved.keep.end(), true);
  cloud.positions.resize(3, num_kept);
  cloud.records.resize(static_cast<std::size_t>(num_kept) * recordSize(cloud.fields));
  std::uint8_t* out = cloud.records.data();
  Index next = 0;
  for (std::size_t i = 0; i < saved.keep.size(); ++i) {
    if (!saved.keep[i]) continue;
    cloud.positions.col(next++) = saved.points.col(static_cast<Index>(i)).cast<double>() + origin;
    if (kept_bytes > 0) record_map.copy(records.data() + i * in_bytes, out);
    out = writeColor(saved, quantities, i, out + kept_bytes);
  }
  return cloud;
}

/// Radiances to shown colours.
void show(const ToneField& tone, const Points& points, TileColors& colors) {
  constexpr float kWhite = 255;
  const Eigen::RowVectorXf factors = tone.factors(points, colors.values);
  for (Index i = 0; i < points.cols(); ++i) {
    colors.values.col(i) *= factors[i];
    if (colors.diffuse.cols() > 0) colors.diffuse.col(i) = (factors[i] * colors.diffuse.col(i)).cwiseMin(kWhite);
    colors.stddev[static_cast<std::size_t>(i)] *= factors[i];
  }
}

}  // namespace

ColoredTiles::ColoredTiles(const Recording& recording, const Params& params)
    : lock_(recording.directory(), false), work_(recording, params) {
  work_.restoreDamagedViews();
  work_.restoreCorrections();
  require(work_.files().holds(kColorsFolder,
                              colorsKey(recording, work_.params(), work_.damagedViews(), work_.corrections())),
          "the colours in ", recording.directory(),
          " were made with other parameters or from fewer points; colour it again first");
}

std::size_t ColoredTiles::countPoints(const TileIds& tiles) const {
  const ColorizeParams& params = work_.params().colorize;
  if (params.uncolored != Uncolored::kDrop && params.moving != Moving::kDrop) {
    return cloud_colorizer::countPoints(recording().tiles(), tiles);
  }
  std::size_t count = 0;
  for (const std::size_t tile : tiles) {
    const std::vector<bool> keep = kept(work_.files().readColors(tile), movingOf(tile));
    count += static_cast<std::size_t>(std::count(keep.begin(), keep.end(), true));
  }
  return count;
}

void ColoredTiles::visit(const TileIds& tiles, bool relative, const std::function<void(const Cloud&)>& visitor) {
  visitShown(tiles, [&](const ShownTile& shown) { visitor(makeCloud(recording(), shown, relative)); });
}

void ColoredTiles::visitShown(const TileIds& tiles, const std::function<void(const ShownTile&)>& visitor) {
  const ColorizeParams& params = work_.params().colorize;
  const bool marks = marksMoving(recording(), work_.params());
  if (!tone_) tone_ = makeTone(work_);
  for (const std::size_t tile : tiles) {
    ShownTile saved{tile, recording().readPoints(tile), work_.files().readColors(tile), {}, movingOf(tile), {}};
    if (params.uncolored == Uncolored::kFill) fillUncolored(work_, tile, saved.colors);
    saved.keep = kept(saved.colors, saved.moving);
    if (!marks) saved.moving.clear();
    if (params.tone == Tone::kRadiance) saved.radiance = saved.colors.values;
    show(*tone_, saved.points, saved.colors);
    visitor(saved);
  }
}

/// Empty where the recording cannot tell, or nobody asked.
std::vector<std::uint8_t> ColoredTiles::movingOf(std::size_t tile) const {
  if (!findsMoving(recording(), work_.params())) return {};
  return work_.files().readMoving(tile);
}

std::vector<bool> ColoredTiles::kept(const TileColors& colors, const std::vector<std::uint8_t>& moving) const {
  const ColorizeParams& params = work_.params().colorize;
  std::vector<bool> keep(colors.count.size());
  for (std::size_t i = 0; i < keep.size(); ++i) {
    keep[i] = (params.uncolored != Uncolored::kDrop || colors.count[i] > 0) &&
              (params.moving != Moving::kDrop || moving.empty() || moving[i] < kMovingShare);
  }
  return keep;
}

std::vector<Field> coloredFields(const Recording& recording, const Params& params) {
  return mapFields(recording, params.colorize.tone == Tone::kRadiance, params.colorize.appearance != Appearance::kNone,
                   marksMoving(recording, params));
}

std::string coloredCrs(const Recording& recording, const Params& params) {
  return params.colorize.crs.empty() ? recording.crs() : params.colorize.crs;
}

}  // namespace cloud_colorizer
