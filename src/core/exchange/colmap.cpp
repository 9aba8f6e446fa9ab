// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/colmap.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

namespace {

constexpr double kPixelCentre = 0.5;  ///< COLMAP's first pixel centre; ours is 0

/// How the PARAMS of a COLMAP camera become our numbers.
struct ColmapCameraModel {
  int num_focal_lengths;  ///< 1: f; 2: fx, fy
  DistortionModel model;
  std::size_t num_distortion;
  bool is_radial;  ///< k1, k2 only
};

const std::map<std::string, ColmapCameraModel>& cameraModels() {
  static const std::map<std::string, ColmapCameraModel> kModels{
      {"SIMPLE_PINHOLE", {1, DistortionModel::kPlumbBob, 0, false}},
      {"PINHOLE", {2, DistortionModel::kPlumbBob, 0, false}},
      {"SIMPLE_RADIAL", {1, DistortionModel::kPlumbBob, 1, true}},
      {"RADIAL", {1, DistortionModel::kPlumbBob, 2, true}},
      {"OPENCV", {2, DistortionModel::kPlumbBob, 4, false}},
      {"FULL_OPENCV", {2, DistortionModel::kRationalPolynomial, 8, false}},
      {"OPENCV_FISHEYE", {2, DistortionModel::kEquidistant, 4, false}}};
  return kModels;
}

long long parseId(const std::string& word, const std::string& where) {
  long long id = 0;
  require(parseInteger(word, id) && id >= 0, where, ": \"", word, "\" is no id or size");
  return id;
}

double parseNumber(const std::string& word, const std::string& where) {
  double number = 0;
  require(parseDouble(word, number) && std::isfinite(number), where, ": \"", word, "\" is no number");
  return number;
}

Intrinsics parseIntrinsics(const std::vector<std::string>& words, const std::string& where) {
  require(words.size() > 4, where, ": a camera is `CAMERA_ID MODEL WIDTH HEIGHT PARAMS...`");
  const auto found = cameraModels().find(words[1]);
  if (found == cameraModels().end()) {
    std::string known;
    for (const auto& entry : cameraModels()) known += ' ' + entry.first;
    throw std::runtime_error(where + ": the camera model " + words[1] + " is unknown; known are" + known);
  }
  const auto& model = found->second;
  std::vector<double> params;
  for (std::size_t i = 4; i < words.size(); ++i) params.push_back(parseNumber(words[i], where));
  const auto num_focal = static_cast<std::size_t>(model.num_focal_lengths);
  require(params.size() == num_focal + 2 + model.num_distortion, where, ": ", words[1], " has ",
          num_focal + 2 + model.num_distortion, " parameters, not ", params.size());
  Intrinsics intrinsics;
  const auto width = parseId(words[2], where), height = parseId(words[3], where);
  require(width > 0 && width < 1'000'000 && height > 0 && height < 1'000'000, where, ": an image of ", width, " x ",
          height, " pixels is impossible");
  intrinsics.width = static_cast<int>(width);
  intrinsics.height = static_cast<int>(height);
  intrinsics.fx = params[0];
  intrinsics.fy = params[num_focal - 1];
  intrinsics.cx = params[num_focal] - kPixelCentre;
  intrinsics.cy = params[num_focal + 1] - kPixelCentre;
  intrinsics.model = model.model;
  intrinsics.distortion.assign(params.begin() + static_cast<std::ptrdiff_t>(num_focal + 2), params.end());
  if (model.is_radial) intrinsics.distortion.resize(4, 0);
  try {
    const Camera checked(intrinsics);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(where + ": " + error.what());
  }
  return intrinsics;
}

struct NumberedImage {
  long long id = 0;
  ColmapImage image;
};

NumberedImage parseImage(const std::string& line, const std::string& where,
                         const std::map<long long, std::size_t>& camera_of_id) {
  const auto words = splitWords(line);
  require(words.size() >= 10, where, ": an image is `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`");
  double v[7];
  for (std::size_t i = 0; i < 7; ++i) v[i] = parseNumber(words[i + 1], where);
  const Eigen::Quaterniond rotation(v[0], v[1], v[2], v[3]);
  require(std::abs(rotation.norm() - 1) < 0.01, where, ": its quaternion has the norm ", rotation.norm(),
          ", which must be 1");
  const auto camera = camera_of_id.find(parseId(words[8], where));
  require(camera != camera_of_id.end(), where, ": the camera ", words[8], " is not in cameras.txt");
  Eigen::Isometry3d camera_from_map = Eigen::Isometry3d::Identity();
  camera_from_map.linear() = rotation.normalized().toRotationMatrix();
  camera_from_map.translation() = Eigen::Vector3d(v[4], v[5], v[6]);
  NumberedImage result{parseId(words[0], where), {camera->second, camera_from_map.inverse(), words[9]}};
  for (std::size_t i = 10; i < words.size(); ++i) result.image.name += ' ' + words[i];
  return result;
}

/// The lines of a text file, with their numbers for messages.
class LineFile {
 public:
  explicit LineFile(const std::string& path) : path_(path), stream_(path) {
    require(stream_.is_open(), "cannot open ", path,
            "; give the directory of a COLMAP model in text form (colmap model_converter --output_type TXT)");
  }
  bool next(std::string& line) {
    ++number_;
    return static_cast<bool>(std::getline(stream_, line));
  }
  /// The next line that is neither empty nor a comment.
  bool nextEntry(std::string& line) {
    while (next(line)) {
      const auto first = line.find_first_not_of(" \t\r");
      if (first != std::string::npos && line[first] != '#') return true;
    }
    return false;
  }
  std::string where() const { return path_ + " line " + std::to_string(number_); }

