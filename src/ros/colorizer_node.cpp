// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include <ros/ros.h>
#include <signal.h>

#include <iostream>
#include <string>

#include "ros/node.hpp"

namespace {

volatile sig_atomic_t stop_requests = 0;

void countRequest(int) {
  stop_requests = stop_requests + 1;
}

}  // namespace

/// The first SIGINT or SIGTERM stops recording (and colours and saves, with ~save_path); the second gives up on that.
/// roslaunch sends SIGTERM 15 s after SIGINT and SIGKILL 2 s later: for a large map start it with --sigint-timeout.
/// `colorizer_node --defaults` prints all parameters and needs no roscore.
int main(int argc, char** argv) {
  if (argc == 2 && (std::string(argv[1]) == "--defaults" || std::string(argv[1]) == "--help")) {
    std::cout << cloud_colorizer::defaultsAsYaml();
    return 0;
  }
  ros::init(argc, argv, "colorizer_node", ros::init_options::NoSigintHandler);
  signal(SIGINT, countRequest);
  signal(SIGTERM, countRequest);
  ros::NodeHandle node, private_node("~");  // outside: the console is silent after the last handle is gone
  try {
    cloud_colorizer::ColorizerNode colorizer(node, private_node, cloud_colorizer::loadParams());
    while (ros::ok() && stop_requests == 0) ros::WallDuration(0.05).sleep();
    const int seen = stop_requests;
    const bool good = colorizer.finish([seen] { return stop_requests > seen; });
    ros::shutdown();
    return good ? 0 : 1;
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    ros::shutdown();
    return 1;
  }
}
