// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "visibility/moving.hpp"

namespace cloud_colorizer {

void MovingVotes::add(const PlacedScan& scan, PointsRef points) {
  for (std::size_t i = 0; i < through_.size(); ++i) {
    const ScanEvidence evidence = scan.at(points.col(static_cast<Eigen::Index>(i)));
    through_[i] = static_cast<std::uint16_t>(through_[i] + (evidence == ScanEvidence::kEmpty ? 1 : 0));
    hit_[i] = static_cast<std::uint16_t>(hit_[i] + (evidence == ScanEvidence::kSurface ? 1 : 0));
  }
}

std::vector<std::uint8_t> MovingVotes::shares() const {
  constexpr std::uint32_t kFewest = 2;
  std::vector<std::uint8_t> shares(through_.size(), 0);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const std::uint32_t through = through_[i], all = through + hit_[i];
    if (through >= kFewest) shares[i] = static_cast<std::uint8_t>(255 * through / all);
  }
  return shares;
}

}  // namespace cloud_colorizer
