// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

namespace cloud_colorizer {
namespace {

std::string writeFile(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

const char* const kSquare =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
    "z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 9\n2 0 0 9\n2 2 0 9\n0 2 0 9\n4 0 1 2 3\n";

std::string messageOf(const std::string& path) {
  try {
    readMesh(path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Mesh, PolygonBecomesAFan) {
  const Mesh mesh = readMesh(writeFile("square.ply", kSquare));
  EXPECT_EQ(mesh.name, "square");
  ASSERT_EQ(mesh.faces.cols(), 2);
  EXPECT_TRUE(mesh.vertices.col(2).isApprox(Eigen::Vector3f(2, 2, 0)));
  EXPECT_TRUE(mesh.normals.col(0).isApprox(Eigen::Vector3f::UnitZ()));
}

TEST(Mesh, BinaryEqualsAscii) {
  std::string binary =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
  const auto put = [&binary](const auto value) { binary.append(reinterpret_cast<const char*>(&value), sizeof(value)); };
  for (int v = 0; v < 3; ++v) {
    put(static_cast<float>(v));
    put(static_cast<double>(v * v));
    put(0.5F);
  }
  put(static_cast<std::uint8_t>(3));
  for (int corner = 0; corner < 3; ++corner) put(corner);
  const Mesh mesh = readMesh(writeFile("triangle.ply", binary));
  EXPECT_TRUE(mesh.vertices.col(2).isApprox(Eigen::Vector3f(2, 4, 0.5F)));
  EXPECT_EQ(mesh.faces.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_NE(messageOf(writeFile("cut.ply", binary.substr(0, binary.size() - 6))).find("truncated"), std::string::npos);
}

TEST(Mesh, BigEndianWithOtherElementsAndProperties) {
  std::string binary =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element tag 2\nproperty list uchar short names\nelement face 1\nproperty float quality\n"
      "property list ushort uint vertex_indices\nend_header\n";
  const auto put = [&binary](const auto value) {
    const std::string bytes(reinterpret_cast<const char*>(&value), sizeof(value));
    binary.append(bytes.rbegin(), bytes.rend());
  };
  for (int v = 0; v < 9; ++v) put(v % 4 == 0 ? 5.F : 0.F);
  for (int tag = 0; tag < 2; ++tag) put(static_cast<std::uint8_t>(1)), put(static_cast<std::int16_t>(7));
  put(0.5F);
  put(static_cast<std::uint16_t>(3));
  for (const std::uint32_t corner : {2U, 0U, 1U}) put(corner);
  const Mesh mesh = readMesh(writeFile("big.ply", binary));
  EXPECT_TRUE(mesh.vertices.isApprox(5 * Eigen::Matrix3f::Identity()));
  EXPECT_EQ(mesh.faces.col(0), Eigen::Vector3i(2, 0, 1));
  EXPECT_NE(messageOf(writeFile("huge.ply",
                                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y"
                                "\nproperty float z\nelement face 999999999999\nend_header\n0 0 0\n"))
                .find("cannot hold"),
            std::string::npos);
}

TEST(Mesh, WithoutFacesIsRefusedWithTheReason) {
  const std::string cloud =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 "
      "0\n";
  EXPECT_NE(messageOf(writeFile("cloud.ply", cloud)).find("no faces"), std::string::npos);
  EXPECT_NE(messageOf(writeFile("text.ply", "hello\n")).find("no PLY file"), std::string::npos);
  EXPECT_NE(messageOf("/nowhere/mesh.ply").find("cannot open"), std::string::npos);
  std::string bad_index = kSquare;
  bad_index.replace(bad_index.rfind('3'), 1, "7");
  EXPECT_NE(messageOf(writeFile("index.ply", bad_index)).find("vertex index"), std::string::npos);
}

TEST(Mesh, ZeroAreaFaceGivesNoNan) {
  Mesh mesh;
  mesh.vertices = Points::Zero(3, 4);
  mesh.vertices.col(1) = Eigen::Vector3f::UnitX();
  mesh.vertices.col(2) = Eigen::Vector3f::UnitY();
  mesh.faces.resize(3, 2);
  mesh.faces << 0, 0, 1, 3, 2, 3;  // the second face is (0, 3, 3): a point
  mesh.normals = vertexNormals(mesh.vertices, mesh.faces);
  EXPECT_TRUE(mesh.normals.allFinite());
  EXPECT_TRUE(sampleSurface(mesh, 100, 1).points.allFinite());
  mesh.faces.col(0) = Eigen::Vector3i::Zero();
  EXPECT_THROW(sampleSurface(mesh, 1, 1), std::invalid_argument);
}

TEST(Mesh, SamplesAreUniformByArea) {
  Mesh mesh;  // a square of area 4 and a triangle of area 1 beside it
  mesh.vertices.resize(3, 7);
  mesh.vertices << 0, 2, 2, 0, 10, 12, 10, 0, 0, 2, 2, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0;
  mesh.faces.resize(3, 3);
  mesh.faces << 0, 0, 4, 1, 2, 5, 2, 3, 6;
  mesh.normals = vertexNormals(mesh.vertices, mesh.faces);
  const SurfaceSamples samples = sampleSurface(mesh, 20000, 7);
  EXPECT_NEAR((samples.points.row(0).array() > 5).cast<double>().mean(), 0.2, 0.01);
  const auto in_square = (samples.points.row(0).array() < 5).cast<float>();
  EXPECT_NEAR((in_square * samples.points.row(1).array()).sum() / in_square.sum(), 1, 0.02);
}

TEST(Mesh, BuiltInShapesAreClosedAndNormalizeToDiameterTwo) {
  for (Mesh mesh : {bumpySphere(20), knottedTorus(8)}) {
    normalizeMesh(mesh);
    EXPECT_NEAR(mesh.vertices.colwise().norm().maxCoeff(), 1, 1e-5);
    // The divergence theorem: the area vectors of a closed surface add up to zero.
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float area = 0;
    for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
      const Eigen::Vector3f a = mesh.vertices.col(mesh.faces(0, f));
      const Eigen::Vector3f normal =
          (mesh.vertices.col(mesh.faces(1, f)) - a).cross(mesh.vertices.col(mesh.faces(2, f)) - a);
      sum += normal;
      area += normal.norm();
    }
    EXPECT_LT(sum.norm(), 1e-4F * area) << mesh.name;
  }
  Mesh point;
  point.vertices = Points::Ones(3, 2);
  EXPECT_THROW(normalizeMesh(point), std::invalid_argument);
}

TEST(Mesh, ScanLinesAreAsFarApartAsAskedForAndDenseAlong) {
  Mesh square;
  square.name = "square";
  square.vertices.resize(3, 4);
  square.vertices << 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1;
  square.normals = Points::Zero(3, 4);
  square.normals.row(1).setOnes();
  square.faces.resize(3, 2);
  square.faces << 0, 0, 1, 2, 2, 3;
  const SurfaceSamples samples = sampleScanLines(square, 1000, 10, 3);  // 10 lines of 100 points
  EXPECT_NEAR(static_cast<double>(samples.points.cols()), 1000, 150);
  std::map<int, int> lines;
  for (Eigen::Index p = 0; p < samples.points.cols(); ++p) {
    const float line = samples.points(2, p) * 10;
    EXPECT_LT(line - std::floor(line), 0.011F);
    ++lines[static_cast<int>(line)];
  }
  EXPECT_EQ(lines.size(), 10U);
  EXPECT_THROW(sampleScanLines(square, 1000, 0.5, 3), std::invalid_argument);
}

}  // namespace
}  // namespace cloud_colorizer
