// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/limited.hpp"

#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fstream>
#include <new>
#include <thread>

#include "base/stop_watch.hpp"
#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

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

/// Exit code of the child.
int writeResult(const std::function<std::string()>& body, const Limits& limits, int file) {
  try {
    limitMemory(limits.megabytes);
    writeAll(file, body());
    return 0;
  } catch (const std::bad_alloc&) {
    return kMemoryExit;
  } catch (const std::exception& error) {
    writeAll(file, error.what());
    return kErrorExit;
  }
}

/// In a thread of its own: OpenMP (in CHOLMOD) keeps a pool of threads for every thread that used it, and the forked
/// main thread would wait for ever for the pool that it had in the parent.
[[noreturn]] void runChild(const std::function<std::string()>& body, const Limits& limits, int file) {
  int code = kErrorExit;
  std::thread([&] { code = writeResult(body, limits, file); }).join();
  close(file);
  _exit(code);
}

double processorSeconds(pid_t process) {
  clockid_t clock;
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Reads until the child closes the pipe; false when its time is over.
bool readInTime(int file, pid_t child, double seconds, std::string& bytes) {
  constexpr double kWallFactor = 50;  // a child that waits for ever uses no processor
  constexpr int kLongestWait = 100;   // ms
  char buffer[65536];
  StopWatch watch;
  double wall = 0;
  while (true) {
    wall += watch.lap();
    if (processorSeconds(child) > seconds || wall > kWallFactor * seconds) return false;
    pollfd waiting{file, POLLIN, 0};
    const int ready = poll(&waiting, 1, kLongestWait);
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
  const pid_t child = fork();
  require(child >= 0, "cannot make a process: ", std::strerror(errno));
  if (child == 0) {
    close(ends[0]);
    runChild(body, limits, ends[1]);
  }
  close(ends[1]);
  LimitedRun run;
  const bool in_time = readInTime(ends[0], child, limits.seconds, run.bytes);
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int wait_status = 0;
  rusage usage{};
  wait4(child, &wait_status, 0, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  run.seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  run.peak_megabytes = static_cast<double>(usage.ru_maxrss) / 1024;
  run.status = statusOf(wait_status, in_time, run.bytes);
  if (run.status != "ok") run.bytes.clear();
  return run;
}

}  // namespace cloud_colorizer
