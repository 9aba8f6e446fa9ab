// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud/las.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

template <class T>
void put(std::string& bytes, std::size_t offset, T value) {
  bytes.resize(std::max(bytes.size(), offset + sizeof(T)));
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
}

template <class T>
T get(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// A file of version 1.2 by the tables of the specification: two points at (1, 2, 3) and (2, 2, 3), offset by 1000.
std::string lasFile(int format, std::uint16_t stride) {
  std::string bytes = "LASF";
  bytes.resize(227);
  put<std::uint8_t>(bytes, 24, 1);
  put<std::uint8_t>(bytes, 25, 2);
  put<std::uint16_t>(bytes, 94, 227);
  put<std::uint32_t>(bytes, 96, 230);  // with a gap before the points
  put<std::uint8_t>(bytes, 104, static_cast<std::uint8_t>(format));
  put<std::uint16_t>(bytes, 105, stride);
  put<std::uint32_t>(bytes, 107, 2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(bytes, 131 + 8 * axis, 0.01);
    put(bytes, 155 + 8 * axis, 1000.0);
  }
  bytes.resize(230 + 2U * stride);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t at = 230 + i * stride;
    put(bytes, at, static_cast<std::int32_t>(100 * (i + 1)));
    put<std::int32_t>(bytes, at + 4, 200);
    put<std::int32_t>(bytes, at + 8, 300);
    put<std::uint16_t>(bytes, at + 12, 4000);
  }
  return bytes;
}

Cloud readAll(const std::string& path) {
  return CloudReader(path).read(1000);
}

double valueOf(const Cloud& cloud, const std::string& name, std::size_t point) {
  std::size_t offset = point * recordSize(cloud.fields);
  for (const Field& field : cloud.fields) {
    if (field.name == name) return numberAt(cloud.records.data() + offset, field.type);
    offset += sizeOf(field.type) * field.count;
  }
  ADD_FAILURE() << "no field " << name;
  return 0;
}

TEST(Las, EveryPointFormatIsRead) {
  ScratchDirectory scratch;
  struct Format {
    int number;
    std::uint16_t size;
    std::size_t time, red;  ///< offsets; 0: none
  };
  for (const Format& format : {Format{0, 20, 0, 0}, Format{1, 28, 20, 0}, Format{2, 26, 0, 20}, Format{3, 34, 20, 28},
                               Format{4, 57, 20, 0}, Format{5, 63, 20, 28}, Format{6, 30, 22, 0}, Format{7, 36, 22, 30},
                               Format{8, 38, 22, 30}, Format{9, 59, 22, 0}, Format{10, 67, 22, 30}}) {
    std::string bytes = lasFile(format.number, static_cast<std::uint16_t>(format.size + 3));  // and bytes of nobody
    const std::size_t second = 230 + format.size + 3;
    if (format.time > 0) put(bytes, second + format.time, 123.5);
    if (format.red > 0) put<std::uint16_t>(bytes, second + format.red + 2, 65535);
    writeText(scratch / "a.las", bytes);
    const Cloud cloud = readAll(scratch / "a.las");
    ASSERT_EQ(cloud.positions.cols(), 2) << format.number;
    EXPECT_LT((cloud.positions.col(1) - Eigen::Vector3d(1002, 1002, 1003)).norm(), 1e-9) << format.number;
    EXPECT_EQ(valueOf(cloud, "intensity", 1), 4000);
    if (format.time > 0) {
      EXPECT_EQ(valueOf(cloud, "gps_time", 1), 123.5) << format.number;
    }
    if (format.red > 0) {
      EXPECT_EQ(valueOf(cloud, "green", 1), 65535) << format.number;
    }
  }
}

