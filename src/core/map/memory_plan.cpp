// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "map/memory_plan.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "base/parallel.hpp"

namespace cloud_colorizer {
namespace {

/// Bytes of the machine, or of the container where that has fewer.
double memoryOfMachine() {
  double bytes = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  for (const char* path : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::ifstream file(path);
    double limit = 0;
    if (file >> limit && limit > 0) bytes = std::min(bytes, limit);
  }
  return bytes;
}

/// 0: half of the memory that there is, at most 4 GB.
double limitOf(double memory_limit_mb) {
  return memory_limit_mb > 0 ? memory_limit_mb * 1e6 : std::min(4e9, std::max(1e8, memoryOfMachine() / 2));
}

}  // namespace

double MemoryPlan::peakMegabytes() {
  constexpr double kKilobytes = 1024;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / kKilobytes;
}

MemoryPlan::MemoryPlan(const Params& params)
    : limit_(limitOf(params.colorize.memory_limit)),
      usual_chunks_(chunkBytes(params.chunks.maxPointsWithHalo()) *
                    static_cast<double>(resolveNumThreads(params.colorize.num_threads))),
      aligns_(params.aligns()) {}

std::size_t MemoryPlan::chunks() const {
  return std::min(share(0.53), static_cast<std::size_t>(usual_chunks_));
}

}  // namespace cloud_colorizer
