// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The paper's method against the 20 nearest neighbours by the number of points, where only the intensities are noisy.
#include <cmath>

#include "base/progress.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

/// AEP of a method, to the digits that it is told with; NaN where it ran into a limit.
double aepOf(const TestBed& bed, const ObservedBed& observed, const std::string& method, const TablesParams& params) {
  const MethodRun run = runMethod(bed, observed, method, params.method, params.density_limits);
  if (run.status != "ok") return std::nan("");
  return std::stod(formatNumber(scoreColors(bed.truth, run.result.values, run.result.colored).aep, 3));
}

}  // namespace

ResultTable makeDensity(const std::vector<Mesh>& meshes, const TablesParams& params, const Callbacks& callbacks) {
  ResultTable table{{"mesh", "points", "mean", "4-pass", "20-NN", "4-pass_above_20-NN_percent"}, {}};
  ProgressMeter meter(callbacks, "density", meshes.size() * params.density_sizes.size());
  for (const Mesh& mesh : meshes) {
    for (const std::size_t size : params.density_sizes) {
      TestBedParams bed_params = params.bed;
      bed_params.num_points = size;
      const TestBed bed = noisyBed(mesh, bed_params, params.noise.onlyIntensities());
      const ObservedBed observed = observeBed(bed, bed.poses, {}, params.method);
      const double mean = aepOf(bed, observed, "mean", params), ours = aepOf(bed, observed, "4-pass", params),
                   other = aepOf(bed, observed, "20-NN", params);
      table.add({mesh.name, std::to_string(size), formatNumber(mean, 3), formatNumber(ours, 3), formatNumber(other, 3),
                 formatNumber(100 * (ours / other - 1), 1)});
      meter.add(1, false);
    }
  }
  return table;
}

}  // namespace cloud_colorizer
