// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/summary.hpp"

#include <cmath>
#include <sstream>

namespace cloud_colorizer {
namespace {

/// How much the views of a point differ, compared to how much the points differ.
class Disagreement {
 public:
  void add(const TileColors& colors) {
    for (std::size_t i = 0; i < colors.count.size(); ++i) {
      if (colors.count[i] < 2) continue;
      const Eigen::Vector3d value = colors.values.col(static_cast<Eigen::Index>(i)).cast<double>();
      ++count_;
      sum_ += value;
      sum_squares_ += value.squaredNorm();
      sum_within_ += double{colors.stddev[i]} * colors.stddev[i];
    }
  }

  double ratio() const {
    constexpr std::size_t kEnough = 100;  // points
    if (count_ < kEnough) return 0;
    const double n = static_cast<double>(count_);
    const double between = (sum_squares_ - sum_.squaredNorm() / n) / (3 * n);
    return between > 0 ? std::sqrt(sum_within_ / n / between) : 0;
  }

 private:
  std::size_t count_ = 0;
  Eigen::Vector3d sum_{0, 0, 0};
  double sum_squares_ = 0, sum_within_ = 0;
};

}  // namespace

ColorizeSummary summarize(const Workspace& work) {
  ColorizeSummary summary;
  Disagreement disagreement;
  for (std::size_t tile = 0; tile < work.recording().tiles().size(); ++tile) {
    const TileColors colors = work.files().readColors(tile);
    for (const Unseen reason : colors.unseen) {
      ++summary.num_points;
      ++summary.by_reason[static_cast<std::size_t>(reason)];
    }
    disagreement.add(colors);
  }
  summary.disagreement = disagreement.ratio();
  summary.num_damaged_views = work.damagedViews().size();
  summary.num_colored = summary.by_reason[static_cast<std::size_t>(Unseen::kSeen)];
  return summary;
}

std::string ColorizeSummary::describe() const {
  const auto reason = [&](Unseen r) { return by_reason[static_cast<std::size_t>(r)]; };
  std::ostringstream text;
  text.precision(3);
  text << num_colored << " of " << num_points << " points coloured in " << seconds
       << " s; the others: " << reason(Unseen::kOutside) << " in no image, " << reason(Unseen::kTooFar)
       << " beyond max_view_distance, " << reason(Unseen::kHidden) << " hidden, " << reason(Unseen::kAbsent)
       << " gone when images were taken, " << reason(Unseen::kMasked) << " masked";
  if (num_damaged_views > 0) text << "; views left out because of their images: " << num_damaged_views;
  return text.str();
}

}  // namespace cloud_colorizer
