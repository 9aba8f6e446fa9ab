// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Everything that defines a simulated drive.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cloud_colorizer/base/types.hpp"

namespace cloud_colorizer::simulation {

/// The initialisers are the preset `clean`.
struct Options {
  std::string preset = "clean";
  int seed = 1;     ///< of the street and of all noise
  int frames = 40;  ///< LiDAR scans, and images of each camera
  int cameras = 2;
  double rate = 10;         ///< Hz, frames a second
  double speed = 10;        ///< m/s
  int passes = 1;           ///< of the way, forth and back
  double stand = 0;         ///< s that the vehicle stands in the middle of its first pass
  bool moving_car = false;  ///< a car comes the other way
  double van_ahead = 0;     ///< m ahead, where a van drives as the vehicle does; 0: none
  int pedestrians = 0;
  int leaves = 0;  ///< of a tree; 0: closed crowns

  int width = 1280, height = 800;  ///< px
  bool pinhole = false;            ///< lenses without distortion
  double pixel_noise = 2;          ///< standard deviation, of 255
  double exposure = 0.12;          ///< largest deviation of the auto-exposure's gain from 1
  double white_balance = 0.03;     ///< largest deviation of a channel's gain of a camera
  double vignetting = 0;           ///< loss of brightness in the corner of the image, 0 to 1
  int jpeg_quality = 95;
  double readout = 0;                          ///< s from the first row of an image to the last
  std::string image_transport = "compressed";  ///< compressed (JPEG) or raw (rgb8)
  double gloss = 0;                            ///< exponent of the sheen of the wet road and the car bodies; 0: none
  bool quantities = false;                     ///< beside each image one of classes and one of temperatures

  int beams = 48;
  int azimuths = 1250;         ///< firings a revolution
  double lidar_range = 60;     ///< m
  double range_noise = 0.015;  ///< m, standard deviation
  bool skewed = false;         ///< points as they were measured; else as of the stamp of their scan
  double beam_divergence = 0;  ///< mrad, full angle; what lies in a beam is mixed

  double pose_noise_deg = 0.06;       ///< deg, standard deviation an axis, of the vehicle's pose
  double pose_noise_m = 0.008;        ///< m, the same of its position
  double drift = 0;                   ///< m, standard deviation an axis of the position's slow error
  double extrinsic_noise_deg = 0.12;  ///< deg an axis (root mean square), of each camera's extrinsics
  double extrinsic_noise_m = 0.006;   ///< m, the same of its position
  double time_offset = 0;             ///< s, by which the cameras' stamps are late

  double voxel_size = 0.05;  ///< m, of truth.ply

