// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/exposure.hpp"

#include <algorithm>
#include <cmath>

#include "alignment/gains.hpp"
#include "alignment/significance.hpp"
#include "alignment/vignetting.hpp"
#include "base/parallel.hpp"
#include "base/robust.hpp"

namespace cloud_colorizer::alignment {
namespace {

struct Channels {
  std::vector<SightValues> channels{3};  // a grey image counts three times
  std::vector<int> in_image;             // by view; 0 where it sees no point
};

Channels sampleChannels(const AlignmentInput& input, const Tracks& tracks, const PoseState& state, double sigma,
                        const Workers& workers) {
  Channels result;
  result.in_image.assign(tracks.numViews(), 0);
  std::vector<SightValues>& channels = result.channels;
  for (SightValues& channel : channels) {
    channel.values.assign(tracks.numObservations(), 0);
    channel.weights.assign(tracks.numObservations(), 0);
  }
  workers.forEach(tracks.numViews(), [&](std::size_t v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) return;
    const auto image = loadImage(input, v);
    const auto mask = loadMask(input, v);
    result.in_image[v] = image->channels();
    for (int c = 0; c < 3; ++c) {
      cv::Mat plane;
      cv::extractChannel(*image, plane, std::min(c, image->channels() - 1));
      const BlurredImage blurred = blurImage(plane, mask.get(), sigma);
      forEachSight(input, tracks, state, v, 1.5 * sigma, [&](auto k, const auto&, const auto& projected) {
        const GreySample sample = sampleGrey(blurred, projected.pixel);
        if (!sample.valid || !(sample.value > 1)) return;
        channels[static_cast<std::size_t>(c)].values[k] = sample.value;
        channels[static_cast<std::size_t>(c)].weights[k] = tracks.sights[k].weight;
      });
    }
  });
  return result;
}

// Undoes what the cameras' lenses darken, in all channels.
void brighten(const AlignmentInput& input, const Tracks& tracks, const PoseState& state,
              const std::vector<Exposure>& exposures, std::vector<SightValues>& channels, const Workers& workers) {
  workers.forEach(tracks.numViews(), [&](std::size_t v) {
    const Intrinsics& intrinsics = input.cameras[input.views[v].camera].intrinsics();
    const auto width = static_cast<float>(intrinsics.width), height = static_cast<float>(intrinsics.height);
    forEachSight(input, tracks, state, v, 0, [&](auto k, const auto&, const auto& projected) {
      const Eigen::Vector2f at = projected.pixel.template cast<float>();
      const float factor = exposures[v].brightening(at.x(), at.y(), width, height);
      for (SightValues& channel : channels) channel.values[k] *= factor;
    });
  });
}

// Leaves out gains that are no larger than what all images get wrong together. Each view is judged by itself as well:
// one gain that stands out stays, and does not keep the small ones of the others.
void shrinkGains(Eigen::VectorXd& log_gains) {
  constexpr double kSystematic = 0.005;
  const double size = std::sqrt(log_gains.squaredNorm() / std::max<double>(1, static_cast<double>(log_gains.size())));
  for (Eigen::Index v = 0; v < log_gains.size(); ++v) {
    log_gains[v] *= shrinkFactor(size, std::abs(log_gains[v]), kSystematic);
  }
}

}  // namespace

std::vector<Exposure> estimateExposures(const AlignmentInput& input, const Tracks& tracks, const PoseState& state,
                                        double sigma, bool with_vignetting, const Workers& workers) {
  std::vector<Exposure> exposures(tracks.numViews());
  for (Exposure& exposure : exposures) exposure.gain = Eigen::ArrayXf::Ones(3);
  Channels sampled = sampleChannels(input, tracks, state, sigma, workers);
  if (with_vignetting) {
    const SightValues& green = sampled.channels[1];
    const auto vignetting = estimateVignetting(input, tracks, state, green.values, green.weights, workers);
    for (std::size_t v = 0; v < exposures.size(); ++v) exposures[v].vignetting = vignetting[input.views[v].camera];
    brighten(input, tracks, state, exposures, sampled.channels, workers);
  }
  for (Eigen::Index c = 0; c < 3; ++c) {
    const SightValues& channel = sampled.channels[static_cast<std::size_t>(c)];
    Eigen::VectorXd gains = estimateLogGains(tracks, channel.values, channel.weights, kMaxGain, workers);
    shrinkGains(gains);
    for (std::size_t v = 0; v < exposures.size(); ++v) {
      exposures[v].gain[c] = static_cast<float>(std::exp(gains[static_cast<Eigen::Index>(v)]));
    }
  }
  for (std::size_t v = 0; v < exposures.size(); ++v) exposures[v].gain.conservativeResize(sampled.in_image[v]);
  return exposures;
}

std::vector<float> sharpnessWeights(const AlignmentInput& input, const Tracks& tracks, const PoseState& state,
                                    const std::vector<Exposure>& exposures, const Workers& workers) {
  constexpr double kSigma = 0.7;  // px: less would measure noise
  constexpr float kMinEdge = 4;   // grey levels a px: weaker gradients are noise
  SightValues channel{std::vector<float>(tracks.numObservations(), 0), std::vector<float>(tracks.numObservations(), 0)};
  workers.forEach(tracks.numViews(), [&](std::size_t v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) return;
    const auto mask = loadMask(input, v);
    const BlurredImage blurred = blurImage(*loadImage(input, v), mask.get(), kSigma);
    const float gain = exposures[v].gain.size() > 0 ? exposures[v].gain.mean() : 1.0F;
    forEachSight(input, tracks, state, v, 3 * kSigma, [&](auto k, const auto&, const auto& projected) {
      const GreySample sample = sampleGrey(blurred, projected.pixel);
      if (!sample.valid) return;
      channel.values[k] = std::max(0.1F, gain * sample.gradient.norm());
      channel.weights[k] = tracks.sights[k].weight;
    });
  });
  const std::vector<float> medians = pointMedians(tracks, channel.values, channel.weights);
  for (std::size_t k = 0; k < channel.weights.size(); ++k) {
    if (medians[tracks.sights[k].point] < kMinEdge) channel.weights[k] = 0;
  }
  const Eigen::VectorXd blur = estimateLogGains(tracks, channel.values, channel.weights, 10, workers);
  std::vector<float> weights(tracks.numViews(), 1);
  const float middle = median(std::vector<float>(blur.data(), blur.data() + blur.size()));
  for (std::size_t v = 0; v < weights.size(); ++v) {
    // Twice the blur: a quarter of the weight. Within 10 % of the median is as sharp as the others.
    const double excess = std::max(0.0, blur[static_cast<Eigen::Index>(v)] - middle - 0.1);
    weights[v] = static_cast<float>(std::clamp(std::exp(-2 * excess), 0.1, 1.0));
  }
  return weights;
}

}  // namespace cloud_colorizer::alignment
