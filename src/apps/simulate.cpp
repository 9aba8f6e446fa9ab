// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Drives a simulated vehicle through a simulated street and writes what its sensors saw.
#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/command_line.hpp"
#include "apps/drive_bag.hpp"
#include "apps/simulate_city.hpp"
#include "base/file_io.hpp"
#include "base/parallel.hpp"
#include "base/stop_watch.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "simulation/truth.hpp"

namespace {

using namespace cloud_colorizer;
using namespace cloud_colorizer::simulation;

constexpr const char* kDefaultPreset = "vehicle";

CommandSpec simulateSpec() {
  CommandSpec spec;
  spec.program = "simulate";
  spec.summary =
      "Drives a vehicle through a simulated street and writes into DIR:\n"
      "  drive.bag        LiDAR, cameras, tf with the noise below\n"
      "  rig.yaml         which topic is what, for colorize_bag\n"
      "  truth.ply        where the LiDAR's rays really ended, with the true colours\n"
      "  truth_poses.csv  true pose and gain of every image\n"
      "  scene.yaml       all options, true and given extrinsics\n"
      "The same options write the same bytes. `simulate city --help`: the street as a dense cloud with photographs.";
  spec.takes_params = false;
  spec.options = {{"output", "DIR", "is made when missing; files of these names in it are replaced", true},
                  {"threads", "N", "0: one a core (0)"}};
  for (const ParamText& option : describeOptions(presetOptions(kDefaultPreset))) {
    const bool is_switch = option.value == "false" || option.value == "true";
    spec.options.push_back({option.name, is_switch ? "" : "VALUE", option.help + " (" + option.value + ")"});
  }
  return spec;
}

struct Arguments {
  Options options;
  int threads = 0;
};

/// Throws UsageError.
Arguments argumentsOf(const CommandLine& line) {
  Arguments arguments;
  try {
    arguments.threads = line.value("threads", 0);
    requireInRange("threads", arguments.threads, 0, 1024);
    arguments.options = presetOptions(line.option("preset", kDefaultPreset));
    for (const auto& [name, value] : line.options) {
      if (name != "output" && name != "threads" && name != "preset") setOption(arguments.options, name, value);
    }
    arguments.options.check();
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  return arguments;
}

struct Frame {
  std::vector<Return> scan;
  std::vector<ImageBytes> images;
  std::vector<QuantityImages> quantities;
};

ImageBytes encode(const cv::Mat3b& rgb, const Options& options) {
  if (options.image_transport == "raw") return {rgb.data, rgb.data + rgb.total() * 3};
  ImageBytes bytes;
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  require(cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, options.jpeg_quality}),
          "OpenCV cannot encode JPEG images");
  return bytes;
}

void writeRigFile(const Drive& drive, const std::string& path) {
  std::string text = "# Which topic of the bag is what. The true time of an image is its stamp plus time_offset [s].\n";
  text += std::string("map_frame: map\ncloud_in: ") + kCloudTopic + "\ncameras:\n";
  for (int i = 0; i < drive.options().cameras; ++i) {
    const std::string& name = drive.cameras()[static_cast<std::size_t>(i)].name;
    text += "  - {image: " + imageTopic(drive, i) + ", camera_info: /" + name + "/camera_info, time_offset: 0" +
            (drive.options().readout > 0 ? ", readout_time: " + formatDouble(drive.options().readout) : "") + "}\n";
  }
  for (int i = 0; drive.options().quantities && i < drive.options().cameras; ++i) {
    const std::string& name = drive.cameras()[static_cast<std::size_t>(i)].name;
    const auto add = [&](const std::string& topic, const std::string& kind) {
      text += "  - {image: /" + name + topic + ", camera_info: /" + name + "/camera_info, kind: " + kind + "}\n";
    };
    add("/labels/compressed", "labels, names: classes.txt");
    add("/thermal", "radiometric, scale: " + formatDouble(kThermalScale) + ", offset: " + formatDouble(kThermalOffset));
  }
  writeFileAtomically(path, text.data(), text.size());
}

