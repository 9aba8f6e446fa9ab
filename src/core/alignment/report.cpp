// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "cloud_colorizer/alignment/align.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kWidth = 960, kPanel = 150, kMargin = 44;  // px of the picture

// One curve: a value a view.
struct Curve {
  std::string label;
  cv::Scalar color;  // BGR
  std::vector<double> values;
};

std::vector<double> column(const AlignmentResult& result, double (*value)(const ViewAlignment&)) {
  std::vector<double> values;
  for (const ViewAlignment& view : result.views) values.push_back(value(view));
  return values;
}

double gain(const ViewAlignment& view, Eigen::Index channel) {
  return channel < view.exposure.gain.size() ? static_cast<double>(view.exposure.gain[channel]) : 1.0;
}

cv::Point toPixel(const Curve& curve, std::size_t i, double low, double high) {
  const double share =
      curve.values.size() > 1 ? static_cast<double>(i) / static_cast<double>(curve.values.size() - 1) : 0.5;
  const double height = (curve.values[i] - low) / (high - low);
  return {kMargin + static_cast<int>(share * (kWidth - 2 * kMargin)),
          kPanel - 12 - static_cast<int>(height * (kPanel - 40))};
}

void drawText(cv::Mat3b& picture, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.42, color, 1, cv::LINE_AA);
}

std::string shortNumber(double value) {
  std::ostringstream text;
  text << std::setprecision(3) << value;
  return text.str();
}

// Draws the curves over the views into one strip, from `low` to the largest value.
void drawPanel(cv::Mat3b panel, const std::vector<Curve>& curves, double low) {
  double high = low + 1e-6;
  for (const Curve& curve : curves) {
    for (const double value : curve.values) high = std::max(high, value);
  }
  drawText(panel, shortNumber(high), {4, 32}, cv::Scalar(90, 90, 90));
  drawText(panel, shortNumber(low), {4, kPanel - 10}, cv::Scalar(90, 90, 90));
  cv::rectangle(panel, cv::Point(kMargin, 26), cv::Point(kWidth - kMargin, kPanel - 10), cv::Scalar(210, 210, 210));
  int x = kMargin;
  for (const Curve& curve : curves) {
    drawText(panel, curve.label, {x, 18}, curve.color);
    x += 12 + 8 * static_cast<int>(curve.label.size());
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      const cv::Point at = toPixel(curve, i, low, high);
      cv::circle(panel, at, 2, curve.color, cv::FILLED, cv::LINE_AA);
      if (i > 0) cv::line(panel, toPixel(curve, i - 1, low, high), at, curve.color, 1, cv::LINE_AA);
    }
  }
}

}  // namespace

std::string describe(const AlignmentResult& result) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2);
  std::size_t refused = 0, soft = 0;
  double low = 1, high = 1;
  for (const ViewAlignment& view : result.views) {
    refused += view.refused;
    soft += view.weight < 0.5F;
    for (Eigen::Index c = 0; c < view.exposure.gain.size(); ++c) {
      low = std::min(low, gain(view, c));
      high = std::max(high, gain(view, c));
    }
  }
  text << "Alignment of " << result.views.size() << " views of " << result.cameras.size() << " cameras in "
       << result.seconds << " s: ";
  if (!result.poses_aligned && !result.exposure_aligned) text << "nothing was changed. ";
  if (result.poses_aligned) {
    text << "poses moved by " << result.pixels
         << " px (median); each view, predicted from the others at held-back points, "
         << "is off by " << result.residual_before << " grey levels with the given poses and by "
         << result.residual_after << " with the corrected ones (+-" << result.residual_error << "): the "
         << (result.corrections_kept ? "corrected" : "given") << " poses are used. ";
  }
  if (result.exposure_aligned) text << "Gains from " << low << " to " << high << ". ";
  if (refused > 0) text << refused << " views keep their pose (alignment/views.csv tells why). ";
  if (soft > 0) text << soft << " views are blurred and weigh less. ";
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    const CameraAlignment& camera = result.cameras[c];
    if (!result.poses_aligned) break;
    text << "\ncamera_" << c << ": " << std::setprecision(3) << camera.rotation << " deg, " << camera.translation
         << " m";
    if (camera.time_offset_stddev > 0) {
      text << ", clock " << std::showpos << camera.time_offset << std::noshowpos << " s (+-"
           << camera.time_offset_stddev << ")";
    }
  }
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    const Eigen::Array2f& vignetting = result.cameras[c].vignetting;
    if ((vignetting == 0).all()) continue;
    text << "\ncamera_" << c << ": its images darken outwards, to " << std::setprecision(2)
         << std::exp(-vignetting.sum()) << " of their brightness at the left and right ends; undone.";
  }
  return text.str();
}

