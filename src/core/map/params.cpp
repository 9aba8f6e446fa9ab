// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/map/params.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <type_traits>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

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

template <class T>
T parse(const std::string& name, const std::string& text) {
  if constexpr (std::is_enum_v<T>) {
    const auto names = enumNames(T{});
    const auto found = std::find(names.begin(), names.end(), text);
    require<std::invalid_argument>(found != names.end(), "parameter ", name, " = '", text,
                                   "' must be one of: ", join(names));
    return static_cast<T>(found - names.begin());
  } else if constexpr (std::is_same_v<T, bool>) {
    require<std::invalid_argument>(text == "true" || text == "false", "parameter ", name, " = '", text,
                                   "' must be true or false");
    return text == "true";
  } else {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    require<std::invalid_argument>(!text.empty() && *end == '\0', "parameter ", name, " = '", text,
                                   "' is not a number");
    if constexpr (std::is_integral_v<T>) {
      requireInRange(name.c_str(), value, static_cast<double>(std::numeric_limits<T>::min()),
                     static_cast<double>(std::numeric_limits<T>::max()));
      require<std::invalid_argument>(value == static_cast<double>(static_cast<T>(value)), "parameter ", name, " = '",
                                     text, "' is not a whole number");
    }
    return static_cast<T>(value);
  }
}

template <class T>
std::string format(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return enumNames(value)[static_cast<std::size_t>(value)];
  } else {
    std::ostringstream text;
    text.precision(15);
    text << std::boolalpha << value;
    return text.str();
  }
}

}  // namespace

std::vector<std::string> enumNames(Method) {
  return {"default", "paper", "mean", "median", "closest"};
}
std::vector<std::string> enumNames(Uncolored) {
  return {"keep", "drop", "fill"};
}
std::vector<std::string> enumNames(SolverKind) {
  return {"cg", "cholmod", "spqr"};
}
std::vector<std::string> enumNames(PassGrids) {
  return {"own", "shared"};
}
std::vector<std::string> enumNames(AnchorKind) {
  return {"random", "consistent"};
}
std::vector<std::string> enumNames(AlignPoses) {
  return {"none", "cameras", "views"};
}

void ColorizeParams::check() const {
  requireInRange("fill_distance", fill_distance, 0.0, 1e3);
  requireInRange("num_threads", num_threads, 0, 1024);
  requireInRange("memory_limit", memory_limit, 100.0, 1e7);
}

void Params::check() const {
  record.check();
  surfels.check();
  depth.check();
  alignment.check();
  observe.check();
  graph.check();
  system.check();
  tone.check();
  chunks.check();
  colorize.check();
}

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  const auto closer = [&](const auto& a, const auto& b) { return editDistance(a, name) < editDistance(b, name); };
  const auto nearest = std::min_element(known.begin(), known.end(), closer);
  return nearest == known.end() ? std::string() : *nearest;
}

void setParam(Params& params, const std::string& name, const std::string& text) {
  bool found = false;
  std::vector<std::string> known;
  visitParams(params, [&](const char* field_name, auto& field, const char*) {
    known.emplace_back(field_name);
    if (name != field_name) return;
    field = parse<std::decay_t<decltype(field)>>(name, text);
    found = true;
  });
  require<std::invalid_argument>(found, "unknown parameter '", name, "'; did you mean '", nearestName(name, known),
                                 "'?");
}

std::vector<ParamText> describeParams(const Params& params) {
  std::vector<ParamText> texts;
  visitParams(params, [&](const char* name, const auto& field, const char* help) {
    texts.push_back({name, format(field), help});
  });
  return texts;
}

}  // namespace cloud_colorizer
