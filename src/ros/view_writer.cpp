// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "ros/view_writer.hpp"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "camera/values.hpp"

namespace cloud_colorizer {
namespace {

cv::Mat opaqueOf(const sensor_msgs::Image& message) {
  return opaquePixels(message);
}
cv::Mat opaqueOf(const sensor_msgs::CompressedImage&) {
  return {};  // what may have alpha is kept as received
}

std::vector<EncodedPixels> valuesOf(const sensor_msgs::Image& message, ImageKind kind, const cv::Mat1b& mask,
                                    const std::string& format) {
  return {{encodeValues(valuesFromMessage(message, kind), format), mask}};
}
std::vector<EncodedPixels> valuesOf(const sensor_msgs::CompressedImage&, ImageKind, const cv::Mat1b&,
                                    const std::string&) {
  return {};  // what shows no colours is kept as received
}

/// BGRA of what is BGR.
cv::Mat withAlpha(const cv::Mat& image, const cv::Mat& opaque) {
  if (opaque.empty()) return image;
  cv::Mat alpha, result;
  opaque.convertTo(alpha, image.depth(), image.depth() == CV_16U ? 257 : 1);
  cv::merge(std::vector<cv::Mat>{image, alpha}, result);
  return result;
}

}  // namespace

ViewWriter::ViewWriter(int num_threads, const std::string& raw_image_format, Kept kept)
    : raw_image_format_(raw_image_format), kept_(std::move(kept)), pool_(num_threads) {}

void ViewWriter::add(PendingView view, const sensor_msgs::ImageConstPtr& raw, Recorder& recorder) {
  view.encoded = encode(raw, view, raw_image_format_);
  views_.push_back(std::move(view));
  writeReady(recorder);
}

void ViewWriter::add(PendingView view, const sensor_msgs::CompressedImageConstPtr& compressed, Recorder& recorder) {
  if (!view.faces.empty()) {
    view.encoded = encode(compressed, view, view.extension);  // with loss only where it has come with loss
  } else if (view.is_decoded) {
    view.encoded = encode(compressed, view, raw_image_format_);
  } else {
    view.bytes = SharedBytes(&compressed->data, [keep = compressed](const void*) {});
  }
  views_.push_back(std::move(view));
  writeReady(recorder);
}

template <class MessagePtr>
std::future<std::vector<EncodedPixels>> ViewWriter::encode(const MessagePtr& message, const PendingView& view,
                                                           const std::string& format) {
  return pool_.run([message, kind = view.kind, bits = view.bits, faces = view.faces, mask = view.mask, format] {
    if (kind != ImageKind::kColor) return valuesOf(*message, kind, mask, format);
    const cv::Mat image = withAlpha(scaledTo16Bits(imageFromMessage(*message), bits), opaqueOf(*message));
    std::vector<EncodedPixels> encoded;
    encoded.reserve(std::max<std::size_t>(1, faces.size()));
    for (const PendingFace& face : faces) {
      encoded.push_back({encodeImage(cutFace(image, face.face), format), cutMask(mask, face.face)});
    }
    if (faces.empty()) encoded.push_back({encodeImage(image, format), mask});
    return encoded;
  });
}

void ViewWriter::write(std::size_t max_left, Recorder& recorder) {
  while (!views_.empty()) {
    const PendingView& front = views_.front();
    const bool ready =
        !front.encoded.valid() || front.encoded.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (!ready && views_.size() <= max_left) return;
    PendingView view = std::move(views_.front());
    views_.pop_front();
    if (!view.encoded.valid()) {
      record(view, recorder);
      continue;
    }
    std::vector<EncodedPixels> encoded = view.encoded.get();
    const Eigen::Isometry3d map_from_panorama = view.map_from_camera;
    for (std::size_t i = 0; i < encoded.size(); ++i) {
      if (!view.faces.empty()) {
        const PanoramaFace& face = view.faces[i].face;
        view.id = view.faces[i].id;
        view.intrinsics = face.intrinsics;
        view.map_from_camera.linear() = map_from_panorama.linear() * face.panorama_from_face;
      }
      view.mask = encoded[i].mask;
      view.extension = encoded[i].image.extension;
      view.bytes = std::make_shared<const std::vector<std::uint8_t>>(std::move(encoded[i].image.bytes));
      record(view, recorder);
    }
  }
}

void ViewWriter::record(const PendingView& view, Recorder& recorder) {
  recorder.addView(view.id, view.stamp, view.map_from_camera, *view.bytes, view.extension, view.mask,
                   view.readout_motion);
  if (kept_) kept_(view);
}

}  // namespace cloud_colorizer