  /// Throws std::invalid_argument with name, value and range.
  void check() const;
};

struct Range {
  double low = 0, high = 0;
};

/// Calls f(name, field, range, help) for every option: the command line, scene.yaml, --help and check() know them from
/// here alone. What is no number has no range.
template <class Options_, class F>
void visitOptions(Options_& o, F&& f) {
  f("preset", o.preset, Range{},
    "vehicle: as a mapping vehicle's data are; cheap: as a small robot's are; clean: without drift, mixed beams, "
    "standing and traffic. Sets all others, which may follow");
  f("seed", o.seed, Range{0, 1000000000}, "of the street and of all noise");
  f("frames", o.frames, Range{1, 100000}, "LiDAR scans, and images of each camera");
  f("cameras", o.cameras, Range{1, 6},
    "1 to 6: plumb_bob left, rational_polynomial right, equidistant ahead, and so on");
  f("rate", o.rate, Range{1.0, 100.0}, "Hz, frames a second");
  f("speed", o.speed, Range{0.0, 50.0}, "m/s of the vehicle");
  f("passes", o.passes, Range{1, 100}, "of the way, forth and back");
  f("stand", o.stand, Range{0.0, 1000.0},
    "s that the vehicle stands in the middle of its first pass, a quarter of the drive at most");
  f("moving-car", o.moving_car, Range{}, "a car comes the other way");
  f("van-ahead", o.van_ahead, Range{0.0, 40.0}, "m ahead, where a van drives as the vehicle does; 0: none");
  f("pedestrians", o.pedestrians, Range{0, 100}, "on the pavements and across the street");
  f("leaves", o.leaves, Range{0, 2000}, "of a tree; 0: closed crowns");
  f("width", o.width, Range{16, 8192}, "px of the images");
  f("height", o.height, Range{16, 8192}, "px of the images");
  f("pinhole", o.pinhole, Range{}, "lenses without distortion");
  f("pixel-noise", o.pixel_noise, Range{0.0, 50.0}, "standard deviation of the noise of a pixel, of 255");
  f("exposure", o.exposure, Range{0.0, 0.75}, "largest deviation of the gain of the auto-exposure from 1");
  f("white-balance", o.white_balance, Range{0.0, 0.5}, "largest deviation of a channel's gain of a camera from 1");
  f("vignetting", o.vignetting, Range{0.0, 0.9}, "loss of brightness in the corner of the image, 0 to 1");
  f("jpeg-quality", o.jpeg_quality, Range{1, 100}, "1 to 100");
  f("readout", o.readout, Range{0.0, 0.1}, "s from the first row of an image to the last, of a rolling shutter");
  f("image-transport", o.image_transport, Range{}, "compressed or raw");
  f("gloss", o.gloss, Range{0.0, 1000.0},
    "exponent (Blinn, Phong) of the sheen of a low sun on the wet road and on cars: 8, 40 or 200, say; 0: all is "
    "matte");
  f("quantities", o.quantities, Range{}, "beside each image one of classes (labels) and one of temperatures (thermal)");
  f("beams", o.beams, Range{1, 256}, "of the LiDAR");
  f("azimuths", o.azimuths, Range{1, 10000}, "firings a revolution of the LiDAR");
  f("lidar-range", o.lidar_range, Range{1.0, 500.0}, "m, the farthest return");
  f("range-noise", o.range_noise, Range{0.0, 1.0}, "m, standard deviation of a range");
  f("skewed", o.skewed, Range{},
    "points are in the frame of the moment at which each was measured; else their motion is undone");
  f("beam-divergence", o.beam_divergence, Range{0.0, 20.0},
    "mrad, full angle: ranges scatter with slant, and mix at edges");
  f("pose-noise-deg", o.pose_noise_deg, Range{0.0, 10.0}, "deg, standard deviation of the vehicle's attitude an axis");
  f("pose-noise-m", o.pose_noise_m, Range{0.0, 1.0}, "m, standard deviation of the vehicle's position an axis");
  f("drift", o.drift, Range{0.0, 10.0}, "m, standard deviation of the slow error of the position an axis");
  f("extrinsic-noise-deg", o.extrinsic_noise_deg, Range{0.0, 10.0}, "deg, error of the extrinsics an axis");
  f("extrinsic-noise-m", o.extrinsic_noise_m, Range{0.0, 1.0}, "m, error of the extrinsics an axis");
  f("time-offset", o.time_offset, Range{-0.2, 0.2}, "s by which the stamps of the images are late");
  f("voxel-size", o.voxel_size, Range{0.0, 10.0}, "m, of truth.ply; 0 keeps every return");
}

/// clean, vehicle or cheap. Throws std::invalid_argument on another name.
Options presetOptions(const std::string& name);

/// Sets one option from text. Throws std::invalid_argument: unknown name, no number.
void setOption(Options& options, const std::string& name, const std::string& text);

std::vector<ParamText> describeOptions(const Options& options);

/// The options of a drive from its scene.yaml, so that its scene and truth can be built again.
/// Throws std::runtime_error with file and reason.
Options readSceneFile(const std::string& path);

}  // namespace cloud_colorizer::simulation
