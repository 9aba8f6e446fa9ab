// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "cloud_colorizer/alignment/gains.hpp"
#include "cloud_colorizer/alignment/intensity.hpp"
#include "cloud_colorizer/alignment/normal_equations.hpp"
#include "cloud_colorizer/alignment/poses.hpp"

namespace cloud_colorizer::alignment {
namespace {

constexpr float kMinScale = 1;          // grey levels: residuals below it are as good as none
constexpr double kEdgeMargin = 1.5;     // sigmas of the blur to keep away from depth edges
constexpr double kCellSigmas = 3.5;     // a square of this side is one independent observation
constexpr double kMinCell = 8;          // px
constexpr float kEvidenceShare = 0.3F;  // what images get wrong together (shading, geometry) is no noise
constexpr double kBlockSigmas = 10;     // side of the blocks that local means are taken in
constexpr double kBlocksAcross = 16;

using Matrix = Eigen::SparseMatrix<double>;

// The observations of one view, as they enter the equations.
class ViewSampler {
 public:
  ViewSampler(const PoseData& data, std::size_t view, const Twist& correction)
      : data_(data),
        camera_(data.input->cameras[data.input->views[view].camera]),
        camera_from_map_(correctedPose(data.input->views[view], correction).inverse()),
        translation_(correction.tail<3>()),
        image_(data.images->get(view)) {}

  struct Sample {
    float value = 0, weight = 0;
    Eigen::Matrix<float, 6, 1> jacobian = Eigen::Matrix<float, 6, 1>::Zero();
    Eigen::Vector2d pixel{0, 0};
  };

  Sample operator()(const Sighting& sighting) const {
    Sample sample;
    if (sighting.edge_distance < kEdgeMargin * data_.sigma) return sample;
    const Eigen::Vector3d local = camera_from_map_ * data_.input->points.col(sighting.point).cast<double>();
    const auto projected = camera_.linearize(local);
    if (!projected) return sample;
    const GreySample grey = sampleGrey(*image_, projected->pixel);
    if (!grey.valid) return sample;
    const Eigen::RowVector3d by_point = grey.gradient.cast<double>().transpose() * projected->jacobian;
    const Eigen::Vector3d lever = local - translation_;  // rotations turn about the uncorrected centre
    sample.value = grey.value;
    sample.weight = sighting.weight;
    sample.pixel = projected->pixel;
    sample.jacobian << lever.cross(by_point.transpose()).cast<float>(), by_point.transpose().cast<float>();
    return sample;
  }

 private:
  const PoseData& data_;
  const Camera& camera_;
  Eigen::Isometry3d camera_from_map_;
  Eigen::Vector3d translation_;
  std::shared_ptr<const BlurredImage> image_;
};

// Share of the observations that are independent: neighbours under one blur say the same.
class CellCounter {
 public:
  CellCounter(const Intrinsics& intrinsics, double sigma)
      : cell_(std::max(kMinCell, kCellSigmas * sigma)),
        columns_(static_cast<std::size_t>(intrinsics.width / cell_) + 1),
        used_(columns_ * (static_cast<std::size_t>(intrinsics.height / cell_) + 1), 0) {}
  void add(const Eigen::Vector2d& pixel) {
    ++count_;
    used_[static_cast<std::size_t>((pixel.y() + 0.5) / cell_) * columns_ +
          static_cast<std::size_t>((pixel.x() + 0.5) / cell_)] = 1;
  }
  float share() const {
    const auto cells = static_cast<float>(std::count(used_.begin(), used_.end(), 1));
    return count_ > 0 ? std::min(1.0F, cells / static_cast<float>(count_)) : 1.0F;
  }

