// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "exchange/colmap_cameras.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "base/text.hpp"
#include "camera/panorama.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "exchange/text_lines.hpp"

namespace cloud_colorizer {
namespace {

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

}  // namespace

Intrinsics intrinsicsOfColmap(const ColmapEntries::Camera& camera) {
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
  intrinsics.cx = camera.params[num_focal] - kColmapPixelCentre;
  intrinsics.cy = camera.params[num_focal + 1] - kColmapPixelCentre;
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

std::string colmapCameraLine(std::size_t id, const Intrinsics& k) {
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
  for (const double value : {k.fx, k.fy, k.cx + kColmapPixelCentre, k.cy + kColmapPixelCentre})
    line += ' ' + formatDouble(value);
  for (const double value : distortion) line += ' ' + formatDouble(value);
  return line + '\n';
}

}  // namespace cloud_colorizer
