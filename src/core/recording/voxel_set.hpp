// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The occupied voxels of one tile, as a hash of blocks of 8 x 8 x 8 bits. A block is one cache line, and neighbouring
/// LiDAR points fall into the same few blocks; on surfaces it takes 1 to 2 bytes a voxel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace cloud_colorizer {

class VoxelSet {
 public:
  static constexpr int kMaxSide = 8192;  ///< voxels; a block's coordinate has ten bits

  /// Adds voxel (x, y, z), each in [0, kMaxSide); false when it was there.
  bool insert(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    const std::uint32_t key = (x >> 3U) | (y >> 3U) << 10U | (z >> 3U) << 20U;
    if (key != last_key_) {
      last_block_ = findBlock(key);
      last_key_ = key;
    }
    auto& word = blocks_[last_block_][z & 7U];
    const std::uint64_t bit = std::uint64_t{1} << ((x & 7U) | (y & 7U) << 3U);
    const bool is_new = (word & bit) == 0;
    word |= bit;
    return is_new;
  }

 private:
  using Block = std::array<std::uint64_t, 8>;
  struct Slot {
    std::uint32_t key = kEmpty;
    std::uint32_t block = 0;
  };
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;

  std::size_t slotOf(std::uint32_t key) const {
    const std::size_t mask = slots_.size() - 1;
    auto slot = static_cast<std::size_t>(key * 0x9E3779B97F4A7C15U >> 32U) & mask;
    while (slots_[slot].key != kEmpty && slots_[slot].key != key) slot = (slot + 1) & mask;
    return slot;
  }

  std::uint32_t findBlock(std::uint32_t key) {
    if (2 * (blocks_.size() + 1) > slots_.size()) grow();
    auto& slot = slots_[slotOf(key)];
    if (slot.key == kEmpty) {
      slot = {key, static_cast<std::uint32_t>(blocks_.size())};
      blocks_.push_back({});
    }
    return slot.block;
  }

  void grow() {
    std::vector<Slot> old(slots_.empty() ? 64 : 2 * slots_.size());
    std::swap(old, slots_);
    for (const auto& slot : old) {
      if (slot.key != kEmpty) slots_[slotOf(slot.key)] = slot;
    }
  }

  std::vector<Slot> slots_;  ///< a power of two, at most half full
  std::vector<Block> blocks_;
  std::uint32_t last_key_ = kEmpty;
  std::uint32_t last_block_ = 0;
};

}  // namespace cloud_colorizer
