// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is made from a recording and lies in its directory.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/file_io.hpp"
#include "cloud_colorizer/camera/view.hpp"
#include "cloud_colorizer/color/tone.hpp"
#include "cloud_colorizer/recording/recording.hpp"
#include "cloud_colorizer/surface/surfels.hpp"
#include "cloud_colorizer/visibility/depth_image.hpp"
#include "cloud_colorizer/visibility/observe.hpp"
#include "color/held_out.hpp"
#include "surface/thinned.hpp"

namespace cloud_colorizer {

// Folders of a recording that hold derived files.
constexpr const char* kImageCheckFolder = "damaged_images";
constexpr const char* kMovingFolder = "moving";
constexpr const char* kSurfelsFolder = "surfels";
constexpr const char* kAlignmentFolder = "alignment";
constexpr const char* kDepthFolder = "depth";
constexpr const char* kColorsFolder = "colored";

constexpr const char* kAlignmentJson = "result.json";
constexpr const char* kCorrectionsFile = "views.bin";  // in the alignment's folder
constexpr const char* kThinnedExtension = ".thinned";  // of a tile's second file of surfels
constexpr const char* kViewsExtension = ".views";      // of a tile's second file of colours

/// Colours of one tile, one column a point.
struct TileColors {
  Values values;                     ///< 3 x n, radiance in grey levels of 8 bits, not negative; 0 where count is 0
  std::vector<std::uint16_t> count;  ///< views that coloured the point
  std::vector<float> stddev;         ///< over the views
  std::vector<Unseen> unseen;        ///< why no view coloured the point
  std::vector<std::array<std::uint8_t, 3>> nearest;  ///< what the nearest view that sees it shows, in its own exposure
  std::vector<std::uint8_t> camera;                  ///< of that view, up to 255
  Eigen::Matrix3Xf diffuse;                          ///< radiance without sheen; empty where nobody asked
  std::vector<std::uint8_t>
      specular;       ///< share of 255 of the brightness, where it is greatest, that is sheen; likewise
  Values quantities;  ///< a row for each field of the recording's quantities, a column a point; see fuseQuantity()
};

/// What the tiles of a chunk tell of their views.
struct TileViews {
  ToneCells tone;
  std::vector<HeldOut> held_out;
};

/// A thinned surface in a file.
struct ThinnedLevel {
  float cell = 0;  ///< m
  std::size_t num_points = 0;
  std::uint64_t offset = 0;
};

/// Indices of views, ascending.
using ViewList = std::vector<std::uint32_t>;

/// One program at a time colours a recording (exclusive), or several do parts of a stage each (shared); several may
/// read its colours, also where they may not write.
class FolderLock {
 public:
  /// Throws where another program holds the lock.
  FolderLock(const std::string& directory, bool exclusive);
  /// Waits as long as other programs hold it, and asks `callbacks` whether to go on; throws Cancelled.
  FolderLock(const std::string& directory, bool exclusive, const Callbacks& callbacks);

 private:
  void open(const std::string& directory, bool exclusive);

  std::optional<File> file_;  ///< none in a directory that nobody has coloured and this program may not write to
};

/// A unit of work (a tile's surfels, a view's depth image, a tile's colours) is one file, written under a temporary
/// name and renamed, with a checksum at its end: it is whole, or counts as absent. Each folder holds key.txt, which
/// tells what its files were made from. What a has...() did not find whole, a read...() throws on. Where only pieces
/// are read again and again (surfels, depth images), has...() alone looks at the checksum.
class DerivedFiles {
 public:
  /// `with_sheen`: the colours are told from it.
  explicit DerivedFiles(const Recording& recording, bool with_sheen = false)
      : recording_(recording), with_sheen_(with_sheen) {}

  /// Empties the folder unless its files were made from `key`. Not while others work on it.
  void claim(const std::string& folder, const std::string& key) const;
  bool holds(const std::string& folder, const std::string& key) const;
  std::string pathOf(const std::string& name) const { return recording_.directory() + '/' + name; }
  std::string nameOfTile(std::size_t tile, const char* extension = ".bin") const;  ///< of its file in any folder
  /// Of the two files that each tile has, the second one with that extension.
  std::vector<std::string> namesOfTiles(const std::vector<std::size_t>& tiles, const char* second) const;
  static std::string nameOfView(std::size_t view);  ///< or of a block of views

  bool hasMoving(std::size_t tile) const;
  void writeMoving(std::size_t tile, const std::vector<std::uint8_t>& shares) const;
  std::vector<std::uint8_t> readMoving(std::size_t tile) const;  ///< MovingVotes::shares()

  bool hasSurfels(std::size_t tile) const;
  void writeSurfels(std::size_t tile, const Surfels& surfels, const std::vector<ThinnedSurface>& levels) const;
  Surfels readSurfels(std::size_t tile) const;
  std::vector<float> readThicknesses(std::size_t tile) const;       ///< m, of each point's surface
  std::vector<ThinnedLevel> thinnedLevels(std::size_t tile) const;  ///< fine to coarse
  Surface readThinned(std::size_t tile, const ThinnedLevel& level) const;

  bool hasDepth(std::size_t view) const;
  void writeDepth(std::size_t view, const DepthImage& image) const;
  /// Without its empty space. Only the cells that are asked for are read.
  DepthImage readDepth(std::size_t view) const;

  bool hasColors(std::size_t tile) const;
  void writeColors(std::size_t tile, const TileColors& colors, const TileViews& views) const;
  TileColors readColors(std::size_t tile) const;
  TileViews readViews(std::size_t tile) const;

  void writeCorrections(const std::vector<CorrectedView>& views) const;
  std::optional<std::vector<CorrectedView>> readCorrections() const;  ///< nothing where they are not whole
  /// Views are looked at block by block, in the order of time.
  std::size_t numViewBlocks() const;
  ViewList viewsOfBlock(std::size_t block) const;
  void writeDamagedViews(std::size_t block, const ViewList& damaged) const;
  std::optional<ViewList> readDamagedViews(std::size_t block) const;  ///< nothing where the list is not whole

 private:
  std::size_t numQuantityFields() const;
  std::size_t bytesOfColor() const;  ///< of a point
  std::string tileFile(const char* folder, std::size_t tile, const char* extension = ".bin") const {
    return pathOf(std::string(folder) + '/' + nameOfTile(tile, extension));
  }
  static std::string inFolder(const char* folder, std::size_t number) {
    return std::string(folder) + '/' + nameOfView(number);
  }

  Recording recording_;
  bool with_sheen_;
};

}  // namespace cloud_colorizer
