// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/quantities.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "color/quantity.hpp"

namespace cloud_colorizer {
namespace {

using Eigen::Index;

/// Of the views of one quantity; `fields` are its rows.
void seeQuantity(Workspace& work, const Surface& surface, const ZOrderGrid& grid, const Quantity& quantity,
                 const std::vector<std::size_t>& views, Eigen::Ref<Values> fields, SeenQuantities& seen) {
  if (views.empty()) return;
  const Params& params = work.params();
  const int channels = work.image(views.front())->channels();
  const auto all = static_cast<std::size_t>(surface.size());
  const std::size_t step = std::min(all, pointsAtATime(quantity, channels));
  for (std::size_t first = 0; first < all; first += step) {
    std::vector<Index> columns(std::min(step, all - first));
    std::iota(columns.begin(), columns.end(), static_cast<Index>(first));
    const Surface part = gatherSurface(surface, columns);
    ObserveResult result = observe(
        part.points, part.surfels, views.size(), [&](std::size_t k) { return work.observedView(views[k]); },
        params.depth, params.observe);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto& offsets = result.observations.offsets;
      int& count = seen.count[columns[k]];
      count = std::max(count, static_cast<int>(offsets[k + 1] - offsets[k]));
      Unseen& unseen = seen.unseen[first + k];
      unseen = std::min(unseen, result.unseen[k]);
    }
    fields.middleCols(static_cast<Index>(first), static_cast<Index>(columns.size())) =
        fuseQuantity(part.points, std::move(result.observations), grid, quantity.kind, params.colorize.method,
                     params.graph, params.system);
  }
}

}  // namespace

SeenQuantities seeQuantities(Workspace& work, const Surface& surface, const ZOrderGrid& grid,
                             const std::function<std::vector<std::size_t>(const Quantity&)>& views_of) {
  const std::vector<Quantity> quantities = work.recording().quantities();
  Index rows = 0;
  for (const Quantity& quantity : quantities) rows += static_cast<Index>(fieldsOf(quantity).size());
  SeenQuantities seen{Values::Zero(rows, surface.size()),
                      std::vector<Unseen>(static_cast<std::size_t>(surface.size()), Unseen::kOutside),
                      Eigen::VectorXi::Zero(surface.size())};
  Index row = 0;
  for (const Quantity& quantity : quantities) {
    const auto count = static_cast<Index>(fieldsOf(quantity).size());
    seeQuantity(work, surface, grid, quantity, views_of(quantity), seen.fields.middleRows(row, count), seen);
    row += count;
  }
  return seen;
}

}  // namespace cloud_colorizer
