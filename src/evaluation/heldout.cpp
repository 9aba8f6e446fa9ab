// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/heldout.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "base/columns.hpp"
#include "base/parallel.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/map/colorize.hpp"
#include "evaluation/clouds.hpp"
#include "evaluation/heldout_pictures.hpp"
#include "evaluation/refine_pose.hpp"
#include "evaluation/score.hpp"
#include "evaluation/trajectory.hpp"
#include "recording/scan_times.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// The map coloured by one method.
struct ColoredMap {
  std::string method;
  std::vector<Eigen::Isometry3d> poses;  ///< of the views that it was coloured from, as the method used them
  Points points;
  Values colors;
  std::vector<std::uint8_t> colored;
};

ColoredMap colorMap(const Recording& training, const HeldoutParams& params, Method method, const Callbacks& callbacks) {
  Params settings = params.params;
  settings.colorize.method = method;
  settings.colorize.uncolored = Uncolored::kKeep;
  colorize(training, settings, callbacks);
  ColoredMap map;
  map.method = enumNames(method)[static_cast<std::size_t>(method)];
  map.poses = usedPoses(training, settings);
  map.points.resize(3, static_cast<Index>(training.numPoints()));
  map.colors.resize(3, map.points.cols());
  Index next = 0;
  forEachColoredTile(training, settings, true, [&](const Cloud& cloud) {
    const ColoredCloud tile = coloredCloud(cloud, training.directory());
    require(next + tile.colors.cols() <= map.points.cols(), "the coloured map has more points than the recording");
    map.points.middleCols(next, tile.colors.cols()) = tile.positions.cast<float>();
    map.colors.middleCols(next, tile.colors.cols()) = tile.colors;
    next += tile.colors.cols();
    for (const std::uint16_t count : tile.count) map.colored.push_back(count > 0 ? 1 : 0);
  });
  require(next == map.points.cols(), "the coloured map has ", next, " points, the recording ", map.points.cols());
  return map;
}

