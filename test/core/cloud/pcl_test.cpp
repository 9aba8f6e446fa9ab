// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/cloud/pcl.hpp"

#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <cstring>
#include <limits>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

/// Points with every type of field, and an array.
Cloud withAllTypes(std::size_t num_points) {
  Cloud cloud;
  cloud.positions = Eigen::Matrix3Xf::Random(3, static_cast<Eigen::Index>(num_points)).cast<double>();
  cloud.fields = {{"rgb", FieldType::kFloat32}, {"several", FieldType::kUint16, 3}};
  for (int type = 1; type <= 8; ++type) {
    cloud.fields.push_back({"type" + std::to_string(type), static_cast<FieldType>(type)});
  }
  cloud.records.resize(num_points * recordSize(cloud.fields));
  for (std::size_t i = 0; i < cloud.records.size(); ++i) cloud.records[i] = static_cast<std::uint8_t>(i * 7 % 64);
  return cloud;
}

void expectEqual(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.fields, b.fields);
  EXPECT_EQ(a.records, b.records);
}

void save(const std::string& path, const Cloud& cloud, bool as_double) {
  CloudWriter writer(path, static_cast<std::size_t>(cloud.positions.cols()), cloud.fields, as_double);
  writer.write(cloud);
  writer.finish();
}

Cloud readWithPcl(const std::string& path) {
  pcl::PCLPointCloud2 points;
  const bool is_pcd = path.find(".pcd") != std::string::npos;
  EXPECT_EQ(is_pcd ? pcl::io::loadPCDFile(path, points) : pcl::io::loadPLYFile(path, points), 0) << path;
  return toCloud(points);
}

TEST(Pcl, PointsComeBackAsTheyWere) {
  pcl::PointCloud<pcl::PointXYZRGBNormal> points;
  for (int i = 0; i < 5; ++i) {
    pcl::PointXYZRGBNormal point;
    point.x = static_cast<float>(i);
    point.y = 0.1F;
    point.z = -3;
    point.r = static_cast<std::uint8_t>(10 * i);
    point.g = 200;
    point.b = 3;
    point.normal_z = 1;
    point.curvature = 0.25F;
    points.push_back(point);
  }
  const Cloud cloud = toCloud(points);
  ASSERT_EQ(cloud.positions.cols(), 5);
  EXPECT_EQ(cloud.positions.col(4), Eigen::Vector3f(4, 0.1F, -3).cast<double>());
  const auto rgb = findField(cloud.fields, "rgb");
  ASSERT_TRUE(rgb);
  EXPECT_EQ(cloud.records[4 * recordSize(cloud.fields) + rgb->offset + 2], 40);  // 0x00RRGGBB
  const auto back = toPcl<pcl::PointXYZRGBNormal>(cloud);
  ASSERT_EQ(back.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(back[i].getVector3fMap(), points[i].getVector3fMap());
    EXPECT_EQ(back[i].r, points[i].r);
    EXPECT_EQ(back[i].normal_z, 1);
    EXPECT_EQ(back[i].curvature, 0.25F);
  }
  EXPECT_EQ(toCloud(pcl::PointCloud<pcl::PointXYZ>()).positions.cols(), 0);
  EXPECT_EQ(toPcl<pcl::PointXYZ>({}).size(), 0U);
}

TEST(Pcl, AllFieldsOfABlobComeBack) {
  const Cloud cloud = withAllTypes(7);
  const pcl::PCLPointCloud2 blob = toPcl(cloud);
  EXPECT_EQ(blob.width, 7U);
  EXPECT_TRUE(blob.is_dense);
  expectEqual(toCloud(blob), cloud);
}

TEST(Pcl, NanPassesThroughAndIsNotDense) {
  Cloud cloud = withAllTypes(2);
  cloud.positions(1, 1) = std::numeric_limits<double>::quiet_NaN();
  const pcl::PCLPointCloud2 blob = toPcl(cloud);
  EXPECT_FALSE(blob.is_dense);
  EXPECT_TRUE(std::isnan(toCloud(blob).positions(1, 1)));
}

