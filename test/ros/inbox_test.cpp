// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/inbox.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>
#include <vector>

#include "core/scratch.hpp"

namespace cloud_colorizer {
namespace {

using namespace std::chrono_literals;

/// Tasks want a collector; what they do to it is not looked at here.
class InboxTest : public testing::Test {
 protected:
  void run(const Inbox::Task& task) { task(collector_); }
  Inbox::Task append(int value) {
    return [this, value](Collector&) { values_.push_back(value); };
  }

  ScratchDirectory scratch_;
  Recorder recorder_{scratch_.path(), "map", RecordParams()};
  Collector collector_{recorder_, CollectorParams(), CollectorEvents()};
  Inbox inbox_;
  std::vector<int> values_;
};

TEST_F(InboxTest, TasksComeInTheirOrder) {
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(inbox_.push(i % 2 == 0 ? "even" : "odd", 5, append(i)));
  while (const auto task = inbox_.pop(0ms)) run(*task);
  EXPECT_EQ(values_, (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST_F(InboxTest, AFullStreamTakesNothingUntilOneIsTaken) {
  EXPECT_TRUE(inbox_.push("images", 2, append(0)));
  EXPECT_TRUE(inbox_.push("images", 2, append(1)));
  EXPECT_FALSE(inbox_.push("images", 2, append(2)));
  EXPECT_TRUE(inbox_.push("clouds", 2, append(3))) << "another stream has room";
  EXPECT_TRUE(inbox_.pop(0ms));
  EXPECT_TRUE(inbox_.push("images", 2, append(4)));
}

TEST_F(InboxTest, PopWaitsNoLongerThanAllowed) {
  EXPECT_FALSE(inbox_.pop(1ms));
  EXPECT_FALSE(inbox_.closed());
}

TEST_F(InboxTest, ClosedIsClosedOnlyWhenItIsEmpty) {
  inbox_.push("clouds", 1, append(0));
  inbox_.close();
  EXPECT_FALSE(inbox_.closed());
  EXPECT_TRUE(inbox_.pop(0ms));
  EXPECT_TRUE(inbox_.closed());
  EXPECT_FALSE(inbox_.pop(1h)) << "does not wait any more";
}

TEST_F(InboxTest, NothingIsLostBetweenThreads) {
  std::vector<std::thread> writers;
  for (int writer = 0; writer < 3; ++writer) {
    writers.emplace_back([this, writer] {
      for (int i = 0; i < 200; ++i) inbox_.push(std::to_string(writer), 1000, append(writer));
    });
  }
  std::thread reader([this] {
    while (!inbox_.closed()) {
      if (const auto task = inbox_.pop(10ms)) run(*task);
    }
  });
  for (std::thread& writer : writers) writer.join();
  inbox_.close();
  reader.join();
  EXPECT_EQ(values_.size(), 600U);
}

}  // namespace
}  // namespace cloud_colorizer
