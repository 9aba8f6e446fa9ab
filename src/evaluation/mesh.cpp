// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "base/columns.hpp"
#include "cloud/ply.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/surface/zorder.hpp"
#include "evaluation/random.hpp"

namespace cloud_colorizer {
namespace {

constexpr float kPi = 3.14159265F;

/// A closed surface of rows x columns quads; `at(u, v)` with u in [0, 1] along the rows and v periodic in [0, 1).
Mesh gridMesh(const std::string& name, int rows, int columns, bool rows_periodic,
              const std::function<Eigen::Vector3f(float, float)>& at) {
  Mesh mesh;
  mesh.name = name;
  const int vertex_rows = rows_periodic ? rows : rows + 1;
  mesh.vertices.resize(3, vertex_rows * columns);
  for (int r = 0; r < vertex_rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      mesh.vertices.col(r * columns + c) =
          at(static_cast<float>(r) / static_cast<float>(rows), static_cast<float>(c) / static_cast<float>(columns));
    }
  }
  mesh.faces.resize(3, 2 * rows * columns);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const int below = (r + 1) % vertex_rows, right = (c + 1) % columns;
      const int a = r * columns + c, b = r * columns + right, d = below * columns + c, e = below * columns + right;
      mesh.faces.col(2 * (r * columns + c)) = Eigen::Vector3i(a, d, b);
      mesh.faces.col(2 * (r * columns + c) + 1) = Eigen::Vector3i(b, d, e);
    }
  }
  mesh.normals = vertexNormals(mesh.vertices, mesh.faces);
  return mesh;
}

/// Normal of a face; its length is twice the area.
Eigen::Vector3d faceNormal(const Points& vertices, const Eigen::Vector3i& face) {
  const Eigen::Vector3d a = vertices.col(face[0]).cast<double>();
  return (vertices.col(face[1]).cast<double>() - a).cross(vertices.col(face[2]).cast<double>() - a);
}

/// Area of the faces up to and with each.
std::vector<double> cumulativeArea(const Mesh& mesh) {
  std::vector<double> cumulative(static_cast<std::size_t>(mesh.faces.cols()));
  double area = 0;
  for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
    area += faceNormal(mesh.vertices, mesh.faces.col(f)).norm() / 2;
    cumulative[static_cast<std::size_t>(f)] = area;
  }
  return cumulative;
}

SurfaceSamples pick(const SurfaceSamples& samples, const std::vector<Eigen::Index>& indices) {
  return {gatherColumns(samples.points, indices), gatherColumns(samples.normals, indices)};
}

SurfaceSamples inZOrder(const SurfaceSamples& samples) {
  const auto order = zorderSort(zorderKeys(samples.points, gridOf(samples.points)), zorderMask(0));
  return pick(samples, {order.begin(), order.end()});
}

}  // namespace

Points vertexNormals(const Points& vertices, const Eigen::Matrix3Xi& faces) {
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, vertices.cols());
  for (Eigen::Index f = 0; f < faces.cols(); ++f) {
    const Eigen::Vector3d normal = faceNormal(vertices, faces.col(f));
    for (int corner = 0; corner < 3; ++corner) sum.col(faces(corner, f)) += normal;
  }
  Points normals(3, vertices.cols());
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    const double norm = sum.col(v).norm();
    normals.col(v) =
        norm > 0 ? Eigen::Vector3f((sum.col(v) / norm).cast<float>()) : Eigen::Vector3f(Eigen::Vector3f::UnitZ());
  }
  return normals;
}

Mesh readMesh(const std::string& path) {
  CloudReader reader(path);
  const std::vector<Eigen::Vector3i> faces = readPlyFaces(path);
  require(!faces.empty(), path, ": the mesh has no faces; the test bed samples points on faces, so give a mesh, not a ",
          "point cloud");
  Mesh mesh;
  mesh.name = std::filesystem::path(path).stem().string();
  mesh.vertices = reader.read(reader.numPoints()).positions.cast<float>();
  mesh.faces = Eigen::Map<const Eigen::Matrix3Xi>(faces.front().data(), 3, static_cast<Eigen::Index>(faces.size()));
  mesh.normals = vertexNormals(mesh.vertices, mesh.faces);
  return mesh;
}

