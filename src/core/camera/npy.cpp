// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "camera/npy.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <regex>
#include <string>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

constexpr std::array<std::uint8_t, 6> kMagic{0x93, 'N', 'U', 'M', 'P', 'Y'};
constexpr std::size_t kPreamble = 10;  // magic, version, length of the text in 2 bytes
constexpr std::size_t kAlignment = 64;

struct Header {
  std::string text;
  std::size_t data = 0;  ///< where the numbers begin
};

/// Version 1 has 2 bytes for the length of its text, the later ones 4.
Header headerOf(const std::vector<std::uint8_t>& bytes) {
  require(isNpy(bytes) && bytes.size() > kPreamble + 2, "it is no .npy file");
  const std::size_t digits = bytes[6] == 1 ? 2 : 4, begin = 8 + digits;
  std::size_t length = 0;
  for (std::size_t i = 0; i < digits; ++i) length |= std::size_t{bytes[8 + i]} << 8 * i;
  require(length <= bytes.size() - begin, "the .npy file is cut off in its header");
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(begin);
  return {std::string(first, first + static_cast<std::ptrdiff_t>(length)), begin + length};
}

std::string headerValue(const Header& header, const std::string& key, const std::string& pattern) {
  std::smatch match;
  require(std::regex_search(header.text, match, std::regex("'" + key + "'\\s*:\\s*" + pattern)),
          "the .npy file does not tell its ", key, " as numpy writes it");
  return match[1];
}

int depthOf(const std::string& type) {
  if (type == "|u1" || type == "u1") return CV_8U;
  if (type == "<u2") return CV_16U;
  if (type == "<f2") return CV_16F;
  require(type == "<f4", "the .npy file holds ", type, "; only |u1, <u2, <f2 and <f4 are read: use astype('float32')");
  return CV_32F;
}

std::vector<int> shapeOf(const Header& header) {
  const std::string text = headerValue(header, "shape", "\\(([0-9, ]*)\\)");
  std::vector<int> shape;
  const std::regex number("[0-9]+");
  for (std::sregex_iterator it(text.begin(), text.end(), number), end; it != end; ++it) {
    const std::string digits = it->str();
    require(digits.size() < 8, "the .npy file has a side of ", digits);
    shape.push_back(std::stoi(digits));
  }
  require(shape.size() == 2 || shape.size() == 3, "the .npy file has ", shape.size(),
          " dimensions, not rows x columns or rows x columns x channels");
  if (shape.size() == 2) shape.push_back(1);
  require(*std::min_element(shape.begin(), shape.end()) > 0 && shape[2] <= CV_CN_MAX, "the .npy file has the shape (",
          text, "), not rows x columns x channels, of which there may be ", CV_CN_MAX);
  return shape;
}

}  // namespace

bool isNpy(const std::vector<std::uint8_t>& bytes) {
  return bytes.size() > kPreamble && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

cv::Mat matOfNpy(const std::vector<std::uint8_t>& bytes) {
  const Header header = headerOf(bytes);
  require(headerValue(header, "fortran_order", "(True|False)") == "False",
          "the .npy file is in Fortran's order; use numpy.ascontiguousarray");
  const int depth = depthOf(headerValue(header, "descr", "'([^']*)'"));
  const std::vector<int> shape = shapeOf(header);
  const int type = CV_MAKETYPE(depth, shape[2]);
  const std::uint64_t size = static_cast<std::uint64_t>(CV_ELEM_SIZE(type)) * static_cast<std::uint64_t>(shape[0]) *
                             static_cast<std::uint64_t>(shape[1]);
  require(bytes.size() - header.data == size, "the .npy file has ", bytes.size() - header.data,
          " bytes of numbers, but its shape needs ", size);
  cv::Mat image(shape[0], shape[1], type);
  std::memcpy(image.data, bytes.data() + header.data, static_cast<std::size_t>(size));
  if (depth == CV_16F) image.convertTo(image, CV_32F);
  return image;
}

std::vector<std::uint8_t> npyOf(const cv::Mat& image) {
  const char* const type = image.depth() == CV_8U ? "|u1" : image.depth() == CV_16U ? "<u2" : "<f4";
  require<std::invalid_argument>(image.depth() == CV_8U || image.depth() == CV_16U || image.depth() == CV_32F,
                                 "an image of type ", image.type(), " has no .npy form here");
  std::string text = std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (" +
                     std::to_string(image.rows) + ", " + std::to_string(image.cols) + ", " +
                     std::to_string(image.channels()) + "), }";
  while ((kPreamble + text.size() + 1) % kAlignment != 0) text += ' ';
  text += '\n';
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  const std::size_t size = whole.total() * whole.elemSize();
  std::vector<std::uint8_t> bytes(kPreamble + text.size() + size);
  std::copy(kMagic.begin(), kMagic.end(), bytes.begin());
  bytes[6] = 1;  // version 1.0
  bytes[8] = static_cast<std::uint8_t>(text.size() & 0xFFU);
  bytes[9] = static_cast<std::uint8_t>(text.size() >> 8U);
  std::memcpy(bytes.data() + kPreamble, text.data(), text.size());
  std::memcpy(bytes.data() + kPreamble + text.size(), whole.data, size);
  return bytes;
}

}  // namespace cloud_colorizer
