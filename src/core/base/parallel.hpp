// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// One parallel loop. A body writes only at its own index, so the output is the same for any number of threads.
#pragma once

#include <cstddef>
#include <functional>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer {

/// Number of threads that a parameter value means: 0 is one for every core.
int resolveNumThreads(int num_threads);

/// Calls body(i) once for every i in [0, count), on up to `num_threads` threads (0: one a core), the calling one
/// included; on fewer where the system starts no more.
/// The exception of the smallest failing index is rethrown after all threads have stopped.
void parallelFor(int num_threads, std::size_t count, const std::function<void(std::size_t)>& body);

/// The same callbacks, but `cancelled` may be asked by several threads: they take turns.
Callbacks takingTurns(const Callbacks& callbacks);

/// Throws Cancelled when the caller wants to stop.
void throwIfCancelled(const Callbacks& callbacks);

/// Threads that stop soon when the caller wants to.
struct Workers {
  int num_threads = 0;  ///< 0: one a core
  Callbacks callbacks;  ///< taking turns

  Workers(int threads, const Callbacks& caller) : num_threads(threads), callbacks(takingTurns(caller)) {}

  /// parallelFor() that asks before each call of the body whether to go on.
  void forEach(std::size_t count, const std::function<void(std::size_t)>& body) const;
};

}  // namespace cloud_colorizer