 private:
  double cell_;
  std::size_t columns_;
  std::vector<std::uint8_t> used_;
  std::size_t count_ = 0;
};

// Number of the square block of the image that a pixel lies in.
std::uint32_t blockOf(const Eigen::Vector2d& pixel, double side, int width) {
  const auto columns = static_cast<std::uint32_t>(width / side) + 1;
  return static_cast<std::uint32_t>((pixel.y() + 0.5) / side) * columns +
         static_cast<std::uint32_t>((pixel.x() + 0.5) / side);
}

Samples sampleAll(const PoseData& data, const PoseState& state, int num_threads) {
  const Tracks& tracks = *data.tracks;
  const std::size_t count = tracks.numObservations();
  Samples samples;
  samples.blocks.assign(count, 0);
  Equations<6>& equations =
      samples.equations = {std::vector<float>(count, 0), std::vector<float>(count, 0),
                           std::vector<Eigen::Matrix<float, 6, 1>>(count, Eigen::Matrix<float, 6, 1>::Zero())};
  parallelFor(num_threads, tracks.numViews(), [&](std::size_t v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) return;
    const ViewSampler sampler(data, v, state.views[v]);
    const auto gain = static_cast<float>(std::exp((*data.log_gains)[static_cast<Eigen::Index>(v)]));
    const Intrinsics& intrinsics = data.input->cameras[data.input->views[v].camera].intrinsics();
    const double side = std::max(kBlockSigmas * data.sigma, intrinsics.width / kBlocksAcross);
    CellCounter cells(intrinsics, data.sigma);
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) {
      const auto sample = sampler(tracks.sightings[k]);
      if (!(sample.weight > 0)) continue;
      equations.values[k] = gain * sample.value;
      equations.weights[k] = sample.weight;
      equations.jacobians[k] = gain * sample.jacobian;
      samples.blocks[k] = blockOf(sample.pixel, side, intrinsics.width);
      cells.add(sample.pixel);
    }
    const float share = cells.share() * kEvidenceShare;
    for (std::uint32_t k = tracks.offsets[v]; k < tracks.offsets[v + 1]; ++k) equations.weights[k] *= share;
  });
  return samples;
}

// Residuals against `centres` of the observations whose point has another one; NaN for the others.
std::vector<float> residualsTo(const Tracks& tracks, const Equations<6>& equations, const std::vector<float>& centres) {
  std::vector<float> residuals(tracks.numObservations(), std::nanf(""));
  for (std::size_t p = 0; p < tracks.numPoints(); ++p) {
    int seen = 0;
    const std::uint32_t begin = tracks.point_offsets[p], end = tracks.point_offsets[p + 1];
    for (std::uint32_t i = begin; i < end; ++i) seen += equations.weights[tracks.by_point[i]] > 0;
    if (seen < 2) continue;
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t k = tracks.by_point[i];
      if (equations.weights[k] > 0) residuals[k] = equations.values[k] - centres[p];
    }
  }
  return residuals;
}

float medianMagnitude(const std::vector<float>& residuals) {
  std::vector<float> magnitudes;
  magnitudes.reserve(residuals.size());
  for (const float r : residuals) {
    if (!std::isnan(r)) magnitudes.push_back(std::abs(r));
  }
  return median(std::move(magnitudes));
}

struct Evaluation {
  Equations<6> equations;  // robust weights
  double cost = 0;         // mean a unit of weight, times the weight of the first evaluation; without priors
  double weight = 0;
  float scale = 0, residual = 0;  // grey levels
  IntensityTerm intensity;
};

// `like`: an evaluation whose scales are kept, so that the costs can be compared; a default one for none.
Evaluation evaluate(const PoseData& data, const PoseState& state, const Evaluation& like, int num_threads) {
  const Tracks& tracks = *data.tracks;
  const float scale = like.scale;
  const double weight = like.weight;
  Evaluation result;
  Samples samples = sampleAll(data, state, num_threads);
  if (data.ranks) result.intensity = intensityTerm(tracks, samples, *data.ranks, num_threads);
  Equations<6>& equations = result.equations = std::move(samples.equations);
  const std::vector<float> medians = pointMedians(tracks, equations.values, equations.weights);
  std::vector<float> residuals = residualsTo(tracks, equations, medians);
  result.residual = medianMagnitude(residuals);
  result.scale = scale > 0 ? scale : std::max(kMinScale, 1.4826F * result.residual);
  const std::vector<float> base = equations.weights;
  for (std::size_t k = 0; k < base.size(); ++k) {
    const bool shared = !std::isnan(residuals[k]);
    equations.weights[k] =
        shared ? base[k] * cauchyWeight(residuals[k], result.scale) / (result.scale * result.scale) : 0;
  }
  const Eigen::VectorXd means = pointMeans(tracks, equations);
  const double c = 2.385;
  double cost = 0;
  for (std::size_t k = 0; k < base.size(); ++k) {
    if (!(equations.weights[k] > 0)) continue;
    const double x = (equations.values[k] - means[tracks.sightings[k].point]) / (c * result.scale);
    cost += 0.5 * base[k] * c * c * std::log1p(x * x);
    result.weight += base[k];
  }
  if (result.weight > 0) result.cost = cost * (weight > 0 ? weight / result.weight : 1);
  result.cost += result.intensity.cost;
  return result;
}

// Unknowns: the views' corrections, then the cameras' with their time offsets.
class PriorTerms {
 public:
  PriorTerms(const std::vector<View>& views, const PosePriors& priors) : views_(views), priors_(priors) {}

