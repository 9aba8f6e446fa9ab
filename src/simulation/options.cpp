// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "simulation/options.hpp"

#include <yaml-cpp/yaml.h>

#include <type_traits>

#include "base/param_text.hpp"

namespace cloud_colorizer::simulation {
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

Options presetOptions(const std::string& name) {
  Options o;
  o.preset = name;
  if (name == "clean") return o;
  require<std::invalid_argument>(name == "vehicle" || name == "cheap", "option --preset = '", name,
                                 "' must be clean, vehicle or cheap");
  o.frames = 60;
  o.passes = 2;
  o.stand = 1;
  o.moving_car = true;
  o.van_ahead = 9;
  o.pedestrians = 5;
  o.leaves = 160;
  o.beam_divergence = 3;
  o.drift = 0.03;
  if (name == "vehicle") return o;
  o.width = 640;
  o.height = 400;
  o.pixel_noise = 4;
  o.exposure = 0.3;
  o.vignetting = 0.2;
  o.jpeg_quality = 85;
  o.beams = 16;
  o.azimuths = 900;
  o.range_noise = 0.03;
  o.pose_noise_deg = 0.12;
  o.drift = 0.06;
  o.extrinsic_noise_deg = 0.4;
  o.extrinsic_noise_m = 0.015;
  return o;
}

void setOption(Options& options, const std::string& name, const std::string& text) {
  if (name == "preset") {
    options = presetOptions(text);
    return;
  }
  bool is_known = false;
  visitOptions(options, [&](const char* known, auto& value, const Range&, const char*) {
    using Value = std::decay_t<decltype(value)>;
    if (name != known) return;
    const bool is_switch = std::is_same_v<Value, bool> && text.empty();  // alone, it is on
    value = parseValue<Value>("option --" + name, is_switch ? "true" : text);
    is_known = true;
  });
  require<std::invalid_argument>(is_known, "unknown option --", name, "; see --help");
}

std::vector<ParamText> describeOptions(const Options& options) {
  return describeFields([&](const auto& describe) {
    visitOptions(options, [&](const char* name, const auto& value, const Range&, const char* help) {
      describe(name, value, help);
    });
  });
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
