// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// colmap_entries.hpp: the binary files.

#include <algorithm>
#include <filesystem>
#include <map>

#include "cloud/block_reader.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "exchange/colmap_entries.hpp"

namespace cloud_colorizer {
namespace {

/// Camera models by their id in a file, with the number of their parameters.
struct NumberedModel {
  const char* name;
  std::size_t num_params;
};
const std::map<std::int32_t, NumberedModel>& numberedModels() {
  static const std::map<std::int32_t, NumberedModel> kModels = {{0, {"SIMPLE_PINHOLE", 3}},
                                                                {1, {"PINHOLE", 4}},
                                                                {2, {"SIMPLE_RADIAL", 4}},
                                                                {3, {"RADIAL", 5}},
                                                                {4, {"OPENCV", 8}},
                                                                {5, {"OPENCV_FISHEYE", 8}},
                                                                {6, {"FULL_OPENCV", 12}},
                                                                {7, {"FOV", 5}},
                                                                {8, {"SIMPLE_RADIAL_FISHEYE", 4}},
                                                                {9, {"RADIAL_FISHEYE", 5}},
                                                                {10, {"THIN_PRISM_FISHEYE", 12}},
                                                                {17, {"EQUIRECTANGULAR", 2}}};
  return kModels;
}

template <class T>
T take(BlockReader& input) {
  T value{};
  input.read(&value, sizeof(T));
  return value;
}

std::vector<double> takeNumbers(BlockReader& input, std::size_t count) {
  std::vector<double> numbers(count);
  input.read(numbers.data(), count * sizeof(double));
  return numbers;
}

ColmapEntries::Pose takePose(BlockReader& input) {
  const std::vector<double> v = takeNumbers(input, 7);
  return {{v[0], v[1], v[2], v[3]}, {v[4], v[5], v[6]}};
}

ColmapEntries::Sensor takeSensor(BlockReader& input) {
  const auto type = take<std::int32_t>(input);
  return {type == 0 ? "CAMERA" : "sensor type " + std::to_string(type), take<std::uint32_t>(input)};
}

std::string takeName(BlockReader& input) {
  constexpr std::size_t kLongest = 4096;  // a path of Linux
  std::string name;
  for (char c = take<char>(input); c != 0; c = take<char>(input)) {
    name += c;
    require(name.size() <= kLongest, input.path(), " is damaged: the name of an image has no end");
  }
  return name;
}

/// How many entries follow, each of at least `size` bytes.
std::uint64_t takeCount(BlockReader& input, std::uint64_t size) {
  const auto count = take<std::uint64_t>(input);
  require(count <= input.remaining() / size, input.path(), " is truncated or damaged: it announces ", count,
          " entries and has ", input.remaining(), " bytes");
  return count;
}

void readCameras(BlockReader& input, ColmapEntries& entries) {
  for (std::uint64_t left = takeCount(input, 24); left > 0; --left) {
    ColmapEntries::Camera camera;
    camera.id = take<std::uint32_t>(input);
    const auto model = take<std::int32_t>(input);
    camera.where = input.path() + " camera " + std::to_string(camera.id);
    const auto found = numberedModels().find(model);
    require(found != numberedModels().end(), camera.where, ": the camera model ", model,
            " is unknown; undistort the images with `colmap image_undistorter` and give its model");
    camera.model = found->second.name;
    const auto width = take<std::uint64_t>(input), height = take<std::uint64_t>(input);
    constexpr std::uint64_t kMost = 1U << 30U;
    camera.width = static_cast<long long>(std::min(width, kMost));
    camera.height = static_cast<long long>(std::min(height, kMost));
    camera.params = takeNumbers(input, found->second.num_params);
    entries.cameras.push_back(camera);
  }
}

void readImages(BlockReader& input, ColmapEntries& entries) {
  constexpr std::uint64_t kPointSize = 2 * sizeof(double) + sizeof(std::int64_t);
  for (std::uint64_t left = takeCount(input, 73); left > 0; --left) {
    ColmapEntries::Image image;
    image.id = take<std::uint32_t>(input);
    image.where = input.path() + " image " + std::to_string(image.id);
    image.camera_from_map = takePose(input);
    image.camera = take<std::uint32_t>(input);
    image.name = takeName(input);
    const std::uint64_t count = takeCount(input, kPointSize);
    const std::uint64_t step = std::max<std::uint64_t>(1, count / ColmapEntries::kMostSights);
    for (std::uint64_t i = 0; i < count; i += step) {
      const std::vector<double> pixel = takeNumbers(input, 2);
      const auto point = take<std::int64_t>(input);
      input.skip((std::min(step, count - i) - 1) * kPointSize);
      if (point >= 0) image.sights.push_back({{pixel[0], pixel[1]}, point});
    }
    entries.images.push_back(image);
  }
}

void readPoints(BlockReader& input, ColmapEntries& entries) {
  const std::set<long long> wanted = entries.pointsOfSights();
  for (std::uint64_t left = takeCount(input, 43); left > 0; --left) {
    const auto id = take<std::uint64_t>(input);
    const std::vector<double> position = takeNumbers(input, 3);
    input.skip(3 + sizeof(double));  // colour and error
    input.skip(takeCount(input, 8) * 8);
    entries.addPoint(static_cast<long long>(id), Eigen::Vector3d(position.data()), wanted);
  }
}

void readRigs(BlockReader& input, ColmapEntries& entries) {
  for (std::uint64_t left = takeCount(input, 8); left > 0; --left) {
    ColmapEntries::Rig rig;
    rig.id = take<std::uint32_t>(input);
    const auto num_sensors = take<std::uint32_t>(input);
    for (std::uint32_t i = 0; i < num_sensors; ++i) {
      const ColmapEntries::Sensor sensor = takeSensor(input);
      if (i == 0 || take<std::uint8_t>(input) != 0)
        rig.sensor_from_rig[sensor] = i == 0 ? ColmapEntries::Pose() : takePose(input);
    }
    entries.rigs.push_back(rig);
  }
}

void readFrames(BlockReader& input, ColmapEntries& entries) {
  for (std::uint64_t left = takeCount(input, 68); left > 0; --left) {
    ColmapEntries::Frame frame;
    frame.where = input.path() + " frame " + std::to_string(take<std::uint32_t>(input));
    frame.rig = take<std::uint32_t>(input);
    frame.rig_from_map = takePose(input);
    for (auto num_data = take<std::uint32_t>(input); num_data > 0; --num_data) {
      const ColmapEntries::Sensor sensor = takeSensor(input);
      frame.data.emplace_back(sensor, static_cast<long long>(take<std::uint64_t>(input)));
    }
    entries.frames.push_back(frame);
  }
}

}  // namespace

ColmapEntries readColmapBinary(const std::string& directory) {
  ColmapEntries entries;
  const auto read = [&](const char* name, auto&& reader, bool is_needed) {
    const std::string path = directory + "/" + name;
    if (!is_needed && !std::filesystem::exists(path)) return;
    BlockReader input(path);
    reader(input, entries);
  };
  read("cameras.bin", readCameras, true);
  read("images.bin", readImages, true);
  try {
    read("points3D.bin", readPoints, false);
  } catch (const std::runtime_error& error) {
    entries.points_error = error.what();
  }
  read("rigs.bin", readRigs, false);
  read("frames.bin", readFrames, false);
  return entries;
}

}  // namespace cloud_colorizer
