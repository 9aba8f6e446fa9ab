// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pcl/io/lzf.h>

#include <algorithm>
#include <filesystem>

#include "base/text.hpp"
#include "cloud/las.hpp"
#include "cloud/pcd.hpp"
#include "cloud/ply.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {

namespace {

Eigen::Vector3d readOrigin(const std::string& path) {
  if (!std::filesystem::exists(path)) return Eigen::Vector3d::Zero();
  BlockReader input(path);
  std::string line;
  input.readLine(line);
  const auto words = splitWords(line);
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  bool is_good = words.size() == 3;
  for (std::size_t i = 0; i < 3 && is_good; ++i) is_good = parseDouble(words[i], origin[static_cast<int>(i)]);
  require(is_good && origin.allFinite(), path, ": this is no origin `x y z` of the cloud beside it");
  return origin;
}

CloudHeader readHeader(BlockReader& input) {
  const auto extension = lowerExtension(input.path());
  require(extension != ".laz", "cannot read ", input.path(), ", which is compressed", remedyOfLaz(input.path()));
  require(extension == ".ply" || extension == ".pcd" || extension == ".las", "cannot read ", input.path(),
          ": its extension must be .ply, .pcd or .las");
  if (extension == ".las") return readLasHeader(input);
  if (extension == ".ply") return readPlyHeader(input);
  CloudHeader header = readPcdHeader(input);
  header.map_from_points.pretranslate(readOrigin(originFile(input.path())));
  return header;
}

/// All columns of a binary_compressed PCD.
std::vector<std::uint8_t> readCompressed(BlockReader& input, std::uint64_t expected_size) {
  std::uint32_t sizes[2];
  input.read(sizes, sizeof sizes);
  require(sizes[1] == expected_size, input.path(), " is damaged: it announces ", sizes[1],
          " bytes of points, but its "
          "header ",
          expected_size);
  require(sizes[0] <= input.remaining(), input.path(), " is truncated: it needs ", sizes[0],
          " bytes of points, but only ", input.remaining(), " are there");
  // LZF packs no more than 264 bytes into three.
  require(sizes[1] / 88 <= sizes[0], input.path(), " is damaged: ", sizes[0], " packed bytes cannot hold its ",
          sizes[1], " bytes of points");
  std::vector<std::uint8_t> packed(sizes[0]), columns(sizes[1]);
  input.read(packed.data(), packed.size());
  const auto size = packed.empty() ? 0 : pcl::lzfDecompress(packed.data(), sizes[0], columns.data(), sizes[1]);
  if (size != sizes[1] && sizes[0] == sizes[1]) return packed;  // what does not shrink is stored as it is
  require(size == sizes[1], input.path(), " is damaged: its points cannot be decompressed");
  return columns;
}

}  // namespace

std::string originFile(const std::string& pcd) {
  return std::filesystem::path(pcd).replace_extension(".origin.txt").string();
}

struct CloudReader::Impl {
  BlockReader input;
  CloudHeader header;
  CloudLayout layout;
  std::vector<std::uint8_t> columns;  ///< of a compressed file
  std::vector<std::uint8_t> raw;
  std::uint64_t num_read = 0;

  explicit Impl(const std::string& path)
      : input(path), header(readHeader(input)), layout(CloudLayout::ofFile(header, path)) {
    const bool is_text = header.encoding == Encoding::kAscii;
    // A number and its separator are two bytes at least.
    const auto min_size = is_text ? 2 * layout.numValues() : layout.stride();
    if (header.encoding == Encoding::kCompressed) {
      require(header.num_points <= 0xFFFFFFFF / min_size, path, ": a compressed PCD cannot hold ", header.num_points,
              " points");
      if (header.num_points > 0) columns = readCompressed(input, header.num_points * layout.stride());
      return;
    }
    const auto available = (input.remaining() + (is_text ? 1 : 0)) / min_size;
    require(header.num_points <= available, path, " is truncated: its header announces ", header.num_points,
            " points of ", min_size, " bytes", is_text ? " at least" : "", ", but there are only ", input.remaining(),
            " bytes after the header");
  }

