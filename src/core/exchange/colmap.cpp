// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/colmap.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "exchange/colmap_cameras.hpp"
#include "exchange/colmap_entries.hpp"
#include "exchange/text_lines.hpp"

namespace cloud_colorizer {

namespace {

Eigen::Isometry3d isometryOf(const ColmapEntries::Pose& pose, const std::string& where) {
  return checkedPose(pose.rotation, pose.translation, where);
}

/// camera_from_map by image id, as the frames say it.
std::map<long long, Eigen::Isometry3d> posesOfFrames(const ColmapEntries& entries) {
  std::map<long long, const ColmapEntries::Rig*> rigs;
  for (const auto& rig : entries.rigs) rigs[rig.id] = &rig;
  std::map<long long, Eigen::Isometry3d> poses;
  for (const auto& frame : entries.frames) {
    const auto rig = rigs.find(frame.rig);
    require(rig != rigs.end(), frame.where, ": the rig ", frame.rig, " is not in the file of rigs");
    const Eigen::Isometry3d rig_from_map = isometryOf(frame.rig_from_map, frame.where);
    for (const auto& [sensor, image] : frame.data) {
      if (sensor.first != "CAMERA") continue;
      const auto pose = rig->second->sensor_from_rig.find(sensor);
      require(pose != rig->second->sensor_from_rig.end(), frame.where, ": the rig ", frame.rig,
              " has no pose of the camera ", sensor.second);
      poses[image] = isometryOf(pose->second, frame.where) * rig_from_map;
    }
  }
  return poses;
}

/// The model in `directory`, in its folder `sparse`, or in the only numbered folder there, as COLMAP writes them.
std::string findModel(const std::string& directory) {
  namespace fs = std::filesystem;
  const auto is_model = [](const fs::path& path) {
    return fs::exists(path / "cameras.bin") || fs::exists(path / "cameras.txt");
  };
  std::vector<std::string> found;
  for (const fs::path& path : {fs::path(directory), fs::path(directory) / "sparse"}) {
    if (is_model(path)) return path.string();
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(path, ignored)) {
      const std::string name = entry.path().filename().string();
      const bool is_number = !name.empty() && name.find_first_not_of("0123456789") == std::string::npos;
      if (is_number && is_model(entry.path())) found.push_back(entry.path().string());
    }
  }
  require(!found.empty(), "there is no COLMAP model in ", directory,
          ": no cameras.bin or cameras.txt, neither there nor in `sparse` or `sparse/0`");
  std::sort(found.begin(), found.end());
  std::string all;
  for (const std::string& path : found) all += ' ' + path;
  require(found.size() == 1, directory, " holds ", found.size(), " models, name one of them:", all);
  return found.front();
}

void writeText(const std::string& path, const std::string& text) {
  writeFileAtomically(path, text.data(), text.size());
}

std::vector<ColmapPoint> pointsOf(const ColmapEntries& entries,
                                  const std::map<long long, std::size_t>& place_of_image) {
  std::vector<ColmapPoint> points;
  std::map<long long, std::size_t> place_of_point;
  for (const auto& [id, position] : entries.points) {
    place_of_point[id] = points.size();
    points.push_back({position, {}});
  }
  for (const auto& image : entries.images) {
    for (const auto& sight : image.sights) {
      const auto point = place_of_point.find(sight.point);
      if (point == place_of_point.end()) continue;
      const Eigen::Vector2d pixel = sight.pixel.array() - kColmapPixelCentre;
      points[point->second].sights.push_back({place_of_image.at(image.id), pixel});
    }
  }
  return points;
}

}  // namespace

std::set<long long> ColmapEntries::pointsOfSights() const {
  std::set<long long> ids;
  for (const Image& image : images) {
    for (const Sight& sight : image.sights) ids.insert(sight.point);
  }
  return ids;
}

void ColmapEntries::addPoint(long long id, const Eigen::Vector3d& position, const std::set<long long>& wanted) {
  if (wanted.count(id) != 0 || points.size() < kMostOtherPoints) points[id] = position;
}

ColmapModel readColmapModel(const std::string& directory) {
  ColmapModel model;
  model.directory = findModel(directory);
  const bool is_binary = std::filesystem::exists(model.directory + "/cameras.bin");  // the order in which COLMAP looks
  const ColmapEntries entries = is_binary ? readColmapBinary(model.directory) : readColmapText(model.directory);
  std::map<long long, const ColmapEntries::Camera*> cameras;
  for (const auto& camera : entries.cameras) {
    const bool is_new = cameras.emplace(camera.id, &camera).second;
    require(is_new, camera.where, ": the camera ", camera.id, " is there twice");
  }
  std::map<long long, std::size_t> camera_of_id;
  for (const auto& [id, camera] : cameras) {
    camera_of_id[id] = model.cameras.size();
    model.cameras.push_back(intrinsicsOfColmap(*camera));
  }
  std::map<long long, ColmapImage> images;
  const std::map<long long, Eigen::Isometry3d> by_frames = posesOfFrames(entries);
  for (const auto& image : entries.images) {
    const auto camera = camera_of_id.find(image.camera);
    require(camera != camera_of_id.end(), image.where, ": the camera ", image.camera, " is not in the file of cameras");
    const auto by_frame = by_frames.find(image.id);
    const Eigen::Isometry3d camera_from_map =
        by_frame == by_frames.end() ? isometryOf(image.camera_from_map, image.where) : by_frame->second;
    const bool is_new =
        images.emplace(image.id, ColmapImage{camera->second, camera_from_map.inverse(), image.name}).second;
    require(is_new, image.where, ": the image ", image.id, " is there twice");
  }
  std::map<long long, std::size_t> place_of_id;
  for (auto& [id, image] : images) {
    place_of_id[id] = model.images.size();
    model.images.push_back(std::move(image));
  }
  model.points = pointsOf(entries, place_of_id);
  model.points_error = entries.points_error;
  return model;
}

void writeColmapModel(const std::string& directory, const ColmapModel& model) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  require(!error, "cannot create ", directory, ": ", error.message());
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t i = 0; i < model.cameras.size(); ++i) cameras += colmapCameraLine(i + 1, model.cameras[i]);
  std::string images = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const auto& image = model.images[i];
    require<std::invalid_argument>(image.camera < model.cameras.size(), "image ", image.name, " has the camera ",
                                   image.camera, " of ", model.cameras.size());
    const Eigen::Isometry3d camera_from_map = image.map_from_camera.inverse();
    const Eigen::Quaterniond rotation(camera_from_map.linear());
    images += std::to_string(i + 1);
    for (const double value : {rotation.w(), rotation.x(), rotation.y(), rotation.z()})
      images += ' ' + formatDouble(value);
    for (int axis = 0; axis < 3; ++axis) images += ' ' + formatDouble(camera_from_map.translation()[axis]);
    images += ' ' + std::to_string(image.camera + 1) + ' ' + image.name + "\n\n";
  }
  writeText(directory + "/cameras.txt", cameras);
  writeText(directory + "/images.txt", images);
  writeText(directory + "/points3D.txt", kPointsHeader);
}

}  // namespace cloud_colorizer