void writeClasses(const std::string& path) {
  const std::string text =
      "sky\nplain\nground\npaving\nkerb\nfacade\nroof\ncar body\ncar cabin\nwheel\nbark\nleaves\n"
      "sign\nbands\n";
  writeFileAtomically(path, text.data(), text.size());
}

/// Frames are simulated a few at a time, each on its own thread, and written in their order.
void driveAndRecord(const Scene& scene, const Drive& drive, int threads, const Callbacks& callbacks, DriveBag& bag,
                    TruthCloud& truth) {
  const Options& o = drive.options();
  std::vector<PixelRays> rays;
  for (const DriveCamera& camera : drive.cameras()) rays.emplace_back(camera.camera, threads);
  const auto take = [&](int frame) {
    Frame taken{takeScan(scene, drive, frame), {}, {}};
    for (int camera = 0; camera < o.cameras; ++camera) {
      if (callbacks.cancelled()) throw Cancelled();
      const PixelRays& of_camera = rays[static_cast<std::size_t>(camera)];
      taken.images.push_back(encode(takeImage(scene, drive, of_camera, camera, frame), o));
      if (o.quantities) taken.quantities.push_back(takeQuantities(scene, drive, of_camera, camera, frame));
    }
    return taken;
  };
  const int batch = 2 * resolveNumThreads(threads);
  StopWatch watch;
  double seconds = 0;
  for (int first = 0; first < o.frames; first += batch) {
    std::vector<Frame> frames(static_cast<std::size_t>(std::min(batch, o.frames - first)));
    parallelFor(threads, frames.size(), [&](std::size_t i) { frames[i] = take(first + static_cast<int>(i)); });
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const int frame = first + static_cast<int>(i);
      bag.writePosesUntil(drive.scanTime(frame + 1));
      for (std::size_t camera = 0; camera < rays.size(); ++camera) {
        bag.writeImage(static_cast<int>(camera), frame, frames[i].images[camera]);
        if (o.quantities) bag.writeQuantities(static_cast<int>(camera), frame, frames[i].quantities[camera]);
      }
      bag.writeScan(frame, frames[i].scan);
      truth.add(scene, frames[i].scan);
    }
    const std::size_t done = static_cast<std::size_t>(first) + frames.size(), all = static_cast<std::size_t>(o.frames);
    seconds += watch.lap();
    callbacks.progress({"frames", done, all, 0, seconds * (static_cast<double>(all) / static_cast<double>(done) - 1)});
  }
  bag.writePosesUntil(drive.duration());
}

void simulate(const CommandLine& line, const Callbacks& callbacks) {
  const Arguments arguments = argumentsOf(line);
  const std::filesystem::path output = line.option("output");
  const Drive drive(arguments.options);
  std::filesystem::create_directories(output);
  const Scene scene = makeStreet(streetOf(arguments.options), arguments.threads);
  TruthCloud truth(arguments.options.voxel_size, arguments.options.quantities);
  DriveBag bag(output / "drive.bag", drive);
  driveAndRecord(scene, drive, arguments.threads, callbacks, bag, truth);
  writeRigFile(drive, output / "rig.yaml");
  if (arguments.options.quantities) writeClasses(output / "classes.txt");
  truth.write(output / "truth.ply");
  writeTruePoses(drive, output / "truth_poses.csv");
  writeSceneFile(drive, output / "scene.yaml");
  bag.close();
  callbacks.log(LogLevel::kInfo, std::to_string(truth.size()) + " true points, " +
                                     std::to_string(std::filesystem::file_size(output / "drive.bag") / 1000000) +
                                     " MB of bag in " + output.string());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1 && std::string(argv[1]) == "city") return runSimulateCity(argc - 1, argv + 1);
  return runMain(argc, argv, simulateSpec(), simulate);
}
