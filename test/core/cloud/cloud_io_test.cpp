// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/cloud/cloud_io.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <random>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class T>
std::string raw(T value, bool swap = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class T>
T valueAt(const Cloud& cloud, std::size_t point, std::size_t offset) {
  T value;
  std::memcpy(&value, cloud.records.data() + point * recordSize(cloud.fields) + offset, sizeof value);
  return value;
}

Cloud readAll(const std::string& path) {
  return CloudReader(path).read(1'000'000);
}

/// Points with every type of field.
Cloud rich(std::size_t num_points) {
  Cloud cloud;
  cloud.fields = {{"a", FieldType::kInt8},  {"b", FieldType::kUint16},  {"rgb", FieldType::kFloat32},
                  {"c", FieldType::kInt32}, {"d", FieldType::kFloat64}, {"e", FieldType::kUint8, 3}};
  cloud.positions = Eigen::Matrix3Xd::Random(3, static_cast<Eigen::Index>(num_points)) * 1e6;
  cloud.records.resize(num_points * recordSize(cloud.fields));
  for (std::size_t i = 0; i < cloud.records.size(); ++i) cloud.records[i] = static_cast<std::uint8_t>(i * 7 % 64);
  return cloud;
}

void save(const std::string& path, const Cloud& cloud, bool as_double) {
  CloudWriter writer(path, static_cast<std::size_t>(cloud.positions.cols()), cloud.fields, as_double);
  writer.write(cloud);
  writer.finish();
}

const std::string kPlyBody =
    "comment made by hand\nelement camera 1\nproperty list uchar short ids\nproperty float f\n"
    "element vertex 2\nproperty double x\nproperty uchar red\nproperty float y\nproperty int32 z\nproperty ushort n\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

void expectHandMade(const Cloud& cloud) {
  ASSERT_EQ(cloud.positions.cols(), 2);
  EXPECT_EQ(cloud.positions.col(0), Eigen::Vector3d(466123.0625, -1.5, 7));
  EXPECT_EQ(cloud.positions.col(1), Eigen::Vector3d(2, 2.5, -70000));
  ASSERT_EQ(cloud.fields, (std::vector<Field>{{"red", FieldType::kUint8}, {"n", FieldType::kUint16}}));
  EXPECT_EQ(valueAt<std::uint8_t>(cloud, 0, 0), 255);
  EXPECT_EQ(valueAt<std::uint16_t>(cloud, 0, 1), 40000);
  EXPECT_EQ(valueAt<std::uint16_t>(cloud, 1, 1), 3);
}

TEST(CloudReader, PlyInAsciiWithOtherElementsAroundThePoints) {
  ScratchDirectory scratch;
  writeText(scratch / "a.ply", "ply\r\nformat ascii 1.0\n" + kPlyBody +
                                   "3 1 2 3 0.5\n466123.0625 255 -1.5 7 40000\n 2 0 2.5 -70000 3 \n3 0 1 0\n");
  expectHandMade(readAll(scratch / "a.ply"));
}

TEST(CloudReader, PlyInBinaryOfBothByteOrders) {
  ScratchDirectory scratch;
  for (const bool big : {false, true}) {
    std::string data = raw<std::uint8_t>(2) + raw<std::int16_t>(1, big) + raw<std::int16_t>(2, big) + raw(0.5F, big);
    data +=
        raw(466123.0625, big) + raw<std::uint8_t>(255) + raw(-1.5F, big) + raw(7, big) + raw<std::uint16_t>(40000, big);
    data += raw(2.0, big) + raw<std::uint8_t>(0) + raw(2.5F, big) + raw(-70000, big) + raw<std::uint16_t>(3, big);
    writeText(scratch / "a.ply", std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" +
                                     kPlyBody + data + "faces");
    expectHandMade(readAll(scratch / "a.ply"));
  }
}

TEST(CloudReader, PcdInAsciiAndBinarySkipsPadding) {
  ScratchDirectory scratch;
  const std::string header =
      "# .PCD v.7\nVERSION .7\nFIELDS x _ y z t\nSIZE 4 1 4 8 8\nTYPE F U F F U\nCOUNT 1 3 1 1 1\nWIDTH 1\nHEIGHT 2\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ";
  writeText(scratch / "a.pcd", header + "ascii\n1 0 0 0 2 3 40\nnan 0 0 0 5 6e3 70\n");
  const auto record = [](float x, float y, double z, std::uint64_t t) {
    return raw(x) + "pad" + raw(y) + raw(z) + raw(t);
  };
  writeText(scratch / "b.pcd", header + "binary\n" + record(1, 2, 3, 40) + record(NAN, 5, 6e3, 70));
  for (const char* name : {"a.pcd", "b.pcd"}) {
    const auto cloud = readAll(scratch / name);
    ASSERT_EQ(cloud.positions.cols(), 2) << name;
    EXPECT_EQ(cloud.positions.col(0), Eigen::Vector3d(1, 2, 3));
    EXPECT_TRUE(std::isnan(cloud.positions(0, 1)));
    EXPECT_EQ(cloud.positions(2, 1), 6000);
    ASSERT_EQ(cloud.fields, (std::vector<Field>{{"t", FieldType::kFloat64}}));
    EXPECT_EQ(valueAt<double>(cloud, 1, 0), 70);
  }
}

/// x = 1 1 1 1, y = 0 0 0 0, z = 0 0 0 0: literals, then copies that overlap themselves.
std::string compressedPcd() {
  const std::string data = std::string("\x03", 1) + raw(1.0F) + std::string("\xE0\x03\x03", 3) + std::string(1, '\0') +
                           std::string(1, '\0') + std::string("\xE0\x16", 2) + std::string(1, '\0');
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\n"
         "DATA binary_compressed\n" +
         raw(static_cast<std::uint32_t>(data.size())) + raw<std::uint32_t>(48) + data;
}

TEST(CloudReader, CompressedPcdIsReadAndDamageIsSeen) {
  ScratchDirectory scratch;
  auto text = compressedPcd();
  writeText(scratch / "a.pcd", text);
  const auto cloud = readAll(scratch / "a.pcd");
  for (int i = 0; i < 4; ++i) EXPECT_EQ(cloud.positions.col(i), Eigen::Vector3d(1, 0, 0));
  for (std::size_t cut = 1; cut < 20; ++cut) {
    writeText(scratch / "b.pcd", text.substr(0, text.size() - cut));
    EXPECT_ERROR(readAll(scratch / "b.pcd"), "b.pcd is truncated");
  }
  const auto first = text.size() - 12;
  for (std::size_t i = first; i < text.size(); ++i) {
    auto damaged = text;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x40);
    writeText(scratch / "b.pcd", damaged);
    messageOf([&] { readAll(scratch / "b.pcd"); });  // an error or other numbers, but nothing out of bounds
  }
  text[first + 4] = '\xFF';
  writeText(scratch / "b.pcd", text);
  EXPECT_ERROR(readAll(scratch / "b.pcd"), "cannot be decompressed");
}

