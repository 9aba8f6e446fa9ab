// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/exchange/colmap.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "camera/panorama.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "exchange/colmap_entries.hpp"
#include "exchange/text_lines.hpp"

namespace cloud_colorizer {

namespace {

constexpr double kPixelCentre = 0.5;  ///< COLMAP's first pixel centre; ours is 0

/// How the PARAMS of a COLMAP camera become our numbers.
struct ColmapCameraModel {
  std::size_t num_focal_lengths;  ///< 1: f; 2: fx, fy
  DistortionModel model;
  std::size_t num_params;  ///< behind the principal point
};

const std::map<std::string, ColmapCameraModel>& cameraModels() {
  static const std::map<std::string, ColmapCameraModel> kModels{
      {"SIMPLE_PINHOLE", {1, DistortionModel::kPlumbBob, 0}},
      {"PINHOLE", {2, DistortionModel::kPlumbBob, 0}},
      {"SIMPLE_RADIAL", {1, DistortionModel::kPlumbBob, 1}},
      {"RADIAL", {1, DistortionModel::kPlumbBob, 2}},
      {"OPENCV", {2, DistortionModel::kPlumbBob, 4}},
      {"FULL_OPENCV", {2, DistortionModel::kRationalPolynomial, 8}},
      {"SIMPLE_FISHEYE", {1, DistortionModel::kEquidistant, 0}},
      {"FISHEYE", {2, DistortionModel::kEquidistant, 0}},
      {"SIMPLE_RADIAL_FISHEYE", {1, DistortionModel::kEquidistant, 1}},
      {"RADIAL_FISHEYE", {1, DistortionModel::kEquidistant, 2}},
      {"OPENCV_FISHEYE", {2, DistortionModel::kEquidistant, 4}},
      {"THIN_PRISM_FISHEYE", {2, DistortionModel::kEquidistant, 8}},
      {"FOV", {2, DistortionModel::kRationalPolynomial, 1}}};
  return kModels;
}

const char* const kUndistort = "; undistort the images with `colmap image_undistorter` and give its model";

/// FOV's radius r_d = atan(2 r tan(w / 2)) / w of the undistorted radius r, as a rational polynomial: its slope at 0
/// goes into the focal lengths, and a least squares fit over the image gives the rest = (1 + k1 r^2 + k2 r^4 + k3 r^6)
/// / (1 + k4 r^2 + k5 r^4 + k6 r^6), times its denominator. Throws where it is off by more than a tenth of a pixel.
std::vector<double> rationalOfFov(double omega, Intrinsics& k, const std::string& where) {
  constexpr int kSamples = 500;
  require(omega > 1e-6 && omega < M_PI, where, ": FOV with the parameter ", omega, ", which must lie between 0 and pi");
  const double x = std::max(k.cx + 0.5, k.width - 0.5 - k.cx) / k.fx;
  const double y = std::max(k.cy + 0.5, k.height - 0.5 - k.cy) / k.fy;
  const double widening = 2 * std::tan(omega / 2);
  const double farthest = std::tan(std::min(std::hypot(x, y) * omega, 1.5)) / widening;
  k.fx *= widening / omega;
  k.fy *= widening / omega;
  Eigen::MatrixXd powers(kSamples, 6);
  Eigen::VectorXd radii(kSamples), scales(kSamples), down = Eigen::VectorXd::Ones(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double r = farthest * (i + 1) / kSamples, r2 = r * r, scale = std::atan(r * widening) / (widening * r);
    radii[i] = r;
    scales[i] = scale;
    powers.row(i) << r2, r2 * r2, r2 * r2 * r2, -scale * r2, -scale * r2 * r2, -scale * r2 * r2 * r2;
  }
  const Eigen::VectorXd wanted = (scales.array() - 1).matrix();
  Eigen::VectorXd fit;
  double error = 0;
  for (int round = 0; round < 10; ++round) {  // weighted by the last denominator, so that pixels are fitted
    const Eigen::VectorXd weights = radii.cwiseQuotient(down);
    fit = (weights.asDiagonal() * powers).colPivHouseholderQr().solve(weights.cwiseProduct(wanted));
    const Eigen::ArrayXd r2 = radii.array().square();
    down = (1 + r2 * (fit[3] + r2 * (fit[4] + r2 * fit[5]))).matrix();
    error =
        ((powers * fit - wanted).cwiseQuotient(down).cwiseProduct(radii)).cwiseAbs().maxCoeff() * std::max(k.fx, k.fy);
  }
  require(error < 0.1, where, ": the camera model FOV with the parameter ", omega,
          " cannot be followed to a tenth of a pixel (", error, " px)", kUndistort);
  return {fit[0], fit[1], 0, 0, fit[2], fit[3], fit[4], fit[5]};
}

std::vector<double> distortionOf(const ColmapEntries::Camera& camera, const std::vector<double>& params,
                                 Intrinsics& intrinsics) {
  if (camera.model == "FOV") return rationalOfFov(params[0], intrinsics, camera.where);
  if (camera.model == "THIN_PRISM_FISHEYE") {  // k1 k2 p1 p2 k3 k4 sx1 sy1
    const bool is_radial = params[2] == 0 && params[3] == 0 && params[6] == 0 && params[7] == 0;
    require(is_radial, camera.where, ": THIN_PRISM_FISHEYE with tangential or thin prism coefficients is not known",
            kUndistort);
    return {params[0], params[1], params[4], params[5]};
  }
  std::vector<double> distortion = params;
  if (!distortion.empty() && distortion.size() < 4) distortion.resize(4, 0);
  return distortion;
}

/// COLMAP's name is EQUIRECTANGULAR; a fork that others read as well says SPHERICAL.
bool isPanorama(const ColmapEntries::Camera& camera) {
  return camera.model == "EQUIRECTANGULAR" || camera.model == "SPHERICAL";
}

Intrinsics panoramaOf(const ColmapEntries::Camera& camera) {
  Intrinsics panorama;
  panorama.width = static_cast<int>(camera.width);
  panorama.height = static_cast<int>(camera.height);
  panorama.model = DistortionModel::kEquirectangular;
  try {
    checkPanorama({panorama.width, panorama.height});
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(camera.where + ": " + error.what());
  }
  return panorama;
}

Intrinsics intrinsicsOf(const ColmapEntries::Camera& camera) {
  const std::string& where = camera.where;
  require(camera.width > 0 && camera.width < 1'000'000 && camera.height > 0 && camera.height < 1'000'000, where,
          ": an image of ", camera.width, " x ", camera.height, " pixels is impossible");
  if (isPanorama(camera)) return panoramaOf(camera);
  const auto found = cameraModels().find(camera.model);
  if (found == cameraModels().end()) {
    std::string known = " EQUIRECTANGULAR";
    for (const auto& entry : cameraModels()) known += ' ' + entry.first;
    throw std::runtime_error(where + ": the camera model " + camera.model + " is unknown; known are" + known +
                             kUndistort);
  }
  const auto& [num_focal, model, num_distortion] = found->second;
  require(camera.params.size() == num_focal + 2 + num_distortion, where, ": ", camera.model, " has ",
          num_focal + 2 + num_distortion, " parameters, not ", camera.params.size());
  Intrinsics intrinsics;
  intrinsics.width = static_cast<int>(camera.width);
  intrinsics.height = static_cast<int>(camera.height);
  intrinsics.fx = camera.params[0];
  intrinsics.fy = camera.params[num_focal - 1];
  intrinsics.cx = camera.params[num_focal] - kPixelCentre;
  intrinsics.cy = camera.params[num_focal + 1] - kPixelCentre;
  intrinsics.model = model;
  const auto behind = camera.params.begin() + static_cast<std::ptrdiff_t>(num_focal + 2);
  try {
    intrinsics.distortion = distortionOf(camera, {behind, camera.params.end()}, intrinsics);
    const Camera checked(intrinsics);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(where + ": " + error.what());
  }
  return intrinsics;
}

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
  distortion.resize(cameraModels().at(model).num_params);
  std::string line = std::to_string(id) + ' ' + model + ' ' + std::to_string(k.width) + ' ' + std::to_string(k.height);
  for (const double value : {k.fx, k.fy, k.cx + kPixelCentre, k.cy + kPixelCentre}) line += ' ' + formatDouble(value);
  for (const double value : distortion) line += ' ' + formatDouble(value);
  return line + '\n';
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
      const Eigen::Vector2d pixel = sight.pixel.array() - kPixelCentre;
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
    model.cameras.push_back(intrinsicsOf(*camera));
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
  writeText(directory + "/points3D.txt", kPointsHeader);
}

}  // namespace cloud_colorizer
