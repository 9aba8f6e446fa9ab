// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Keeps what was used last, up to a number of bytes.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace cloud_colorizer {

/// Values that are costly to load, by number. Safe to use from several threads; loading happens outside the lock.
/// What is handed out stays valid after it has left the cache.
template <class Value>
class LruCache {
 public:
  using Pointer = std::shared_ptr<const Value>;

  LruCache(std::size_t max_bytes, std::function<Value(std::size_t)> load,
           std::function<std::size_t(const Value&)> bytes)
      : max_bytes_(max_bytes), load_(std::move(load)), bytes_(std::move(bytes)) {}

  Pointer get(std::size_t key) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto found = entries_.find(key);
      if (found != entries_.end()) {
        order_.splice(order_.begin(), order_, found->second.position);
        return found->second.value;
      }
    }
    auto value = std::make_shared<const Value>(load_(key));
    const std::lock_guard<std::mutex> lock(mutex_);
    if (entries_.count(key) == 0) insert(key, value);
    return value;
  }

 private:
  struct Entry {
    Pointer value;
    std::list<std::size_t>::iterator position;
  };

  void insert(std::size_t key, const Pointer& value) {
    order_.push_front(key);
    entries_[key] = {value, order_.begin()};
    used_bytes_ += bytes_(*value);
    while (used_bytes_ > max_bytes_ && order_.size() > 1) {
      const auto oldest = entries_.find(order_.back());
      used_bytes_ -= bytes_(*oldest->second.value);
      entries_.erase(oldest);
      order_.pop_back();
    }
  }

  std::size_t max_bytes_;
  std::function<Value(std::size_t)> load_;
  std::function<std::size_t(const Value&)> bytes_;
  std::mutex mutex_;
  std::list<std::size_t> order_;  ///< keys, the last used first
  std::unordered_map<std::size_t, Entry> entries_;
  std::size_t used_bytes_ = 0;
};

}  // namespace cloud_colorizer
