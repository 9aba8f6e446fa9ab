// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/param_text.hpp"

#include <cctype>
#include <numeric>

namespace cloud_colorizer {
namespace {

/// Number of single-character edits between two words (Levenshtein).
std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  const auto closer = [&](const auto& a, const auto& b) { return editDistance(a, name) < editDistance(b, name); };
  const auto nearest = std::min_element(known.begin(), known.end(), closer);
  return nearest == known.end() ? std::string() : *nearest;
}

std::size_t parseWord(const std::string& what, const std::string& text, const std::vector<std::string>& allowed) {
  const auto found = std::find(allowed.begin(), allowed.end(), text);
  if (found != allowed.end()) return static_cast<std::size_t>(found - allowed.begin());
  throw std::invalid_argument(what + " = '" + text + "' must be one of: " + join(allowed, ", "));
}

double parseNumber(const std::string& what, const std::string& text) {
  double value = 0;
  const bool starts_plain = !text.empty() && std::isspace(static_cast<unsigned char>(text[0])) == 0;
  require<std::invalid_argument>(starts_plain && parseDouble(text, value), what, " = '", text, "' is not a number");
  return value;
}

bool parseBool(const std::string& what, const std::string& text) {
  const bool yes = text == "true" || text == "1";
  require<std::invalid_argument>(yes || text == "false" || text == "0", what, " = '", text, "' must be true or false");
  return yes;
}

}  // namespace cloud_colorizer