Eigen::Vector3f bilinear(const cv::Mat3b& image, const Eigen::Vector2f& pixel) {
  const float x = std::clamp(pixel.x(), 0.F, static_cast<float>(image.cols - 1));
  const float y = std::clamp(pixel.y(), 0.F, static_cast<float>(image.rows - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.cols - 1), y1 = std::min(y0 + 1, image.rows - 1);
  const float ax = x - static_cast<float>(x0), ay = y - static_cast<float>(y0);
  Eigen::Vector3f value;
  for (int c = 0; c < 3; ++c) {
    const auto above = static_cast<float>(image(y0, x0)[c]) * (1 - ax) + static_cast<float>(image(y0, x1)[c]) * ax;
    const auto below = static_cast<float>(image(y1, x0)[c]) * (1 - ax) + static_cast<float>(image(y1, x1)[c]) * ax;
    value[c] = above * (1 - ay) + below * ay;
  }
  return value;
}

constexpr float kSaturated = 250;

/// All points that the view sees clearly, whatever their colour.
SeenImage lookAtPoints(PointsRef points, const Surfels& surfels, const Camera& camera, const View& view,
                       const cv::Mat3b& image, const cv::Mat& mask,
                       const std::shared_ptr<const EmptySpace>& empty_space, const Params& params) {
  const Eigen::Isometry3f camera_from_map = view.map_from_camera.inverse().cast<float>();
  DepthSplatter splatter(camera, camera_from_map, params.depth, empty_space);
  splatter.add(points, surfels);
  const DepthImage depth = splatter.finish();
  SeenImage seen;
  const auto border = static_cast<float>(params.observe.image_border);
  const auto right = static_cast<float>(image.cols - 1) - border, bottom = static_cast<float>(image.rows - 1) - border;
  std::vector<Eigen::Vector3f> values;
  for (Index p = 0; p < points.cols(); ++p) {
    const Eigen::Vector3f local = camera_from_map * surfels.onSurface(p, points.col(p));
    if (local.z() <= 0 || local.norm() > static_cast<float>(params.depth.max_view_distance)) continue;
    const auto pixel = camera.project(camera_from_map * points.col(p));
    if (!pixel || pixel->x() < border || pixel->y() < border || pixel->x() > right || pixel->y() > bottom) continue;
    if (!mask.empty() && mask.at<std::uint8_t>(cv::Point(cvRound(pixel->x()), cvRound(pixel->y()))) == 0) continue;
    const Eigen::Vector3f normal = camera_from_map.linear() * surfels.normals.col(p);
    if (depth.test(*pixel, local, normal, surfels.radii[p], params.depth) != Visibility::kVisible) continue;
    const Eigen::Vector3f value = bilinear(image, *pixel);
    if (value.maxCoeff() >= kSaturated) continue;  // what is brighter than the image holds tells no colour
    seen.points.push_back(p);
    seen.pixels.push_back(*pixel);
    seen.depths.push_back(local.z());
    seen.pixel_radii.push_back(surfels.radii[p] * static_cast<float>(camera.intrinsics().fx) / local.z());
    values.push_back(value);
  }
  seen.values.resize(3, static_cast<Index>(values.size()));
  for (std::size_t k = 0; k < values.size(); ++k) seen.values.col(static_cast<Index>(k)) = values[k];
  return seen;
}

/// Errors of one method in one or more images.
struct Errors {
  std::vector<float> raw, after_gain, given, trimmed, refined;  ///< mean over the channels, by point
  double squares = 0;                                           ///< sum over points and channels, after the gain
  std::size_t visible = 0, colored = 0, moved = 0;
  double seam = 0;
  std::size_t seam_pairs = 0;

  void add(const Errors& other) {
    raw.insert(raw.end(), other.raw.begin(), other.raw.end());
    after_gain.insert(after_gain.end(), other.after_gain.begin(), other.after_gain.end());
    given.insert(given.end(), other.given.begin(), other.given.end());
    trimmed.insert(trimmed.end(), other.trimmed.begin(), other.trimmed.end());
    refined.insert(refined.end(), other.refined.begin(), other.refined.end());
    squares += other.squares;
    visible += other.visible;
    colored += other.colored;
    moved += other.moved;
    seam += other.seam;
    seam_pairs += other.seam_pairs;
  }
};

/// The map's colours at the points of an image, brought to the image's exposure by one gain a channel.
Values predict(const ColoredMap& map, const SeenImage& seen, bool with_gain) {
  Values predicted = gatherColumns(map.colors, seen.points);
  if (!with_gain) return predicted;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> image, colors;
    for (std::size_t k = 0; k < seen.points.size(); ++k) {
      if (map.colored[static_cast<std::size_t>(seen.points[k])] == 0) continue;
      image.push_back(seen.values(c, static_cast<Index>(k)));
      colors.push_back(predicted(c, static_cast<Index>(k)));
    }
    predicted.row(c) *= static_cast<float>(bestGain(image, colors));
  }
  return predicted.cwiseMin(255);
}

/// Points where even the median of the views is far from the image: moved, or reflecting.
std::vector<std::uint8_t> movedPoints(const ColoredMap& median, const SeenImage& seen, double threshold) {
  const Values predicted = predict(median, seen, true);
  std::vector<std::uint8_t> moved(seen.points.size(), 0);
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const auto column = static_cast<Index>(k);
    const bool colored = median.colored[static_cast<std::size_t>(seen.points[k])] != 0;
    const float error = (predicted.col(column) - seen.values.col(column)).cwiseAbs().mean();
    moved[k] = colored && error > static_cast<float>(threshold) ? 1 : 0;
  }
  return moved;
}

/// Steps between neighbours that the image does not have: mean |(c_p - c_q) - (v_p - v_q)| over pairs of points next
/// to each other on the surface.
void addSeams(const ColoredMap& map, const SeenImage& seen, const Values& predicted,
              const std::vector<std::uint8_t>& moved, const std::vector<Edge>& neighbors, Errors& errors) {
  std::vector<std::int32_t> at(map.colored.size(), -1);
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    const auto point = static_cast<std::size_t>(seen.points[k]);
    if (map.colored[point] != 0 && moved[k] == 0) at[point] = static_cast<std::int32_t>(k);
  }
  for (const Edge& edge : neighbors) {
    const std::int32_t p = at[edge.p], q = at[edge.q];
    if (p < 0 || q < 0) continue;
    const Eigen::Vector3f step = predicted.col(p) - predicted.col(q) - seen.values.col(p) + seen.values.col(q);
    errors.seam += step.cwiseAbs().mean();
    ++errors.seam_pairs;
  }
}