TEST(Pcl, WhatDoesNotFitIsExplained) {
  const pcl::PCLPointCloud2 good = toPcl(withAllTypes(3));
  auto blob = good;
  blob.fields[1].name = "height";
  EXPECT_ERROR(toCloud(blob), "there is no field y");
  blob = good;
  blob.fields[3].datatype = 9;
  EXPECT_ERROR(toCloud(blob), "unknown datatype 9");
  blob = good;
  blob.fields[4].count = 40;
  EXPECT_ERROR(toCloud(blob), "does not fit into point_step");
  blob = good;
  for (auto& field : blob.fields) field.offset = 0;
  blob.fields[4].count = 22;
  EXPECT_ERROR(toCloud(blob), "overlap");
  blob.point_step = 4'000'000'000;  // the memory of this many is not taken
  blob.fields[4].count = 1'000'000'000;
  EXPECT_ERROR(toCloud(blob), "numbers is too large");
  blob = good;
  blob.data.pop_back();
  EXPECT_ERROR(toCloud(blob), "data has");
}

TEST(Pcl, ReadsThePcdFilesThatWeWrite) {
  ScratchDirectory scratch;
  for (const bool as_double : {false, true}) {
    const Cloud cloud = withAllTypes(50);
    save(scratch / "a.pcd", cloud, as_double);
    expectEqual(readWithPcl(scratch / "a.pcd"), cloud);
    save(scratch / "empty.pcd", withAllTypes(0), as_double);
    pcl::PCLPointCloud2 none;
    pcl::PCDReader().readHeader(scratch / "empty.pcd", none);
    EXPECT_EQ(none.fields.size(), 3 + cloud.fields.size());
  }
}

TEST(Pcl, ReadsThePlyFilesThatWeWrite) {
  ScratchDirectory scratch;
  for (const bool as_double : {false, true}) {
    const Cloud cloud = withAllTypes(50);
    save(scratch / "a.ply", cloud, as_double);
    Cloud read = readWithPcl(scratch / "a.ply"), expected = cloud;
    expected.fields = {expected.fields[0],
                       {"several_0", FieldType::kUint16},
                       {"several_1", FieldType::kUint16},
                       {"several_2", FieldType::kUint16}};
    expected.fields.insert(expected.fields.end(), cloud.fields.begin() + 2, cloud.fields.end());
    for (std::size_t i = 0; i < 50; ++i) {  // beside red, green and blue there is a byte that a PLY has not
      for (Cloud* one : {&read, &expected}) one->records.at(i * recordSize(one->fields) + 3) = 0;
    }
    expectEqual(read, expected);
    save(scratch / "empty.ply", withAllTypes(0), as_double);
    expectEqual(readWithPcl(scratch / "empty.ply"), {Eigen::Matrix3Xd(3, 0), expected.fields, {}});
  }
}

TEST(Pcl, ReadsTheTilesOfARecording) {
  ScratchDirectory scratch;
  Cloud cloud = withAllTypes(400);
  cloud.positions = 5 * cloud.positions;
  RecordParams params;
  params.voxel_size = 0;
  params.min_range = 0;
  Recorder recorder(scratch / "recording", "map", params);
  recorder.addCloud(cloud, Eigen::Isometry3d::Identity());
  const Recording recording = recorder.snapshot();
  ASSERT_GT(recording.tiles().size(), 1U);
  for (std::size_t tile = 0; tile < recording.tiles().size(); ++tile) {
    const auto& index = recording.tiles()[tile].index;
    const Cloud read = readWithPcl(scratch / ("recording/tiles/" + std::to_string(index[0]) + '_' +
                                              std::to_string(index[1]) + '_' + std::to_string(index[2]) + ".pcd"));
    expectEqual(read, {recording.readPoints(tile).cast<double>(), cloud.fields, recording.readRecords(tile)});
  }
}

}  // namespace
}  // namespace cloud_colorizer