 private:
  std::string path_;
  std::ifstream stream_;
  std::size_t number_ = 0;
};

std::string cameraLine(std::size_t id, const Intrinsics& k) {
  auto distortion = k.distortion;
  distortion.resize(8, 0);
  const bool is_fisheye = k.model == DistortionModel::kEquidistant;
  const auto last = std::find_if(distortion.rbegin(), distortion.rend(), [](double value) { return value != 0; });
  const auto num_used = distortion.rend() - last;
  const bool is_rational = k.model == DistortionModel::kRationalPolynomial || num_used > 4;
  const char* model = is_fisheye      ? "OPENCV_FISHEYE"
                      : num_used == 0 ? "PINHOLE"
                      : is_rational   ? "FULL_OPENCV"
                                      : "OPENCV";
  distortion.resize(cameraModels().at(model).num_distortion);
  std::string line = std::to_string(id) + ' ' + model + ' ' + std::to_string(k.width) + ' ' + std::to_string(k.height);
  for (const double value : {k.fx, k.fy, k.cx + kPixelCentre, k.cy + kPixelCentre}) line += ' ' + formatDouble(value);
  for (const double value : distortion) line += ' ' + formatDouble(value);
  return line + '\n';
}

void writeText(const std::string& path, const std::string& text) {
  writeFileAtomically(path, text.data(), text.size());
}

}  // namespace

ColmapModel readColmapModel(const std::string& directory) {
  std::map<long long, Intrinsics> cameras;
  std::string line;
  for (LineFile file(directory + "/cameras.txt"); file.nextEntry(line);) {
    const auto words = splitWords(line);
    const auto is_new = cameras.emplace(parseId(words[0], file.where()), parseIntrinsics(words, file.where())).second;
    require(is_new, file.where(), ": the camera ", words[0], " is there twice");
  }
  ColmapModel model;
  std::map<long long, std::size_t> camera_of_id;
  for (const auto& [id, intrinsics] : cameras) {
    camera_of_id[id] = model.cameras.size();
    model.cameras.push_back(intrinsics);
  }
  std::map<long long, ColmapImage> images;
  for (LineFile file(directory + "/images.txt"); file.nextEntry(line);) {
    auto entry = parseImage(line, file.where(), camera_of_id);
    const auto is_new = images.emplace(entry.id, std::move(entry.image)).second;
    require(is_new, file.where(), ": the image ", entry.id, " is there twice");
    file.next(line);  // the points of the image; this line is often empty
  }
  for (auto& entry : images) model.images.push_back(std::move(entry.second));
  return model;
}

void writeColmapModel(const std::string& directory, const ColmapModel& model) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  require(!error, "cannot create ", directory, ": ", error.message());
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t i = 0; i < model.cameras.size(); ++i) cameras += cameraLine(i + 1, model.cameras[i]);
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
  writeText(directory + "/points3D.txt", "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
}

}  // namespace cloud_colorizer
