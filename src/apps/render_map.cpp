// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// render_map MAP.ply [MAP2.ply ...] --output picture.png: pictures of coloured maps, side by side.
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "apps/command_line.hpp"
#include "apps/field_colors.hpp"
#include "base/columns.hpp"
#include "base/file_io.hpp"
#include "cloud/cloud_colors.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/picture/picture.hpp"

namespace {

using namespace cloud_colorizer;

constexpr std::size_t kBlock = 500000;  // points

/// Calls visit(cloud) for one block of the file after another.
template <class Visit>
void forEachBlock(const std::string& path, const Visit& visit) {
  CloudReader reader(path);
  for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) visit(block);
}

using Colorist = std::function<Values(const Cloud&)>;

/// The colours of a map, on the scale that the largest of them tells.
Colorist colorsOf(const std::string& path, const Callbacks& callbacks) {
  const CloudColors fields(CloudReader(path).fields(), path);
  if (fields.isBytes()) return [=](const Cloud& cloud) { return fields.read(cloud); };
  float largest = 0;
  forEachBlock(path, [&](const Cloud& block) { largest = std::max(largest, fields.read(block).maxCoeff()); });
  const std::string note = fields.describe(largest);
  if (!note.empty()) callbacks.log(LogLevel::kInfo, path + ": " + note);
  return [fields, scale = fields.scale(largest)](const Cloud& cloud) -> Values { return fields.read(cloud) * scale; };
}

/// The points that are somewhere: a map may hold NaN where a ray met nothing.
std::vector<Eigen::Index> finiteOf(const Cloud& cloud) {
  std::vector<Eigen::Index> finite;
  for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
    if (cloud.positions.col(i).allFinite()) finite.push_back(i);
  }
  return finite;
}

ColoredPoints mapSource(const std::string& path, const Colorist& colorist, const Eigen::Vector3d& origin) {
  return [=](const std::function<void(PointsRef, ValuesRef)>& visit) {
    forEachBlock(path, [&](const Cloud& block) {
      const std::vector<Eigen::Index> finite = finiteOf(block);
      const Points points = (block.positions.colwise() - origin).cast<float>();
      visit(gatherColumns(points, finite), gatherColumns(colorist(block), finite));
    });
  };
}

Eigen::AlignedBox3d boundsOf(const std::string& path) {
  Eigen::AlignedBox3d box;
  forEachBlock(path, [&](const Cloud& block) {
    for (const Eigen::Index i : finiteOf(block)) box.extend(block.positions.col(i));
  });
  require(!box.isEmpty(), path, " has no points at finite positions");
  return box;
}

/// A place above the middle, high enough to see it all.
Eigen::Vector3d eyeAbove(const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& up, const PictureParams& params) {
  const auto extent = [&](const Eigen::Vector3d& direction) { return direction.cwiseAbs().dot(bounds.sizes()); };
  const Eigen::Matrix3d axes = lookAt(up, Eigen::Vector3d::Zero(), up).linear();
  const double half_width = 0.5 * std::max(extent(axes.col(1)) * params.width / params.height, extent(axes.col(0)));
  const double distance = half_width / std::tan(params.field_of_view * M_PI / 360);
  return bounds.center() + (0.5 * extent(up) + distance) * up;
}

void render(const CommandLine& line, const Callbacks& callbacks) {
  PictureParams params;
  const auto size = line.list<int>("size", "960x540", 'x', 2);
  params.width = size[0];
  params.height = size[1];
  params.field_of_view = line.value("fov", 70.0);
  params.point_size = line.value("point-size", 0.07);
  params.check();
  const auto end = [&](const char* name) {
    return line.has(name) ? std::optional<float>(line.value(name, 0.F)) : std::nullopt;
  };
  const auto vector = [&](const char* name, const Eigen::Vector3d& otherwise) -> Eigen::Vector3d {
    return line.has(name) ? Eigen::Vector3d(line.list<double>(name, "", ',', 3).data()) : otherwise;
  };
  const Eigen::Vector3d up = vector("up", Eigen::Vector3d::UnitZ());
  require<UsageError>(up.norm() > 0, "--up ", line.option("up"), ": the direction has no length");

  const Eigen::AlignedBox3d bounds = boundsOf(line.positionals[0]);
  const Eigen::Vector3d origin = bounds.center();
  const Eigen::Vector3d eye = vector("eye", eyeAbove(bounds, up.normalized(), params)) - origin;
  const Eigen::Vector3d target = vector("target", origin) - origin;

  const std::string field = line.option("field", "rgb");
  std::vector<cv::Mat> pictures;
  std::vector<std::string> captions;
  for (const std::string& path : line.positionals) {
    const auto draw = [&](const Colorist& colorist) {
      pictures.push_back(drawPicture(mapSource(path, colorist, origin), lookAt(eye, target, up), params));
    };
    if (field == "rgb") {
      draw(colorsOf(path, callbacks));
    } else {
      const FieldColors colors(path, field, end("low"), end("high"));
      draw(colors);
      colors.drawBar(pictures.back());
    }
    captions.push_back(std::filesystem::path(path).stem().string());
  }
  const cv::Mat picture = pictures.size() == 1 ? pictures[0] : besideEachOther(pictures, captions);
  const std::string output = line.option("output");
  std::vector<std::uint8_t> bytes;
  require(cv::imencode(std::filesystem::path(output).extension().string(), picture, bytes), "cannot encode ", output);
  writeFileAtomically(output, bytes.data(), bytes.size());
  callbacks.log(LogLevel::kInfo, "wrote " + output);
}

}  // namespace

int main(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "render_map";
  spec.summary = "Draws coloured maps (.ply, .pcd, .las) as a picture; several are drawn side by side.";
  spec.positionals = "MAP [MAP2 ...]";
  spec.min_positionals = 1;
  spec.max_positionals = 16;
  spec.takes_params = false;
  spec.options = {
      {"output", "FILE", "the picture, .png or .jpg", true},
      {"eye", "X,Y,Z", "m, where to look from; default: above, high enough to see all", false},
      {"target", "X,Y,Z", "m, where to look to; default: the centre", false},
      {"up", "X,Y,Z", "what is upwards; default 0,0,1 (0,-1,0 in the frame of a camera)", false},
      {"fov", "DEG", "horizontal field of view; default 70", false},
      {"size", "WxH", "px of one picture; default 960x540", false},
      {"point-size", "M", "diameter of a point; default 0.07", false},
      {"field", "NAME",
       "rgb (default), view_count, color_stddev or another field: temperature, or label (a colour a class)", false},
      {"low", "X", "value at the dark end of the scale of a field; default 0, or of a measured value its least", false},
      {"high", "X", "value at the bright end; default 20, or the greatest", false}};
  return runMain(argc, argv, spec, render);
}