  void readLines(std::size_t num_points) {
    std::string line;
    for (std::size_t i = 0; i < num_points; ++i) {
      do {
        require(input.readLine(line), input.path(), " is truncated: it ends after ", num_read + i, " of ",
                header.num_points, " points");
      } while (line.find_first_not_of(" \t") == std::string::npos);
      if (!header.lists.empty()) line = withoutLists(line);
      const auto error = layout.parseLine(line.c_str(), raw.data() + i * layout.stride());
      require(error.empty(), input.path(), ": the line of point ", num_read + i, " (`", line.substr(0, 80),
              "`): ", error);
    }
  }

  /// The words of a line that are not in a list.
  std::string withoutLists(const std::string& line) const {
    const auto words = splitWords(line);
    std::string kept;
    std::size_t at = 0;
    auto list = header.lists.begin();
    for (std::size_t field = 0; field <= header.fields.size(); ++field) {
      for (; list != header.lists.end() && list->before == field; ++list) {
        long long length = 0;
        if (at < words.size()) parseInteger(words[at], length);
        at += 1 + static_cast<std::size_t>(std::clamp(length, 0LL, 1LL << 30U));
      }
      if (field < header.fields.size() && at < words.size()) kept += words[at++] + ' ';
    }
    for (; at < words.size(); ++at) kept += words[at] + ' ';
    return kept;
  }

  /// Points with lists between their fields lie one after the other at no fixed distance.
  void readBetweenLists(std::size_t num_points) {
    for (std::size_t i = 0; i < num_points; ++i) {
      std::uint8_t* target = raw.data() + i * layout.stride();
      auto list = header.lists.begin();
      for (std::size_t field = 0; field <= header.fields.size(); ++field) {
        for (; list != header.lists.end() && list->before == field; ++list) {
          const std::uint64_t length = readListLength(input, list->length_type, header.encoding);
          require(length <= input.remaining() / list->item_size, input.path(), " is truncated or damaged: a list of ",
                  length, " items begins shortly before its end");
          input.skip(length * list->item_size);
        }
        if (field == header.fields.size()) break;
        const auto size = sizeOf(header.fields[field].field.type) * header.fields[field].field.count;
        input.read(target, size);
        target += size;
      }
    }
  }

  void readBlock(std::size_t num_points) {
    raw.resize(num_points * layout.stride());
    if (header.encoding == Encoding::kAscii) {
      readLines(num_points);
    } else if (header.encoding == Encoding::kCompressed) {
      layout.gather(columns.data(), header.num_points, num_read, num_points, raw.data());
    } else if (!header.lists.empty()) {
      readBetweenLists(num_points);
    } else {
      input.read(raw.data(), raw.size());
    }
  }
};

CloudReader::CloudReader(const std::string& path) : impl_(std::make_unique<Impl>(path)) {}
CloudReader::~CloudReader() = default;
std::size_t CloudReader::numPoints() const {
  return impl_->header.num_points;
}
const std::vector<Field>& CloudReader::fields() const {
  return impl_->layout.fields();
}
const std::string& CloudReader::crs() const {
  return impl_->header.crs;
}

Cloud CloudReader::read(std::size_t max_points) {
  auto& impl = *impl_;
  const auto num_points = std::min<std::size_t>(max_points, impl.header.num_points - impl.num_read);
  const auto block_points = impl.layout.pointsPerBlock();
  Cloud cloud;
  cloud.fields = impl.layout.fields();
  cloud.positions.resize(3, static_cast<Eigen::Index>(num_points));
  cloud.records.resize(num_points * recordSize(cloud.fields));
  for (std::size_t first = 0; first < num_points; first += block_points) {
    const auto count = std::min(block_points, num_points - first);
    impl.readBlock(count);
    impl.layout.decode(impl.raw.data(), count, cloud, first);
    impl.num_read += count;
  }
  const Eigen::Affine3d& map_from_points = impl.header.map_from_points;
  if (!map_from_points.matrix().isIdentity(0)) cloud.positions = map_from_points * cloud.positions;
  return cloud;
}

}  // namespace cloud_colorizer
