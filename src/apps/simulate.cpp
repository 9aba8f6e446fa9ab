// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Drives a simulated vehicle through a simulated street and writes what its sensors saw.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "apps/drive_bag.hpp"
#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "simulation/truth.hpp"

namespace {

using namespace cloud_colorizer;
using namespace cloud_colorizer::simulation;
namespace fs = std::filesystem;

volatile std::sig_atomic_t interrupted = 0;

struct Arguments {
  Options options;
  fs::path output;
  int threads = 0;
  bool help = false;
};

void printHelp() {
  std::cout << "Usage: simulate --output DIR [--name value ...]\n\n"
               "Drives a vehicle through a simulated street and writes into DIR:\n"
               "  drive.bag        LiDAR, cameras, tf with the noise below\n"
               "  rig.yaml         which topic is what, for colorize_bag\n"
               "  truth.ply        where the LiDAR's rays really ended, with the true colours\n"
               "  truth_poses.csv  true pose and gain of every image\n"
               "  scene.yaml       all options, true and given extrinsics\n"
               "The same options write the same bytes.\n\n"
               "  --output DIR             is made when missing; files of these names in it are replaced\n"
               "  --threads N              0: one a core (0)\n";
  for (const OptionText& option : describeOptions(Options{})) {
    std::printf("  --%-22s %s (%s)\n", option.name.c_str(), option.help.c_str(), option.value.c_str());
  }
  std::cout << "  --help                   this text\n\n"
               "Exit code: 0 done, 1 failed or interrupted, 2 wrong usage.\n";
}

/// Both `--name value` and `--name=value`; a switch alone means true. Throws std::invalid_argument.
Arguments parseArguments(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      arguments.help = true;
      return arguments;
    }
    require<std::invalid_argument>(name.rfind("--", 0) == 0, "what is \"", name, "\"? Options begin with --");
    name = name.substr(2);
    std::string value;
    const auto equals = name.find('=');
    if (equals != std::string::npos) {
      value = name.substr(equals + 1);
      name = name.substr(0, equals);
    } else if (i + 1 < argc && std::string(argv[i + 1]).rfind("--", 0) != 0) {
      value = argv[++i];
    }
    if (name == "output") {
      arguments.output = value;
    } else if (name == "threads") {
      Options number;  // borrows the parsing of whole numbers
      setOption(number, "seed", value);
      arguments.threads = number.seed;
      requireInRange("threads", arguments.threads, 0, 1024);
    } else {
      setOption(arguments.options, name, value);
    }
  }
  require<std::invalid_argument>(!arguments.output.empty(), "--output DIR is missing");
  arguments.options.check();
  return arguments;
}

/// A file under another name until it is whole; removed when it never was.
class PartialFile {
 public:
  explicit PartialFile(fs::path path) : path_(std::move(path)), partial_(path_.string() + ".part") {}
  ~PartialFile() {
    std::error_code ignored;
    if (!is_kept_) fs::remove(partial_, ignored);
  }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  std::string partial() const { return partial_.string(); }
  void keep() {
    fs::rename(partial_, path_);
    is_kept_ = true;
  }

 private:
  fs::path path_, partial_;
  bool is_kept_ = false;
};

struct Frame {
  std::vector<Return> scan;
  std::vector<EncodedImage> images;
};

EncodedImage encode(const cv::Mat3b& rgb, const Options& options) {
  EncodedImage image;
  if (options.image_transport == "raw") {
    image.bytes.assign(rgb.data, rgb.data + rgb.total() * 3);
    return image;
  }
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  require(cv::imencode(".jpg", bgr, image.bytes, {cv::IMWRITE_JPEG_QUALITY, options.jpeg_quality}),
          "OpenCV cannot encode JPEG images");
  return image;
}

void printProgress(int done, int total, double seconds) {
  const double left = seconds / done * (total - done);
  std::fprintf(stderr, "\rframe %d of %d, %.0f s left   ", done, total, left);
  if (done == total) std::fprintf(stderr, "\n");
}

