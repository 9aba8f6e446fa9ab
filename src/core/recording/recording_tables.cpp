// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_tables.hpp"

#include <fcntl.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "recording/image_files.hpp"

namespace cloud_colorizer {

namespace {

namespace fs = std::filesystem;

constexpr const char* kViewsHeader = "camera,stamp,x,y,z,qx,qy,qz,qw,image\n";
constexpr const char* kReadoutsHeader = "view,rx,ry,rz,tx,ty,tz\n";
constexpr const char* kScansHeader = "stamp,x,y,z,qx,qy,qz,qw,ranges\n";
constexpr const char* kCloudsHeader = "stamp,sensor\n";

std::string viewsPath(const std::string& directory) {
  return directory + "/views.csv";
}
std::string scansPath(const std::string& directory) {
  return directory + "/scans.csv";
}
std::string readoutsPath(const std::string& directory) {
  return directory + "/readouts.csv";
}
std::string cloudsPath(const std::string& directory) {
  return directory + "/clouds.csv";
}

/// `count` numbers, and after them `texts` other values.
std::vector<double> parseNumbers(const std::vector<std::string>& parts, std::size_t count, std::size_t texts,
                                 const std::string& where) {
  require(parts.size() == count + texts, where, " is damaged: it has ", parts.size(), " values instead of ",
          count + texts);
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    require(parseDouble(parts[i], values[i]) && std::isfinite(values[i]), where, " is damaged: \"", parts[i],
            "\" is no number");
  }
  return values;
}

Eigen::Isometry3d makePose(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = translation;
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

/// x, y, z, qx, qy, qz, qw.
Eigen::Isometry3d parsePose(const double* values, const std::string& where) {
  const Eigen::Quaterniond rotation(values[6], values[3], values[4], values[5]);
  require(std::abs(rotation.norm() - 1) < 1e-3, where, " is damaged: its quaternion has the norm ", rotation.norm());
  return makePose(Eigen::Vector3d(values[0], values[1], values[2]), rotation);
}

std::string poseText(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond rotation(pose.linear());
  std::string text;
  for (int axis = 0; axis < 3; ++axis) text += ',' + formatDouble(pose.translation()[axis]);
  for (int i = 0; i < 4; ++i) text += ',' + formatDouble(rotation.coeffs()[i]);
  return text;
}

View parseView(const std::string& line, const std::string& where) {
  const auto parts = splitAt(line, ',');
  const std::vector<double> values = parseNumbers(parts, 9, 1, where);
  require(values[0] >= 0 && values[0] < 1e6, where, " is damaged: there is no camera ", parts[0]);
  View view;
  view.camera = static_cast<std::uint32_t>(values[0]);
  view.stamp = values[1];
  view.map_from_camera = parsePose(values.data() + 2, where);
  view.image = parts.back();
  return view;
}

Scan parseScan(const std::string& line, const std::string& where) {
  const auto parts = splitAt(line, ',');
  const std::vector<double> values = parseNumbers(parts, 8, 1, where);
  return {values[0], parsePose(values.data() + 1, where), parts.back()};
}

/// How the camera of a view moved while its image was read.
struct Readout {
  double view = 0;
  Twist motion = Twist::Zero();
};

Readout parseReadout(const std::string& line, const std::string& where) {
  const std::vector<double> values = parseNumbers(splitAt(line, ','), 7, 0, where);
  return {values[0], Eigen::Map<const Twist>(values.data() + 1)};
}

std::string wholeLine(const std::string& line, const std::string&) {
  return line;
}

/// Of views, as they are named in it.
std::set<std::string> listMasks(const std::string& directory) {
  std::set<std::string> masks;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(directory + "/images", error), end; !error && entry != end;
       entry.increment(error)) {
    std::string path = fs::path(entry->path()).lexically_relative(directory).string();
    if (endsWith(path, ".mask.png")) masks.insert(std::move(path));
  }
  return masks;
}

template <class Row>
Table<Row> readTable(const std::string& path, const std::string& header,
                     Row (*parse)(const std::string&, const std::string&)) {
  Table<Row> table;
  if (!std::filesystem::exists(path)) return table;
  const auto bytes = readFile(path);
  const std::string text(bytes.begin(), bytes.end());
  std::size_t number = 0;
  for (auto end = text.find('\n'); end != std::string::npos; end = text.find('\n', table.num_bytes)) {
    const auto line = text.substr(table.num_bytes, end - table.num_bytes);
    const auto where = path + " line " + std::to_string(++number);
    if (number == 1) {
      require(line + '\n' == header, where, " is damaged: it must be ", header);
    } else {
      table.rows.push_back(parse(line, where));
    }
    table.num_bytes = end + 1;
  }
  return table;
}

}  // namespace

