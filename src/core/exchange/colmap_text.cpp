// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colmap_entries.hpp: the text files.

#include <algorithm>
#include <filesystem>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "exchange/colmap_entries.hpp"
#include "exchange/text_lines.hpp"

namespace cloud_colorizer {
namespace {

long long parseId(const std::string& word, const std::string& where) {
  long long id = 0;
  require(parseInteger(word, id) && id >= 0, where, ": \"", word, "\" is no id or size");
  return id;
}

bool isNumber(const std::string& word) {
  double number = 0;
  return parseDouble(word, number);
}

/// The words of a line, one after the other.
class Words {
 public:
  Words(const std::string& line, std::string where, std::string form)
      : words_(splitWords(line)), where_(std::move(where)), form_(std::move(form)) {}
  const std::string& next() {
    require(at_ < words_.size(), where_, ": the line ends too early; it is `", form_, "`");
    return words_[at_++];
  }
  long long nextId() { return parseId(next(), where_); }
  double nextNumber() { return finiteNumber(next(), where_); }
  ColmapEntries::Pose nextPose() {
    double v[7];
    for (double& value : v) value = nextNumber();
    return {{v[0], v[1], v[2], v[3]}, {v[4], v[5], v[6]}};
  }
  ColmapEntries::Sensor nextSensor() {
    const std::string type = next();
    return {type, nextId()};
  }
  bool atEnd() const { return at_ == words_.size(); }
  const std::string& where() const { return where_; }

 private:
  std::vector<std::string> words_;
  std::string where_, form_;
  std::size_t at_ = 0;
};

void readCameras(LineFile file, ColmapEntries& entries) {
  for (std::string line; file.nextEntry(line);) {
    Words words(line, file.where(), "CAMERA_ID MODEL WIDTH HEIGHT PARAMS...");
    ColmapEntries::Camera camera;
    camera.where = file.where();
    camera.id = words.nextId();
    camera.model = words.next();
    camera.width = words.nextId();
    camera.height = words.nextId();
    while (!words.atEnd()) camera.params.push_back(words.nextNumber());
    entries.cameras.push_back(camera);
  }
}

/// The points of an image are triples of numbers, and its line ends in a name.
bool isPoints(const std::vector<std::string>& words) {
  return words.size() % 3 == 0 && std::all_of(words.begin(), words.end(), isNumber);
}

/// Some of the triples X Y POINT3D_ID that have a point.
std::vector<ColmapEntries::Sight> someSights(const std::vector<std::string>& words) {
  std::vector<ColmapEntries::Sight> sights;
  const std::size_t step = std::max<std::size_t>(1, words.size() / 3 / ColmapEntries::kMostSights);
  for (std::size_t i = 0; i + 2 < words.size(); i += 3 * step) {
    ColmapEntries::Sight sight;
    if (!parseInteger(words[i + 2], sight.point) || sight.point < 0) continue;
    parseDouble(words[i], sight.pixel.x());
    parseDouble(words[i + 1], sight.pixel.y());
    sights.push_back(sight);
  }
  return sights;
}

void readImages(LineFile file, ColmapEntries& entries) {
  std::string line;
  bool has_line = file.nextEntry(line);
  while (has_line) {
    Words words(line, file.where(), "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    ColmapEntries::Image image;
    image.where = file.where();
    image.id = words.nextId();
    image.camera_from_map = words.nextPose();
    image.camera = words.nextId();
    image.name = words.next();
    while (!words.atEnd()) image.name += ' ' + words.next();
    // The points of the image follow, on a line that is often empty, and that some programs leave out.
    has_line = file.next(line);
    const auto points = splitWords(line);
    if (has_line && (!LineFile::isEntry(line) || isPoints(points))) {
      image.sights = someSights(points);
      has_line = file.nextEntry(line);
    }
    entries.images.push_back(std::move(image));
  }
}

void readPoints(LineFile file, ColmapEntries& entries) {
  const std::set<long long> wanted = entries.pointsOfSights();
  for (std::string line; file.nextEntry(line);) {
    Words words(line, file.where(), "POINT3D_ID X Y Z R G B ERROR TRACK...");
    const long long id = words.nextId();
    const double x = words.nextNumber(), y = words.nextNumber(), z = words.nextNumber();
    entries.addPoint(id, {x, y, z}, wanted);
  }
}

void readRigs(LineFile file, ColmapEntries& entries) {
  for (std::string line; file.nextEntry(line);) {
    Words words(line, file.where(), "RIG_ID NUM_SENSORS REF_SENSOR_TYPE REF_SENSOR_ID SENSORS...");
    ColmapEntries::Rig rig;
    rig.id = words.nextId();
    const long long num_sensors = words.nextId();
    for (long long i = 0; i < num_sensors; ++i) {
      const ColmapEntries::Sensor sensor = words.nextSensor();
      if (i == 0) {
        rig.sensor_from_rig[sensor] = {};
      } else if (words.nextId() != 0) {
        rig.sensor_from_rig[sensor] = words.nextPose();
      }
    }
    entries.rigs.push_back(rig);
  }
}

void readFrames(LineFile file, ColmapEntries& entries) {
  for (std::string line; file.nextEntry(line);) {
    Words words(line, file.where(), "FRAME_ID RIG_ID QW QX QY QZ TX TY TZ NUM_DATA_IDS DATA_IDS...");
    ColmapEntries::Frame frame;
    frame.where = file.where();
    (void)words.nextId();
    frame.rig = words.nextId();
    frame.rig_from_map = words.nextPose();
    for (long long left = words.nextId(); left > 0; --left) {
      const ColmapEntries::Sensor sensor = words.nextSensor();
      frame.data.emplace_back(sensor, words.nextId());
    }
    entries.frames.push_back(frame);
  }
}

}  // namespace

ColmapEntries readColmapText(const std::string& directory) {
  ColmapEntries entries;
  readCameras(LineFile(directory + "/cameras.txt"), entries);
  readImages(LineFile(directory + "/images.txt"), entries);
  try {
    if (std::filesystem::exists(directory + "/points3D.txt"))
      readPoints(LineFile(directory + "/points3D.txt"), entries);
  } catch (const std::runtime_error& error) {
    entries.points_error = error.what();
  }
  if (std::filesystem::exists(directory + "/rigs.txt")) readRigs(LineFile(directory + "/rigs.txt"), entries);
  if (std::filesystem::exists(directory + "/frames.txt")) readFrames(LineFile(directory + "/frames.txt"), entries);
  return entries;
}

}  // namespace cloud_colorizer
