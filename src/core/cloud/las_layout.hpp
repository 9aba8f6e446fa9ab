// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Where LAS keeps what. "LAS Specification 1.4 - R15", ASPRS, 2019.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "cloud/cloud_layout.hpp"

namespace cloud_colorizer {

constexpr std::size_t kLasHeaderSize = 375;  // bytes, of version 1.4
constexpr std::size_t kLasRecordHead = 54;   // bytes before what a variable length record holds
constexpr std::size_t kLasExtraSize = 192;   // bytes that describe one field of extra bytes
constexpr std::size_t kLasReturnFlags = 14;  // offset in a point of any format

struct LasSlot {
  const char* name;
  FieldType type;
  std::size_t offset;
};
/// Where the fields of a point format lie, x, y and z first.
struct LasPointFormat {
  std::vector<LasSlot> slots;
  std::size_t colors = 0;  ///< offset of red, green and blue; 0: it has none
  std::size_t size = 0;
};

/// Table of the specification: formats 0 to 5 have 20 bytes, 6 to 10 have 30, then time, colours and waves.
LasPointFormat lasPointFormat(int number);

/// Codes 1 to 10 of extra bytes.
struct LasExtraType {
  FieldType type;
  Wide wide;
};
constexpr std::array<LasExtraType, 10> kLasExtraTypes = {{{FieldType::kUint8, Wide::kNo},
                                                          {FieldType::kInt8, Wide::kNo},
                                                          {FieldType::kUint16, Wide::kNo},
                                                          {FieldType::kInt16, Wide::kNo},
                                                          {FieldType::kUint32, Wide::kNo},
                                                          {FieldType::kInt32, Wide::kNo},
                                                          {FieldType::kFloat64, Wide::kUint64},
                                                          {FieldType::kFloat64, Wide::kInt64},
                                                          {FieldType::kFloat32, Wide::kNo},
                                                          {FieldType::kFloat64, Wide::kNo}}};

}  // namespace cloud_colorizer
