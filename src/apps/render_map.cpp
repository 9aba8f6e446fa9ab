// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// render_map MAP.ply [MAP2.ply ...] --output picture.png: pictures of coloured maps, side by side.
#include <cstring>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "apps/command_line.hpp"
#include "base/file_io.hpp"
#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/picture/picture.hpp"

namespace {

using namespace cloud_colorizer;

constexpr std::size_t kBlock = 500000;  // points

/// "1,2,3" as numbers; throws UsageError.
std::vector<double> parseNumbers(const std::string& option, const std::string& text, std::size_t count,
                                 char separator) {
  std::vector<double> numbers;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, separator);) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (word.empty() || *end != '\0') numbers.clear();
  }
  require<UsageError>(numbers.size() == count, "--", option, " ", text, ": expected ", count, " numbers separated by '",
                      separator, "'");
  return numbers;
}

/// Where the value of a field starts in a record.
std::size_t fieldOffset(const std::string& path, const std::vector<Field>& fields, const std::string& name) {
  std::size_t offset = 0;
  std::string known;
  for (const Field& field : fields) {
    if (field.name == name) return offset;
    offset += sizeOf(field.type) * field.count;
    known += " " + field.name;
  }
  throw std::runtime_error(path + " has no field " + name + "; it has:" + known);
}

/// Colours of a block: a packed rgb, separate red, green and blue, or a number shown on a scale.
class Colorist {
 public:
  Colorist(const std::string& path, const std::vector<Field>& fields, const std::string& name, float high)
      : record_(recordSize(fields)), high_(high) {
    for (const Field& field : fields) separate_ = separate_ || field.name == "red";
    separate_ = separate_ && name == "rgb";
    packed_ = name == "rgb" && !separate_;
    offset_ = fieldOffset(path, fields, separate_ ? "red" : name);
    for (const Field& field : fields) whole_ = whole_ || (field.name == name && field.type == FieldType::kUint16);
  }

  Values operator()(const Cloud& cloud) const {
    const Eigen::Index count = cloud.positions.cols();
    Values colors(3, count);
    Eigen::VectorXf numbers(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const std::uint8_t* value = cloud.records.data() + static_cast<std::size_t>(i) * record_ + offset_;
      if (separate_) {
        colors.col(i) << value[0], value[1], value[2];
      } else if (packed_) {
        colors.col(i) << value[2], value[1], value[0];
      } else {
        numbers[i] = readNumber(value);
      }
    }
    return separate_ || packed_ ? colors : colorScale(numbers, whole_ ? 1.F : 0.F, high_);
  }

 private:
  float readNumber(const std::uint8_t* value) const {
    std::uint16_t whole = 0;
    float number = 0;
    std::memcpy(&whole, value, sizeof(whole));
    if (!whole_) std::memcpy(&number, value, sizeof(number));
    return whole_ ? static_cast<float>(whole) : number;
  }

  std::size_t record_ = 0, offset_ = 0;
  float high_;
  bool separate_ = false, packed_ = false, whole_ = false;
};

ColoredPoints mapSource(const std::string& path, const std::string& field, float high, const Eigen::Vector3d& origin) {
  return [=](const std::function<void(PointsRef, ValuesRef)>& visit) {
    CloudReader reader(path);
    const Colorist colorist(path, reader.fields(), field, high);
    for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
      visit((block.positions.colwise() - origin).cast<float>(), colorist(block));
    }
  };
}

Eigen::AlignedBox3d boundsOf(const std::string& path) {
  CloudReader reader(path);
  Eigen::AlignedBox3d box;
  for (Cloud block = reader.read(kBlock); block.positions.cols() > 0; block = reader.read(kBlock)) {
    box.extend(block.positions.rowwise().minCoeff()).extend(block.positions.rowwise().maxCoeff());
  }
  require(!box.isEmpty(), path, " has no points");
  return box;
}

void render(const CommandLine& line, const Callbacks& callbacks) {
  PictureParams params;
  const auto size = parseNumbers("size", line.option("size", "960x540"), 2, 'x');
  params.width = static_cast<int>(size[0]);
  params.height = static_cast<int>(size[1]);
  params.field_of_view = parseNumbers("fov", line.option("fov", "70"), 1, ',')[0];
  params.point_size = parseNumbers("point-size", line.option("point-size", "0.07"), 1, ',')[0];
  params.check();
  const double high = parseNumbers("high", line.option("high", "20"), 1, ',')[0];

  const Eigen::AlignedBox3d bounds = boundsOf(line.positionals[0]);
  const Eigen::Vector3d origin = bounds.center();
  // Without a place to stand: from above, high enough to see it all.
  const double half_width = 0.5 * std::max(bounds.sizes().x() * params.width / params.height, bounds.sizes().y());
  Eigen::Vector3d target = origin;
  Eigen::Vector3d eye = origin;
  eye.z() = bounds.max().z() + half_width / std::tan(params.field_of_view * M_PI / 360);
  if (line.has("eye")) eye = Eigen::Vector3d(parseNumbers("eye", line.option("eye"), 3, ',').data());
  if (line.has("target")) target = Eigen::Vector3d(parseNumbers("target", line.option("target"), 3, ',').data());

  std::vector<cv::Mat> pictures;
  std::vector<std::string> captions;
  for (const std::string& path : line.positionals) {
    const auto source = mapSource(path, line.option("field", "rgb"), static_cast<float>(high), origin);
    pictures.push_back(drawPicture(source, lookAt(eye - origin, target - origin), params));
    captions.push_back(std::filesystem::path(path).stem().string());
  }
  const cv::Mat picture = pictures.size() == 1 ? pictures[0] : besideEachOther(pictures, captions);
  const std::string output = line.option("output");
  std::vector<std::uint8_t> bytes;
  require(cv::imencode(std::filesystem::path(output).extension().string(), picture, bytes), "cannot encode ", output);
  writeFileAtomically(output, bytes.data(), bytes.size());
  callbacks.log(LogLevel::kInfo, "wrote " + output);
}

}  // namespace

int main(int argc, char** argv) {
  CommandSpec spec;
  spec.program = "render_map";
  spec.summary = "Draws coloured maps (.ply, .pcd) as a picture; several are drawn side by side.";
  spec.positionals = "MAP [MAP2 ...]";
  spec.min_positionals = 1;
  spec.max_positionals = 16;
  spec.takes_params = false;
  spec.options = {{"output", "FILE", "the picture, .png or .jpg", true},
                  {"eye", "X,Y,Z", "m, where to look from; default: above, high enough to see all", false},
                  {"target", "X,Y,Z", "m, where to look to; default: the centre", false},
                  {"fov", "DEG", "horizontal field of view; default 70", false},
                  {"size", "WxH", "px of one picture; default 960x540", false},
                  {"point-size", "M", "diameter of a point; default 0.07", false},
                  {"field", "NAME", "rgb (default), view_count, color_stddev or another field", false},
                  {"high", "X", "value at the bright end of the scale of a field; default 20", false}};
  return runMain(argc, argv, spec, render);
}
