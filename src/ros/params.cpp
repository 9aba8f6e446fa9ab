// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/params.hpp"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kMaxCameras = 64;

/// Read by other libraries from our private names.
bool isForeign(const std::string& name) {
  return name == "diagnostic_period" || name.rfind("plugins/", 0) == 0;
}

template <class T>
T numberFromText(const std::string& name, const std::string& text) {
  std::istringstream stream(text);
  T value{};
  require<std::invalid_argument>(static_cast<bool>(stream >> value) && (stream >> std::ws).eof(), "parameter ", name,
                                 " = \"", text, "\" is not ", std::is_integral<T>::value ? "an integer" : "a number");
  return value;
}

void readText(const std::string&, const std::string& text, std::string& value) {
  value = text;
}
void readText(const std::string& name, const std::string& text, double& value) {
  value = numberFromText<double>(name, text);
}
void readText(const std::string& name, const std::string& text, int& value) {
  value = numberFromText<int>(name, text);
}
void readText(const std::string& name, const std::string& text, bool& value) {
  require<std::invalid_argument>(text == "true" || text == "false" || text == "1" || text == "0", "parameter ", name,
                                 " = \"", text, "\" is neither true nor false");
  value = text == "true" || text == "1";
}

std::string toText(const std::string& value) {
  return value;
}
std::string toText(int value) {
  return std::to_string(value);
}
std::string toText(bool value) {
  return value ? "true" : "false";
}

/// The shortest decimal that reads back as the same number.
std::string toText(double value) {
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::ostringstream out;
    out.precision(digits);
    out << value;
    if (digits == std::numeric_limits<double>::max_digits10 || std::stod(out.str()) == value) return out.str();
  }
  return {};
}

void flattenInto(const std::string& name, XmlRpc::XmlRpcValue value, std::map<std::string, std::string>& texts) {
  using XmlRpc::XmlRpcValue;
  switch (value.getType()) {
    case XmlRpcValue::TypeStruct:
      for (auto& member : value)
        flattenInto(name.empty() ? member.first : name + "/" + member.first, member.second, texts);
      return;
    case XmlRpcValue::TypeString:
      texts[name] = static_cast<std::string>(value);
      return;
    case XmlRpcValue::TypeBoolean:
      texts[name] = toText(static_cast<bool>(value));
      return;
    case XmlRpcValue::TypeInt:
      texts[name] = toText(static_cast<int>(value));
      return;
    case XmlRpcValue::TypeDouble:
      texts[name] = toText(static_cast<double>(value));
      return;
    default:
      throw std::invalid_argument("parameter " + name + " must be one number, word or truth value, not a list");
  }
}

/// Whether there is a plugin of that name is seen when the node subscribes.
void checkTransport(const std::string& name, const std::string& value) {
  const auto is_letter = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  require<std::invalid_argument>(!value.empty() && std::all_of(value.begin(), value.end(), is_letter), "parameter ",
                                 name, " = \"", value,
                                 "\" must be raw, compressed or the name of another image transport");
}

}  // namespace

void NodeParams::check() const {
  collector.check();
  checkTransport("image_transport", image_transport);
  for (std::size_t i = 0; i < camera_transports.size(); ++i) {
    if (!camera_transports[i].empty())
      checkTransport("camera_" + std::to_string(i) + "/image_transport", camera_transports[i]);
  }
  requireInRange("colorize_after", colorize_after, 0.0, 1e9);
  requireInRange("queue_size", queue_size, 1, 100000);
  requireInRange("preview_voxel_size", preview_voxel_size, 1e-3, 1e3);
  requireInRange("preview_period", preview_period, 0.0, 1e9);
  requireInRange("max_preview_points", max_preview_points, 1, 50000000);
  requireInRange("max_published_points", max_published_points, 1, 50000000);
}

void takeCollectorParams(std::map<std::string, std::string>& texts, CollectorParams& params) {
  visitCollectorParams(params, [&](const char* name, auto& value, const char*) {
    const auto found = texts.find(name);
    if (found == texts.end()) return;
    readText(name, found->second, value);
    texts.erase(found);
  });
}

std::vector<ParamText> describeCollectorParams(const CollectorParams& params) {
  std::vector<ParamText> rows;
  visitCollectorParams(params, [&](const char* name, const auto& value, const char* help) {
    rows.push_back({name, toText(value), help});
  });
  return rows;
}

AllParams paramsFromText(const std::map<std::string, std::string>& texts) {
  AllParams params;
  std::map<std::string, std::string> rest = texts;
  for (auto entry = rest.begin(); entry != rest.end();) entry = isForeign(entry->first) ? rest.erase(entry) : ++entry;

  int num_cameras = static_cast<int>(params.node.collector.cameras.size());
  if (rest.count("num_cameras") != 0) readText("num_cameras", rest["num_cameras"], num_cameras);
  requireInRange("num_cameras", num_cameras, 0, kMaxCameras);
  params.node.collector.cameras.resize(static_cast<std::size_t>(num_cameras));
  params.node.camera_transports.resize(static_cast<std::size_t>(num_cameras));
  rest.erase("num_cameras");

  std::vector<std::string> known = {"num_cameras"};
  visitNodeParams(params.node, [&](const char* name, auto& value, const char*) {
    known.push_back(name);
    if (rest.count(name) == 0) return;
    readText(name, rest[name], value);
    rest.erase(name);
  });
  std::vector<std::string> core;
  visitParams(params.core, [&](const char* name, auto&, const char*) { core.push_back(name); });
  known.insert(known.end(), core.begin(), core.end());
  for (const auto& [name, text] : rest) {
    require<std::invalid_argument>(std::find(core.begin(), core.end(), name) != core.end(), "unknown parameter ~", name,
                                   " = \"", text, "\"; did you mean ~", nearestName(name, known), "?");
    setParam(params.core, name, text);
  }
  params.node.collector.record = params.core.record;
  params.core.check();
  params.node.check();
  return params;
}

std::vector<ParamText> describeAllParams(const AllParams& params) {
  std::vector<ParamText> rows;
  rows.push_back({"num_cameras", std::to_string(params.node.collector.cameras.size()), "number of cameras"});
  visitNodeParams(params.node, [&](const char* name, const auto& value, const char* help) {
    rows.push_back({name, toText(value), help});
  });
  for (const ParamText& row : describeParams(params.core)) rows.push_back(row);
  return rows;
}

std::string defaultsAsYaml() {
  std::ostringstream out;
  out << "# All parameters of colorizer_node with their defaults; made by `colorizer_node --defaults`, a test "
         "compares.\n"
      << "# Every camera has its own camera_<i>/... .\n";
  for (const ParamText& row : describeAllParams(AllParams())) {
    out << std::left << std::setw(32) << row.name + ": " + (row.value.empty() ? "\"\"" : row.value) << " # " << row.help
        << '\n';
  }
  return out.str();
}

std::map<std::string, std::string> flattenParams(const XmlRpc::XmlRpcValue& value) {
  std::map<std::string, std::string> texts;
  if (value.valid()) flattenInto("", value, texts);
  return texts;
}

AllParams loadParams() {
  XmlRpc::XmlRpcValue value;
  ros::param::get(ros::this_node::getName(), value);
  const AllParams params = paramsFromText(flattenParams(value));
  for (const ParamText& row : describeAllParams(params)) {
    ROS_INFO_STREAM_NAMED("params", "~" << row.name << ": " << (row.value.empty() ? "\"\"" : row.value));
  }
  return params;
}

}  // namespace cloud_colorizer
