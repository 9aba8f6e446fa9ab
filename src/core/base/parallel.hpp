// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// One parallel loop. A body writes only at its own index, so the output is the same for any number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace cloud_colorizer {

/// Number of threads that a parameter value means: 0 is one for every core.
int resolveNumThreads(int num_threads);

/// Calls body(i) once for every i in [0, count), on up to `num_threads` threads (0: one a core).
/// The exception of the smallest failing index is rethrown after all threads have stopped.
void parallelFor(int num_threads, std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace cloud_colorizer
