// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Triangle meshes, the geometry of the test bed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

struct Mesh {
  std::string name;
  Points vertices;         ///< 3 x number of vertices
  Points normals;          ///< unit, of the smooth surface at the vertices; never NaN
  Eigen::Matrix3Xi faces;  ///< indices of vertices
};

/// Reads a PLY with faces of three or more corners (fans are made of the latter).
/// The name is the file's stem. Throws std::runtime_error with file and reason: no faces, an index out of range, ...
Mesh readMesh(const std::string& path);

/// Closed shapes for machines without downloaded meshes; `detail` is the number of quads from pole to pole.
Mesh bumpySphere(int detail = 200);
Mesh knottedTorus(int detail = 120);  ///< a tube that occludes itself

/// Moves and scales so that the vertices' bounding box is centred at zero and the farthest vertex is at distance 1:
/// the diameter is 2. Throws std::invalid_argument when all vertices are one point.
void normalizeMesh(Mesh& mesh);

/// Area-weighted vertex normals; a vertex with only zero-area faces gets (0, 0, 1).
Points vertexNormals(const Points& vertices, const Eigen::Matrix3Xi& faces);

struct SurfaceSamples {
  Points points;   ///< 3 x n
  Points normals;  ///< unit, interpolated
};
/// `count` points, independent and uniform by area, in Z-order as a chunk's points are; the same for the same seed.
/// Throws std::invalid_argument when the area is zero.
SurfaceSamples sampleSurface(const Mesh& mesh, std::size_t count, std::uint64_t seed);

/// About `count` points in horizontal lines, as a LiDAR samples: the lines are `ratio` times (at least 1) as far apart
/// as the points along a line, which are random.
SurfaceSamples sampleScanLines(const Mesh& mesh, std::size_t count, double ratio, std::uint64_t seed);

}  // namespace cloud_colorizer
