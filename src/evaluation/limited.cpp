// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_colorizer/evaluation/limited.hpp"

#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <new>

#include "cloud_colorizer/check.hpp"

namespace cloud_colorizer {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMemoryExit = 77, kErrorExit = 78;

void limitMemory(double megabytes) {
  double pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const double bytes = pages * static_cast<double>(sysconf(_SC_PAGESIZE)) + megabytes * 1e6;
  rlimit limit{};
  limit.rlim_cur = limit.rlim_max = static_cast<rlim_t>(bytes);
  setrlimit(RLIMIT_AS, &limit);
}

void writeAll(int file, const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = write(file, bytes.data() + done, bytes.size() - done);
    if (count <= 0) return;
    done += static_cast<std::size_t>(count);
  }
}

[[noreturn]] void runChild(const std::function<std::string()>& body, const Limits& limits, int file) {
  int code = 0;
  try {
    limitMemory(limits.megabytes);
    writeAll(file, body());
  } catch (const std::bad_alloc&) {
    code = kMemoryExit;
  } catch (const std::exception& error) {
    writeAll(file, error.what());
    code = kErrorExit;
  }
  close(file);
  _exit(code);
}

/// Reads until the child closes the pipe; false when the time is over.
bool readUntil(int file, Clock::time_point deadline, std::string& bytes) {
  char buffer[65536];
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd waiting{file, POLLIN, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min<long>(left, 1000)));
    if (ready <= 0) continue;
    const ssize_t count = read(file, buffer, sizeof buffer);
    if (count == 0) return true;
    if (count > 0) bytes.append(buffer, static_cast<std::size_t>(count));
  }
}

std::string statusOf(int wait_status, bool in_time, const std::string& bytes) {
  if (!in_time) return "time limit";
  if (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0) return "ok";
  if (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == kMemoryExit) return "memory limit";
  if (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == kErrorExit) {
    return bytes.find("out of memory") != std::string::npos ? "memory limit" : bytes;
  }
  // Libraries that do not check an allocation crash at the limit.
  return "memory limit or crash (signal " + std::to_string(WIFSIGNALED(wait_status) ? WTERMSIG(wait_status) : 0) + ")";
}

}  // namespace

LimitedRun runLimited(const std::function<std::string()>& body, const Limits& limits) {
  requireInRange("time limit", limits.seconds, 0.001, 1e6);
  requireInRange("memory limit", limits.megabytes, 1.0, 1e7);
  int ends[2];
  require(pipe(ends) == 0, "cannot make a pipe: ", std::strerror(errno));
  const auto start = Clock::now();
  const pid_t child = fork();
  require(child >= 0, "cannot make a process: ", std::strerror(errno));
  if (child == 0) {
    close(ends[0]);
    runChild(body, limits, ends[1]);
  }
  close(ends[1]);
  LimitedRun run;
  const auto deadline =
      start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
  const bool in_time = readUntil(ends[0], deadline, run.bytes);
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int wait_status = 0;
  rusage usage{};
  wait4(child, &wait_status, 0, &usage);
  run.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  run.peak_megabytes = static_cast<double>(usage.ru_maxrss) / 1024;
  run.status = statusOf(wait_status, in_time, run.bytes);
  if (run.status != "ok") run.bytes.clear();
  return run;
}

}  // namespace cloud_colorizer