Mesh bumpySphere(int detail) {
  requireInRange("detail", detail, 4, 4000);
  return gridMesh("bumpy_sphere", detail, 2 * detail, false, [](float u, float v) {
    const float theta = kPi * u, phi = 2 * kPi * v;
    const Eigen::Vector3f direction(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    const float bump = std::sin(5 * direction.x()) * std::sin(4 * direction.y() + 1) * std::cos(6 * direction.z());
    return Eigen::Vector3f(direction * (1 + 0.15F * bump));
  });
}

Mesh knottedTorus(int detail) {
  requireInRange("detail", detail, 4, 2000);
  const auto centre = [](float t) {  // the trefoil knot
    const float a = 2 * kPi * t;
    return Eigen::Vector3f(std::sin(a) + 2 * std::sin(2 * a), std::cos(a) - 2 * std::cos(2 * a), -std::sin(3 * a));
  };
  return gridMesh("knot", 6 * detail, detail, true, [&centre](float u, float v) {
    const Eigen::Vector3f along = (centre(u + 1e-3F) - centre(u - 1e-3F)).normalized();
    const Eigen::Vector3f side = along.cross(Eigen::Vector3f::UnitZ()).normalized();
    const float angle = 2 * kPi * v;
    return Eigen::Vector3f(centre(u) + 0.55F * (std::cos(angle) * side + std::sin(angle) * side.cross(along)));
  });
}

void normalizeMesh(Mesh& mesh) {
  require<std::invalid_argument>(mesh.vertices.cols() > 0, "mesh '", mesh.name, "' has no vertices");
  const Eigen::Vector3f middle = (mesh.vertices.rowwise().minCoeff() + mesh.vertices.rowwise().maxCoeff()) / 2;
  mesh.vertices.colwise() -= middle;
  const float radius = mesh.vertices.colwise().norm().maxCoeff();
  require<std::invalid_argument>(radius > 0 && std::isfinite(radius), "mesh '", mesh.name, "' has radius ", radius,
                                 "; its vertices must be finite and not all the same");
  mesh.vertices /= radius;
}

SurfaceSamples sampleSurface(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  const std::vector<double> cumulative = cumulativeArea(mesh);
  const double area = cumulative.empty() ? 0 : cumulative.back();
  require<std::invalid_argument>(area > 0, "mesh '", mesh.name, "' has no area (", mesh.faces.cols(), " faces)");
  SurfaceSamples samples{Points(3, count), Points(3, count)};
  for (std::size_t i = 0; i < count; ++i) {
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), area * uniform(seed, 3 * i));
    const auto face = std::min<std::ptrdiff_t>(found - cumulative.begin(), mesh.faces.cols() - 1);
    const float root = std::sqrt(static_cast<float>(uniform(seed, 3 * i + 1)));
    const float second = static_cast<float>(uniform(seed, 3 * i + 2));
    const Eigen::Vector3f weights(1 - root, root * (1 - second), root * second);
    Eigen::Vector3f point = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
    for (int corner = 0; corner < 3; ++corner) {
      point += weights[corner] * mesh.vertices.col(mesh.faces(corner, face));
      normal += weights[corner] * mesh.normals.col(mesh.faces(corner, face));
    }
    samples.points.col(static_cast<Eigen::Index>(i)) = point;
    samples.normals.col(static_cast<Eigen::Index>(i)) = normal.stableNormalized();
  }
  return inZOrder(samples);
}

SurfaceSamples sampleScanLines(const Mesh& mesh, std::size_t count, double ratio, std::uint64_t seed) {
  requireInRange("ratio", ratio, 1.0, 1000.0);
  constexpr double kThickness = 0.1;  // of a line, in spacings along it
  // A line every `apart`, with a point every `apart / ratio`: one point on apart^2 / ratio.
  const std::vector<double> cumulative = cumulativeArea(mesh);
  const double area = cumulative.empty() ? 0 : cumulative.back();
  const double apart = std::sqrt(ratio * area / static_cast<double>(std::max<std::size_t>(1, count)));
  const auto candidates = static_cast<std::size_t>(static_cast<double>(count) * ratio / kThickness);
  const SurfaceSamples dense = sampleSurface(mesh, candidates, seed);
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < dense.points.cols(); ++i) {
    const double line = static_cast<double>(dense.points(2, i)) / apart;
    if (line - std::floor(line) < kThickness / ratio) chosen.push_back(i);
  }
  return pick(dense, chosen);
}

}  // namespace cloud_colorizer