  Eigen::Index size() const { return cameraBase(priors_.camera_sigmas.size()); }
  Eigen::Index cameraBase(std::size_t camera) const {
    return static_cast<Eigen::Index>(6 * views_.size() + 7 * camera);
  }

  Twist deviation(const PoseState& state, std::size_t v) const {
    const std::uint32_t c = views_[v].camera;
    return (state.views[v] - state.cameras[c] - state.time_offsets[c] * priors_.velocities[v])
        .cwiseQuotient(priors_.view_sigmas[v]);
  }

  double cost(const PoseState& state) const {
    double sum = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) sum += deviation(state, v).squaredNorm();
    for (std::size_t c = 0; c < state.cameras.size(); ++c) {
      sum += state.cameras[c].cwiseQuotient(priors_.camera_sigmas[c]).squaredNorm();
      sum += std::pow(state.time_offsets[c] / priors_.time_sigmas[c], 2);
    }
    return 0.5 * sum;
  }

  void addTo(const PoseState& state, std::vector<Eigen::Triplet<double>>& lower, Eigen::VectorXd& gradient) const {
    for (std::size_t v = 0; v < views_.size(); ++v) addView(state, v, lower, gradient);
    for (std::size_t c = 0; c < state.cameras.size(); ++c) {
      const auto base = static_cast<int>(cameraBase(c));
      for (int i = 0; i < 6; ++i) {
        const double s2 = std::pow(priors_.camera_sigmas[c][i], -2);
        lower.emplace_back(base + i, base + i, s2);
        gradient[base + i] += s2 * state.cameras[c][i];
      }
      const double s2 = std::pow(priors_.time_sigmas[c], -2);
      lower.emplace_back(base + 6, base + 6, s2);
      gradient[base + 6] += s2 * state.time_offsets[c];
    }
  }

 private:
  // Of (d - e - tau u)^2 / sigma^2 in each component: rows for d, e and tau.
  void addView(const PoseState& state, std::size_t v, std::vector<Eigen::Triplet<double>>& lower,
               Eigen::VectorXd& gradient) const {
    const auto d = static_cast<int>(6 * v), e = static_cast<int>(cameraBase(views_[v].camera)), tau = e + 6;
    const Twist deviation = this->deviation(state, v);
    for (int i = 0; i < 6; ++i) {
      const double s = 1 / priors_.view_sigmas[v][i], s2 = s * s, u = priors_.velocities[v][i];
      lower.emplace_back(d + i, d + i, s2);
      lower.emplace_back(e + i, d + i, -s2);
      lower.emplace_back(e + i, e + i, s2);
      lower.emplace_back(tau, d + i, -s2 * u);
      lower.emplace_back(tau, e + i, s2 * u);
      lower.emplace_back(tau, tau, s2 * u * u);
      gradient[d + i] += s * deviation[i];
      gradient[e + i] -= s * deviation[i];
      gradient[tau] -= s * u * deviation[i];
    }
  }

  const std::vector<View>& views_;
  const PosePriors& priors_;
};

struct System {
  Matrix lower;
  Eigen::VectorXd data_diagonal;  // of the data alone: damping must not act on stiff priors
  Eigen::VectorXd gradient;
};

System assembleSystem(const PoseData& data, const Evaluation& evaluation, const PriorTerms& terms,
                      const PoseState& state, int num_threads) {
  NormalEquations normal = assemble(*data.tracks, evaluation.equations, num_threads);
  System system;
  system.gradient = Eigen::VectorXd::Zero(terms.size());
  system.gradient.head(normal.gradient.size()) = normal.gradient;
  for (std::size_t v = 0; v < evaluation.intensity.gradients.size(); ++v) {
    const auto base = static_cast<int>(6 * v);
    system.gradient.segment<6>(base) += evaluation.intensity.gradients[v];
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c)
        normal.lower.emplace_back(base + r, base + c, evaluation.intensity.hessians[v](r, c));
    }
  }
  system.data_diagonal = Eigen::VectorXd::Zero(terms.size());
  for (const auto& entry : normal.lower) {
    if (entry.row() == entry.col()) system.data_diagonal[entry.row()] += entry.value();
  }
  terms.addTo(state, normal.lower, system.gradient);
  system.lower.resize(terms.size(), terms.size());
  system.lower.setFromTriplets(normal.lower.begin(), normal.lower.end());
  return system;
}

