// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Who follows whom in the Z-orders of the passes.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace cloud_colorizer {

using Link = std::pair<std::uint32_t, std::uint32_t>;  ///< two points, first < second

/// Links of passes that have a grid each: the keys shifted and mirrored. Pass by pass, so some are there twice.
std::vector<Link> ownGridLinks(const std::vector<std::uint64_t>& keys, int passes);

/// Links of passes that mirror one grid, each link once, those inside of a block before those out of it.
///
/// All passes at once in O(n) after one sort: a block of the grid's binary tree is one run of points in every pass, so
/// only where a pass enters and leaves it matters. Two points meet in one block only, so duplicates are local to it.
std::vector<Link> sharedGridLinks(const std::vector<std::uint64_t>& keys, int passes);

/// An order of elimination for the matrix of these shared-grid links that costs nothing: points by the block that their
/// last link is in, inner blocks first. A pass enters and leaves a block once, so at most 8 points of a block have
/// links out of it, and the factor has few entries a point whatever n is; no search for an ordering (AMD) is needed.
std::vector<int> orderByLastLink(std::size_t num_points, const std::vector<Link>& links);

}  // namespace cloud_colorizer
