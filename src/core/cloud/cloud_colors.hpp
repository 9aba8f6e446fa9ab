// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The colours of a cloud, however other programs wrote them.
#pragma once

#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"
#include "cloud_colorizer/cloud/cloud.hpp"

namespace cloud_colorizer {

/// A packed rgb or rgba (0x..RRGGBB, as PCL has it), or numbers red, green and blue of any type.
class CloudColors {
 public:
  /// Throws std::runtime_error, naming `source`, when there are no colours.
  CloudColors(const std::vector<Field>& fields, const std::string& source);

  /// 3 x n, as the numbers are in the file (0 for what is no number); `scale` brings them to 0 to 255.
  Values read(const Cloud& cloud) const;

  /// Numbers of one byte are 0 to 255. Others tell by the largest of the whole cloud: floating-point numbers up to 1
  /// are 0 to 1, numbers of 16 bits above 255 are 0 to 65535, and what is left is 0 to 255.
  bool isBytes() const { return sizeOf(type_) == 1; }
  float scale(float largest) const;
  /// How they were taken, where not as 0 to 255; else empty.
  std::string describe(float largest) const;

 private:
  std::vector<std::size_t> offsets_;  ///< of red, green and blue; of the packed number alone
  FieldType type_ = FieldType::kUint8;
};

}  // namespace cloud_colorizer