PoseState stepped(const PoseState& state, const Eigen::VectorXd& step, const PriorTerms& terms) {
  PoseState next = state;
  for (std::size_t v = 0; v < next.views.size(); ++v) {
    next.views[v] += step.segment<6>(static_cast<Eigen::Index>(6 * v));
  }
  for (std::size_t c = 0; c < next.cameras.size(); ++c) {
    next.cameras[c] += step.segment<6>(terms.cameraBase(c));
    next.time_offsets[c] += step[terms.cameraBase(c) + 6];
  }
  return next;
}

double largestStep(const Eigen::VectorXd& step, const PosePriors& priors) {
  double largest = 0;
  for (std::size_t v = 0; v < priors.view_sigmas.size(); ++v) {
    const Twist scaled = step.segment<6>(static_cast<Eigen::Index>(6 * v)).cwiseQuotient(priors.camera_sigmas[0]);
    largest = std::max(largest, scaled.cwiseAbs().maxCoeff());
  }
  return largest;
}

std::vector<double> timeStddevs(const System& system, const PriorTerms& terms, std::size_t num_cameras) {
  std::vector<double> stddevs;
  const Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factor(system.lower);
  for (std::size_t c = 0; c < num_cameras; ++c) {
    const Eigen::Index i = terms.cameraBase(c) + 6;
    const Eigen::VectorXd column = factor.solve(Eigen::VectorXd::Unit(terms.size(), i));
    stddevs.push_back(std::sqrt(std::max(0.0, column[i])));
  }
  return stddevs;
}

}  // namespace

PoseRounds refinePoses(const PoseData& data, const PosePriors& priors, int rounds, int num_threads, PoseState& state) {
  constexpr double kSmallStep = 0.004;  // of a prior's sigma
  const PriorTerms terms(data.input->views, priors);
  Evaluation current = evaluate(data, state, {}, num_threads);
  double cost = current.cost + terms.cost(state), damping = 1e-4;
  PoseRounds result;
  result.residual_first = current.residual;
  System system = assembleSystem(data, current, terms, state, num_threads);
  for (int round = 0; round < rounds; ++round) {
    Matrix damped = system.lower;
    for (Eigen::Index i = 0; i < damped.rows(); ++i) damped.coeffRef(i, i) += damping * system.data_diagonal[i];
    const Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factor(damped);
    const Eigen::VectorXd step = factor.solve(-system.gradient);
    if (factor.info() != Eigen::Success || !step.allFinite()) break;
    const PoseState next = stepped(state, step, terms);
    Evaluation trial = evaluate(data, next, current, num_threads);
    const double trial_cost = trial.cost + terms.cost(next);
    if (!(trial_cost < cost)) {
      damping = std::max(1e-2, 10 * damping);
      continue;
    }
    trial.weight = current.weight;
    current = std::move(trial);
    state = next;
    cost = trial_cost;
    damping /= 5;
    ++result.accepted;
    system = assembleSystem(data, current, terms, state, num_threads);
    if (largestStep(step, priors) < kSmallStep) break;
  }
  result.residual_last = current.residual;
  result.explained = current.intensity.explained;
  result.time_stddevs = timeStddevs(system, terms, priors.camera_sigmas.size());
  return result;
}

GreyValues greyValues(const PoseData& data, const PoseState& state, int num_threads) {
  Equations<6> equations = sampleAll(data, state, num_threads).equations;
  return {std::move(equations.values), std::move(equations.weights)};
}

StateCost stateCost(const PoseData& data, const PoseState& state, const StateCost& like, int num_threads) {
  Evaluation scales;
  scales.scale = like.scale;
  const Evaluation evaluation = evaluate(data, state, scales, num_threads);
  return {evaluation.weight > 0 ? evaluation.cost / evaluation.weight : 0, evaluation.scale};
}

double searchTimeOffset(const PoseData& data, const PosePriors& priors, const PoseState& state, int num_threads) {
  constexpr int kSteps = 12;  // to either side
  double fastest = 0, prior = 0;
  for (const Twist& velocity : priors.velocities) fastest = std::max(fastest, velocity.norm());
  for (const double sigma : priors.time_sigmas) prior = std::max(prior, sigma);
  if (!(fastest > 0)) return 0;
  const double step = 4 * prior / kSteps;
  StateCost like;
  const auto costAt = [&](double offset) {
    PoseState moved = state;
    for (std::size_t v = 0; v < moved.views.size(); ++v) moved.views[v] += offset * priors.velocities[v];
    const StateCost cost = stateCost(data, moved, like, num_threads);
    if (like.scale <= 0) like = cost;
    return cost.cost;
  };
  double best = 0, least = costAt(0);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double cost = i == 0 ? least : costAt(i * step);
    if (cost < least) {
      least = cost;
      best = i * step;
    }
  }
  return best;
}

}  // namespace cloud_colorizer::alignment
