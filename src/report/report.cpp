// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "report/report.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/picture/picture.hpp"
#include "report/certain.hpp"
#include "report/edge_pictures.hpp"
#include "report/facts.hpp"
#include "report/map_sample.hpp"
#include "report/page.hpp"
#include "visibility/moving.hpp"

namespace cloud_colorizer {
namespace {

using nlohmann::json;

constexpr std::size_t kMostDrawn = 2'000'000;  // points, of the pictures
constexpr float kBeforeTheEye = 0.05F;         // of the map's extent: nearer points hide the picture
constexpr Eigen::Index kPictureBlock = 65536;

/// Those that have a colour, stand still, and are not right before the eye.
/// `shades`: red green blue a point.
ColoredPoints pointsToDraw(const MapSample& sample, const std::vector<std::uint8_t>& shades, const Eigen::Vector3f& eye,
                           float nearest) {
  return [&sample, &shades, eye, nearest](const std::function<void(PointsRef, ValuesRef)>& visit) {
    Points points(3, kPictureBlock);
    Values colors(3, kPictureBlock);
    Eigen::Index count = 0;
    const auto give = [&] {
      if (count > 0) visit(points.leftCols(count), colors.leftCols(count));
      count = 0;
    };
    for (std::size_t i = 0; i < sample.size(); ++i) {
      const Eigen::Map<const Eigen::Vector3f> point(sample.positions.data() + 3 * i);
      if (sample.counts[i] == 0 || sample.moving[i] >= kMovingShare || (point - eye).norm() < nearest) continue;
      points.col(count) = point;
      for (int c = 0; c < 3; ++c) colors(c, count) = shades[3 * i + static_cast<std::size_t>(c)];
      if (++count == kPictureBlock) give();
    }
    give();
  };
}

/// As a data: address.
std::string pictureOf(const MapSample& sample, const std::vector<std::uint8_t>& shades, const Eigen::Isometry3d& pose,
                      float nearest, double field_of_view, double point_size) {
  PictureParams params;
  params.width = 960;
  params.height = 540;
  params.field_of_view = field_of_view;
  params.point_size = point_size;
  params.background = {246, 247, 249};
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg",
               drawPicture(pointsToDraw(sample, shades, pose.translation().cast<float>(), nearest), pose, params),
               bytes, {cv::IMWRITE_JPEG_QUALITY, 85});
  return "data:image/jpeg;base64," + base64Of(bytes.data(), bytes.size());
}

/// Red, green, blue of numbers from 0 to `high`.
template <class Number>
std::vector<std::uint8_t> shadesOf(const std::vector<Number>& numbers, float high) {
  const Eigen::Map<const Eigen::Matrix<Number, Eigen::Dynamic, 1>> column(numbers.data(),
                                                                          static_cast<Eigen::Index>(numbers.size()));
  const Values colors = colorScale(column.template cast<float>().eval(), 0, high);
  std::vector<std::uint8_t> shades(static_cast<std::size_t>(colors.size()));
  std::transform(colors.data(), colors.data() + colors.size(), shades.begin(),
                 [](float value) { return static_cast<std::uint8_t>(value); });
  return shades;
}

/// From above, and from the place in the middle of the drive.
json picturesOf(const MapSample& sample, std::size_t num_points, const Recording& recording,
                const std::vector<Eigen::Isometry3d>& poses, const json& map) {
  json pictures = json::object();
  const bool any_colored =
      std::any_of(sample.counts.begin(), sample.counts.end(), [](auto count) { return count > 0; });
  if (!any_colored || recording.views().empty()) return pictures;
  const Eigen::AlignedBox3d box = sample.coloredBox().cast<double>();
  const Eigen::Vector3d sizes = box.sizes(), center = box.center();
  const double thinning = std::sqrt(static_cast<double>(num_points) / static_cast<double>(sample.size()));
  const double cell = std::sqrt(std::max(sizes.x() * sizes.y(), 1e-12) / static_cast<double>(sample.size()));
  const double spacing = recording.voxelSize() > 0 ? recording.voxelSize() * thinning : cell;
  const double height = 1.1 * std::max(sizes.x() / 0.8, sizes.y() / 0.45) + sizes.z();
  const Eigen::Vector3d eye = center + Eigen::Vector3d(0, 0, height);
  const auto above = [&](const std::vector<std::uint8_t>& shades) {
    return pictureOf(sample, shades, lookAt(eye, center, Eigen::Vector3d::UnitY()), 0, 44, 2 * std::max(spacing, cell));
  };
  pictures["above"] = above(sample.colors);
  pictures["camera"] = pictureOf(sample, sample.colors, poses[poses.size() / 2],
                                 kBeforeTheEye * static_cast<float>(sizes.norm()), 80, 1.2 * spacing);
  pictures["deviation"] = above(shadesOf(sample.deviations, static_cast<float>(map["shown_deviation"])));
  pictures["thickness"] = above(shadesOf(sample.thicknesses, static_cast<float>(map["shown_thickness_m"])));
  return pictures;
}

json pathOf(const Recording& recording, const std::vector<Eigen::Isometry3d>& poses) {
  json path = json::array();
  for (std::size_t v = 0; v < poses.size(); ++v) {
    const Eigen::Vector3d t = poses[v].translation(), z = poses[v].linear().col(2);
    path.push_back({recording.views()[v].camera, t.x(), t.y(), t.z(), z.x(), z.y(), z.z()});
  }
  return path;
}

void replace(std::string& text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  require(at != std::string::npos, "the page of the report has no place for ", what);
  text.replace(at, what.size(), by);
}

/// Nothing in it ends the script that it stands in, or begins another.
std::string insideScript(const json& value) {
  std::string text;
  for (const char c : value.dump(-1, ' ', true, json::error_handler_t::replace)) {
    c == '<' ? text += "\\u003c" : text += c;
  }
  return text;
}

json edgePicturesOf(Workspace& work, const json& alignment, const Callbacks& callbacks) {
  return edgePictures(work, alignment.contains("views") ? alignment["views"] : json(), callbacks);
}

}  // namespace

