// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "alignment/exposure.hpp"

#include <algorithm>
#include <cmath>

#include "alignment/gains.hpp"
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
    const int step = smallStep(input.cameras[input.views[v].camera].intrinsics());
    result.in_image[v] = image->channels();
    for (int c = 0; c < 3; ++c) {
      cv::Mat plane;
      cv::extractChannel(*image, plane, std::min(c, image->channels() - 1));
      const BlurredImage blurred = blurImage(shrinkImage(plane, mask.get(), step), sigma * step);
      forEachSight(input, tracks, state, v, 1.5 * sigma * step, [&](auto k, const auto&, const auto& projected) {
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

// A channel of all views, with gains.
Showing shown(const Tracks& tracks, const SightValues& channel, const Eigen::VectorXd& log_gains) {
  Showing showing{channel.values, channel.weights, {}, {}};
  for (std::size_t k = 0; k < showing.values.size(); ++k) {
    showing.values[k] *= static_cast<float>(std::exp(log_gains[static_cast<Eigen::Index>(tracks.views[k])]));
  }
  return showing;
}

// Gains of each channel, by points that are not held back.
std::vector<Eigen::VectorXd> logGains(const Tracks& tracks, const Blocks& blocks,
                                      const std::vector<SightValues>& channels, const Workers& workers) {
  std::vector<Eigen::VectorXd> gains;
  for (const SightValues& channel : channels) {
    const std::vector<float> part = estimateWeights(tracks, blocks, channel.weights);
    gains.push_back(estimateLogGains(tracks, channel.values, part, kMaxGain, workers));
  }
  return gains;
}

// Leaves out what held-back points do not prove: all gains, or those of single views, in all channels at once. The
// channel that they change most decides.
void keepProven(const Tracks& tracks, const Blocks& blocks, const std::vector<SightValues>& channels,
                std::vector<Eigen::VectorXd>& gains, const Workers& workers) {
  const auto size = [](const Eigen::VectorXd& a) { return a.squaredNorm(); };
  const auto most = std::max_element(gains.begin(), gains.end(), [&](auto& a, auto& b) { return size(a) < size(b); });
  const SightValues& channel = channels[static_cast<std::size_t>(most - gains.begin())];
  const Showing before = shown(tracks, channel, Eigen::VectorXd::Zero(most->size())),
                after = shown(tracks, channel, *most);
  const bool any = evidence(tracks, blocks, before, after, Choice::ofAll(tracks.numViews())).isProven();
  std::vector<std::uint8_t> keeps(tracks.numViews(), 0);
  workers.forEach(keeps.size(), [&](std::size_t v) {
    keeps[v] = any && evidence(tracks, blocks, before, after, Choice::ofView(v, keeps.size())).isProven();
  });
  for (Eigen::VectorXd& channel_gains : gains) {
    for (std::size_t v = 0; v < keeps.size(); ++v) channel_gains[static_cast<Eigen::Index>(v)] *= keeps[v];
  }
}

// Of every camera; zero where held-back points do not prove it.
std::vector<Eigen::Array2f> provenVignetting(const AlignmentInput& input, const Tracks& tracks, const Blocks& blocks,
                                             const PoseState& state, const SightValues& channel,
                                             const Workers& workers) {
  const std::vector<float> part = estimateWeights(tracks, blocks, channel.weights);
  auto vignetting = estimateVignetting(input, tracks, state, channel.values, part, workers);
  std::vector<SightValues> channels = {channel};
  const Showing before = shown(tracks, channel, logGains(tracks, blocks, channels, workers)[0]);
  std::vector<Exposure> exposures(tracks.numViews());
  for (std::size_t v = 0; v < exposures.size(); ++v) exposures[v].vignetting = vignetting[input.views[v].camera];
  brighten(input, tracks, state, exposures, channels, workers);
  const Showing after = shown(tracks, channels[0], logGains(tracks, blocks, channels, workers)[0]);
  for (std::uint32_t c = 0; c < vignetting.size(); ++c) {
    if (!evidence(tracks, blocks, before, after, Choice::ofCamera(c, input.views)).isProven()) vignetting[c] = 0;
  }
  return vignetting;
}

}  // namespace

std::vector<Exposure> estimateExposures(const AlignmentInput& input, const Tracks& tracks, const Blocks& blocks,
                                        const PoseState& state, double sigma, bool with_vignetting,
                                        const Workers& workers) {
  std::vector<Exposure> exposures(tracks.numViews());
  for (Exposure& exposure : exposures) exposure.gain = Eigen::ArrayXf::Ones(3);
  Channels sampled = sampleChannels(input, tracks, state, sigma, workers);
  if (with_vignetting) {
    const auto vignetting = provenVignetting(input, tracks, blocks, state, sampled.channels[1], workers);
    for (std::size_t v = 0; v < exposures.size(); ++v) exposures[v].vignetting = vignetting[input.views[v].camera];
    brighten(input, tracks, state, exposures, sampled.channels, workers);
  }
  std::vector<Eigen::VectorXd> gains = logGains(tracks, blocks, sampled.channels, workers);
  keepProven(tracks, blocks, sampled.channels, gains, workers);
  for (std::size_t v = 0; v < exposures.size(); ++v) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      exposures[v].gain[c] =
          static_cast<float>(std::exp(gains[static_cast<std::size_t>(c)][static_cast<Eigen::Index>(v)]));
    }
    exposures[v].gain.conservativeResize(sampled.in_image[v]);
  }
  return exposures;
}

std::vector<float> sharpnessWeights(const AlignmentInput& input, const Tracks& tracks, const PoseState& state,
                                    const std::vector<Exposure>& exposures, const SmallImages& small,
                                    const Workers& workers) {
  constexpr double kSigma = 0.7;  // px of the small images: less would measure noise
  constexpr float kMinEdge = 4;   // grey levels from one of their px to the next: weaker gradients are noise
  const BlurredImages images(input, small, kSigma);
  SightValues channel{std::vector<float>(tracks.numObservations(), 0), std::vector<float>(tracks.numObservations(), 0)};
  workers.forEach(tracks.numViews(), [&](std::size_t v) {
    if (tracks.offsets[v] == tracks.offsets[v + 1]) return;
    const auto image = images.get(v);
    const int step = smallStep(input.cameras[input.views[v].camera].intrinsics());
    const float gain = exposures[v].gain.size() > 0 ? exposures[v].gain.mean() : 1.0F;
    forEachSight(input, tracks, state, v, 3 * images.sigma(v), [&](auto k, const auto&, const auto& projected) {
      const GreySample sample = sampleGrey(*image, projected.pixel);
      if (!sample.valid) return;
      channel.values[k] = std::max(0.1F, gain * static_cast<float>(step) * sample.gradient.norm());
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
