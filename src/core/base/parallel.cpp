// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {

int resolveNumThreads(int num_threads) {
  return num_threads > 0 ? num_threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallelFor(int num_threads, std::size_t count, const std::function<void(std::size_t)>& body) {
  const auto workers = std::min<std::size_t>(static_cast<std::size_t>(resolveNumThreads(num_threads)), count);
  if (workers <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  std::size_t failed_index = count;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (i < failed_index) {
          failed_index = i;
          failure = std::current_exception();
        }
        next = count;
      }
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(workers);
  try {
    while (threads.size() + 1 < workers) threads.emplace_back(work);
  } catch (const std::system_error&) {
    // The system has no more threads: those that there are do all.
  }
  work();
  for (auto& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

Callbacks takingTurns(const Callbacks& callbacks) {
  Callbacks result = callbacks;
  if (!callbacks.cancelled) return result;
  result.cancelled = [cancelled = callbacks.cancelled, mutex = std::make_shared<std::mutex>()] {
    const std::lock_guard<std::mutex> lock(*mutex);
    return cancelled();
  };
  return result;
}

void throwIfCancelled(const Callbacks& callbacks) {
  if (callbacks.cancelled && callbacks.cancelled()) throw Cancelled();
}

void Workers::forEach(std::size_t count, const std::function<void(std::size_t)>& body) const {
  parallelFor(num_threads, count, [&](std::size_t i) {
    throwIfCancelled(callbacks);
    body(i);
  });
}

}  // namespace cloud_colorizer
