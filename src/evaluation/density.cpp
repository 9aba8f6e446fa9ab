// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The paper's method against the 20 nearest neighbours by the number of points, where only the intensities are noisy.
#include <cmath>

#include "cloud_colorizer/base/check.hpp"
#include "evaluation/neighbors.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

/// AEP of a method; NaN where it ran into a limit.
double aepOf(const TestBed& bed, const ObservedBed& observed, const std::string& method, const TablesParams& params) {
  if (method.find("-NN") != std::string::npos && !hasNearestNeighbors()) return std::nan("");
  const LimitedRun run = runLimited(
      [&] {
        const MethodResult result = colorizeArrays(bed, observed, method, params.method);
        return formatNumber(scoreColors(bed.truth, result.values, result.colored).aep, 3);
      },
      params.density_limits);
  return run.status == "ok" ? std::stod(run.bytes) : std::nan("");
}

}  // namespace

Table makeDensity(const std::vector<Mesh>& meshes, const TablesParams& params, const Callbacks& callbacks) {
  Table table{{"mesh", "points", "mean", "4-pass", "20-NN", "4-pass_above_20-NN_percent"}, {}};
  for (const Mesh& mesh : meshes) {
    for (const std::size_t size : params.density_sizes) {
      if (callbacks.cancelled && callbacks.cancelled()) throw Cancelled();
      TestBedParams bed_params = params.bed;
      bed_params.num_points = size;
      NoiseParams noise = params.noise;
      noise.rotation = noise.centre = 0;
      const TestBed bed = addNoise(renderTestBed(mesh, bed_params), noise, bed_params.seed, bed_params.num_threads);
      const ObservedBed observed = observeBed(bed, bed.poses, {}, params.method);
      const double mean = aepOf(bed, observed, "mean", params), ours = aepOf(bed, observed, "4-pass", params),
                   other = aepOf(bed, observed, "20-NN", params);
      table.add({mesh.name, std::to_string(size), formatNumber(mean, 3), formatNumber(ours, 3), formatNumber(other, 3),
                 formatNumber(100 * (ours / other - 1), 1)});
      if (callbacks.progress) {
        callbacks.progress({"density", table.rows.size(), meshes.size() * params.density_sizes.size(), 0, -1});
      }
    }
  }
  return table;
}

}  // namespace cloud_colorizer
