// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <cmath>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/camera/view.hpp"

namespace cloud_colorizer {

std::vector<std::string> enumNames(ImageKind) {
  return {"color", "radiometric", "labels", "logits"};
}

void Quantity::check() const {
  using Invalid = std::invalid_argument;
  if (kind == ImageKind::kColor) return;
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  require<Invalid>(!name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
                       std::all_of(name.begin(), name.end(), is_plain),
                   "quantity \"", name, "\" must be a word of letters, digits and _, as it names a field of the map");
  require<Invalid>(std::isfinite(scale) && scale != 0 && std::isfinite(offset), "quantity ", name, ": scale = ", scale,
                   " must not be 0, and offset = ", offset, " finite");
}

}  // namespace cloud_colorizer
