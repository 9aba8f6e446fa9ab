// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/topic_monitor.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace cloud_colorizer {
namespace {

using Names = std::vector<std::string>;

TEST(TopicMonitor, SilenceIsToldOnceAndAgainAfterAMessage) {
  TopicMonitor monitor;
  monitor.watch("/points");
  monitor.watch("/image");
  EXPECT_EQ(monitor.newlySilent(std::chrono::seconds(3600)), Names());
  EXPECT_EQ(monitor.newlySilent(std::chrono::seconds(0)), (Names{"/image", "/points"}));
  EXPECT_EQ(monitor.newlySilent(std::chrono::seconds(0)), Names());
  monitor.count("/points");
  EXPECT_EQ(monitor.newlySilent(std::chrono::seconds(0)), Names{"/points"});
}

TEST(TopicMonitor, SilenceIsThatOfTheNewestMessage) {
  TopicMonitor monitor;
  monitor.watch("/points");
  EXPECT_LT(monitor.secondsOfSilence(), 0) << "no message has come";
  monitor.count("/points");
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_GE(monitor.secondsOfSilence(), 0.03);
  monitor.count("/image");
  EXPECT_LT(monitor.secondsOfSilence(), 0.03);
}

TEST(TopicMonitor, ReportCountsSinceTheLastReport) {
  TopicMonitor monitor;
  for (int i = 0; i < 3; ++i) monitor.count("/points");
  monitor.countDropped("/points");
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const auto first = monitor.report();
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].topic, "/points");
  EXPECT_EQ(first[0].messages, 3U);
  EXPECT_EQ(first[0].dropped, 1U);
  EXPECT_GT(first[0].rate, 0);
  EXPECT_LE(first[0].rate, 3 / 0.02);
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(monitor.report()[0].rate, 0);
}

TEST(TopicMonitor, CountsFromSeveralThreads) {
  TopicMonitor monitor;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&monitor] {
      for (int i = 0; i < 500; ++i) {
        monitor.count("/points");
        monitor.secondsOfSilence();
      }
    });
  }
  for (int i = 0; i < 50; ++i) monitor.report();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(monitor.report()[0].messages, 2000U);
}

}  // namespace
}  // namespace cloud_colorizer
