// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/cloud/cloud.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace cloud_colorizer {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Cloud, RecordSizeIsPacked) {
  EXPECT_EQ(recordSize({}), 0U);
  EXPECT_EQ(recordSize({{"ring", FieldType::kUint16}, {"time", FieldType::kFloat64}, {"rgb", FieldType::kUint8, 3}}),
            2U + 8U + 3U);
  EXPECT_THROW(sizeOf(static_cast<FieldType>(9)), std::invalid_argument);
}

TEST(Cloud, NumbersOfEveryType) {
  const auto check = [](FieldType type, double number) {
    Bytes bytes(9);
    const auto size = withType(type, [&](auto zero) {
      const auto stored = static_cast<decltype(zero)>(number);
      std::memcpy(bytes.data() + 1, &stored, sizeof stored);
      return sizeof stored;
    });
    EXPECT_EQ(sizeOf(type), size);
    EXPECT_EQ(numberAt(bytes.data() + 1, type), number) << static_cast<int>(type);
  };
  check(FieldType::kInt8, -128);
  check(FieldType::kUint8, 255);
  check(FieldType::kInt16, -32768);
  check(FieldType::kUint16, 65535);
  check(FieldType::kInt32, -2147483648.0);
  check(FieldType::kUint32, 4294967295.0);
  check(FieldType::kFloat32, 0.5F);
  check(FieldType::kFloat64, 1e300);
  EXPECT_THROW(numberAt(Bytes(8).data(), static_cast<FieldType>(0)), std::invalid_argument);
}

TEST(Cloud, FieldsAreFoundByName) {
  const std::vector<Field> fields{{"ring", FieldType::kUint16}, {"rgb", FieldType::kUint8, 3}, {"t"}};
  ASSERT_TRUE(findField(fields, "t"));
  EXPECT_EQ(findField(fields, "t")->offset, 5U);
  EXPECT_EQ(findField(fields, "t")->field, fields[2]);
  EXPECT_EQ(findField(fields, "ring")->offset, 0U);
  EXPECT_FALSE(findField(fields, "x"));
  EXPECT_FALSE(findField({}, "t"));
}

TEST(Cloud, FieldsThatNoFileCanHoldAreRefused) {
  EXPECT_NO_THROW(checkFields({{"intensity"}, {"ring", FieldType::kUint16}}));
  EXPECT_THROW(checkFields({{""}}), std::invalid_argument);
  EXPECT_THROW(checkFields({{"two words"}}), std::invalid_argument);
  EXPECT_THROW(checkFields({{"x"}}), std::invalid_argument);
  EXPECT_THROW(checkFields({{"_"}}), std::invalid_argument);
  EXPECT_THROW(checkFields({{"a"}, {"a", FieldType::kUint8}}), std::invalid_argument);
  EXPECT_THROW(checkFields({{"a", FieldType::kUint8, 0}}), std::invalid_argument);
}

TEST(Cloud, RecordsMustFitThePositions) {
  Cloud cloud;
  EXPECT_NO_THROW(checkCloud(cloud));
  cloud.positions.resize(3, 2);
  cloud.fields = {{"a", FieldType::kUint8}};
  cloud.records = {1};
  EXPECT_THROW(checkCloud(cloud), std::invalid_argument);
}

TEST(RecordMap, MatchesByNameAndTypeAndFillsWithZero) {
  const std::vector<Field> from{{"a", FieldType::kUint8}, {"b", FieldType::kUint16}, {"c", FieldType::kUint8}};
  const std::vector<Field> to{{"c", FieldType::kUint8}, {"b", FieldType::kInt16}, {"a", FieldType::kUint8}};
  const RecordMap map(from, to);
  EXPECT_EQ(map.dropped(), std::vector<std::string>{"b"});
  EXPECT_EQ(map.missing(), std::vector<std::string>{"b"});
  const Bytes record{1, 2, 3, 4};
  Bytes result(4, 99);
  map.copy(record.data(), result.data());
  EXPECT_EQ(result, (Bytes{4, 0, 0, 1}));
}

TEST(RecordMap, SameFieldsAreCopiedWhole) {
  const std::vector<Field> fields{{"a", FieldType::kUint8}, {"b", FieldType::kUint16}};
  const RecordMap map(fields, fields);
  EXPECT_TRUE(map.dropped().empty() && map.missing().empty());
  const Bytes record{7, 8, 9};
  Bytes result(3);
  map.copy(record.data(), result.data());
  EXPECT_EQ(result, record);
}

}  // namespace
}  // namespace cloud_colorizer
