// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/params.hpp"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include <algorithm>
#include <cctype>
#include <iomanip>
#include <sstream>

#include "base/param_text.hpp"

namespace cloud_colorizer {
namespace {

constexpr int kMaxCameras = 64;

/// Read by other libraries from our private names.
bool isForeign(const std::string& name) {
  return name == "diagnostic_period" || name.rfind("plugins/", 0) == 0;
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
      texts[name] = formatValue(static_cast<bool>(value));
      return;
    case XmlRpcValue::TypeInt:
      texts[name] = formatValue(static_cast<int>(value));
      return;
    case XmlRpcValue::TypeDouble:
      texts[name] = formatValue(static_cast<double>(value));
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

/// Sets those of `texts` that are fields, and removes them from it.
template <class Visit>
void takeFields(std::map<std::string, std::string>& texts, const Visit& visit) {
  for (auto text = texts.begin(); text != texts.end();) {
    text = setField(visit, "parameter ", text->first, text->second) ? texts.erase(text) : std::next(text);
  }
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
  requireInRange("preview_period", preview_period, 0.0, 1e9);
  requireInRange("max_published_points", max_published_points, 1, 50000000);
}

void takeCollectorParams(std::map<std::string, std::string>& texts, CollectorParams& params) {
  const auto visit = [&](const auto& f) { visitCollectorParams(params, f); };
  takeFields(texts, visit);
}

std::vector<ParamText> describeCollectorParams(const CollectorParams& params) {
  return describeFields([&](const auto& f) { visitCollectorParams(params, f); });
}

AllParams paramsFromText(const std::map<std::string, std::string>& texts) {
  AllParams params;
  std::map<std::string, std::string> rest = texts;
  for (auto entry = rest.begin(); entry != rest.end();) entry = isForeign(entry->first) ? rest.erase(entry) : ++entry;

  int num_cameras = static_cast<int>(params.node.collector.cameras.size());
  if (rest.count("num_cameras") != 0) num_cameras = parseValue<int>("parameter num_cameras", rest["num_cameras"]);
  requireInRange("num_cameras", num_cameras, 0, kMaxCameras);
  params.node.collector.cameras.resize(static_cast<std::size_t>(num_cameras));
  params.node.camera_transports.resize(static_cast<std::size_t>(num_cameras));
  rest.erase("num_cameras");
  takeFields(rest, [&](const auto& f) { visitNodeParams(params.node, f); });
  takeFields(rest, [&](const auto& f) { visitParams(params.core, f); });
  if (!rest.empty()) {
    std::vector<std::string> known;
    for (const ParamText& param : describeAllParams(params)) known.push_back(param.name);
    const auto& [name, text] = *rest.begin();
    const std::string removed = removedParam(name);
    require<std::invalid_argument>(removed.empty(), removed);
    throw std::invalid_argument("unknown parameter ~" + name + " = '" + text + "'; did you mean ~" +
                                nearestName(name, known) + "?");
  }
  params.node.collector.record = params.core.record;
  params.core.check();
  params.node.check();
  return params;
}

std::vector<ParamText> describeAllParams(const AllParams& params) {
  std::vector<ParamText> rows;
  rows.push_back({"num_cameras", std::to_string(params.node.collector.cameras.size()), "number of cameras"});
  for (const ParamText& row : describeFields([&](const auto& f) { visitNodeParams(params.node, f); })) {
    rows.push_back(row);
  }
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
  AllParams params = paramsFromText(flattenParams(value));
  for (const ParamText& row : describeAllParams(params)) {
    ROS_INFO_STREAM_NAMED("params", "~" << row.name << ": " << (row.value.empty() ? "\"\"" : row.value));
  }
  return params;
}

}  // namespace cloud_colorizer
