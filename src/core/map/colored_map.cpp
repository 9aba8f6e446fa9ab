// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <set>

#include "base/file_io.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/map/colorize.hpp"
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

/// Appended where it is known: 0 to 255, from 128 on something that moved.
const Field kMovingField = {"moving", FieldType::kUint8, 1};

/// Names that our files give a meaning to.
bool isOurs(const std::string& name) {
  static const std::set<std::string> kOurs = {"rgb",           "red",          "green",        "blue",
                                              "view_count",    "color_stddev", "radiance_red", "radiance_green",
                                              "radiance_blue", "moving"};
  return kOurs.count(name) != 0;
}

bool marksMoving(const Recording& recording, const Params& params) {
  return params.colorize.moving == Moving::kMark && findsMoving(recording, params);
}

/// What is saved of a tile, one column or element a point.
struct TileToSave {
  Points points;
  TileColors colors;                 ///< as they are shown: 0 to 255
  Values radiance;                   ///< 3 x n, or empty: not saved
  std::vector<std::uint8_t> moving;  ///< or empty: not saved
  std::vector<bool> keep;            ///< false: left out
};

/// Of point i. rgb is 0x00RRGGBB, which rviz and PCL read as FLOAT32.
std::uint8_t* writeColor(const TileToSave& tile, std::size_t i, std::uint8_t* out) {
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
  if (!tile.moving.empty()) *out++ = tile.moving[i];
  return out;
}

/// The fields of a recording that go into its coloured map. Not the colours that an earlier run of this program gave a
/// map which is coloured again: they are replaced.
std::vector<Field> keptFields(const std::vector<Field>& fields) {
  if (!findField(fields, "view_count") || !findField(fields, "color_stddev")) return fields;
  std::vector<Field> kept;
  std::copy_if(fields.begin(), fields.end(), std::back_inserter(kept),
               [](const Field& field) { return !isOurs(field.name); });
  return kept;
}

/// All fields of the coloured map.
std::vector<Field> mapFields(const Recording& recording, bool with_radiance, bool with_moving) {
  std::vector<Field> fields = keptFields(recording.fields());
  std::set<std::string> given;
  for (const Field& field : fields) given.insert(field.name);
  for (Field& field : fields) {
    if (!isOurs(field.name) && field.name != "rgba") continue;
    do field.name = "input_" + field.name;
    while (given.count(field.name) != 0);
    given.insert(field.name);
  }
  fields.insert(fields.end(), kColorFields.begin(), kColorFields.end());
  if (with_radiance) fields.insert(fields.end(), kRadianceFields.begin(), kRadianceFields.end());
  if (with_moving) fields.push_back(kMovingField);
  return fields;
}

Cloud makeCloud(const Recording& recording, std::size_t tile, const TileToSave& saved, bool relative) {
  const std::vector<std::uint8_t> records = recording.readRecords(tile);
  const std::vector<Field> kept = keptFields(recording.fields());
  const RecordMap record_map(recording.fields(), kept);
  const std::size_t in_bytes = recordSize(recording.fields()), kept_bytes = recordSize(kept);
  const Eigen::Vector3d origin = relative ? Eigen::Vector3d::Zero() : recording.origin();

  Cloud cloud;
  cloud.fields = mapFields(recording, saved.radiance.cols() > 0, !saved.moving.empty());
  const auto num_kept = std::count(saved.keep.begin(), saved.keep.end(), true);
  cloud.positions.resize(3, num_kept);
  cloud.records.resize(static_cast<std::size_t>(num_kept) * recordSize(cloud.fields));
  std::uint8_t* out = cloud.records.data();
  Index next = 0;
  for (std::size_t i = 0; i < saved.keep.size(); ++i) {
    if (!saved.keep[i]) continue;
    cloud.positions.col(next++) = saved.points.col(static_cast<Index>(i)).cast<double>() + origin;
    if (kept_bytes > 0) record_map.copy(records.data() + i * in_bytes, out);
    out = writeColor(saved, i, out + kept_bytes);
  }
  return cloud;
}

/// Radiances to shown colours.
void show(const ToneField& tone, const Points& points, TileColors& colors) {
  const Eigen::RowVectorXf factors = tone.factors(points, colors.values);
  for (Index i = 0; i < points.cols(); ++i) {
    colors.values.col(i) *= factors[i];
    colors.stddev[static_cast<std::size_t>(i)] *= factors[i];
  }
}

/// The colours that were made with these parameters; nobody colours anew while they are read.
class ColoredTiles {
 public:
  ColoredTiles(const Recording& recording, const Params& params)
      : lock_(recording.directory(), false), work_(recording, params) {
    work_.restoreDamagedViews();
    work_.restoreCorrections();
    require(work_.files().holds(kColorsFolder, colorsKey(recording, params, work_.damagedViews(), work_.corrections())),
            "the colours in ", recording.directory(),
            " were made with other parameters or from fewer points; colour it again first");
  }

  std::size_t numPoints() const {
    const bool all = uncolored() != Uncolored::kDrop && !dropsMoving();
    if (all) return work_.recording().numPoints();
    std::size_t count = 0;
    for (std::size_t tile = 0; tile < work_.recording().tiles().size(); ++tile) {
      const std::vector<bool> keep = kept(work_.files().readColors(tile), movingOf(tile));
      count += static_cast<std::size_t>(std::count(keep.begin(), keep.end(), true));
    }
    return count;
  }