Errors compare(const ColoredMap& map, const SeenImage& seen, const std::vector<std::uint8_t>& moved,
               const std::vector<Edge>& neighbors) {
  Errors errors;
  const Values raw = predict(map, seen, false), corrected = predict(map, seen, true);
  errors.visible = seen.points.size();
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    if (map.colored[static_cast<std::size_t>(seen.points[k])] == 0) continue;
    const auto column = static_cast<Index>(k);
    ++errors.colored;
    errors.raw.push_back((raw.col(column) - seen.values.col(column)).cwiseAbs().mean());
    errors.after_gain.push_back((corrected.col(column) - seen.values.col(column)).cwiseAbs().mean());
    errors.squares += (corrected.col(column) - seen.values.col(column)).squaredNorm();
    if (moved[k] == 0) errors.trimmed.push_back(errors.after_gain.back());
    errors.moved += moved[k];
  }
  addSeams(map, seen, corrected, moved, neighbors, errors);
  return errors;
}

/// The same points, where the image shows them from another pose.
SeenImage seenFrom(const Eigen::Isometry3d& map_from_camera, const ColoredMap& map, const SeenImage& seen,
                   const Camera& camera, const cv::Mat3b& image) {
  const Eigen::Isometry3f camera_from_map = map_from_camera.inverse().cast<float>();
  SeenImage moved = seen;
  for (std::size_t k = 0; k < seen.points.size(); ++k) {
    const auto pixel = camera.project(camera_from_map * map.points.col(seen.points[k]));
    if (!pixel) continue;
    moved.pixels[k] = *pixel;
    moved.values.block<3, 1>(0, static_cast<Index>(k)) = bilinear(image, *pixel);
  }
  return moved;
}

/// The pose from which the image fits this map best. At it no method pays for the error of the held-out view's own
/// pose, nor has an advantage when the map moved with a correction of the extrinsics.
Eigen::Isometry3d refinedPose(const ColoredMap& map, const SeenImage& seen, const Camera& camera,
                              const Eigen::Isometry3d& start, const cv::Mat3b& image) {
  std::vector<Index> colored;
  for (const Index p : seen.points) {
    if (map.colored[static_cast<std::size_t>(p)] != 0) colored.push_back(p);
  }
  return refinePose(gatherColumns(map.points, colored), gatherColumns(map.colors, colored), camera, image, start);
}

double mean(const std::vector<float>& values) {
  return values.empty() ? std::nan("")
                        : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median(std::vector<float> values) {
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

const std::vector<std::string> kHeader = {"method",
                                          "points",
                                          "mean",
                                          "median",
                                          "mean_with_gain",
                                          "median_with_gain",
                                          "mean_given_pose",
                                          "mean_trimmed",
                                          "mean_refined_pose",
                                          "median_refined_pose",
                                          "psnr",
                                          "coverage",
                                          "seam_step",
                                          "moved_percent"};

std::vector<std::string> cells(const std::string& method, const Errors& e) {
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? std::nan("") : static_cast<double>(part) / static_cast<double>(whole);
  };
  const double mse = e.colored == 0 ? std::nan("") : e.squares / (3.0 * static_cast<double>(e.colored));
  return {method,
          std::to_string(e.colored),
          formatNumber(mean(e.raw), 3),
          formatNumber(median(e.raw), 3),
          formatNumber(mean(e.after_gain), 3),
          formatNumber(median(e.after_gain), 3),
          formatNumber(mean(e.given), 3),
          formatNumber(mean(e.trimmed), 3),
          formatNumber(mean(e.refined), 3),
          formatNumber(median(e.refined), 3),
          formatNumber(10 * std::log10(255 * 255 / mse), 2),
          formatNumber(share(e.colored, e.visible), 4),
          formatNumber(e.seam / static_cast<double>(e.seam_pairs), 3),
          formatNumber(100 * share(e.moved, e.colored), 2)};
}

/// Short links of the surface: those of one Z-order pass that are not longer than three times their median.
std::vector<Edge> shortLinks(PointsRef points) {
  ZOrderGrid grid;
  grid.origin = points.rowwise().minCoeff();
  grid.cell = std::max(1e-3F, (points.rowwise().maxCoeff() - grid.origin).maxCoeff() / static_cast<float>(1 << 20));
  GraphParams params;
  params.passes = 1;
  std::vector<Edge> edges = zorderGraph(points, grid, params);
  std::vector<float> lengths;
  for (const Edge& edge : edges) lengths.push_back((points.col(edge.p) - points.col(edge.q)).norm());
  const auto limit = static_cast<float>(3 * median(lengths));
  edges.erase(std::remove_if(edges.begin(), edges.end(),
                             [&](const Edge& e) { return !((points.col(e.p) - points.col(e.q)).norm() <= limit); }),
              edges.end());
  return edges;
}

}  // namespace

