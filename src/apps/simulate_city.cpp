// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// simulate city: the street as a dense cloud, photographs and a COLMAP model, for maps of any size.
#include "apps/simulate_city.hpp"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/command_line.hpp"
#include "base/file_io.hpp"
#include "base/parallel.hpp"
#include "base/progress.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "simulation/city.hpp"
#include "simulation/truth.hpp"

namespace cloud_colorizer {
namespace {

namespace fs = std::filesystem;
using namespace simulation;

CommandSpec citySpec() {
  CommandSpec spec;
  spec.program = "simulate city";
  spec.summary =
      "Scans a simulated street as densely as asked for and writes into DIR, point by point in bounded memory:\n"
      "  cloud.ply   points with true_red, true_green, true_blue, seen and hidden, for `evaluate city`\n"
      "  images/     photographs, with other gains and noise\n"
      "  model/      COLMAP's text model, with the noise of a vehicle's poses\n"
      "  scene.yaml  all options of the drive\n"
      "The same options write the same bytes.";
  spec.takes_params = false;
  spec.options = {{"output", "DIR", "is made when missing; files of these names in it are replaced", true},
                  {"points", "N", "of the cloud (1000000)"},
                  {"views", "N", "of two cameras, two a metre (120)"},
                  {"image-size", "WxH", "px (3000x2000)"},
                  {"seed", "N", "of the street and of all noise (1)"},
                  {"threads", "N", "0: one a core (0)"}};
  return spec;
}

/// Throws UsageError.
CityOptions cityOptions(const CommandLine& line) {
  CityOptions options;
  options.points = line.value("points", options.points);
  options.views = line.value("views", options.views);
  options.seed = line.value("seed", options.seed);
  const std::string size = std::to_string(options.width) + "x" + std::to_string(options.height);
  const std::vector<int> sides = line.list<int>("image-size", size, 'x', 2);
  options.width = sides[0];
  options.height = sides[1];
  return options;
}

std::string imageName(int camera, int frame) {
  return "camera_" + std::to_string(camera) + "/" + sixDigits(static_cast<std::size_t>(frame)) + ".jpg";
}

void writeImages(const Scene& scene, const Drive& drive, const std::vector<CityView>& views, int threads,
                 const std::string& folder, const Callbacks& callbacks) {
  std::vector<PixelRays> rays;
  for (std::size_t c = 0; c < drive.cameras().size(); ++c) {
    rays.emplace_back(drive.cameras()[c].camera, threads);
    fs::create_directories(folder + "/" + drive.cameras()[c].name);
  }
  const Callbacks turns = takingTurns(callbacks);
  ProgressMeter progress(turns, "images", views.size());
  parallelFor(threads, views.size(), [&](std::size_t v) {
    const auto [camera, frame] = views[v];
    cv::Mat bgr;
    cv::cvtColor(takeImage(scene, drive, rays[static_cast<std::size_t>(camera)], camera, frame), bgr,
                 cv::COLOR_RGB2BGR);
    std::vector<std::uint8_t> bytes;
    require(cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, drive.options().jpeg_quality}),
            "OpenCV cannot encode JPEG images");
    writeFileAtomically(folder + "/" + imageName(camera, frame), bytes.data(), bytes.size());
    progress.add(1);
  });
}

void writeModel(const Drive& drive, const std::vector<CityView>& views, const std::string& folder) {
  ColmapModel model;
  for (const DriveCamera& camera : drive.cameras()) model.cameras.push_back(camera.camera.intrinsics());
  for (const auto& [camera, frame] : views) {
    const auto index = static_cast<std::size_t>(camera);
    const Eigen::Isometry3d map_from_base = drive.mapFromBaseGiven(drive.imageTime(camera, frame));
    model.images.push_back(
        {index, map_from_base * drive.cameras()[index].base_from_camera_given, imageName(camera, frame)});
  }
  writeColmapModel(folder, model);
}

void writeCloud(const Scene& scene, const Drive& drive, const std::vector<CityView>& views, std::size_t num_points,
                int threads, const std::string& path, const Callbacks& callbacks) {
  CityScanner scanner(scene, drive, views, num_points, threads);
  CloudWriter writer(path, num_points, CityScanner::fields(), false);
  ProgressMeter progress(callbacks, "points", num_points);
  for (Cloud cloud = scanner.next(); cloud.positions.cols() > 0; cloud = scanner.next()) {
    writer.write(cloud);
    progress.add(static_cast<std::size_t>(cloud.positions.cols()));
  }
  writer.finish();
}

void simulateCity(const CommandLine& line, const Callbacks& callbacks) {
  const int threads = line.value("threads", 0);
  const CityOptions options = cityOptions(line);
  Options drive_options;
  try {
    requireInRange("threads", threads, 0, 1024);
    drive_options = driveOfCity(options);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  const std::string output = line.option("output");
  fs::create_directories(output);
  const Drive drive(drive_options);
  const Scene scene = makeStreet(streetOf(drive_options), threads);
  const std::vector<CityView> views = viewsOfCity(drive, options.views);
  writeModel(drive, views, output + "/model");
  writeSceneFile(drive, output + "/scene.yaml");
  writeImages(scene, drive, views, threads, output + "/images", callbacks);
  writeCloud(scene, drive, views, options.points, threads, output + "/cloud.ply", callbacks);
}

}  // namespace

int runSimulateCity(int argc, char** argv) {
  return runMain(argc, argv, citySpec(), simulateCity);
}

}  // namespace cloud_colorizer
