// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Files of every kind that is read, of which something was changed, always the same ones: each is read, or refused by
/// an error that names it. Meant for the sanitizers as well. FUZZ_FILES: how many of each kind (600).

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "base/file_io.hpp"
#include "camera/npy.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/exchange/colmap.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"
#include "exchange/trajectory_file.hpp"
#include "recording/image_files.hpp"

namespace cloud_colorizer {
namespace {

using Bytes = std::vector<std::uint8_t>;

int numFiles() {
  const char* asked = std::getenv("FUZZ_FILES");
  return asked != nullptr ? std::atoi(asked) : 600;
}

/// Changes a few places of a file: most often those where its header is.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  Bytes changed(Bytes bytes) {
    for (std::size_t count = 1 + below(3); count > 0 && !bytes.empty(); --count) changeOnce(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_); }
  std::size_t place(const Bytes& bytes) {
    return below(3) == 0 ? below(bytes.size()) : below(std::min<std::size_t>(bytes.size(), 500));
  }

  void changeOnce(Bytes& bytes) {
    const std::size_t at = place(bytes);
    const auto here = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (below(7)) {
      case 0:
        bytes[at] = static_cast<std::uint8_t>(random_());
        break;
      case 1:
        bytes[at] ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3: {  // a number at which arithmetic ends
        const std::uint64_t value = kEnds[below(kEnds.size())];
        const std::size_t size = std::min<std::size_t>(std::size_t{1} << below(4), bytes.size() - at);
        std::memcpy(&bytes[at], &value, size);
        break;
      }
      case 4: {  // likewise of text
        const std::string& word = kWords[below(kWords.size())];
        bytes.insert(here, word.begin(), word.end());
        break;
      }
      case 5:
        bytes.erase(here, here + static_cast<std::ptrdiff_t>(std::min(bytes.size() - at, 1 + below(20))));
        break;
      default: {
        const Bytes part(here, here + static_cast<std::ptrdiff_t>(std::min(bytes.size() - at, 1 + below(60))));
        bytes.insert(here, part.begin(), part.end());
      }
    }
  }

  const std::vector<std::uint64_t> kEnds = {0,
                                            ~0ULL,
                                            1,
                                            0x7FFFFFFFFFFFFFFFULL,
                                            0x7FFFFFFFULL,
                                            0xFFFFFFFFULL,
                                            0x7FF0ULL << 48U,
                                            0x7F800000ULL,
                                            0x8000000000000000ULL};
  const std::vector<std::string> kWords = {
      "-1", "0", "99999999999999999999",        "4294967295", "nan", "1e999", "\n", " ", "#", "\r\n",
      "-",  ".", "property list uchar int x\n", "\0"};
  std::mt19937 random_;
};

class FuzzFiles : public testing::Test {
 protected:
  /// `read` is called with changed files in place of `path`. Its errors must tell the file; nothing else may happen.
  void expectReadOrRefused(const std::string& path, const std::function<void()>& read, int count = numFiles()) {
    const Bytes whole = readFile(path);
    ASSERT_NO_THROW(read()) << path;
    Mutator mutator(7);
    int num_refused = 0;
    for (int i = 0; i < count; ++i) {
      const Bytes changed = mutator.changed(whole);
      writeFileAtomically(path, changed.data(), changed.size());
      try {
        read();
      } catch (const std::bad_alloc&) {
        FAIL() << path << ", change " << i << ": asks for more memory than there is";
      } catch (const std::runtime_error& error) {
        ++num_refused;
        ASSERT_NE(std::string(error.what()).find(scratch_.path()), std::string::npos) << i << ": " << error.what();
      }
    }
    EXPECT_GT(num_refused, count / 20) << path << ": the changes are too small";
    writeFileAtomically(path, whole.data(), whole.size());
  }

  static long peakMemory() {  // kB
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  }

  Cloud cloud() const {
    Cloud cloud;
    cloud.fields = {{"intensity", FieldType::kFloat32, 1}, {"ring", FieldType::kUint16, 1}};
    cloud.positions = Eigen::Matrix3Xd::Random(3, 40);
    cloud.records.assign(40 * 6, 3);
    return cloud;
  }

  void readCloud(const std::string& path) {
    CloudReader reader(path);
    for (std::size_t count = 0; count < 1000;) {
      const auto block = static_cast<std::size_t>(reader.read(100).positions.cols());
      if (block == 0) break;
      count += block;
    }
  }

  static void readModel(const std::string& folder) {
    const ColmapModel model = readColmapModel(folder);
    require(model.points_error.empty(), model.points_error);
  }

  ScratchDirectory scratch_;
};