HeldoutResult scoreHeldout(const Recording& recording, const HeldoutParams& params, const std::string& directory,
                           const Callbacks& callbacks) {
  params.check();
  const std::vector<std::size_t> heldout = heldoutViews(recording.views(), params.every);
  require(!heldout.empty(), "recording ", recording.directory(), " has ", recording.views().size(),
          " views, of which --every ", params.every, " leaves none out; choose a smaller number");
  std::vector<std::size_t> kept;
  for (std::size_t v = 0; v < recording.views().size(); ++v) {
    if (!std::binary_search(heldout.begin(), heldout.end(), v)) kept.push_back(v);
  }
  const Recording training = withViews(recording, kept, directory + "/training");
  std::vector<ColoredMap> maps;
  for (const Method method : params.methods) maps.push_back(colorMap(training, params, method, callbacks));
  const auto median_map =
      std::find_if(maps.begin(), maps.end(), [](const ColoredMap& map) { return map.method == "median"; });
  require(median_map != maps.end(), "the methods must include median, which tells the moved points");
  const Points& points = maps.front().points;
  const Surfels surfels = estimateSurfels(points, params.params.surfels);
  const std::vector<Edge> neighbors = shortLinks(points);

  const ScanTimes scan_times(recording.scans());
  const auto emptyAt = [&](const View& view) -> std::shared_ptr<const EmptySpace> {
    if (!params.params.depth.use_scans) return nullptr;
    return emptySpaceAt(recording, scan_times, view.stamp, view.map_from_camera, [&](std::size_t scan) {
      return std::make_shared<const cv::Mat1w>(emptyRanges(recording.readScan(scan)));
    });
  };

  std::vector<std::vector<Errors>> errors(heldout.size());
  std::mutex mutex;
  std::size_t done = 0;
  parallelFor(params.params.colorize.num_threads, heldout.size(), [&](std::size_t h) {
    const View& view = recording.views()[heldout[h]];
    const Camera camera(recording.cameras()[view.camera].intrinsics);
    const cv::Mat3b image = recording.readImage(heldout[h]);
    const SeenImage seen = lookAtPoints(points, surfels, camera, view, image, recording.readMask(view.camera),
                                        emptyAt(view), params.params);
    const std::vector<std::uint8_t> moved = movedPoints(*median_map, seen, params.moved_error);
    SeenImage own;
    for (const ColoredMap& map : maps) {
      const Eigen::Isometry3d pose = poseOnTrajectory(view, training.views(), map.poses);
      own = seenFrom(pose, map, seen, camera, image);
      Errors found = compare(map, own, moved, neighbors);
      found.given = compare(map, seen, moved, {}).after_gain;
      found.refined =
          compare(map, seenFrom(refinedPose(map, own, camera, pose, image), map, own, camera, image), moved, {})
              .trimmed;
      errors[h].push_back(std::move(found));
    }
    const ColoredMap& last = maps.back();
    std::vector<std::uint8_t> colored;
    for (const Index p : own.points) colored.push_back(last.colored[static_cast<std::size_t>(p)]);
    savePictures(directory + "/view_" + std::to_string(heldout[h]) + ".png", last.method, own, predict(last, own, true),
                 colored, image);
    const std::lock_guard<std::mutex> lock(mutex);
    if (callbacks.progress) callbacks.progress({"held-out views", ++done, heldout.size(), 0, -1});
  });

  HeldoutResult result;
  result.methods.header = kHeader;
  result.views.header = kHeader;
  result.views.header.insert(result.views.header.begin(), "view");
  for (std::size_t m = 0; m < maps.size(); ++m) {
    Errors all;
    for (std::size_t h = 0; h < heldout.size(); ++h) {
      all.add(errors[h][m]);
      std::vector<std::string> row = cells(maps[m].method, errors[h][m]);
      row.insert(row.begin(), std::to_string(heldout[h]));
      result.views.add(row);
    }
    result.methods.add(cells(maps[m].method, all));
  }
  return result;
}

}  // namespace cloud_colorizer