TEST(CloudReader, CompressedPcdThatClaimsMoreThanItCanHoldIsRefusedBeforeMemoryIsTaken) {
  ScratchDirectory scratch;
  writeText(scratch / "a.pcd",
            "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 300000000\nHEIGHT 1\nDATA binary_compressed\n" +
                raw<std::uint32_t>(8) + raw<std::uint32_t>(3'600'000'000) + std::string(8, 'x'));
  EXPECT_ERROR(readAll(scratch / "a.pcd"), "8 packed bytes cannot hold");
}

/// Whatever the bytes: points, or an error that names the file.
TEST(CloudReader, MutatedFilesAreReadOrExplained) {
  ScratchDirectory scratch;
  for (const char* name : {"binary.ply", "binary.pcd"}) save(scratch / name, rich(20), true);
  writeText(scratch / "text.ply", "ply\nformat ascii 1.0\n" + kPlyBody + "1 2 3 0.5\n1 2 3 4 5\n6 7 8 9 10\n3 0 1 2\n");
  writeText(scratch / "text.pcd",
            "FIELDS x y z t\nSIZE 4 8 8 8\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
            "POINTS 2\nDATA ascii\n1 2 3 4\nnan 6 7 8\n");
  writeText(scratch / "compressed.pcd", compressedPcd());
  std::mt19937 random(1);
  const auto draw = [&](std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random); };
  for (const char* name : {"binary.ply", "binary.pcd", "text.ply", "text.pcd", "compressed.pcd"}) {
    std::ifstream stream(scratch / name, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    for (int i = 0; i < 400; ++i) {
      auto text = whole;
      for (auto changes = draw(4); changes > 0; --changes) {
        const bool is_digit = draw(2) == 0;
        text[draw(draw(3) == 0 ? text.size() : std::min<std::size_t>(text.size(), 300))] =
            static_cast<char>(is_digit ? '0' + draw(10) : draw(256));
      }
      if (draw(4) == 0) text.resize(draw(text.size()));
      const std::string path = scratch / (std::to_string(i) + name);
      writeText(path, text);
      const auto message = messageOf([&] {
        const auto cloud = readAll(path);
        checkCloud(cloud);
        EXPECT_LE(static_cast<std::size_t>(cloud.positions.size()), 100 * text.size());
      });
      EXPECT_TRUE(message.empty() || message.find(path) != std::string::npos) << message;
    }
  }
}

TEST(CloudReader, ReadsInBlocksOfAnySize) {
  ScratchDirectory scratch;
  const auto cloud = rich(20001);
  save(scratch / "a.pcd", cloud, true);
  CloudReader reader(scratch / "a.pcd");
  EXPECT_EQ(reader.numPoints(), 20001U);
  Bytes records;
  Eigen::Index first = 0;
  for (auto part = reader.read(777); part.positions.cols() > 0; part = reader.read(777)) {
    EXPECT_EQ(part.positions, cloud.positions.middleCols(first, part.positions.cols()));
    records.insert(records.end(), part.records.begin(), part.records.end());
    first += part.positions.cols();
  }
  EXPECT_EQ(first, 20001);
  EXPECT_EQ(records, cloud.records);
}

TEST(CloudWriter, PcdRoundTripKeepsAllFields) {
  ScratchDirectory scratch;
  const auto cloud = rich(100);
  for (const bool as_double : {true, false}) {
    save(scratch / "a.PCD", cloud, as_double);
    const auto read = readAll(scratch / "a.PCD");
    EXPECT_EQ(read.fields, cloud.fields);
    EXPECT_EQ(read.records, cloud.records);
    EXPECT_EQ(read.positions,
              as_double ? cloud.positions : Eigen::Matrix3Xd(cloud.positions.cast<float>().cast<double>()));
  }
}

TEST(CloudWriter, PlySplitsColourAndArraysAndRenamesAClash) {
  ScratchDirectory scratch;
  Cloud cloud;
  cloud.positions = Eigen::Vector3d(1, 2, 3);
  cloud.fields = {{"red", FieldType::kUint8}, {"rgb", FieldType::kFloat32}, {"v", FieldType::kUint8, 2}};
  cloud.records = {5, 30, 20, 10, 0, 6, 7};
  save(scratch / "a.ply", cloud, false);
  const auto read = readAll(scratch / "a.ply");
  std::string names;
  for (const auto& field : read.fields) names += field.name + ' ';
  EXPECT_EQ(names, "input_red red green blue v_0 v_1 ");
  EXPECT_EQ(read.records, (Bytes{5, 10, 20, 30, 6, 7}));
  EXPECT_EQ(read.positions, cloud.positions);
}

TEST(CloudWriter, EmptyCloudIsAFileThatReadsBack) {
  ScratchDirectory scratch;
  for (const char* name : {"a.ply", "a.pcd"}) {
    save(scratch / name, {}, false);
    EXPECT_EQ(readAll(scratch / name).positions.cols(), 0);
  }
}

TEST(CloudWriter, NothingRemainsWithoutFinish) {
  ScratchDirectory scratch;
  const auto cloud = rich(10);
  {
    CloudWriter writer(scratch / "a.ply", 11, cloud.fields, false);
    writer.write(cloud);
    EXPECT_ERROR(writer.finish(), "11 points, but 10");
    EXPECT_ERROR(writer.write(cloud), "there are more");
    EXPECT_ERROR(writer.write(Cloud{cloud.positions.leftCols(0), {}, {}}), "fields");
  }
  EXPECT_EQ(scratch.numFiles(), 0U);
}

TEST(CloudWriter, BadPathsAreRefusedBeforeWork) {
  ScratchDirectory scratch;
  EXPECT_ERROR(CloudWriter::checkPath(scratch / "a.e57"), "must be .ply, .pcd or .las");
  EXPECT_ERROR(CloudWriter::checkPath(scratch / "none/a.ply"), "there is no directory");
  std::filesystem::create_directory(scratch / "d.ply");
  EXPECT_ERROR(CloudWriter::checkPath(scratch / "d.ply"), "is a directory");
  EXPECT_NO_THROW(CloudWriter::checkPath(scratch / "a.PLY"));
  EXPECT_NO_THROW(CloudWriter::checkPath("a.pcd"));
}

TEST(CloudWriter, ReadOnlyDirectoryIsSaidToBeSo) {
  ScratchDirectory scratch;
  if (!scratch.mountDisk("ro")) GTEST_SKIP() << "no right to mount a disk";
  errno = ENOENT;  // of something earlier
  EXPECT_ERROR(CloudWriter::checkPath(scratch / "a.ply"), "Read-only file system");
}

TEST(CloudWriter, FullDiskIsReportedAndLeavesNothing) {
  ScratchDirectory scratch;
  if (!scratch.mountDisk("size=256k")) GTEST_SKIP() << "no right to mount a small disk";
  for (const char* name : {"a.ply", "a.pcd"}) {
    EXPECT_ERROR(save(scratch / name, rich(50000), true), "No space left on device");
    EXPECT_EQ(scratch.numFiles(), 0U);
  }
}

TEST(CloudReader, BadPlyFilesAreExplained) {
  ScratchDirectory scratch;
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string start = "ply\nformat ascii 1.0\nelement vertex 1\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"plx\n", "is no PLY file"},
      {"ply\nformat ascii 1.0\n", "no end_header"},
      {"ply\nelement vertex 0\n" + xyz + "end_header\n", "no format"},
      {"ply\nformat binary_middle_endian 1.0\n", "binary_middle_endian"},
      {"ply\nformat ascii 1.0\nend_header\n", "no element vertex"},
      {"ply\nformat ascii 1.0\nelement vertex -1\n", "line 3"},
      {start + "property long x\n", "\"long\" is unknown"},
      {start + "nonsense\n", "is no PLY header line"},
      {start + "property float x\nproperty float y\nend_header\n1 2\n", "needs the fields x, y and z"},
      {start + xyz + "property float x\nend_header\n1 2 3 4\n", "must be there once"},
      {start + xyz + "property float a\nproperty float a\nend_header\n1 2 3 4 5\n", "there twice"},
      {start + xyz + "end_header\n1 2\n\n\n\n", "it needs 3 numbers"},
      {start + xyz + "end_header\n1 2 3 4\n", "more than 3 numbers"},
      {start + xyz + "end_header\n1 2 x\n", "it needs 3 numbers"},
      {start + xyz + "property uchar r\nend_header\n1 2 3 256\n", "256 does not fit"},
      {start + xyz + "property uchar r\nend_header\n1 2 3 1.5\n", "does not fit"},
      {start + xyz + "end_header\n1,5 2,5 3,5\n", "it has a comma"},
      {start + xyz + "end_header\n1.#X 2 3\n", "it needs 3 numbers"},
      {start + xyz + "end_header\n\n\n\n\n\n\n", "ends after 0 of 1"},
      {"ply\nformat ascii 1.0\nelement vertex 999999999999\n" + xyz + "end_header\n1 2 3\n", "is truncated"},
      {"ply\nformat binary_little_endian 1.0\nelement vertex 2\n" + xyz + "end_header\n" + std::string(23, 'x'),
       "2 points of 12 bytes, but there are only 23"},
  };
  for (const auto& [text, part] : cases) {
    writeText(scratch / "a.ply", text);
    EXPECT_ERROR(readAll(scratch / "a.ply"), part);
  }
  EXPECT_ERROR(readAll(scratch / "none.ply"), "No such file");
  writeText(scratch / "a.e57", "ASTM-E57");
  EXPECT_ERROR(readAll(scratch / "a.e57"), "must be .ply, .pcd or .las");
}

/// What programs write that are not quite by the book.
TEST(CloudReader, DialectsOfPly) {
  ScratchDirectory scratch;
  const Eigen::Vector3d expected(1, 2, 3);
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 1\n";
  std::string macintosh = head + xyz + "end_header\n1 2 3\n";
  std::replace(macintosh.begin(), macintosh.end(), '\n', '\r');
  const std::vector<std::string> texts = {
      "\xEF\xBB\xBF" + head + xyz + "end_header\n1 2 3\n",
      macintosh,
      head + "property float X\nproperty float Y\nproperty float Z\nend_header\n1 2 3\n",
      head + xyz + "property int64 stamp\nend_header\n1 2 3 99\n",
      head + xyz + "property float intensity\nend_header\n1 2 3 -1.#IND\n",
      head + xyz + "property uchar red\nend_header\n1 2 3 nan\n",
      head + "property list uchar int views\n" + xyz +
          "property list uchar float weights\nend_header\n2 7 8 1 2 3 0\n"};
  for (const std::string& text : texts) {
    writeText(scratch / "a.ply", text);
    const Cloud cloud = readAll(scratch / "a.ply");
    ASSERT_EQ(cloud.positions.cols(), 1) << text;
    EXPECT_EQ(cloud.positions.col(0), expected) << text;
  }
}

TEST(CloudReader, ListsBetweenBinaryFieldsArePassedOver) {
  ScratchDirectory scratch;
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty list uchar int l\n"
      "property float y\nproperty float z\nproperty int64 stamp\nend_header\n";
  const auto add = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (int point = 0; point < 2; ++point) {
    add(1.0F + static_cast<float>(point));
    add(static_cast<std::uint8_t>(point));
    for (int i = 0; i < point; ++i) add(77);
    add(2.0F);
    add(3.0F);
    add(std::int64_t{10000000000} + point);
  }
  writeText(scratch / "a.ply", bytes);
  const Cloud cloud = readAll(scratch / "a.ply");
  ASSERT_EQ(cloud.positions.cols(), 2);
  EXPECT_EQ(cloud.positions.col(1), Eigen::Vector3d(2, 2, 3));
  double stamp = 0;
  std::memcpy(&stamp, cloud.records.data() + sizeof(double), sizeof stamp);
  EXPECT_EQ(stamp, 1e10 + 1);
  bytes.resize(bytes.size() - 9);
  writeText(scratch / "a.ply", bytes);
  EXPECT_ERROR(readAll(scratch / "a.ply"), "truncated");
}

TEST(CloudReader, DialectsOfPcd) {
  ScratchDirectory scratch;
  const std::string fields = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  for (const std::string& text : {fields + "WIDTH 1\nDATA ascii\n1 2 3\n", fields + "POINTS 1\nDATA ascii\n1 2 3\n",
                                  fields + "WIDTH 1\nHEIGHT 1\nVIEWPOINT 1 0 0 1 0 0 0\nDATA ascii\n0 2 3\n",
                                  // a half turn about z
                                  fields + "WIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 0 0 0 1\nDATA ascii\n-1 -2 3\n"}) {
    writeText(scratch / "a.pcd", text);
    EXPECT_LT((readAll(scratch / "a.pcd").positions - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12) << text;
  }
  writeText(scratch / "a.origin.txt", "1000000 0 0\n");
  EXPECT_EQ(readAll(scratch / "a.pcd").positions(0, 0), 1000001);
  writeText(scratch / "a.origin.txt", "somewhere\n");
  EXPECT_ERROR(readAll(scratch / "a.pcd"), "no origin");
}

TEST(CloudReader, BadPcdFilesAreExplained) {
  ScratchDirectory scratch;
  const std::string fields = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "no DATA line"},
      {"FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 0\nHEIGHT 1\nDATA ascii\n", "one entry a field"},
      {"FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 0\nHEIGHT 1\nDATA ascii\n", "SIZE 3"},
      {"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 0\nWIDTH 0\nHEIGHT 1\nDATA ascii\n", "COUNT 0"},
      {"FIELDS x y z a\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 4000000000\nWIDTH 0\nHEIGHT 1\nDATA ascii\n",
       "a point of 4000000003 numbers is too large"},
      {fields + "WIDTH 1\nWIDTH 2\nHEIGHT 1\nDATA ascii\n", "there twice"},
      {fields + "HEIGHT 1\nDATA ascii\n", "POINTS in its header is missing"},
      {fields + "WIDTH 1\nHEIGHT 1\nVIEWPOINT 0 0 0 0 0 0\nDATA ascii\n1 2 3\n", "VIEWPOINT"},
      {fields + "WIDTH 2\nHEIGHT 1\nPOINTS 3\nDATA ascii\n", "POINTS 3 is not WIDTH 2"},
      {fields + "WIDTH 1\nHEIGHT 1\nDATA zip\n", "DATA zip is unknown"},
      {fields + "WIDTH 1\nHEIGHT 1\nDATA ascii\n1 2\n", "is truncated"},
      {fields + "WIDTH 2\nHEIGHT 1\nDATA binary\n" + std::string(23, 'x'), "is truncated"},
  };
  for (const auto& [text, part] : cases) {
    writeText(scratch / "a.pcd", text);
    EXPECT_ERROR(readAll(scratch / "a.pcd"), part);
  }
}

}  // namespace
}  // namespace cloud_colorizer
