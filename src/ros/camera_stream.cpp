// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/camera_stream.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <utility>

#include "camera/pixels.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/ros/conversions.hpp"

namespace cloud_colorizer {
namespace {

using Invalid = std::invalid_argument;

constexpr std::size_t kMaxMasks = 2000;  // that wait for their image; a guard for images that do not come

bool sameCamera(const sensor_msgs::CameraInfo& a, const sensor_msgs::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.distortion_model == b.distortion_model && a.D == b.D &&
         a.K == b.K && a.P == b.P && a.header.frame_id == b.header.frame_id && a.binning_x == b.binning_x &&
         a.binning_y == b.binning_y && a.roi == b.roi;
}

cv::Mat1b readMask(const std::string& file) {
  if (file.empty()) return {};
  cv::Mat mask = cv::imread(file, cv::IMREAD_GRAYSCALE);
  require(!mask.empty(), "the mask ", file, " cannot be read as an image");
  return mask;
}

/// Throws Refused.
cv::Mat decode(const ImageMessage& image) {
  try {
    return image.raw ? imageFromMessage(*image.raw) : imageFromMessage(*image.compressed);
  } catch (const Invalid& error) {
    throw Refused{Outcome::kUndecodable, error.what()};
  }
}

/// Size of the image; throws Refused when it cannot be decoded.
cv::Size inspectSize(const ImageMessage& image, ImageKind kind, PendingView& view) {
  try {
    view.kind = kind;
    if (image.raw) {
      checkImage(*image.raw, kind);
      return {static_cast<int>(image.raw->width), static_cast<int>(image.raw->height)};
    }
    const EncodedInfo info = inspectCompressed(*image.compressed, kind);
    view.extension = info.extension;
    view.is_decoded = kind == ImageKind::kColor && (info.is_mosaic || info.depth == 16);
    return info.size;
  } catch (const Invalid& error) {
    throw Refused{Outcome::kUndecodable, error.what()};
  }
}

}  // namespace

CameraStream::CameraStream(const CameraParams& params, std::size_t number)
    : params_(params), name_("camera_" + std::to_string(number)), mask_(readMask(params.mask)) {}

std::string CameraStream::frameOf(const ImageMessage& image) const {
  std::string frame = withoutSlash(image.header.frame_id);
  if (frame.empty() && info_) frame = withoutSlash(info_->header.frame_id);
  if (frame.empty()) throw Refused{Outcome::kMalformed, "neither the image nor its camera_info has a frame_id"};
  return frame;
}

void CameraStream::takeInfo(const sensor_msgs::CameraInfoConstPtr& message, double max_image_size, Recorder& into,
                            const Say& say) {
  if (info_ && sameCamera(*info_, *message)) return;
  info_ = message;
  if (params_.isPanorama()) return;  // only its frame counts
  readInfo(into, max_image_size, say);
}

void CameraStream::enter(Recorder& into, double max_image_size, const Say& say) {
  last_kept_.reset();
  resumed_at_.reset();
  faces_.clear();
  if (info_ && !params_.isPanorama()) readInfo(into, max_image_size, say);
}

void CameraStream::readInfo(Recorder& into, double max_image_size, const Say& say) {
  id_.reset();
  info_error_.outcome = Outcome::kBadCameraInfo;
  try {
    const CameraFromInfo result = cameraFromMessage(*info_, params_.rectified);
    if (!result.warning.empty()) say(LogLevel::kWarning, "info", result.warning);
    intrinsics_ = result.intrinsics;
    baseline_ = result.baseline;
    checkSize(max_image_size);
  } catch (const Invalid& error) {
    info_error_.reason = error.what();
    return;
  }
  id_ = into.setCamera(name_, intrinsics_, params_.toldQuantity());
  if (!mask_.empty()) into.setMask(*id_, mask_);
}

/// Throws std::invalid_argument; then info_error_ has the outcome.
void CameraStream::checkSize(double max_image_size) {
  const double size = 1e-6 * intrinsics_.width * intrinsics_.height;
  if (size > max_image_size) info_error_.outcome = Outcome::kTooLarge;
  require<Invalid>(size <= max_image_size, params_.isPanorama() ? "" : "camera_info: ", "an image of ",
                   intrinsics_.width, " x ", intrinsics_.height,
                   " px is larger than ~max_image_size = ", max_image_size,
                   " Mpx; raise it if the camera has so many pixels");
  require<Invalid>(mask_.empty() || mask_.size() == cv::Size(intrinsics_.width, intrinsics_.height), "the mask ",
                   params_.mask, " is ", mask_.cols, " x ", mask_.rows, ", but the images are ", intrinsics_.width,
                   " x ", intrinsics_.height);
}

void CameraStream::takeMask(ImageMessage mask) {
  masks_.push_back(std::move(mask));
  if (masks_.size() > kMaxMasks) masks_.pop_front();
}

PendingView CameraStream::newPanorama(const ImageMessage& image, double max_image_size, Recorder& into) {
  PendingView view;
  const cv::Size size = inspectSize(image, params_.kind, view);
  if (faces_.empty() || size != cv::Size(intrinsics_.width, intrinsics_.height)) {
    faces_.clear();
    intrinsics_.width = size.width;
    intrinsics_.height = size.height;
    info_error_.outcome = Outcome::kSizeMismatch;
    try {
      checkPanorama(size);
      checkSize(max_image_size);
    } catch (const Invalid& error) {
      throw Refused{info_error_.outcome, error.what()};
    }
    for (PanoramaFace& face : panoramaFaces(size.width)) {
      const std::uint32_t id = into.setCamera(name_ + '_' + face.name, face.intrinsics);
      if (!mask_.empty()) into.setMask(id, cutMask(mask_, face));
      faces_.push_back({std::move(face), id});
    }
  }
  view.id = faces_.front().id;
  view.intrinsics = intrinsics_;
  view.faces = faces_;
  return view;
}

PendingView CameraStream::newView(const ImageMessage& image, double max_image_size, Recorder& into) {
  if (params_.isPanorama()) return newPanorama(image, max_image_size, into);
  if (!info_) throw NotYet{{Outcome::kNoCameraInfo, "no camera_info has come"}};
  if (!id_) throw info_error_;
  PendingView view;
  view.id = *id_;
  view.intrinsics = intrinsics_;
  return view;
}

bool CameraStream::isRecorded(PendingView& view, Recorder& recorder) {
  if (resumed_at_ && view.stamp <= *resumed_at_) last_kept_.reset();
  resumed_at_.reset();
  const auto is_known = [&](std::uint32_t id) { return recorder.recognizeView(id, view.stamp); };
  if (view.faces.empty()) {
    if (!is_known(view.id)) return false;
  } else {
    const auto known = std::remove_if(view.faces.begin(), view.faces.end(),
                                      [&](const PendingFace& face) { return is_known(face.id); });
    view.faces.erase(known, view.faces.end());
    if (!view.faces.empty()) return false;
  }
  last_kept_ = view.map_from_camera;
  return true;
}

bool CameraStream::isKeyframe(const Eigen::Isometry3d& pose, const RecordParams& record) const {
  if (!last_kept_) return true;
  const Eigen::Isometry3d moved = last_kept_->inverse() * pose;
  const double angle = Eigen::AngleAxisd(moved.linear()).angle() * 180 / M_PI;
  return moved.translation().norm() >= record.keyframe_distance || angle >= record.keyframe_angle;
}

void CameraStream::resumeAt(const Eigen::Isometry3d& pose, double stamp) {
  last_kept_ = pose;
  resumed_at_ = std::max(stamp, resumed_at_.value_or(stamp));
}

void CameraStream::inspect(const ImageMessage& image, PendingView& view, const Say& say) {
  const cv::Size size = inspectSize(image, params_.kind, view);
  if (size != cv::Size(intrinsics_.width, intrinsics_.height)) {
    std::ostringstream text;
    text << "the image is " << size.width << " x " << size.height << ", its camera_info says " << intrinsics_.width
         << " x " << intrinsics_.height;
    throw Refused{Outcome::kSizeMismatch, text.str()};
  }
  if (params_.masks) view.mask = maskOf(image);
  if (params_.kind != ImageKind::kColor) return;
  if (image.raw ? isWide(*image.raw) : view.is_decoded) view.bits = bitsOfCamera(image, say);
}

void CameraStream::dropMasksBefore(ros::Time stamp) {
  masks_.erase(
      std::remove_if(masks_.begin(), masks_.end(), [&](const ImageMessage& mask) { return mask.header.stamp < stamp; }),
      masks_.end());
}

cv::Mat1b CameraStream::maskOf(const ImageMessage& image) const {
  const ros::Time stamp = image.header.stamp;
  const auto found =
      std::find_if(masks_.begin(), masks_.end(), [&](const ImageMessage& mask) { return mask.header.stamp == stamp; });
  if (found == masks_.end()) {
    const Refused missing = {Outcome::kNoMask, "no mask with the stamp of the image has come"};
    if (masks_.empty()) throw NotYet{missing};
    throw missing;  // a later one is there
  }
  cv::Mat mask = decode(*found);
  if (mask.channels() == 3) cv::cvtColor(mask, mask, cv::COLOR_BGR2GRAY);
  try {
    return fittedMask(mask != 0, {intrinsics_.width, intrinsics_.height});
  } catch (const Invalid& error) {
    throw Refused{Outcome::kNoMask, error.what()};
  }
}

/// Cameras of 10, 12 and 14 bits come in 16, where nothing says how many are filled.
int CameraStream::bitsOfCamera(const ImageMessage& image, const Say& say) {
  if (params_.bits != 0) return params_.bits;
  const cv::Mat pixels = decode(image);
  if (pixels.depth() != CV_16U) return 16;
  const int bits = bitsOf(pixels);
  if (bits <= bits_) return bits_;
  if (bits_ != 0) {
    say(LogLevel::kWarning, "bits",
        "an image has more than the " + std::to_string(bits_) +
            " bits of those before it, which are now too bright; record again with " + name_ +
            "/bits=" + std::to_string(bits));
  } else {
    say(LogLevel::kInfo, "bits",
        "of 16 bits a channel, the first image fills " + std::to_string(bits) +
            ", which is taken as full scale; else set " + name_ + "/bits");
  }
  return bits_ = bits;
}

}  // namespace cloud_colorizer
