// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Keeps what was used last, up to a number of bytes.
#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace cloud_colorizer {

/// Values that are costly to load, by number. Safe to use from several threads; loading happens outside the lock, once
/// a key: who asks for what another thread is loading waits for it. A failure is told to all who wait, and forgotten.
/// What is handed out stays valid after it has left the cache.
template <class Value>
class LruCache {
 public:
  using Pointer = std::shared_ptr<const Value>;

  LruCache(std::size_t max_bytes, std::function<Value(std::size_t)> load,
           std::function<std::size_t(const Value&)> bytes)
      : max_bytes_(max_bytes), load_(std::move(load)), bytes_(std::move(bytes)) {}

  Pointer get(std::size_t key) {
    std::promise<Pointer> promise;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      const auto [entry, is_new] = entries_.try_emplace(key);
      if (!is_new) {
        if (entry->second.loaded) order_.splice(order_.begin(), order_, entry->second.position);
        const std::shared_future<Pointer> value = entry->second.value;
        lock.unlock();
        return value.get();
      }
      entry->second.value = promise.get_future().share();
    }
    try {
      auto value = std::make_shared<const Value>(load_(key));
      keep(key, bytes_(*value));
      promise.set_value(value);
      return value;
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      entries_.erase(key);
      promise.set_exception(std::current_exception());
      throw;
    }
  }

 private:
  struct Entry {
    std::shared_future<Pointer> value;
    bool loaded = false;  ///< only then it has the rest, and may be dropped
    std::size_t bytes = 0;
    std::list<std::size_t>::iterator position;
  };

  void keep(std::size_t key, std::size_t bytes) {
    const std::lock_guard<std::mutex> lock(mutex_);
    order_.push_front(key);
    Entry& entry = entries_.at(key);
    entry.loaded = true;
    entry.bytes = bytes;
    entry.position = order_.begin();
    used_bytes_ += bytes;
    while (used_bytes_ > max_bytes_ && order_.size() > 1) {
      const auto oldest = entries_.find(order_.back());
      used_bytes_ -= oldest->second.bytes;
      entries_.erase(oldest);
      order_.pop_back();
    }
  }

  std::size_t max_bytes_;
  std::function<Value(std::size_t)> load_;
  std::function<std::size_t(const Value&)> bytes_;
  std::mutex mutex_;
  std::list<std::size_t> order_;  ///< keys of what is loaded, the last used first
  std::unordered_map<std::size_t, Entry> entries_;
  std::size_t used_bytes_ = 0;
};

}  // namespace cloud_colorizer
