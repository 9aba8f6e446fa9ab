// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud/crs.hpp"
#include "cloud/las.hpp"
#include "cloud/pcd.hpp"
#include "cloud/ply.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {

namespace {

/// Rounded to kilometres, as recordings have their origins.
Eigen::Vector3d lasOffset(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return Eigen::Vector3d::Zero();
  return (box.center() / 1000).array().round() * 1000;
}

}  // namespace

struct CloudWriter::Impl {
  std::string path;
  std::vector<Field> fields;
  std::size_t num_points = 0, num_written = 0;
  PackedFormat format;
  std::optional<LasFormat> las;
  AtomicFile file;
  std::vector<std::uint8_t> block;

  Impl(const std::string& file_path, std::size_t count, const std::vector<Field>& cloud_fields, bool as_double,
       const Eigen::AlignedBox3d& box, const std::string& crs)
      : path((checkPath(file_path), file_path)),
        fields((checkFields(cloud_fields), cloud_fields)),
        num_points(count),
        format(extension() == ".ply" ? plyFormat(fields, as_double) : wholeRecords(fields, as_double)),
        file(path) {
    const std::filesystem::path whole(path);
    removeAbandonedFiles(whole.has_parent_path() ? whole.parent_path().string() : ".", whole.filename().string() + '.');
    if (extension() == ".las") {
      require<std::invalid_argument>(count == 0 || !box.isEmpty(), path, " needs the box around its points");
      las.emplace(fields, count, box, lasOffset(box), crs.empty() || isWellKnownText(crs) ? crs : wellKnownText(crs));
    }
    const std::string header = las                     ? las->header()
                               : extension() == ".ply" ? plyHeader(fields, as_double, count)
                                                       : pcdHeader(fields, as_double, count);
    file.append(header.data(), header.size());
  }
  std::string extension() const { return lowerExtension(path); }
  std::size_t pointSize() const { return las ? las->pointSize() : format.pointSize(); }
  void pack(const Cloud& cloud, std::size_t first, std::size_t count) {
    block.resize(count * pointSize());
    if (las) {
      las->pack(cloud, first, count, block.data());
    } else {
      format.pack(cloud, first, count, block.data());
    }
  }
};

CloudWriter::CloudWriter(const std::string& path, std::size_t num_points, const std::vector<Field>& fields,
                         bool double_positions, const Eigen::AlignedBox3d& box, const std::string& crs)
    : impl_(std::make_unique<Impl>(path, num_points, fields, double_positions, box, crs)) {}
CloudWriter::~CloudWriter() = default;

void CloudWriter::write(const Cloud& cloud) {
  constexpr std::size_t kBlockPoints = 8192;
  auto& impl = *impl_;
  checkCloud(cloud);
  require<std::invalid_argument>(cloud.fields == impl.fields, "the fields of a cloud differ from those of ", impl.path);
  const auto num_points = static_cast<std::size_t>(cloud.positions.cols());
  require<std::invalid_argument>(num_points <= impl.num_points - impl.num_written, impl.path, " was opened for ",
                                 impl.num_points, " points, and there are more");
  for (std::size_t first = 0; first < num_points; first += kBlockPoints) {
    const auto count = std::min(kBlockPoints, num_points - first);
    impl.pack(cloud, first, count);
    impl.file.append(impl.block.data(), impl.block.size());
  }
  impl.num_written += num_points;
}

void CloudWriter::finish() {
  require<std::invalid_argument>(impl_->num_written == impl_->num_points, impl_->path, " was opened for ",
                                 impl_->num_points, " points, but ", impl_->num_written, " were written");
  impl_->file.commit(true);
}

void CloudWriter::checkPath(const std::string& path) {
  const auto extension = lowerExtension(path);
  require(extension == ".ply" || extension == ".pcd" || extension == ".las", "cannot write ", path,
          ": its extension must be .ply, .pcd or .las");
  auto directory = std::filesystem::path(path).parent_path();
  if (directory.empty()) directory = ".";
  require(std::filesystem::is_directory(directory), "cannot write ", path, ": there is no directory ",
          directory.string(), "; create it first");
  require(!std::filesystem::is_directory(path), "cannot write ", path, ": it is a directory");
  const bool is_writable = ::access(directory.c_str(), W_OK) == 0;
  require(is_writable, "cannot write ", path, ": ", std::generic_category().message(errno));
}

}  // namespace cloud_colorizer
