// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/encoder_pool.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>

namespace cloud_colorizer {
namespace {

TEST(EncoderPool, EachFutureHasItsTasksResult) {
  EncoderPool<int> pool(3);
  std::vector<std::future<int>> futures;
  for (int i = 0; i < 100; ++i) futures.push_back(pool.run([i] { return i * i; }));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(futures[static_cast<std::size_t>(i)].get(), i * i);
}

TEST(EncoderPool, OneThreadKeepsTheOrder) {
  EncoderPool<int> pool(1);
  std::atomic<int> next{0};
  std::vector<std::future<int>> futures;
  for (int i = 0; i < 20; ++i) futures.push_back(pool.run([&next] { return next++; }));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(futures[static_cast<std::size_t>(i)].get(), i);
}

TEST(EncoderPool, ATasksErrorIsItsFuturesAndTheThreadGoesOn) {
  EncoderPool<int> pool(1);
  auto bad = pool.run([]() -> int { throw std::runtime_error("no luck"); });
  auto good = pool.run([] { return 7; });
  EXPECT_THROW(bad.get(), std::runtime_error);
  EXPECT_EQ(good.get(), 7);
}

TEST(EncoderPool, TasksRunSideBySide) {
  EncoderPool<int> pool(2);
  std::promise<void> first_runs, second_runs;
  auto first = pool.run([&] {
    first_runs.set_value();
    second_runs.get_future().wait();  // for ever, if there were one thread
    return 1;
  });
  auto second = pool.run([&] {
    first_runs.get_future().wait();
    second_runs.set_value();
    return 2;
  });
  EXPECT_EQ(first.get() + second.get(), 3);
}

TEST(EncoderPool, TheEndDropsWhatWaitsAndFinishesWhatRuns) {
  std::atomic<int> num_run{0};
  std::promise<void> runs;
  std::future<int> running, waiting;
  {
    EncoderPool<int> pool(1);
    running = pool.run([&] {
      runs.set_value();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return ++num_run;
    });
    runs.get_future().wait();
    waiting = pool.run([&] { return ++num_run; });
  }
  EXPECT_EQ(running.get(), 1);
  EXPECT_THROW(waiting.get(), std::future_error);
  EXPECT_EQ(num_run, 1);
}

}  // namespace
}  // namespace cloud_colorizer
