// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/quantities.hpp"

#include <cmath>
#include <sstream>

#include "evaluation/neighbors.hpp"

namespace cloud_colorizer {
namespace {

/// The numbers of a field.
class Column {
 public:
  Column(const Cloud& cloud, const LocatedField& field)
      : cloud_(cloud), field_(field), record_size_(recordSize(cloud.fields)) {}
  double operator[](std::size_t i) const {
    return numberAt(cloud_.records.data() + i * record_size_ + field_.offset, field_.field.type);
  }

 private:
  const Cloud& cloud_;
  LocatedField field_;
  std::size_t record_size_;
};

QuantityScore scoreQuantity(const Column& truth, const Column& values, const Column& known, bool is_class,
                            const std::vector<Neighbor>& nearest, double max_distance) {
  QuantityScore score;
  score.is_class = is_class;
  for (std::size_t p = 0; p < nearest.size(); ++p) {
    const std::size_t q = nearest[p].index;
    if (nearest[p].distance > max_distance || !(known[q] > 0)) continue;
    ++score.num_points;
    score.accuracy += values[q] == truth[p] ? 1 : 0;
    score.mean_error += std::abs(values[q] - truth[p]);
    score.error_of_views += 1 / std::sqrt(known[q]);
  }
  const double count = static_cast<double>(score.num_points);
  if (count == 0) return score;
  score.coverage = count / static_cast<double>(nearest.size());
  for (double* sum : {&score.accuracy, &score.mean_error, &score.error_of_views}) *sum /= count;
  return score;
}

}  // namespace

std::vector<QuantityScore> scoreQuantities(const Cloud& truth, const Cloud& result, double max_distance) {
  std::vector<QuantityScore> scores;
  std::vector<Neighbor> nearest;
  for (const Field& field : truth.fields) {
    const auto values = findField(result.fields, field.name);
    const auto confidence = findField(result.fields, field.name + "_confidence");
    const auto known = confidence ? confidence : findField(result.fields, field.name + "_views");
    if (!values || !known) continue;
    if (nearest.empty()) {
      const Eigen::Vector3d origin = truth.positions.col(0);
      nearest = nearestNeighbors((result.positions.colwise() - origin).cast<float>(),
                                 (truth.positions.colwise() - origin).cast<float>());
    }
    scores.push_back(scoreQuantity(Column(truth, *findField(truth.fields, field.name)), Column(result, *values),
                                   Column(result, *known), confidence.has_value(), nearest, max_distance));
    scores.back().name = field.name;
  }
  return scores;
}

std::string QuantityScore::describe() const {
  std::ostringstream text;
  text.precision(4);
  text << name << ": " << num_points << " points (coverage " << 100 * coverage << " %): ";
  if (is_class) {
    text << "accuracy " << 100 * accuracy << " %";
  } else {
    text << "mean error " << mean_error << ", mean of 1/sqrt(views) " << error_of_views;
  }
  return text.str();
}

}  // namespace cloud_colorizer