void writeRigFile(const Drive& drive, const std::string& path) {
  std::ofstream file(path);
  file << "# Which topic of the bag is what. The true time of an image is its stamp plus time_offset [s].\n"
       << "map_frame: map\ncloud_in: " << kCloudTopic << "\ncameras:\n";
  for (int i = 0; i < drive.options().cameras; ++i) {
    const std::string& name = drive.cameras()[static_cast<std::size_t>(i)].name;
    file << "  - {image: " << imageTopic(drive, i) << ", camera_info: /" << name << "/camera_info, time_offset: 0}\n";
  }
  file.close();
  require(!file.fail(), "cannot write ", path);
}

/// Frames are simulated a few at a time, each on its own thread, and written in their order.
void driveAndRecord(const Scene& scene, const Drive& drive, int threads, DriveBag& bag, TruthCloud& truth) {
  const Options& o = drive.options();
  const auto start = std::chrono::steady_clock::now();
  std::vector<PixelRays> rays;
  for (const DriveCamera& camera : drive.cameras()) rays.emplace_back(camera.camera, threads);
  const int batch = 2 * resolveNumThreads(threads);
  for (int first = 0; first < o.frames; first += batch) {
    std::vector<Frame> frames(static_cast<std::size_t>(std::min(batch, o.frames - first)));
    parallelFor(threads, frames.size(), [&](std::size_t i) {
      const int frame = first + static_cast<int>(i);
      if (interrupted) throw Cancelled();
      frames[i].scan = takeScan(scene, drive, frame);
      for (int camera = 0; camera < o.cameras; ++camera) {
        if (interrupted) throw Cancelled();
        frames[i].images.push_back(
            encode(takeImage(scene, drive, rays[static_cast<std::size_t>(camera)], camera, frame), o));
      }
    });
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const int frame = first + static_cast<int>(i);
      bag.writePosesUntil(drive.scanTime(frame + 1));
      for (int camera = 0; camera < o.cameras; ++camera) {
        bag.writeImage(camera, frame, frames[i].images[static_cast<std::size_t>(camera)]);
      }
      bag.writeScan(frame, frames[i].scan);
      truth.add(scene, frames[i].scan);
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    printProgress(first + static_cast<int>(frames.size()), o.frames, seconds.count());
  }
  bag.writePosesUntil(drive.duration());
}

void simulate(const Arguments& arguments) {
  const Drive drive(arguments.options);
  fs::create_directories(arguments.output);
  PartialFile bag_file(arguments.output / "drive.bag");
  PartialFile rig_file(arguments.output / "rig.yaml");
  PartialFile truth_file(arguments.output / "truth.ply");
  PartialFile poses_file(arguments.output / "truth_poses.csv");
  PartialFile scene_file(arguments.output / "scene.yaml");
  const Scene scene = makeStreet(streetOf(arguments.options), arguments.threads);
  TruthCloud truth(arguments.options.voxel_size);
  DriveBag bag(bag_file.partial(), drive);
  driveAndRecord(scene, drive, arguments.threads, bag, truth);
  bag.close();
  writeRigFile(drive, rig_file.partial());
  truth.write(truth_file.partial());
  writeTruePoses(drive, poses_file.partial());
  writeSceneFile(drive, scene_file.partial());
  for (PartialFile* file : {&rig_file, &truth_file, &poses_file, &scene_file, &bag_file}) file->keep();
  std::cerr << truth.size() << " true points, " << fs::file_size(arguments.output / "drive.bag") / 1000000
            << " MB of bag in " << arguments.output.string() << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  try {
    arguments = parseArguments(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << "\nTry simulate --help\n";
    return 2;
  }
  if (arguments.help) {
    printHelp();
    return 0;
  }
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  try {
    simulate(arguments);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "\nsimulate: " << error.what() << '\n';
    return 1;
  }
}
