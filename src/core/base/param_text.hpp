// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Values of parameters and options as text: one parser and one printer for files, programs and the node, whatever the
/// locale. Enumerations are words: `enumNames(T)` lists those of T in the order of its values.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// The word of `known` that looks most like `name`: for "did you mean". Empty without any.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/// Throws std::invalid_argument with the allowed words unless `text` is one of them. Returns its index.
std::size_t parseWord(const std::string& what, const std::string& text, const std::vector<std::string>& allowed);
double parseNumber(const std::string& what, const std::string& text);
bool parseBool(const std::string& what, const std::string& text);

/// Throws std::invalid_argument that begins with `what` ("parameter passes") and the text.
template <class T>
T parseValue(const std::string& what, const std::string& text) {
  if constexpr (std::is_same_v<T, std::string>) {
    return text;
  } else if constexpr (std::is_same_v<T, bool>) {
    return parseBool(what, text);
  } else if constexpr (std::is_enum_v<T>) {
    return static_cast<T>(parseWord(what, text, enumNames(T{})));
  } else {
    const double value = parseNumber(what, text);
    if constexpr (std::is_integral_v<T>) {
      constexpr double kWhole = 9007199254740992;  // 2^53: beyond it a double leaves whole numbers out
      const double low = std::max(-kWhole, static_cast<double>(std::numeric_limits<T>::min()));
      const double high = std::min(kWhole, static_cast<double>(std::numeric_limits<T>::max()));
      require<std::invalid_argument>(value >= low && value <= high, what, " = '", text, "' must lie in [",
                                     formatDouble(low), ", ", formatDouble(high), "]");
      require<std::invalid_argument>(value == static_cast<double>(static_cast<T>(value)), what, " = '", text,
                                     "' is not a whole number");
    }
    return static_cast<T>(value);
  }
}

/// Values between separators: "1,2,3".
template <class T>
std::vector<T> parseList(const std::string& what, const std::string& text, char separator) {
  std::vector<T> values;
  for (const std::string& word : splitAt(text, separator)) values.push_back(parseValue<T>(what, word));
  return values;
}

template <class T>
std::string formatValue(const T& value) {
  if constexpr (std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_enum_v<T>) {
    return enumNames(value)[static_cast<std::size_t>(value)];
  } else if constexpr (std::is_integral_v<T>) {
    return std::to_string(value);
  } else {
    return formatDouble(value);
  }
}

/// The rest is for structs whose fields a function shows: visit(f) calls f(name, field, help) for each.

template <class Visit>
std::vector<ParamText> describeFields(const Visit& visit) {
  std::vector<ParamText> texts;
  visit([&](const char* name, const auto& field, const char* help) {
    texts.push_back({name, formatValue(field), help});
  });
  return texts;
}

/// Sets the field of that name from text; false without such a field. Errors begin with `prefix` and the name.
template <class Visit>
bool setField(const Visit& visit, const std::string& prefix, const std::string& name, const std::string& text) {
  bool found = false;
  visit([&](const char* field_name, auto& field, const char*) {
    if (name != field_name) return;
    field = parseValue<std::decay_t<decltype(field)>>(prefix + name, text);
    found = true;
  });
  return found;
}

}  // namespace cloud_colorizer