TEST(Las, WhatIsWrittenIsReadAgain) {
  ScratchDirectory scratch;
  for (const bool has_time : {true, false}) {
    Cloud cloud;
    cloud.fields = {{"intensity", FieldType::kUint16, 1},
                    {"rgb", FieldType::kFloat32, 1},
                    {"view_count", FieldType::kUint16, 1},
                    {"color_stddev", FieldType::kFloat32, 1},
                    {"normal", FieldType::kFloat64, 3}};
    if (has_time) cloud.fields.push_back({"gps_time", FieldType::kFloat64, 1});
    cloud.positions = (Eigen::Matrix3Xd::Random(3, 50) * 300).colwise() + Eigen::Vector3d(433000, 5720000, 120);
    cloud.records.resize(50 * recordSize(cloud.fields));
    std::string record;
    put<std::uint16_t>(record, 0, 777);
    put<std::uint32_t>(record, 2, 0x00FF8001U);  // red 255, green 128, blue 1
    put<std::uint16_t>(record, 6, 12);
    put<float>(record, 8, 3.5F);
    for (std::size_t i = 0; i < 3; ++i) put<double>(record, 12 + 8 * i, static_cast<double>(i));
    if (has_time) put<double>(record, 36, 1e9 + 0.25);
    for (std::size_t i = 0; i < 50; ++i)
      std::memcpy(cloud.records.data() + i * record.size(), record.data(), record.size());
    Eigen::AlignedBox3d box(cloud.positions.rowwise().minCoeff().eval());
    box.extend(cloud.positions.rowwise().maxCoeff().eval());
    CloudWriter writer(scratch / "a.las", 50, cloud.fields, true, box);
    writer.write(cloud);
    writer.finish();

    const std::string bytes = readText(scratch / "a.las");
    EXPECT_EQ(get<std::uint8_t>(bytes, 25), 4);
    EXPECT_EQ(get<std::uint8_t>(bytes, 104), has_time ? 7 : 2);
    EXPECT_EQ(get<std::uint64_t>(bytes, 247), 50U);
    EXPECT_EQ(get<double>(bytes, 155), 433000);
    const auto points_at = get<std::uint32_t>(bytes, 96);
    EXPECT_EQ(bytes.size(), points_at + 50U * get<std::uint16_t>(bytes, 105));
    EXPECT_EQ(static_cast<std::uint8_t>(bytes[points_at + 14]), has_time ? 0x11 : 0x09);  // return 1 of 1

    const Cloud read = readAll(scratch / "a.las");
    ASSERT_EQ(read.positions.cols(), 50);
    EXPECT_LT((read.positions - cloud.positions).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_EQ(valueOf(read, "intensity", 49), 777);
    EXPECT_EQ(valueOf(read, "red", 49), 65535);
    EXPECT_EQ(valueOf(read, "green", 49), 128 * 257);
    EXPECT_EQ(valueOf(read, "blue", 49), 257);
    EXPECT_EQ(valueOf(read, "view_count", 49), 12);
    EXPECT_EQ(valueOf(read, "color_stddev", 49), 3.5);
    EXPECT_EQ(valueOf(read, "normal_2", 49), 2);
    if (has_time) {
      EXPECT_EQ(valueOf(read, "gps_time", 49), 1e9 + 0.25);
    }
  }
}

TEST(Las, TheCoordinateReferenceSystemIsPassedOn) {
  ScratchDirectory scratch;
  const std::vector<Field> fields = {{"view_count", FieldType::kUint16, 1}};
  CloudWriter(scratch / "a.las", 0, fields, false, {}, "EPSG:25832").finish();
  const std::string text = CloudReader(scratch / "a.las").crs(), bytes = readText(scratch / "a.las");
  EXPECT_EQ(text.rfind("PROJCS[\"ETRS89 / UTM zone 32N\"", 0), 0U) << text;
  EXPECT_NE(text.find("AUTHORITY[\"EPSG\",\"25832\"]"), std::string::npos);
  EXPECT_EQ(get<std::uint16_t>(bytes, 6) & 0x10, 0x10);  // it is WKT
  EXPECT_EQ(get<std::uint32_t>(bytes, 100), 2U);         // beside the extra bytes
  CloudWriter(scratch / "b.las", 0, fields, false, {}, text).finish();
  EXPECT_EQ(CloudReader(scratch / "b.las").crs(), text);
  CloudWriter(scratch / "c.las", 0, fields, false).finish();
  EXPECT_EQ(CloudReader(scratch / "c.las").crs(), "");
  EXPECT_THROW(CloudWriter(scratch / "d.las", 0, fields, false, {}, "EPSG:1"), std::invalid_argument);
}

/// A file of version 1.2 with GeoTIFF's keys: of a projection and of heights.
TEST(Las, CodesOfGeoKeysAreRead) {
  ScratchDirectory scratch;
  std::string record(54, '\0');
  record.replace(2, 15, "LASF_Projection");
  put<std::uint16_t>(record, 18, 34735);
  put<std::uint16_t>(record, 20, 40);
  for (const int number : {1, 1, 0, 4, 1024, 0, 1, 1, 2049, 34737, 7, 0, 3072, 0, 1, 25832, 4096, 0, 1, 5783}) {
    put<std::uint16_t>(record, record.size(), static_cast<std::uint16_t>(number));
  }
  std::string bytes = lasFile(0, 20);
  const auto points_at = get<std::uint32_t>(bytes, 96);
  bytes.insert(227, record);
  put<std::uint32_t>(bytes, 96, points_at + static_cast<std::uint32_t>(record.size()));
  put<std::uint32_t>(bytes, 100, 1);
  writeText(scratch / "a.las", bytes);
  EXPECT_EQ(CloudReader(scratch / "a.las").crs(), "EPSG:25832+5783");
  EXPECT_EQ(readAll(scratch / "a.las").positions.cols(), 2);
}

TEST(Las, AnEmptyMapIsWritten) {
  ScratchDirectory scratch;
  CloudWriter writer(scratch / "a.las", 0, {}, false);
  writer.finish();
  EXPECT_EQ(readAll(scratch / "a.las").positions.cols(), 0);
  EXPECT_THROW(CloudWriter(scratch / "b.las", 1, {}, false), std::invalid_argument);
}

TEST(Las, BadFilesAreExplained) {
  ScratchDirectory scratch;
  const auto errorOf = [&](const std::string& bytes) {
    writeText(scratch / "a.las", bytes);
    return messageOf([&] { readAll(scratch / "a.las"); });
  };
  const std::string good = lasFile(3, 34);
  EXPECT_EQ(errorOf(good), "");
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_NE(errorOf(good.substr(0, size)).find("truncated"), std::string::npos) << size;
  }
  const auto changed = [&](std::size_t offset, auto value) {
    std::string bytes = good;
    put(bytes, offset, value);
    return errorOf(bytes);
  };
  EXPECT_NE(changed(0, 'X').find("no LAS file"), std::string::npos);
  EXPECT_NE(changed(104, std::uint8_t{3 | 0x80}).find("laszip"), std::string::npos);
  EXPECT_NE(changed(104, std::uint8_t{11}).find("point format 11"), std::string::npos);
  EXPECT_NE(changed(105, std::uint16_t{33}).find("33 bytes is less than the 34"), std::string::npos);
  EXPECT_NE(changed(131, std::nan("")).find("not finite"), std::string::npos);
  EXPECT_NE(changed(100, std::uint32_t{1}).find("within its records"), std::string::npos);
  EXPECT_NE(changed(107, std::uint32_t{3}).find("truncated"), std::string::npos);
  writeText(scratch / "a.laz", good);
  EXPECT_ERROR(readAll(scratch / "a.laz"), "pdal translate");
}

}  // namespace
}  // namespace cloud_colorizer
