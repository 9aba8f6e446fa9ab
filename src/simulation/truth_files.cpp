// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <cmath>
#include <iomanip>
#include <sstream>

#include "base/file_io.hpp"
#include "simulation/quantities.hpp"
#include "simulation/random.hpp"
#include "simulation/truth.hpp"

namespace cloud_colorizer::simulation {
namespace {

void write(const std::string& path, const std::ostringstream& text) {
  const std::string bytes = text.str();
  writeFileAtomically(path, bytes.data(), bytes.size());
}

/// tx ty tz qx qy qz qw
void writePose(std::ostream& out, const Eigen::Isometry3d& pose, const char* separator) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  out << t.x() << separator << t.y() << separator << t.z() << separator << q.x() << separator << q.y() << separator
      << q.z() << separator << q.w();
}

std::string secondsOf(std::int64_t nanoseconds) {
  std::string digits = std::to_string(nanoseconds);
  return digits.insert(digits.size() - 9, ".");
}

}  // namespace

void TruthCloud::add(const Scene& scene, const std::vector<Return>& returns) {
  for (const Return& r : returns) {
    if (scene.solids()[static_cast<std::size_t>(r.truth.solid)].isMoving()) continue;
    if (voxel_size_ > 0) {
      const Eigen::Array3d voxel = (r.truth.point.array() / voxel_size_).floor();
      const auto key = keyOf(static_cast<std::int64_t>(voxel.x()), static_cast<std::int64_t>(voxel.y()),
                             static_cast<std::int64_t>(voxel.z()));
      if (!taken_.insert(key).second) continue;
    }
    positions_.push_back(r.truth.point);
    const Color color = scene.trueColor(r.truth);
    for (int c = 0; c < 3; ++c) colors_.push_back(static_cast<std::uint8_t>(std::lround(color[c])));
    labels_.push_back(classOf(scene.solids()[static_cast<std::size_t>(r.truth.solid)]));
  }
}

void TruthCloud::write(const std::string& path) const {
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\ncomment true surface points and colours\nelement vertex " << size()
         << "\nproperty double x\nproperty double y\nproperty double z\n"
         << "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         << (with_quantities_ ? "property uchar label\nproperty float temperature\n" : "") << "end_header\n";
  AtomicFile file(path);
  file.append(header.str().data(), header.str().size());
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    file.append(positions_[i].data(), 24);
    file.append(&colors_[3 * i], 3);
    if (!with_quantities_) continue;
    const auto temperature = static_cast<float>(temperatureAt(positions_[i]));
    file.append(&labels_[i], 1);
    file.append(&temperature, sizeof temperature);
  }
  file.commit(false);
}

void writeTruePoses(const Drive& drive, const std::string& path) {
  std::ostringstream file;
  file << "# true map_from_camera (optical frame) of every image, and what the camera multiplied the colours with\n"
       << "camera,frame,stamp,gain_red,gain_green,gain_blue,tx,ty,tz,qx,qy,qz,qw\n"
       << std::setprecision(12);
  for (int frame = 0; frame < drive.options().frames; ++frame) {
    for (int camera = 0; camera < drive.options().cameras; ++camera) {
      const Color gain = drive.gain(camera, frame);
      file << drive.cameras()[static_cast<std::size_t>(camera)].name << ',' << frame << ','
           << secondsOf(drive.imageStamp(camera, frame)) << ',' << gain[0] << ',' << gain[1] << ',' << gain[2] << ',';
      writePose(file, drive.mapFromCamera(camera, frame), ",");
      file << '\n';
    }
  }
  write(path, file);
}

void writeSceneFile(const Drive& drive, const std::string& path) {
  std::ostringstream file;
  file << "# A simulated drive. The same options make the same files again.\noptions:\n" << std::setprecision(12);
  for (const ParamText& option : describeOptions(drive.options())) {
    file << "  " << option.name << ": " << option.value << "  # " << option.help << '\n';
  }
  file << "# [tx, ty, tz, qx, qy, qz, qw] of base_link from the camera's optical frame\ncameras:\n";
  for (const DriveCamera& camera : drive.cameras()) {
    file << "  - name: " << camera.name << "\n    true_extrinsics: [";
    writePose(file, camera.base_from_camera, ", ");
    file << "]\n    given_extrinsics: [";
    writePose(file, camera.base_from_camera_given, ", ");
    file << "]\n    white_balance: [" << camera.white_balance[0] << ", " << camera.white_balance[1] << ", "
         << camera.white_balance[2] << "]\n";
  }
  write(path, file);
}

}  // namespace cloud_colorizer::simulation
