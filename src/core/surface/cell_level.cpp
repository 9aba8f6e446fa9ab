// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surface/cell_level.hpp"

#include <algorithm>

namespace cloud_colorizer {
namespace {

constexpr int kBlockBits = 6;  // of a key: 4 x 4 x 4 cells
constexpr std::uint64_t kAxisBits = 0x1249249249249249;

/// The key of the cell one further along an axis, or one back.
std::uint64_t shiftedKey(std::uint64_t key, int axis, int step) {
  const std::uint64_t bits = kAxisBits << axis, one = std::uint64_t{1} << axis;
  const std::uint64_t along = step > 0 ? (key | ~bits) + one : (key & bits) - one;
  return step == 0 ? key : (key & ~bits) | (along & bits);
}

/// Number k = 0 to 26 of the cells around one, as steps along the axes.
constexpr int stepOf(int k, int axis) {
  return (axis == 0 ? k % 3 : axis == 1 ? k / 3 % 3 : k / 9) - 1;
}

/// Where the 27 cells around a cell of a block are: in which of the 27 blocks around, and which cell of it.
struct Place {
  std::uint8_t block, cell;
};
using Places = std::array<std::array<Place, 27>, 64>;

Places makePlaces() {
  Places places{};
  for (unsigned cell = 0; cell < 64; ++cell) {
    for (int k = 0; k < 27; ++k) {
      int block = 0, scale = 1;
      unsigned bits = 0;
      for (int axis = 0; axis < 3; ++axis, scale *= 3) {
        const unsigned at = (cell >> axis & 1U) | (cell >> (axis + 3) & 1U) << 1;
        const int moved = static_cast<int>(at) + stepOf(k, axis);
        block += scale * (moved < 0 ? 0 : moved > 3 ? 2 : 1);
        const auto inside = static_cast<unsigned>(moved) & 3U;
        bits |= (inside & 1U) << axis | (inside >> 1) << (axis + 3);
      }
      places[cell][static_cast<std::size_t>(k)] = {static_cast<std::uint8_t>(block), static_cast<std::uint8_t>(bits)};
    }
  }
  return places;
}

const Places kPlaces = makePlaces();

}  // namespace

CellLevel::CellLevel(PointsRef points, const std::vector<std::uint64_t>& keys, const ZOrderGrid& grid, int level)
    : level_(level) {
  keys_.reserve(keys.size()), begins_.reserve(keys.size() + 1), moments_.reserve(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::uint64_t key = keys[i] >> (3 * level);
    if (keys_.empty() || keys_.back() != key) {
      keys_.push_back(key);
      begins_.push_back(static_cast<std::uint32_t>(i));
      moments_.emplace_back();
    }
    moments_.back().add(positionInCell(gridPosition(points.col(static_cast<Eigen::Index>(i)), grid), level));
  }
  begins_.push_back(static_cast<std::uint32_t>(keys.size()));
  makeBlocks();
}

CellLevel CellLevel::parents() const {
  CellLevel up(level_ + 1);
  up.keys_.reserve(size()), up.begins_.reserve(size() + 1), up.moments_.reserve(size());
  for (std::size_t i = 0; i < size(); ++i) {
    const std::uint64_t key = keys_[i] >> 3;
    if (up.keys_.empty() || up.keys_.back() != key) {
      up.keys_.push_back(key);
      up.begins_.push_back(begins_[i]);
      up.moments_.emplace_back();
    }
    const Eigen::Vector3f side(keys_[i] & 1U ? 0.25F : -0.25F, keys_[i] & 2U ? 0.25F : -0.25F,
                               keys_[i] & 4U ? 0.25F : -0.25F);
    up.moments_.back().add(moments_[i].halved(), side);
  }
  up.begins_.push_back(begins_.back());
  up.makeBlocks();
  return up;
}

void CellLevel::makeBlocks() {
  block_of_cell_.reserve(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::uint64_t key = keys_[i] >> kBlockBits;
    if (blocks_.empty() || blocks_.back().key != key) blocks_.push_back({key, 0, static_cast<std::uint32_t>(i)});
    blocks_.back().mask |= std::uint64_t{1} << (keys_[i] & 63U);
    block_of_cell_.push_back(static_cast<std::uint32_t>(blocks_.size() - 1));
  }
  around_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    for (int k = 0; k < 27; ++k) {
      std::uint64_t near = blocks_[b].key;
      for (int axis = 0; axis < 3; ++axis) near = shiftedKey(near, axis, stepOf(k, axis));
      around_[b][static_cast<std::size_t>(k)] = findBlock(near, b);
    }
  }
}

/// Searches in steps that double, as most blocks that touch are near in Z-order.
std::uint32_t CellLevel::findBlock(std::uint64_t key, std::size_t from) const {
  const auto before = [](const Block& block, std::uint64_t wanted) { return block.key < wanted; };
  std::size_t low = from, high = from, step = 1;
  if (blocks_[from].key < key) {
    for (; high < blocks_.size() && blocks_[high].key < key; step *= 2) low = high, high += step;
    high = std::min(high, blocks_.size());
  } else {
    for (; low > 0 && blocks_[low].key >= key; step *= 2) high = low, low -= std::min(low, step);
    if (high < blocks_.size()) ++high;
  }
  const auto at = std::lower_bound(blocks_.begin() + static_cast<std::ptrdiff_t>(low),
                                   blocks_.begin() + static_cast<std::ptrdiff_t>(high), key, before);
  return at != blocks_.end() && at->key == key ? static_cast<std::uint32_t>(at - blocks_.begin()) : kNoBlock;
}

void CellNeighbors::moveTo(std::size_t cell) {
  const auto& places = kPlaces[level_.key(cell) & 63U];
  const CellLevel::BlocksAround& around = level_.around_[level_.block_of_cell_[cell]];
  count_ = 0;
  for (int k = 0; k < 27; ++k) {
    const Place place = places[static_cast<std::size_t>(k)];
    if (around[place.block] == CellLevel::kNoBlock) continue;
    const CellLevel::Block& block = level_.blocks_[around[place.block]];
    const std::uint64_t bit = std::uint64_t{1} << place.cell;
    if ((block.mask & bit) == 0) continue;
    const auto before = static_cast<std::uint32_t>(__builtin_popcountll(block.mask & (bit - 1)));
    found_[count_++] = {block.first + before,
                        Eigen::Vector3f(static_cast<float>(stepOf(k, 0)), static_cast<float>(stepOf(k, 1)),
                                        static_cast<float>(stepOf(k, 2)))};
  }
}

}  // namespace cloud_colorizer
