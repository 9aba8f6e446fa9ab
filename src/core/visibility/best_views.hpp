// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Which views of a point are kept.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "cloud_colorizer/visibility/observe.hpp"

namespace cloud_colorizer {

/// What one view has of a point, but for its values.
struct Candidate {
  std::uint32_t view = 0;
  float distance = 0, weight = 0;
};

/// The best few views of every point. Lists grow by blocks of one arena, for most points have far fewer than
/// `max_views`.
class BestViews {
 public:
  BestViews(std::size_t num_points, int max_views)
      : max_views_(static_cast<std::uint32_t>(max_views)), points_(num_points) {}

  /// Room for all that can come: memory that is not touched costs nothing, and growing would copy it.
  void reserve(std::size_t num_views, int channels) {
    channels_ = static_cast<std::size_t>(channels);
    const std::size_t most = std::min({num_views, std::size_t{max_views_}, std::size_t{32}});
    const std::size_t blocks = (most + kBlock - 1) / kBlock;
    next_.reserve(points_.size() * blocks);
    candidates_.reserve(points_.size() * blocks * kBlock);
    values_.reserve(points_.size() * blocks * kBlock * channels_);
  }

  /// Some view tells that the point is hidden from it.
  void markHidden(std::size_t point) { points_[point].hidden = 1; }

  /// Whether no view of at most this weight, nor its telling that the point is hidden, can change anything.
  bool isSettled(std::size_t point, float weight) const {
    return points_[point].clear && weight < points_[point].worst;
  }

  /// The least weight that can change anything for any of these points; infinite where none can.
  float leastUseful(std::size_t begin, std::size_t end) const {
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t p = begin; p < end; ++p) least = std::min(least, points_[p].clear ? points_[p].worst : 0.F);
    return least;
  }

  /// Keeps it if it is among the best. The first clear one drops those at edges.
  void add(std::size_t point, const Candidate& candidate, const float* values, bool edge) {
    List& list = points_[point];
    if (edge && list.clear) return;
    if (!edge && !list.clear) list.clear = true, list.count = 0, list.worst = 0;
    if (candidate.weight < list.worst) return;
    const bool full = list.count == max_views_;
    const std::uint32_t at = full ? worstOf(list) : slot(list, list.count++);
    if (full && !better(candidate, candidates_[at])) return;
    candidates_[at] = candidate;
    if (list.count == max_views_) list.worst = candidates_[worstOf(list)].weight;
    std::copy(values, values + channels_, values_.begin() + static_cast<std::ptrdiff_t>(at * channels_));
  }

  Observations finish();

 private:
  static constexpr std::uint32_t kBlock = 4;  ///< slots that a point's list grows by
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  struct List {
    std::uint32_t first = kNone;  // block
    std::uint32_t count : 30, clear : 1, hidden : 1;
    float worst = 0;  // weight of what is kept, once there are max_views
    List() : count(0), clear(0), hidden(0) {}
  };

  /// Slot i of a list; appends a block when the list has none for it.
  std::uint32_t slot(List& list, std::uint32_t i) {
    std::uint32_t* block = &list.first;
    for (std::uint32_t hop = i / kBlock;; --hop) {
      if (*block == kNone) {
        const auto added = static_cast<std::uint32_t>(next_.size());
        *block = added;  // before next_ grows, which may move what `block` points to
        next_.push_back(kNone);
        candidates_.resize(candidates_.size() + kBlock);
        values_.resize(values_.size() + kBlock * channels_);
        return added * kBlock + i % kBlock;
      }
      if (hop == 0) return *block * kBlock + i % kBlock;
      block = &next_[*block];
    }
  }

  static bool better(const Candidate& a, const Candidate& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.view < b.view;
  }

  /// Slot of the one that goes first.
  std::uint32_t worstOf(const List& list) const {
    std::uint32_t worst = list.first * kBlock, left = list.count;
    for (std::uint32_t block = list.first; left > 0; block = next_[block]) {
      const std::uint32_t end = block * kBlock + std::min(left, kBlock);
      for (std::uint32_t at = block * kBlock; at < end; ++at) {
        if (better(candidates_[worst], candidates_[at])) worst = at;
      }
      left -= std::min(left, kBlock);
    }
    return worst;
  }

  std::uint32_t max_views_;
  std::size_t channels_ = 0;
  std::vector<List> points_;
  std::vector<std::uint32_t> next_;    // of a block
  std::vector<Candidate> candidates_;  // kBlock a block
  std::vector<float> values_;          // channels_ a slot
};

inline Observations BestViews::finish() {
  // At a depth edge a small error of a pose decides which surface a view shows: one against another is no evidence.
  for (List& list : points_) list.count = !list.clear && list.hidden && list.count == 1 ? 0 : list.count;
  Observations out;
  out.offsets.reserve(points_.size() + 1);
  out.offsets.push_back(0);
  for (const List& list : points_) out.offsets.push_back(out.offsets.back() + list.count);
  const std::size_t total = out.offsets.back();
  out.views.resize(total), out.distances.resize(total), out.weights.resize(total);
  out.values.resize(static_cast<Eigen::Index>(channels_), static_cast<Eigen::Index>(total));
  std::vector<std::uint32_t> slots;
  for (std::size_t p = 0; p < points_.size(); ++p) {
    slots.clear();
    for (std::uint32_t i = 0; i < points_[p].count; ++i) slots.push_back(slot(points_[p], i));
    std::sort(slots.begin(), slots.end(), [&](auto a, auto b) { return candidates_[a].view < candidates_[b].view; });
    std::size_t to = out.offsets[p];
    for (const std::uint32_t from : slots) {
      out.views[to] = candidates_[from].view;
      out.distances[to] = candidates_[from].distance;
      out.weights[to] = candidates_[from].weight;
      const float* const values = values_.data() + from * channels_;
      std::copy(values, values + channels_, out.values.data() + to * channels_);
      ++to;
    }
  }
  return out;
}

}  // namespace cloud_colorizer
