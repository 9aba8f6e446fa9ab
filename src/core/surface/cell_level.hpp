// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// One level of a pyramid of cells over points in Z-order: the occupied cells, what is in them, and which touch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/surface/zorder.hpp"
#include "surface/moments.hpp"

namespace cloud_colorizer {

/// The occupied cells of one size, in Z-order. Lengths are in units of the cell.
class CellLevel {
 public:
  /// Cells of 2^level grid cells. `keys`: of the points, ascending.
  CellLevel(PointsRef points, const std::vector<std::uint64_t>& keys, const ZOrderGrid& grid, int level);
  /// Cells twice as large.
  CellLevel parents() const;

  std::size_t size() const { return keys_.size(); }
  int level() const { return level_; }
  std::uint64_t key(std::size_t cell) const { return keys_[cell]; }
  std::uint32_t begin(std::size_t cell) const { return begins_[cell]; }  ///< its first point
  std::uint32_t end(std::size_t cell) const { return begins_[cell + 1]; }
  const Moments& moments(std::size_t cell) const { return moments_[cell]; }  ///< about the centre of the cell

 private:
  friend class CellNeighbors;
  /// 4 x 4 x 4 cells: bit k of the mask is set where the cell with the last six bits k of the key is occupied.
  struct Block {
    std::uint64_t key, mask;
    std::uint32_t first;  ///< cell
  };
  /// The 27 blocks around one; kNoBlock where nothing is.
  using BlocksAround = std::array<std::uint32_t, 27>;
  static constexpr std::uint32_t kNoBlock = 0xFFFFFFFFU;

  explicit CellLevel(int level) : level_(level) {}
  void makeBlocks();
  std::uint32_t findBlock(std::uint64_t key, std::size_t from) const;  ///< or kNoBlock

  int level_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> begins_;
  std::vector<Moments> moments_;
  std::vector<Block> blocks_;
  std::vector<BlocksAround> around_;  ///< a block
  std::vector<std::uint32_t> block_of_cell_;
};

/// The up to 27 occupied cells that touch a cell, itself included.
class CellNeighbors {
 public:
  struct Neighbor {
    std::uint32_t cell;
    Eigen::Vector3f offset;  ///< of its centre, in cells
  };

  explicit CellNeighbors(const CellLevel& level) : level_(level) {}
  void moveTo(std::size_t cell);
  const Neighbor* begin() const { return found_.data(); }
  const Neighbor* end() const { return found_.data() + count_; }

 private:
  const CellLevel& level_;
  std::array<Neighbor, 27> found_;
  std::size_t count_ = 0;
};

/// The coordinates of a point in units of the grid's cell, from its origin.
inline Eigen::Vector3d gridPosition(const Eigen::Vector3f& point, const ZOrderGrid& grid) {
  return (point.cast<double>() - grid.origin.cast<double>()) / static_cast<double>(grid.cell);
}

/// A point relative to the centre of its cell of 2^level grid cells, in units of that cell.
inline Eigen::Vector3f positionInCell(const Eigen::Vector3d& grid_position, int level) {
  const Eigen::Array3d cells = grid_position.array() / static_cast<double>(std::int64_t{1} << level);
  return (cells - cells.floor() - 0.5).matrix().cast<float>();
}

}  // namespace cloud_colorizer
