// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "cloud_colorizer/ros/params.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <functional>
#include <set>

namespace cloud_colorizer {
namespace {

std::string errorOf(const std::map<std::string, std::string>& texts) {
  try {
    paramsFromText(texts);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(RosParams, DefaultsWithoutAnyText) {
  const AllParams params = paramsFromText({});
  EXPECT_EQ(params.node.collector.cameras.size(), 1U);
  EXPECT_EQ(params.node.collector.map_frame, "map");
  EXPECT_EQ(params.core.record.voxel_size, Params{}.record.voxel_size);
}

TEST(RosParams, TextsArriveInTheirFields) {
  const AllParams params = paramsFromText({{"num_cameras", "3"},
                                           {"camera_2/time_offset", "-0.02"},
                                           {"camera_1/rectified", "true"},
                                           {"tf_wait", "0.5"},
                                           {"voxel_size", "0.1"},
                                           {"method", "paper"},
                                           {"camera_0/image_transport", "theora"},
                                           {"plugins/camera_0/theora/post_processing_level", "0"},
                                           {"diagnostic_period", "2"}});
  EXPECT_EQ(params.node.collector.cameras.at(2).time_offset, -0.02);
  EXPECT_TRUE(params.node.collector.cameras.at(1).rectified);
  EXPECT_EQ(params.node.camera_transports.at(0), "theora");
  EXPECT_EQ(params.node.collector.tf_wait, 0.5);
  EXPECT_EQ(params.node.collector.record.voxel_size, 0.1);
  EXPECT_EQ(params.core.colorize.method, Method::kPaper);
}

TEST(RosParams, UnknownNameGetsTheNearestKnownOne) {
  EXPECT_NE(errorOf({{"voxel_sise", "0.1"}}).find("~voxel_size"), std::string::npos);
  EXPECT_NE(errorOf({{"save_patch", "a.ply"}}).find("~save_path"), std::string::npos);
  EXPECT_NE(errorOf({{"camera_0/time_ofset", "1"}}).find("camera_0/time_offset"), std::string::npos);
  EXPECT_NE(errorOf({{"camera_1/time_offset", "1"}}).find("unknown parameter"), std::string::npos);  // one camera only
}

TEST(RosParams, RemovedNameSaysWhatIsDoneInstead) {
  EXPECT_NE(errorOf({{"tf_cache", "60"}}).find("tf_cache is gone"), std::string::npos);
  EXPECT_NE(errorOf({{"max_gain", "3"}}).find("max_gain is gone"), std::string::npos);
}

TEST(RosParams, BadValuesAreRefusedWithNameAndValue) {
  for (const auto& [name, text] : std::map<std::string, std::string>{{"voxel_size", "-1"},
                                                                     {"tf_wait", "soon"},
                                                                     {"num_cameras", "many"},
                                                                     {"num_cameras", "-1"},
                                                                     {"image_transport", "no transport"},
                                                                     {"camera_0/image_transport", "a/b"},
                                                                     {"colorize_after", "-3"},
                                                                     {"method", "magic"},
                                                                     {"camera_0/rectified", "perhaps"},
                                                                     {"queue_size", "1.5"},
                                                                     {"raw_image_format", "gif"}}) {
    const std::string error = errorOf({{name, text}});
    EXPECT_NE(error.find(name), std::string::npos) << name << ": " << error;
    EXPECT_NE(error.find(text), std::string::npos) << name << ": " << error;
  }
}

TEST(RosParams, NestedStructuresBecomePaths) {
  XmlRpc::XmlRpcValue value;
  value["camera_0"]["time_offset"] = 0.25;
  value["passes"] = 4;
  value["camera_0"]["rectified"] = true;
  const auto texts = flattenParams(value);
  EXPECT_EQ(texts.at("camera_0/time_offset"), "0.25");
  EXPECT_EQ(texts.at("passes"), "4");
  EXPECT_EQ(texts.at("camera_0/rectified"), "true");
  value["list"][0] = 1;
  EXPECT_THROW(flattenParams(value), std::invalid_argument);
  EXPECT_TRUE(flattenParams(XmlRpc::XmlRpcValue()).empty());
}

TEST(RosParams, DoublesSurviveTheServer) {
  for (const double number : {0.1, 1e-7, 123456.789012345, 1.0 / 3}) {
    XmlRpc::XmlRpcValue value;
    value["tf_wait"] = number;
    EXPECT_EQ(std::stod(flattenParams(value).at("tf_wait")), number);
  }
}

TEST(RosParams, NamesAreUnique) {
  std::set<std::string> names;
  for (const ParamText& row : describeAllParams(AllParams{})) EXPECT_TRUE(names.insert(row.name).second) << row.name;
}

TEST(DefaultYaml, EqualsTheDefaultsInTheCode) {
  const YAML::Node yaml = YAML::LoadFile("config/default.yaml");
  std::map<std::string, std::string> in_file;
  const std::function<void(const YAML::Node&, const std::string&)> flatten = [&](const YAML::Node& node,
                                                                                 const std::string& prefix) {
    for (const auto& entry : node) {
      const std::string name = prefix + entry.first.as<std::string>();
      if (entry.second.IsMap()) {
        flatten(entry.second, name + "/");
      } else {
        in_file[name] = entry.second.as<std::string>();
      }
    }
  };
  flatten(yaml, "");
  std::map<std::string, std::string> in_code;
  for (const ParamText& row : describeAllParams(AllParams{})) in_code[row.name] = row.value;
  EXPECT_EQ(in_file, in_code);
}

}  // namespace
}  // namespace cloud_colorizer
