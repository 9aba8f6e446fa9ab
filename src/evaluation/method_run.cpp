// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// One method on one test bed, in a process of its own where it may run into limits.
#include "evaluation/neighbors.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

bool isDelaunay(const std::string& method) {
  return method.rfind("DT", 0) == 0;
}

bool isGraph(const std::string& method) {
  return method.find("-NN") != std::string::npos || method.find("-pass") != std::string::npos || isDelaunay(method);
}

std::string pack(const MethodResult& result) {
  std::string bytes;
  const double numbers[] = {result.seconds, result.edges_per_point, result.unanchored_share, result.reprojection_error,
                            result.gain_error};
  appendBytes(bytes, numbers, 5);
  appendBytes(bytes, result.values.data(), static_cast<std::size_t>(result.values.size()));
  appendBytes(bytes, result.colored.data(), result.colored.size());
  return bytes;
}

MethodResult unpack(const std::string& bytes, Eigen::Index num_points) {
  MethodResult result;
  result.values.resize(3, num_points);
  result.colored.resize(static_cast<std::size_t>(num_points));
  std::size_t at = 0;
  for (double* number : {&result.seconds, &result.edges_per_point, &result.unanchored_share, &result.reprojection_error,
                         &result.gain_error}) {
    takeBytes(bytes, at, number, 1);
  }
  takeBytes(bytes, at, result.values.data(), static_cast<std::size_t>(result.values.size()));
  takeBytes(bytes, at, result.colored.data(), result.colored.size());
  return result;
}

}  // namespace

MethodRun runMethod(const TestBed& bed, const ObservedBed& observed, const std::string& method, const Params& params,
                    const Limits& limits) {
  MethodRun row;
  if (isDelaunay(method) && !hasDelaunay()) {
    row.status = "not built";
  } else if (isGraph(method)) {
    const LimitedRun run = runLimited([&] { return pack(colorizeArrays(bed, observed, method, params)); }, limits);
    row.status = run.status;
    row.result.seconds = run.seconds;
    if (run.status == "ok") row.result = unpack(run.bytes, bed.points.cols());
  } else {
    row.result = colorizeArrays(bed, observed, method, params);
  }
  return row;
}

}  // namespace cloud_colorizer
