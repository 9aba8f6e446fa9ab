// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud/pcd.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {

namespace {

/// A run of bytes of our record that goes into the file's.
struct Run {
  std::size_t from, to, size;
};

struct FileFormat {
  std::string header;
  std::vector<Run> runs;
  std::size_t record_size = 0;  ///< in the file, without the position
};

bool isPackedColor(const Field& field) {
  return field.name == "rgb" && field.count == 1 &&
         (field.type == FieldType::kFloat32 || field.type == FieldType::kUint32);
}

/// Properties of a PLY after x, y, z. Arrays become name_0, name_1, ...; rgb becomes red, green, blue, and fields that
/// have these names already get the prefix "input_".
std::vector<Field> plyFields(const std::vector<Field>& fields) {
  const bool has_color = std::any_of(fields.begin(), fields.end(), isPackedColor);
  std::vector<Field> result;
  for (const auto& field : fields) {
    const bool clashes = has_color && (field.name == "red" || field.name == "green" || field.name == "blue");
    if (isPackedColor(field)) {
      for (const char* name : {"red", "green", "blue"}) result.push_back({name, FieldType::kUint8});
    } else if (field.count == 1) {
      result.push_back({(clashes ? "input_" : "") + field.name, field.type});
    } else {
      for (std::uint32_t i = 0; i < field.count; ++i) {
        result.push_back({field.name + '_' + std::to_string(i), field.type});
      }
    }
  }
  checkFields(result);
  return result;
}

FileFormat plyFormat(const std::vector<Field>& fields, bool double_positions, std::size_t num_points) {
  constexpr std::array<const char*, 8> kTypes{"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
  FileFormat format;
  format.header = "ply\nformat binary_little_endian 1.0\ncomment cloud_colorizer\nelement vertex " +
                  std::to_string(num_points) + '\n';
  for (const char* axis : {"x", "y", "z"}) {
    format.header += std::string("property ") + (double_positions ? "double " : "float ") + axis + '\n';
  }
  for (const auto& field : plyFields(fields)) {
    format.header +=
        std::string("property ") + kTypes[static_cast<std::size_t>(field.type) - 1] + ' ' + field.name + '\n';
  }
  format.header += "end_header\n";
  std::size_t from = 0;
  for (const auto& field : fields) {
    const auto size = sizeOf(field.type) * field.count;
    auto& to = format.record_size;
    if (isPackedColor(field)) {  // 0x00RRGGBB, little endian
      for (const std::size_t byte : {2, 1, 0}) format.runs.push_back({from + byte, to++, 1});
    } else {
      format.runs.push_back({from, to, size});
      to += size;
    }
    from += size;
  }
  return format;
}

FileFormat pcdFormat(const std::vector<Field>& fields, bool double_positions, std::size_t num_points) {
  const auto size = recordSize(fields);
  return {pcdHeader(fields, double_positions, num_points), {{0, 0, size}}, size};
}

}  // namespace

struct CloudWriter::Impl {
  std::vector<Field> fields;
  std::size_t num_points = 0, num_written = 0;
  bool double_positions = false;
  FileFormat format;
  AtomicFile file;
  std::string path;
  std::vector<std::uint8_t> block;

  Impl(const std::string& file_path, std::size_t count, const std::vector<Field>& cloud_fields, bool as_double)
      : fields(cloud_fields),
        num_points(count),
        double_positions(as_double),
        format((checkPath(file_path), checkFields(fields), lowerExtension(file_path)) == ".ply"
                   ? plyFormat(fields, as_double, count)
                   : pcdFormat(fields, as_double, count)),
        file(file_path),
        path(file_path) {
    file.append(format.header.data(), format.header.size());
  }

  /// Positions and records of points [first, first + count), packed into `block`.
  void pack(const Cloud& cloud, std::size_t first, std::size_t count) {
    const auto source_size = recordSize(fields);
    const auto position_size = 3 * (double_positions ? sizeof(double) : sizeof(float));
    block.resize(count * (position_size + format.record_size));
    auto* target = block.data();
    const auto* record = cloud.records.data() + first * source_size;
    for (std::size_t i = 0; i < count; ++i, record += source_size) {
      const Eigen::Vector3d position = cloud.positions.col(static_cast<Eigen::Index>(first + i));
      const Eigen::Vector3f rounded = position.cast<float>();
      if (double_positions) {
        std::memcpy(target, position.data(), position_size);
      } else {
        std::memcpy(target, rounded.data(), position_size);
      }
      target += position_size;
      for (const auto& run : format.runs) std::memcpy(target + run.to, record + run.from, run.size);
      target += format.record_size;
    }
  }
};

CloudWriter::CloudWriter(const std::string& path, std::size_t num_points, const std::vector<Field>& fields,
                         bool double_positions)
    : impl_(std::make_unique<Impl>(path, num_points, fields, double_positions)) {}
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
    impl.pack(cloud, first, std::min(kBlockPoints, num_points - first));
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
  require(extension == ".ply" || extension == ".pcd", "cannot write ", path, ": its extension must be .ply or .pcd");
  auto directory = std::filesystem::path(path).parent_path();
  if (directory.empty()) directory = ".";
  require(std::filesystem::is_directory(directory), "cannot write ", path, ": there is no directory ",
          directory.string(), "; create it first");
  require(!std::filesystem::is_directory(path), "cannot write ", path, ": it is a directory");
  require(::access(directory.c_str(), W_OK) == 0, "cannot write ", path, ": ", std::generic_category().message(errno));
}

}  // namespace cloud_colorizer