json writeReport(const Recording& recording, const Params& params, const RunFacts& run, const std::string& directory,
                 const Callbacks& callbacks) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  require(!error, "cannot create ", directory, ": ", error.message());
  const std::size_t drawn = std::max(kMostDrawn, run.max_points);
  const MapSample sample = sampleMap(recording, params, run.summary.num_points, drawn, callbacks);
  Workspace work(recording, params);
  work.restoreDamagedViews();
  work.restoreCorrections();
  json facts = collectFacts(recording, params, run, sample);
  facts["map"]["certainly_seen_colored_share"] = certainlySeenColored(work, sample);
  facts["lights"] = lightsOf(facts);
  const std::vector<Eigen::Isometry3d> poses = usedPoses(recording, params);
  json page_facts = facts;
  page_facts["edges"] = edgePicturesOf(work, facts["alignment"], callbacks);
  page_facts["pictures"] = picturesOf(sample, run.summary.num_points, recording, poses, facts["map"]);
  page_facts["path"] = pathOf(recording, poses);
  std::string points;
  page_facts["sample"] = packSample(sample, points, run.max_points);
  std::string page = kPage;
  replace(page, "@FACTS@", insideScript(page_facts));
  replace(page, "@POINTS@", points);
  const std::string text = facts.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
  writeFileAtomically(directory + "/report.json", text.data(), text.size());
  writeFileAtomically(directory + "/report.html", page.data(), page.size());
  return facts;
}

bool holds(const std::string& condition, const json& report) {
  using Invalid = std::invalid_argument;
  const auto at = condition.find_first_of("<>");
  double limit = 0;
  require<Invalid>(at != std::string::npos && parseDouble(condition.substr(at + 1), limit), "the condition \"",
                   condition, "\" must be a name of report.json, < or >, and a number: map.colored_share<0.9");
  const json* value = &report;
  for (const std::string& name : splitAt(condition.substr(0, at), '.')) {
    require<Invalid>(value->is_object() && value->contains(name), "report.json has no ", condition.substr(0, at));
    value = &(*value)[name];
  }
  require<Invalid>(value->is_number(), condition.substr(0, at), " of report.json is no number");
  return condition[at] == '<' ? value->get<double>() < limit : value->get<double>() > limit;
}

}  // namespace cloud_colorizer
