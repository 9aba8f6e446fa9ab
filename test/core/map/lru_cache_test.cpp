// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/lru_cache.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace cloud_colorizer {
namespace {

/// A cache of 10 bytes whose value of a key is the key and takes one byte; counts the loads.
struct Counted {
  std::vector<int> num_loads = std::vector<int>(100, 0);
  LruCache<std::size_t> cache{10,
                              [this](std::size_t key) {
                                ++num_loads[key];
                                return key;
                              },
                              [](const std::size_t&) { return std::size_t{1}; }};
};

TEST(LruCache, LoadsOnceWhatFits) {
  Counted counted;
  for (int round = 0; round < 3; ++round) {
    for (std::size_t key = 0; key < 10; ++key) EXPECT_EQ(*counted.cache.get(key), key);
  }
  for (std::size_t key = 0; key < 10; ++key) EXPECT_EQ(counted.num_loads[key], 1);
}

TEST(LruCache, DropsWhatWasUsedLongestAgo) {
  Counted counted;
  for (std::size_t key = 0; key < 10; ++key) counted.cache.get(key);
  counted.cache.get(0);
  counted.cache.get(10);  // drops 1
  counted.cache.get(0);
  EXPECT_EQ(counted.num_loads[0], 1);
  counted.cache.get(1);
  EXPECT_EQ(counted.num_loads[1], 2);
}

TEST(LruCache, WhatIsLargerThanAllStaysUntilTheNext) {
  LruCache<int> cache(
      10, [](std::size_t key) { return static_cast<int>(key); }, [](const int&) { return std::size_t{100}; });
  const auto first = cache.get(1);
  EXPECT_EQ(cache.get(1), first);
  cache.get(2);
  EXPECT_EQ(*first, 1);  // still valid
  EXPECT_NE(cache.get(1), first);
}

TEST(LruCache, TwoThreadsThatMissLoadOnce) {
  std::atomic<int> num_loads{0}, num_waiting{0};
  LruCache<int> cache(
      10,
      [&](std::size_t key) {
        ++num_loads;
        while (num_waiting < 4) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return static_cast<int>(key);
      },
      [](const int&) { return std::size_t{1}; });
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      ++num_waiting;
      EXPECT_EQ(*cache.get(7), 7);
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(num_loads, 1);
}

TEST(LruCache, AFailureIsToldAndNotKept) {
  bool fails = true;
  LruCache<int> cache(
      10,
      [&](std::size_t) {
        if (fails) throw std::runtime_error("disk");
        return 3;
      },
      [](const int&) { return std::size_t{1}; });
  EXPECT_THROW(cache.get(0), std::runtime_error);
  EXPECT_THROW(cache.get(0), std::runtime_error);
  fails = false;
  EXPECT_EQ(*cache.get(0), 3);
}

TEST(LruCache, ManyThreadsGetTheRightValuesInLittleRoom) {
  LruCache<std::size_t> cache(
      5, [](std::size_t key) { return 3 * key; }, [](const std::size_t&) { return std::size_t{1}; });
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < 5000; ++i) {
        const std::size_t key = (i * (t + 7)) % 13;
        EXPECT_EQ(*cache.get(key), 3 * key);
      }
    });
  }
  for (auto& thread : threads) thread.join();
}

}  // namespace
}  // namespace cloud_colorizer