Eigen::Isometry3d poseInTable(const Eigen::Isometry3d& pose) {
  return makePose(pose.translation(), Eigen::Quaterniond(pose.linear()));
}

Table<View> readViews(const std::string& directory) {
  Table<View> table = readTable(viewsPath(directory), kViewsHeader, parseView);
  const std::set<std::string> masks = listMasks(directory);
  for (View& view : table.rows) {
    const std::string mask = maskFileOf(view.image);
    if (masks.count(mask) != 0) view.mask = mask;
  }
  // Written before their views: one may be of a view that a killed program could not write, and another came later.
  for (const Readout& readout : readTable(readoutsPath(directory), kReadoutsHeader, parseReadout).rows) {
    if (!(readout.view >= 0 && readout.view < static_cast<double>(table.rows.size()))) continue;
    table.rows[static_cast<std::size_t>(readout.view)].readout_motion = readout.motion;
  }
  return table;
}

bool hasReadouts(const std::string& directory) {
  return fs::exists(readoutsPath(directory));
}

Table<Scan> readScans(const std::string& directory) {
  return readTable(scansPath(directory), kScansHeader, parseScan);
}

Table<std::string> readClouds(const std::string& directory) {
  return readTable(cloudsPath(directory), kCloudsHeader, wholeLine);
}

std::string viewLine(const View& view) {
  return std::to_string(view.camera) + ',' + formatFixed(view.stamp, 9) + poseText(view.map_from_camera) + ',' +
         view.image + '\n';
}

std::string scanLine(const Scan& scan) {
  return formatFixed(scan.stamp, 9) + poseText(scan.map_from_sensor) + ',' + scan.image + '\n';
}

TableWriter TableWriter::ofViews(const std::string& directory) {
  return {viewsPath(directory), kViewsHeader, readViews(directory).num_bytes};
}

std::string readoutLine(std::size_t view, const Twist& motion) {
  std::string text = std::to_string(view);
  for (const double value : motion) text += ',' + formatDouble(value);
  return text + '\n';
}

TableWriter TableWriter::ofReadouts(const std::string& directory) {
  const auto table = readTable(readoutsPath(directory), kReadoutsHeader, parseReadout);
  return {readoutsPath(directory), kReadoutsHeader, table.num_bytes};
}

TableWriter TableWriter::ofScans(const std::string& directory) {
  return {scansPath(directory), kScansHeader, readScans(directory).num_bytes};
}

TableWriter TableWriter::ofClouds(const std::string& directory) {
  return {cloudsPath(directory), kCloudsHeader, readClouds(directory).num_bytes};
}

TableWriter::TableWriter(const std::string& path, const char* header, std::uint64_t num_bytes)
    : file_(path, O_WRONLY | O_CREAT), size_(num_bytes) {
  file_.truncate(size_);
  if (size_ == 0) append(header);
}

void TableWriter::append(const std::string& lines) {
  try {
    file_.writeAt(size_, lines.data(), lines.size());
  } catch (const std::runtime_error&) {
    file_.truncate(size_);
    throw;
  }
  size_ += lines.size();
}

}  // namespace cloud_colorizer