  void visit(bool relative, const std::function<void(const Cloud&)>& visitor) {
    const bool marks = marksMoving(work_.recording(), work_.params());
    const ToneField tone = makeTone(work_);
    for (std::size_t tile = 0; tile < work_.recording().tiles().size(); ++tile) {
      TileToSave saved{work_.recording().readPoints(tile), work_.files().readColors(tile), {}, movingOf(tile), {}};
      if (uncolored() == Uncolored::kFill) fillUncolored(work_, tile, saved.colors);
      saved.keep = kept(saved.colors, saved.moving);
      if (!marks) saved.moving.clear();
      if (work_.params().colorize.tone == Tone::kRadiance) saved.radiance = saved.colors.values;
      show(tone, saved.points, saved.colors);
      visitor(makeCloud(work_.recording(), tile, saved, relative));
    }
  }

 private:
  Uncolored uncolored() const { return work_.params().colorize.uncolored; }
  bool dropsMoving() const { return work_.params().colorize.moving == Moving::kDrop; }

  /// Empty where the recording cannot tell, or nobody asked.
  std::vector<std::uint8_t> movingOf(std::size_t tile) const {
    if (!findsMoving(work_.recording(), work_.params())) return {};
    return work_.files().readMoving(tile);
  }

  std::vector<bool> kept(const TileColors& colors, const std::vector<std::uint8_t>& moving) const {
    std::vector<bool> keep(colors.count.size());
    for (std::size_t i = 0; i < keep.size(); ++i) {
      keep[i] = (uncolored() != Uncolored::kDrop || colors.count[i] > 0) &&
                (!dropsMoving() || moving.empty() || moving[i] < kMovingShare);
    }
    return keep;
  }

  FolderLock lock_;
  Workspace work_;
};

}  // namespace

std::vector<Field> coloredFields(const Recording& recording, const Params& params) {
  return mapFields(recording, params.colorize.tone == Tone::kRadiance, marksMoving(recording, params));
}

std::string coloredCrs(const Recording& recording, const Params& params) {
  return params.colorize.crs.empty() ? recording.crs() : params.colorize.crs;
}

void forEachColoredTile(const Recording& recording, const Params& params, bool relative,
                        const std::function<void(const Cloud&)>& visit) {
  ColoredTiles(recording, params).visit(relative, visit);
}

namespace {

Eigen::AlignedBox3d boxAround(const Recording& recording) {
  Eigen::AlignedBox3d box;
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
    const Points points = recording.readPoints(tile);
    if (points.cols() == 0) continue;
    box.extend(points.rowwise().minCoeff().cast<double>() + recording.origin());
    box.extend(points.rowwise().maxCoeff().cast<double>() + recording.origin());
  }
  return box;
}

/// PCL reads x, y and z as floats only, which keep no centimetres of UTM coordinates. So the points of a PCD are
/// relative to the recording's origin, which stands beside it; CloudReader adds it again.
void writeOrigin(const std::string& path, const Eigen::Vector3d& origin, const Callbacks& callbacks) {
  const std::string file = originFile(path);
  if (origin.isZero()) {
    std::error_code ignored;
    if (lowerExtension(path) == ".pcd") std::filesystem::remove(file, ignored);  // of an earlier map
    return;
  }
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += (axis > 0 ? " " : "") + formatDouble(origin[axis]);
  const std::string line = text + '\n';
  writeFileAtomically(file, line.data(), line.size());
  if (callbacks.log) callbacks.log(LogLevel::kInfo, path + " is relative to " + text + ", as " + file + " says");
}

}  // namespace

std::size_t saveColored(const Recording& recording, const Params& params, const std::string& path,
                        const Callbacks& callbacks) {
  CloudWriter::checkPath(path);
  ColoredTiles tiles(recording, params);
  const std::size_t num_points = tiles.numPoints();
  const bool is_far = !recording.origin().isZero();
  const bool is_relative = is_far && lowerExtension(path) == ".pcd";
  const Eigen::AlignedBox3d box = lowerExtension(path) == ".las" ? boxAround(recording) : Eigen::AlignedBox3d();
  CloudWriter writer(path, num_points, coloredFields(recording, params), is_far && !is_relative, box,
                     coloredCrs(recording, params));
  ProgressMeter progress(callbacks, "save", num_points);
  tiles.visit(is_relative, [&](const Cloud& cloud) {
    writer.write(cloud);
    progress.add(static_cast<std::size_t>(cloud.positions.cols()));
  });
  writeOrigin(path, is_relative ? recording.origin() : Eigen::Vector3d::Zero().eval(), callbacks);
  writer.finish();
  return num_points;
}

std::vector<Eigen::Isometry3d> usedPoses(const Recording& recording, const Params& params) {
  const FolderLock lock(recording.directory(), false);
  Workspace work(recording, params);
  work.restoreDamagedViews();
  const bool aligned = work.restoreCorrections();
  require(aligned || !work.params().aligns() || !std::filesystem::exists(work.files().pathOf(kAlignmentFolder)),
          "the poses in ", work.files().pathOf(kAlignmentFolder),
          " were found with other parameters or from other views, or are damaged; colour the recording again first");
  std::vector<Eigen::Isometry3d> poses;
  for (const CorrectedView& view : work.corrections()) poses.push_back(view.map_from_camera);
  return poses;
}

}  // namespace cloud_colorizer