std::string alignmentCsv(const AlignmentResult& result, const std::vector<View>& views) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "view,camera,stamp,points,rotation_deg,translation_m,pixels,gain_r,gain_g,gain_b,weight,residual_before,"
          "residual_after,refused,reason\n";
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const ViewAlignment& view = result.views[v];
    text << v << ',' << views[v].camera << ',' << std::fixed << std::setprecision(6) << views[v].stamp
         << std::defaultfloat << ',' << view.num_points << ',' << view.rotation << ',' << view.translation << ','
         << view.pixels;
    for (Eigen::Index c = 0; c < 3; ++c) text << ',' << gain(view, c);
    text << ',' << view.weight << ',' << view.residual_before << ',' << view.residual_after << ',' << view.refused
         << ",\"" << view.reason << "\"\n";
  }
  return text.str();
}

std::string alignmentJson(const AlignmentResult& result, const std::vector<View>& views,
                          const std::vector<std::size_t>& ids) {
  using nlohmann::json;
  json rows = json::array(), cameras = json::array(), trials = json::array();
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const ViewAlignment& view = result.views[v];
    rows.push_back({ids[v], views[v].camera, views[v].stamp, view.num_points, view.rotation, view.translation,
                    view.pixels, gain(view, 0), gain(view, 1), gain(view, 2), view.weight, view.residual_before,
                    view.residual_after, view.refused ? 1 : 0});
  }
  for (const CameraAlignment& camera : result.cameras) {
    cameras.push_back({{"rotation_deg", camera.rotation},
                       {"rotation_error_deg", camera.rotation_error},
                       {"translation_error_m", camera.translation_error},
                       {"translation_m", camera.translation},
                       {"vignetting", {camera.vignetting[0], camera.vignetting[1]}},
                       {"time_offset_s", camera.time_offset},
                       {"time_offset_stddev_s", camera.time_offset_stddev},
                       {"time_offset_suspect", camera.time_offset_suspect},
                       {"calibration_suspect", camera.calibration_suspect}});
  }
  for (const ClockTrial& trial : result.clock_trials) trials.push_back({trial.offset, trial.cost});
  return json{{"text", describe(result)},
              {"warnings", result.warnings},
              {"poses_aligned", result.poses_aligned},
              {"exposure_aligned", result.exposure_aligned},
              {"corrections_kept", result.corrections_kept},
              {"residual_before", result.residual_before},
              {"residual_after", result.residual_after},
              {"residual_error", result.residual_error},
              {"thickness_m", result.thickness},
              {"clock_trials", trials},
              {"cameras", cameras},
              {"views",
               {{"columns",
                 {"view", "camera", "stamp", "points", "rotation_deg", "translation_m", "pixels", "gain_r", "gain_g",
                  "gain_b", "weight", "residual_before", "residual_after", "refused"}},
                {"rows", rows}}}}
             .dump(1, ' ', false, json::error_handler_t::replace) +
         '\n';
}

cv::Mat3b alignmentPicture(const AlignmentResult& result) {
  const cv::Scalar red(40, 40, 200), green(40, 140, 40), blue(200, 80, 30), grey(120, 120, 120);
  cv::Mat3b picture(4 * kPanel, kWidth, cv::Vec3b(255, 255, 255));
  const auto panel = [&](int i) { return picture.rowRange(i * kPanel, (i + 1) * kPanel); };
  drawPanel(panel(0), {{"correction [px]", blue, column(result, [](const ViewAlignment& v) { return v.pixels; })}}, 0);
  drawPanel(panel(1),
            {{"residual before [grey levels]", grey, column(result, [](const auto& v) { return v.residual_before; })},
             {"after", green, column(result, [](const ViewAlignment& v) { return v.residual_after; })}},
            0);
  drawPanel(panel(2),
            {{"gain red", red, column(result, [](const ViewAlignment& v) { return gain(v, 0); })},
             {"green", green, column(result, [](const ViewAlignment& v) { return gain(v, 1); })},
             {"blue", blue, column(result, [](const ViewAlignment& v) { return gain(v, 2); })}},
            0);
  drawPanel(panel(3),
            {{"sharpness weight", blue, column(result, [](const auto& v) { return static_cast<double>(v.weight); })},
             {"refused", red, column(result, [](const ViewAlignment& v) { return v.refused ? 1.0 : 0.0; })}},
            0);
  return picture;
}

}  // namespace cloud_colorizer