TEST_F(FuzzFiles, Clouds) {
  const long before = peakMemory();
  for (const char* extension : {".ply", ".pcd", ".las"}) {
    const std::string path = scratch_ / (std::string("cloud") + extension);
    CloudWriter writer(path, 40, cloud().fields, false, {Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)},
                       "EPSG:25832");
    writer.write(cloud());
    writer.finish();
    expectReadOrRefused(path, [&] { readCloud(path); });
  }
  const std::string text = scratch_ / "text.ply";
  writeText(
      text,
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar "
      "red\nelement face 1\nproperty list uchar int i\nend_header\n1 2 3 4\n5 6 7 8\n9 1 2 3\n3 0 1 2\n");
  expectReadOrRefused(text, [&] { readCloud(text); });
  const std::string pcd = scratch_ / "text.pcd";
  writeText(pcd,
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3 4.2e-41\n5 6 7 8e-42\n");
  expectReadOrRefused(pcd, [&] { readCloud(pcd); });
  EXPECT_LT(peakMemory() - before, 600'000);
}

TEST_F(FuzzFiles, Models) {
  ColmapModel model;
  model.cameras.push_back({64, 48, 50, 50, 31.5, 23.5, DistortionModel::kPlumbBob, {0.1, 0.01, 0, 0}});
  for (const char* name : {"a.jpg", "b.jpg"}) model.images.push_back({0, Eigen::Isometry3d::Identity(), name});
  const std::string folder = scratch_ / "model";
  writeColmapModel(folder, model);
  writeText(folder + "/images.txt", "1 1 0 0 0 0 0 0 1 a.jpg\n10 20 1 30 40 -1\n2 1 0 0 0 0 0 1 1 b.jpg\n10 20.5 1\n");
  writeText(folder + "/points3D.txt", "# a comment\n1 0.5 0.5 3 9 9 9 0.4 1 0 2 0\n2 0.5 1e3 3 9 9 9 0.4\n");
  for (const char* file : {"/cameras.txt", "/images.txt", "/points3D.txt"}) {
    expectReadOrRefused(folder + file, [&] { readModel(folder); });
  }
}

TEST_F(FuzzFiles, BinaryModels) {
  const std::string folder = scratch_ / "model";
  std::filesystem::create_directories(folder);
  std::string cameras, images;
  const auto put = [](std::string& to, auto value) { to.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(cameras, std::uint64_t{1});
  put(cameras, std::uint32_t{1});
  put(cameras, std::int32_t{4});  // OPENCV
  put(cameras, std::uint64_t{64});
  put(cameras, std::uint64_t{48});
  for (const double number : {50.0, 50.0, 32.0, 24.0, 0.1, 0.01, 0.0, 0.0}) put(cameras, number);
  put(images, std::uint64_t{2});
  for (std::uint32_t id = 1; id <= 2; ++id) {
    put(images, id);
    for (const double number : {1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0}) put(images, number);
    put(images, std::uint32_t{1});
    images += id == 1 ? "a.jpg" : "b.jpg";
    images += '\0';
    put(images, std::uint64_t{1});
    for (const double number : {3.0, 4.0}) put(images, number);
    put(images, std::int64_t{7});
  }
  std::string points;
  put(points, std::uint64_t{1});
  put(points, std::uint64_t{7});
  for (const double number : {1.0, 2.0, 3.0}) put(points, number);
  points += "rgb";
  put(points, 0.5);
  put(points, std::uint64_t{1});
  put(points, std::uint64_t{1});
  writeText(folder + "/cameras.bin", cameras);
  writeText(folder + "/images.bin", images);
  const long before = peakMemory();
  writeText(folder + "/points3D.bin", points);
  for (const char* file : {"/cameras.bin", "/images.bin", "/points3D.bin"}) {
    expectReadOrRefused(folder + file, [&] { readModel(folder); });
  }
  EXPECT_LT(peakMemory() - before, 600'000);
}

TEST_F(FuzzFiles, Trajectories) {
  const std::string tum = scratch_ / "poses.txt", kitti = scratch_ / "kitti.txt";
  writeText(tum, "# a comment\n1.5 1 2 3 0 0 0 1\n2.5 1 2 4 0 0 0.6 0.8\n");
  writeText(kitti, "1 0 0 1 0 1 0 2 0 0 1 3\n1 0 0 1 0 1 0 2 0 0 1 4\n");
  expectReadOrRefused(tum, [&] { readTrajectory(tum); });
  expectReadOrRefused(kitti, [&] { readTrajectory(kitti); });
}

TEST_F(FuzzFiles, ImagesThatShowNoColours) {
  Intrinsics size;
  size.width = 8, size.height = 6;
  cv::Mat scores(6, 8, CV_32FC(5));
  cv::randu(scores, -3, 3);
  const std::string npy = scratch_ / "scores.npy", png = scratch_ / "labels.png";
  const Bytes bytes = npyOf(scores);
  writeFileAtomically(npy, bytes.data(), bytes.size());
  cv::imwrite(png, cv::Mat1b(6, 8, std::uint8_t{3}));
  expectReadOrRefused(npy, [&] { decodePixels(npy, size, ImageKind::kLogits); });
  expectReadOrRefused(png, [&] { decodePixels(png, size, ImageKind::kLabels); });
}

TEST_F(FuzzFiles, Recordings) {
  const std::string folder = scratch_ / "r";
  {
    RecordParams params;
    params.min_range = 0;
    Recorder recorder(folder, "map", params);
    recorder.addCloud(cloud(), Eigen::Isometry3d::Identity());
    Bytes png;
    cv::imencode(".png", cv::Mat4b(48, 64, cv::Vec4b(1, 2, 3, 255)), png);
    const auto camera = recorder.setCamera("camera_0", {64, 48, 50, 50, 31.5, 23.5, DistortionModel::kPlumbBob, {}});
    recorder.addView(camera, 1, Eigen::Isometry3d::Identity(), png, "png", cv::Mat1b(48, 64, std::uint8_t{255}),
                     Twist::Constant(0.01));
    recorder.addScan("lidar", 1, cloud().positions, Eigen::Isometry3d::Identity());
  }
  const auto read = [&] {
    const Recording recording = Recording::open(folder);
    for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
      recording.readPoints(tile);
      recording.readRecords(tile);
    }
    for (std::size_t view = 0; view < recording.views().size(); ++view) recording.readPixels(view);
    for (std::size_t scan = 0; scan < recording.scans().size(); ++scan) recording.readScan(scan);
  };
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    // What a Recorder alone reads is left out.
    if (entry.is_regular_file() && name != "lock" && name != "clouds.csv" && name[0] != '.')
      files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 7U);
  for (const std::string& file : files) {
    if (readFile(file).empty()) continue;
    expectReadOrRefused(file, read, numFiles() / 4);
  }
}

}  // namespace
}  // namespace cloud_colorizer
