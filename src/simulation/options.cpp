// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/options.hpp"

#include <yaml-cpp/yaml.h>

#include <sstream>
#include <type_traits>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer::simulation {
namespace {

void parse(const std::string& name, const std::string& text, std::string& value) {
  require<std::invalid_argument>(!text.empty(), "option --", name, " needs a value");
  value = text;
}

void parse(const std::string& name, const std::string& text, bool& value) {
  require<std::invalid_argument>(text == "true" || text == "false" || text.empty(), "option --", name, " = \"", text,
                                 "\" must be true or false");
  value = text != "false";
}

template <class Number>
void parse(const std::string& name, const std::string& text, Number& value) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  Number number{};
  require<std::invalid_argument>(stream >> number && stream.peek() == std::istringstream::traits_type::eof(),
                                 "option --", name, " = \"", text, "\" is not ",
                                 std::is_integral<Number>::value ? "a whole number" : "a number");
  value = number;
}

template <class Value>
std::string toText(const Value& value) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream.precision(12);
  stream << std::boolalpha << value;
  return stream.str();
}

}  // namespace

void Options::check() const {
  visitOptions(*this, [](const char* name, const auto& value, const Range& range, const char*) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      requireInRange(name, value, static_cast<Value>(range.low), static_cast<Value>(range.high));
    }
  });
  require<std::invalid_argument>(image_transport == "compressed" || image_transport == "raw",
                                 "parameter image-transport = ", image_transport, " must be compressed or raw");
}

void setOption(Options& options, const std::string& name, const std::string& text) {
  bool is_known = false;
  visitOptions(options, [&](const char* known, auto& value, const Range&, const char*) {
    if (name != known) return;
    parse(name, text, value);
    is_known = true;
  });
  require<std::invalid_argument>(is_known, "unknown option --", name, "; see --help");
}

std::vector<OptionText> describeOptions(const Options& options) {
  std::vector<OptionText> texts;
  visitOptions(options, [&](const char* name, const auto& value, const Range&, const char* help) {
    texts.push_back({name, toText(value), help});
  });
  return texts;
}

Options readSceneFile(const std::string& path) {
  try {
    const YAML::Node file = YAML::LoadFile(path);
    require(static_cast<bool>(file["options"]), "has no section \"options\"");
    Options options;
    for (const auto& entry : file["options"]) {
      setOption(options, entry.first.as<std::string>(), entry.second.as<std::string>());
    }
    options.check();
    return options;
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace cloud_colorizer::simulation
