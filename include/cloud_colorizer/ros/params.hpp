// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Parameters from the parameter server: the method's (Params) and those that only a ROS program has (NodeParams).
#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include <map>
#include <string>
#include <vector>

#include "cloud_colorizer/map/params.hpp"
#include "cloud_colorizer/ros/collector.hpp"

namespace cloud_colorizer {

/// What the node has beside the collector and the method.
struct NodeParams {
  CollectorParams collector;
  std::string recording_dir;            ///< empty: a new one below $ROS_HOME/cloud_colorizer
  std::string save_path;                ///< empty: nothing is saved on shutdown
  std::string save_dir;                 ///< below which ~save_map may write; empty: the recording's parent directory
  bool report = false;                  ///< beside every map that is saved, map_report/report.html
  std::string image_transport = "raw";  ///< raw, compressed, or another with a plugin for image_transport
  std::vector<std::string> camera_transports = std::vector<std::string>(1);  ///< by camera; empty: image_transport
  double colorize_after = 0;           ///< s without any message after which the map is coloured; 0: never
  int queue_size = 40;                 ///< messages of a topic that wait to be recorded
  double preview_period = 1;           ///< s between two previews while recording; 0: no preview
  int max_published_points = 5000000;  ///< of colored_map; beyond it every k-th point is published

  void check() const;  ///< throws std::invalid_argument with name, value and what is allowed
};

/// Calls f(name, field, help) for every parameter of collecting. `camera_<i>/...` exist for each of `p.cameras`.
template <class CollectorParamsT, class F>
void visitCollectorParams(CollectorParamsT& p, F&& f) {
  f("map_frame", p.map_frame, "frame in which the map is built");
  f("sensor_frame", p.sensor_frame, "frame from which ranges are measured; empty: that of the cloud");
  f("tf_wait", p.tf_wait, "s of message time that a cloud or an image waits for its transform");
  f("tf_max_gap", p.tf_max_gap, "s between two transforms of a frame that moves, which may be interpolated; 0: any");
  f("cloud_time_offset", p.cloud_time_offset, "s added to the cloud stamps");
  f("deskew", p.deskew,
    "auto, on or off: undo the motion during a cloud by the times of its points; auto: where the map gets thinner");
  f("raw_image_format", p.raw_image_format,
    "ppm (fast), png (half the size, slow) or jpg (small, lossy): how raw images are kept");
  f("encode_threads", p.encode_threads, "threads that encode raw images");
  f("max_image_size", p.max_image_size, "Mpx; larger images are refused, as damaged messages claim any size");
  for (std::size_t i = 0; i < p.cameras.size(); ++i) {
    const std::string prefix = "camera_" + std::to_string(i) + "/";
    auto& camera = p.cameras[i];
    f((prefix + "time_offset").c_str(), camera.time_offset, "s added to the image stamps");
    f((prefix + "mask").c_str(), camera.mask, "image file, black where the camera must not colour");
    f((prefix + "masks").c_str(), camera.masks,
      "true: every image gets a mask of its own, from the topic camera_<i>/mask; without it, it is not recorded");
    f((prefix + "model").c_str(), camera.model,
      "camera_info, or equirectangular: images of all directions, without a camera_info");
    f((prefix + "rectified").c_str(), camera.rectified, "true for rectified images: P is used, without distortion");
    f((prefix + "readout_time").c_str(), camera.readout_time,
      "s from the first row of an image, at its stamp, to its last: of a rolling shutter");
    f((prefix + "bits").c_str(), camera.bits,
      "that the camera fills of 16 bits a channel; 0: as the first image tells");
    f((prefix + "kind").c_str(), camera.kind,
      "color, radiometric (a temperature, say), labels (the class of each pixel) or logits (a score of each class)");
    f((prefix + "quantity").c_str(), camera.quantity,
      "field of the map that other kinds than color give; empty: temperature or label");
    f((prefix + "scale").c_str(), camera.scale, "radiometric: value = scale * number + offset");
    f((prefix + "offset").c_str(), camera.offset, "likewise");
    f((prefix + "names").c_str(), camera.names,
      "labels, logits: a file that tells what the classes are, kept beside the map");
  }
}

/// The same for the node.
template <class NodeParamsT, class F>
void visitNodeParams(NodeParamsT& p, F&& f) {
  f("recording_dir", p.recording_dir, "directory of the recording; empty: a new one below ~/.ros/cloud_colorizer");
  f("save_path", p.save_path, ".ply, .pcd or .las; the map is coloured and saved there on shutdown");
  f("save_dir", p.save_dir, "directory that holds what ~save_map may write; empty: the one around the recording");
  f("report", p.report, "true: beside every map that is saved, say drive.ply, drive_report/report.html");
  f("image_transport", p.image_transport,
    "raw, compressed (files kept as received), or another one that image_transport has a plugin for");
  f("colorize_after", p.colorize_after, "s without a message after which the map is coloured; 0: never");
  f("queue_size", p.queue_size, "messages of a topic that may wait to be recorded");
  f("preview_period", p.preview_period, "s between previews while recording; 0: none");
  f("max_published_points", p.max_published_points, "points of colored_map; of a larger map every k-th is published");
  visitCollectorParams(p.collector, f);
  for (std::size_t i = 0; i < p.camera_transports.size(); ++i) {
    const std::string name = "camera_" + std::to_string(i) + "/image_transport";
    f(name.c_str(), p.camera_transports[i], "transport of this camera; empty: as image_transport");
  }
}

/// Sets those of `texts` that are parameters of collecting, and removes them from it.
void takeCollectorParams(std::map<std::string, std::string>& texts, CollectorParams& params);
std::vector<ParamText> describeCollectorParams(const CollectorParams& params);

/// All that the node is told by parameters.
struct AllParams {
  Params core;
  NodeParams node;
};

/// From name -> text. `num_cameras` gives the number of cameras (default 1). Throws std::invalid_argument: an unknown
/// name (with the nearest known ones), no value of the type, a value out of range.
AllParams paramsFromText(const std::map<std::string, std::string>& texts);

/// (name, value, help) of every parameter: num_cameras, the node's, the method's.
std::vector<ParamText> describeAllParams(const AllParams& params);

/// The defaults as a file for rosparam, with the help as comments: config/default.yaml.
std::string defaultsAsYaml();

/// A value of the parameter server as name -> text, names of nested structures joined by '/'.
/// Throws std::invalid_argument for lists and binary values.
std::map<std::string, std::string> flattenParams(const XmlRpc::XmlRpcValue& value);

/// Reads the private parameters of this node and logs each at start.
AllParams loadParams();

}  // namespace cloud_colorizer
