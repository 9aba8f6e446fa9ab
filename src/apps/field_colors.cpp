// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "apps/field_colors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/picture/picture.hpp"

namespace cloud_colorizer {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr float kUnknown = 128;  // grey

LocatedField located(const std::string& path, const std::vector<Field>& fields, const std::string& name) {
  const auto found = findField(fields, name);
  std::string known;
  for (const Field& field : fields) known += " " + field.name;
  require(found.has_value(), path, " has no field ", name, "; it has:", known);
  return *found;
}

/// Neighbouring numbers get hues far from each other.
float shadeOfClass(float number, int channel) {
  constexpr float kGoldenAngle = 2.39996F, kThird = 2.09440F;
  const float hue = kGoldenAngle * number, light = 0.75F + 0.25F * std::cos(0.7F * number);
  return 255 * light * (0.5F + 0.45F * std::cos(hue - kThird * static_cast<float>(channel)));
}

}  // namespace

FieldColors::FieldColors(const std::string& path, const std::string& name, std::optional<float> low,
                         std::optional<float> high)
    : name_(name) {
  const std::vector<Field> fields = CloudReader(path).fields();
  field_ = located(path, fields, name);
  record_size_ = recordSize(fields);
  known_ = findField(fields, name + "_confidence");
  is_class_ = known_.has_value();
  if (!known_) known_ = findField(fields, name + "_views");
  const FieldType type = field_.field.type;
  // Whole numbers begin at 1: a view_count of 0 is no colour.
  low_ = type == FieldType::kFloat32 || type == FieldType::kFloat64 ? 0 : 1;
  if (known_ && !is_class_ && !(low && high)) findRange(path);
  low_ = low.value_or(low_);
  high_ = high.value_or(high_);
}

std::optional<float> FieldColors::numberAtPoint(const Cloud& cloud, std::size_t i) const {
  const std::uint8_t* record = cloud.records.data() + i * record_size_;
  if (known_ && !(numberAt(record + known_->offset, known_->field.type) > 0)) return std::nullopt;
  return static_cast<float>(numberAt(record + field_.offset, field_.field.type));
}

void FieldColors::findRange(const std::string& path) {
  constexpr std::size_t kBlock = 500000, kEach = 7;  // points; of which one tells the range
  constexpr double kOutside = 0.01;
  std::vector<float> numbers;
  CloudReader reader(path);
  for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(block.positions.cols()); i += kEach) {
      const auto number = numberAtPoint(block, i);
      if (number && std::isfinite(*number)) numbers.push_back(*number);
    }
  }
  if (numbers.empty()) return;
  const auto at = [&](double share) {
    const auto nth = numbers.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(numbers.size() - 1));
    std::nth_element(numbers.begin(), nth, numbers.end());
    return *nth;
  };
  low_ = at(kOutside);
  high_ = at(1 - kOutside);
}

Values FieldColors::operator()(const Cloud& cloud) const {
  Eigen::VectorXf numbers(cloud.positions.cols());
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    numbers[i] = numberAtPoint(cloud, static_cast<std::size_t>(i)).value_or(kNone);
  }
  if (!is_class_) {
    // What is below the range of measured values is at its end; a number below others' is none.
    if (known_) numbers = numbers.unaryExpr([&](float x) { return x < low_ ? low_ : x; });
    return colorScale(numbers, low_, high_);
  }
  Values colors = Values::Constant(3, numbers.size(), kUnknown);
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    for (int c = 0; c < 3 && !std::isnan(numbers[i]); ++c) colors(c, i) = shadeOfClass(numbers[i], c);
  }
  return colors;
}

void FieldColors::drawBar(cv::Mat& picture) const {
  constexpr int kWidth = 200, kHeight = 14, kMargin = 14;
  if (is_class_ || picture.cols < kWidth + 2 * kMargin || picture.rows < 4 * kHeight) return;
  Eigen::VectorXf ramp(kWidth);
  for (int x = 0; x < kWidth; ++x) {
    ramp[x] = low_ + (high_ - low_) * static_cast<float>(x) / static_cast<float>(kWidth - 1);
  }
  const Values colors = colorScale(ramp, low_, high_);
  const int top = picture.rows - kMargin - kHeight;
  for (int x = 0; x < kWidth; ++x) {
    const auto color = colors.col(x);
    cv::line(picture, {kMargin + x, top}, {kMargin + x, top + kHeight},
             cv::Scalar(static_cast<double>(color[2]), static_cast<double>(color[1]), static_cast<double>(color[0])));
  }
  const auto write = [&](const std::string& text, int x) {
    for (const auto& [shade, thickness] : {std::pair<int, int>{255, 3}, {20, 1}}) {
      cv::putText(picture, text, {x, top - 6}, cv::FONT_HERSHEY_SIMPLEX, 0.45, cv::Scalar::all(shade), thickness,
                  cv::LINE_AA);
    }
  };
  const auto rounded = [](float number) { return formatDouble(std::round(static_cast<double>(number) * 100) / 100); };
  write(rounded(low_), kMargin);
  write(name_, kMargin + kWidth / 3);
  write(rounded(high_), kMargin + kWidth - 30);
}

}  // namespace cloud_colorizer
