// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// DerivedFiles: what hides and is hidden, surfels and depth images.
#include "base/text.hpp"
#include "map/blob.hpp"
#include "map/derived_files.hpp"

namespace cloud_colorizer {
namespace {

/// Bytes of a point's normal, radius, offset and thickness; with its position.
constexpr std::size_t kSurfelBytes = 6 * sizeof(float), kSurfaceBytes = 9 * sizeof(float);

/// Before the levels of a thinned surface: their number, and a head for each.
struct LevelHead {
  float cell;
  std::uint32_t num_points;
};

/// Before the cells of a depth image.
struct DepthHead {
  std::int32_t rows, cols;
  float cell_size, pixel_angle;
};

Surface surfaceOf(Eigen::Index num_points) {
  return {Points(3, num_points),
          {Eigen::Matrix3Xf(3, num_points), Eigen::VectorXf(num_points), Eigen::VectorXf(num_points),
           Eigen::VectorXf(num_points)}};
}

template <class Blob>
void readSurfelsFrom(Blob& blob, Surfels& surfels) {
  blob.read(surfels.normals);
  blob.read(surfels.radii);
  blob.read(surfels.offsets);
  blob.read(surfels.thicknesses);
}

void addSurfelsTo(BlobWriter& blob, const Surfels& surfels) {
  blob.add(surfels.normals);
  blob.add(surfels.radii);
  blob.add(surfels.offsets);
  blob.add(surfels.thicknesses);
}

}  // namespace

bool DerivedFiles::hasSurfels(std::size_t tile) const {
  return isWholeBlob(tileFile(kSurfelsFolder, tile), kSurfelBytes * recording_.tiles()[tile].num_points) &&
         readWholeBlob(tileFile(kSurfelsFolder, tile, kThinnedExtension)).has_value();
}

void DerivedFiles::writeSurfels(std::size_t tile, const Surfels& surfels,
                                const std::vector<ThinnedSurface>& levels) const {
  BlobWriter blob, thinned;
  const auto count = static_cast<std::uint32_t>(levels.size());
  thinned.add(&count, 1);
  for (const ThinnedSurface& level : levels) {
    const LevelHead head{level.cell, static_cast<std::uint32_t>(level.surface.size())};
    thinned.add(&head, 1);
  }
  for (const ThinnedSurface& level : levels) {
    thinned.add(level.surface.points);
    addSurfelsTo(thinned, level.surface.surfels);
  }
  thinned.save(tileFile(kSurfelsFolder, tile, kThinnedExtension));
  addSurfelsTo(blob, surfels);
  blob.save(tileFile(kSurfelsFolder, tile));
}

Surfels DerivedFiles::readSurfels(std::size_t tile) const {
  Surfels surfels = surfaceOf(static_cast<Eigen::Index>(recording_.tiles()[tile].num_points)).surfels;
  BlobPieces blob(tileFile(kSurfelsFolder, tile));
  readSurfelsFrom(blob, surfels);
  return surfels;
}

std::vector<float> DerivedFiles::readThicknesses(std::size_t tile) const {
  constexpr std::size_t kBytesBefore = 5 * sizeof(float);  // of a point: normal, radius, offset
  std::vector<float> thicknesses(recording_.tiles()[tile].num_points);
  BlobPieces blob(tileFile(kSurfelsFolder, tile), kBytesBefore * thicknesses.size());
  blob.read(thicknesses);
  return thicknesses;
}

std::vector<ThinnedLevel> DerivedFiles::thinnedLevels(std::size_t tile) const {
  BlobPieces blob(tileFile(kSurfelsFolder, tile, kThinnedExtension));
  std::uint32_t count = 0;
  blob.read(&count, 1);
  std::vector<LevelHead> heads(count);
  blob.read(heads);
  std::vector<ThinnedLevel> levels;
  std::uint64_t offset = sizeof(count) + count * sizeof(LevelHead);
  for (const LevelHead& head : heads) {
    levels.push_back({head.cell, head.num_points, offset});
    offset += kSurfaceBytes * head.num_points;
  }
  return levels;
}

Surface DerivedFiles::readThinned(std::size_t tile, const ThinnedLevel& level) const {
  Surface surface = surfaceOf(static_cast<Eigen::Index>(level.num_points));
  BlobPieces blob(tileFile(kSurfelsFolder, tile, kThinnedExtension), level.offset);
  blob.read(surface.points);
  readSurfelsFrom(blob, surface.surfels);
  return surface;
}

bool DerivedFiles::hasDepth(std::size_t view) const {
  return readWholeBlob(pathOf(inFolder(kDepthFolder, view))).has_value();
}

void DerivedFiles::writeDepth(std::size_t view, const DepthImage& image) const {
  BlobWriter blob;
  const DepthHead head = {image.depth.rows, image.depth.cols, image.cell_size, image.pixel_angle};
  blob.add(&head, 1);
  blob.add(image.depth.ptr<float>(), image.depth.total());
  blob.add(image.edge.ptr<std::uint8_t>(), image.edge.total());
  blob.save(pathOf(inFolder(kDepthFolder, view)));
}

DepthImage DerivedFiles::readDepth(std::size_t view) const {
  const std::string path = pathOf(inFolder(kDepthFolder, view));
  DepthHead head{};
  File(path, O_RDONLY).readAt(0, &head, sizeof(head));
  const std::size_t cells = static_cast<std::size_t>(head.rows) * static_cast<std::size_t>(head.cols);
  const auto file = std::make_shared<const MappedFile>(path, sizeof(head) + cells * (sizeof(float) + 1));
  // Nobody writes to an image that was read.
  auto* const bytes = const_cast<std::uint8_t*>(file->data()) + sizeof(head);
  DepthImage image;
  image.cell_size = head.cell_size;
  image.pixel_angle = head.pixel_angle;
  image.depth = cv::Mat1f(head.rows, head.cols, reinterpret_cast<float*>(bytes));
  image.edge = cv::Mat1b(head.rows, head.cols, bytes + cells * sizeof(float));
  image.owner = file;
  return image;
}

}  // namespace cloud_colorizer
