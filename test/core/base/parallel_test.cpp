// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/parallel.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

TEST(ParallelFor, CallsEveryIndexOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> calls(1000, 0);
    parallelFor(threads, calls.size(), [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(1000, 1));
  }
  parallelFor(3, 0, [](std::size_t) { FAIL(); });
}

TEST(ParallelFor, TellsTheFailureOfTheSmallestIndex) {
  for (const int threads : {1, 4}) {
    try {
      parallelFor(threads, 100, [](std::size_t i) { throw std::runtime_error(std::to_string(i)); });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "0");
    }
  }
}

#ifdef __GLIBC__
TEST(ParallelFor, WithoutFurtherThreadsTheCallerDoesAll) {
  pthread_attr_t usual, huge;
  ASSERT_EQ(pthread_getattr_default_np(&usual), 0);
  ASSERT_EQ(pthread_attr_init(&huge), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&huge, std::size_t{1} << 46U), 0);  // no thread can have such a stack
  ASSERT_EQ(pthread_setattr_default_np(&huge), 0);
  std::vector<int> calls(1000, 0);
  EXPECT_NO_THROW(parallelFor(8, calls.size(), [&](std::size_t i) { ++calls[i]; }));
  EXPECT_EQ(calls, std::vector<int>(1000, 1));
  pthread_setattr_default_np(&usual);
  pthread_attr_destroy(&usual);
  pthread_attr_destroy(&huge);
}
#endif

TEST(Workers, StopBeforeTheNextUnit) {
  Callbacks callbacks;
  int asked = 0, done = 0;
  callbacks.cancelled = [&] { return ++asked > 5; };
  EXPECT_THROW(Workers(1, callbacks).forEach(100, [&](std::size_t) { ++done; }), Cancelled);
  EXPECT_EQ(done, 5);
}

TEST(Workers, AskOneAtATime) {
  Callbacks callbacks;
  std::atomic<int> inside{0}, most{0};
  callbacks.cancelled = [&] {
    most = std::max<int>(most, ++inside);
    std::this_thread::yield();
    --inside;
    return false;
  };
  Workers(4, callbacks).forEach(1000, [](std::size_t) {});
  EXPECT_EQ(most, 1);
}

}  // namespace
}  // namespace cloud_colorizer
