// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// 20,000 messages of which something was changed, always the same ones, through the conversions, the collector and a
/// bag: each is kept or counted, nothing is thrown, and what is kept can be read. Meant for the sanitizers as well.

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <random>

#include "cloud_colorizer/ros/bag_source.hpp"
#include "cloud_colorizer/ros/collector.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "core/scratch.hpp"
#include "ros/small_bag.hpp"

namespace cloud_colorizer {
namespace {

using sensor_msgs::CameraInfo;
using sensor_msgs::CompressedImage;
using sensor_msgs::Image;
using sensor_msgs::PointCloud2;
using tf2_msgs::TFMessage;

constexpr double kMaxImageSize = 0.005;  // Mpx: 64 x 48 px fit, 128 x 96 px do not
constexpr double kStart = 1000;          // s

/// Changes messages. Numbers become those at which arithmetic ends.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::size_t below(std::size_t end) { return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_); }
  bool chance(double share) { return std::uniform_real_distribution<double>(0, 1)(random_) < share; }
  template <class T>
  const T& oneOf(const std::vector<T>& values) {
    return values[below(values.size())];
  }

  template <class T>
  void integer(T& value) {
    constexpr T kMost = std::numeric_limits<T>::max();
    value = oneOf<T>({0, 1, kMost, kMost - 1, kMost / 2, kMost / 2 + 1, static_cast<T>(value + 1),
                      static_cast<T>(value - 1), static_cast<T>(value * 2), static_cast<T>(random_())});
  }
  void real(double& value) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    value = oneOf<double>({0, -0.0, 1, -1, 1e308, -1e308, 1e-308, 1e10, kInf, -kInf, std::nan(""), value * 1.001});
  }
  void text(std::string& value) {
    value = oneOf<std::string>({"",
                                "/",
                                "map",
                                "lidar",
                                "camera_0",
                                "/camera_1",
                                "x",
                                "rgb8",
                                "mono16",
                                "bayer_rggb16",
                                "yuv422",
                                "nv12",
                                "nv21",
                                "nv24",
                                "8UC999999",
                                "32FC1",
                                "16UC3",
                                "plumb_bob",
                                "equidistant",
                                "rational_polynomial",
                                std::string("a\0b", 3),
                                std::string(9000, 'y')});
  }
  void bytes(std::vector<std::uint8_t>& data) {
    for (std::size_t i = below(8); i > 0 && !data.empty(); --i)
      integer(data[below(std::min<std::size_t>(data.size(), chance(0.5) ? 64 : 100000))]);
    if (chance(0.3)) data.resize(below(data.size() + 9));
  }
  void stamp(ros::Time& value) {
    integer(chance(0.8) ? value.sec : value.nsec);
    if (chance(0.2)) value.nsec = 999999999;
  }
  void header(std_msgs::Header& header) { chance(0.6) ? stamp(header.stamp) : text(header.frame_id); }

  void mutate(PointCloud2& m) {
    const std::size_t what = below(9);
    if (what == 0) header(m.header);
    if (what == 1) integer(m.width);
    if (what == 2) integer(m.height);
    if (what == 3) integer(m.point_step);
    if (what == 4) integer(m.row_step);
    if (what == 5) bytes(m.data);
    if (what == 6) m.is_bigendian = static_cast<std::uint8_t>(below(3));
    if (what == 7 && !m.fields.empty()) field(m.fields[below(m.fields.size())]);
    if (what == 8) {
      for (std::size_t i = below(50); i > 0 && !m.fields.empty(); --i) {
        m.fields.push_back(oneOf(m.fields));
        m.fields.back().name += std::to_string(i);
      }
      if (chance(0.3)) m.fields.resize(below(m.fields.size() + 1));
    }
  }
  void mutate(Image& m) {
    const std::size_t what = below(7);
    if (what == 0) header(m.header);
    if (what == 1) integer(m.width);
    if (what == 2) integer(m.height);
    if (what == 3) integer(m.step);
    if (what == 4) bytes(m.data);
    if (what == 5) m.is_bigendian = static_cast<std::uint8_t>(below(3));
    if (what == 6) text(m.encoding);
  }
  void mutate(CompressedImage& m) {
    if (chance(0.2)) return header(m.header);
    bytes(m.data);
  }
  void mutate(CameraInfo& m) {
    const std::size_t what = below(9);
    if (what == 0) header(m.header);
    if (what == 1) integer(chance(0.5) ? m.width : m.height);
    if (what == 2) m.D.resize(below(20), 0.1);
    if (what == 3 && !m.D.empty()) real(m.D[below(m.D.size())]);
    if (what == 4) real(m.K[below(m.K.size())]);
    if (what == 5) real(m.P[below(m.P.size())]);
    if (what == 6) text(m.distortion_model);
    if (what == 7) integer(chance(0.5) ? m.binning_x : m.binning_y);
    if (what == 8) integer(*oneOf<std::uint32_t*>({&m.roi.x_offset, &m.roi.y_offset, &m.roi.width, &m.roi.height}));
  }
  void mutate(TFMessage& m) {
    for (auto& transform : m.transforms) {
      auto& [translation, rotation] = transform.transform;
      const std::size_t what = below(4);
      if (what == 0) header(transform.header);
      if (what == 1) text(transform.child_frame_id);
      if (what == 2) real(*oneOf<double*>({&translation.x, &translation.y, &translation.z}));
      if (what == 3) real(*oneOf<double*>({&rotation.x, &rotation.y, &rotation.z, &rotation.w}));
    }
  }

 private:
  void field(sensor_msgs::PointField& f) {
    const std::size_t what = below(4);
    if (what == 0) text(f.name);
    if (what == 1) integer(f.offset);
    if (what == 2) integer(f.datatype);
    if (what == 3) integer(f.count);
  }

  std::mt19937 random_;
};

// ---- the conversions ----

template <class Body>
void expectRefusedOrDone(const Body& body) {
  try {
    body();
  } catch (const std::invalid_argument& error) {
    EXPECT_STRNE(error.what(), "");
  }
}

void convert(const PointCloud2& message) {
  expectRefusedOrDone([&] {
    const Cloud cloud = cloudFromMessage(message);
    const std::uint64_t num_points = std::uint64_t{message.width} * message.height;
    ASSERT_EQ(static_cast<std::uint64_t>(cloud.positions.cols()), num_points);
    EXPECT_LE(num_points * message.point_step, message.data.size());
    EXPECT_LE(cloud.records.size(), message.data.size());
    EXPECT_EQ(cloud.records.size(), num_points * recordSize(cloud.fields));
  });
}

std::uint64_t bytesOfPixel(const std::string& encoding) {
  try {
    return sensor_msgs::image_encodings::numChannels(encoding) * sensor_msgs::image_encodings::bitDepth(encoding) / 8;
  } catch (const std::runtime_error&) {
    return 1;  // of a newer driver
  }
}

void convert(const Image& message) {
  expectRefusedOrDone([&] {
    const cv::Mat image = imageFromMessage(message);
    ASSERT_TRUE(image.type() == CV_8UC1 || image.type() == CV_16UC1 || image.type() == CV_8UC3) << message.encoding;
    EXPECT_GE(message.step, message.width * bytesOfPixel(message.encoding));
    EXPECT_GE(message.data.size(),
              std::uint64_t{message.step} * (message.height - 1) + message.width * bytesOfPixel(message.encoding));
    EXPECT_EQ(static_cast<std::uint32_t>(image.cols), message.width);
    EXPECT_GE(static_cast<std::uint32_t>(image.rows), message.height);
    std::size_t sum = 0;
    for (int i = 0; i < image.rows; ++i)
      sum = std::accumulate(image.ptr(i), image.ptr(i) + image.cols * static_cast<int>(image.elemSize()), sum);
    EXPECT_LE(sum, image.total() * image.elemSize() * 255);
  });
}

void convert(const CompressedImage& message) {
  expectRefusedOrDone([&] {
    const EncodedInfo info = inspectCompressed(message);
    EXPECT_TRUE(info.size.width > 0 && info.size.height > 0);
  });
}

void convert(const CameraInfo& message) {
  for (const bool rectified : {false, true}) {
    expectRefusedOrDone([&] {
      const Camera camera(cameraFromMessage(message, rectified).intrinsics);
      camera.project({0.1F, 0.2F, 1});
      camera.bearing({10, 20});
    });
  }
}

void convert(const TFMessage&) {}

// ---- a drive that never ends ----

/// One of the messages of a drive, at the given time; some images are larger than is allowed.
class Drive {
 public:
  Drive() { large_.width = 128, large_.height = 96; }

  PointCloud2 cloud(double time) {
    auto message =
        testing_ros::PointWriter().field("x", 7).field("y", 7).field("z", 7).field("t", 8).field("ring", 4).done(6, 3);
    return stamped(message, time, "lidar");
  }
  Image image(double time, int camera, bool large) { return stamped(of(large).rawImage(0, camera), time, camera); }
  CompressedImage compressed(double time, int camera, bool large, const std::string& format) {
    return stamped(testing_ros::encoded(of(large).picture(camera), format), time, camera);
  }
  CameraInfo info(double time, int camera, bool large) {
    return stamped(of(large).cameraInfo(0, camera), time, camera);
  }
  static TFMessage pose(double time) { return testing_ros::transformMessage("map", "lidar", time, time - kStart); }

 private:
  const testing_ros::SmallDrive& of(bool large) const { return large ? large_ : small_; }
  template <class Message>
  static Message stamped(Message message, double time, const std::string& frame) {
    message.header.stamp.fromSec(time);
    message.header.frame_id = frame;
    return message;
  }
  template <class Message>
  static Message stamped(const Message& message, double time, int camera) {
    return stamped(message, time, "camera_" + std::to_string(camera));
  }

  testing_ros::SmallDrive small_, large_;
};

/// Calls give(topic, message) for `count` messages that were changed, among others that were not.
template <class Give>
void giveMutated(unsigned seed, int count, const Give& give) {
  Mutator mutator(seed);
  int left = count;
  Drive drive;
  int i = 0;
  while (left > 0) {
    const double time = kStart + 0.02 * i;
    const auto change = [&](const std::string& topic, auto message) {
      // Mostly one thing, or the first mistake would hide the others.
      if (mutator.chance(0.75)) {
        do mutator.mutate(message);
        while (mutator.chance(0.2));
        --left;
      }
      convert(message);
      give(topic, message, time);
    };
    const int camera = static_cast<int>(mutator.below(2));
    const std::string name = "/camera_" + std::to_string(camera);
    const bool large = mutator.chance(0.1);
    const std::size_t kind = mutator.below(20);  // camera_info costs the most
    if (kind < 5) {
      change("/tf", Drive::pose(time));
    } else if (kind < 10) {
      change("/points", drive.cloud(time - 0.2));
    } else if (kind < 14) {
      change("/camera_1/image", drive.image(time - 0.2, 1, large));
    } else if (kind < 18) {
      change("/camera_0/image/compressed", drive.compressed(time - 0.2, 0, large, mutator.chance(0.5) ? "png" : "jpg"));
    } else {
      change(name + "/camera_info", drive.info(time - 0.2, camera, large));
    }
    if (i % 5 == 0) give("/tf", Drive::pose(time), time);
    if (i % 20 == 0) give(name + "/camera_info", drive.info(time, camera, false), time);
    ++i;
  }
}

class FuzzTest : public testing::Test {
 protected:
  FuzzTest() {
    params_.cameras.resize(2);
    params_.cameras[0].time_offset = -0.01;
    params_.cameras[1].mask = scratch_ / "mask.png";
    params_.max_image_size = kMaxImageSize;
    params_.record.min_range = 0;
    params_.record.max_range = 1000;
    params_.record.keyframe_distance = 0.1;
    cv::imwrite(params_.cameras[1].mask, cv::Mat1b(48, 64, 255));
  }

  static void expectAllCounted(const CollectorStats& stats) {
    std::vector<StreamStats> streams = stats.cameras;
    streams.push_back(stats.cloud);
    for (const StreamStats& stream : streams) {
      EXPECT_EQ(std::accumulate(stream.outcomes.begin(), stream.outcomes.end(), std::size_t{0}), stream.received);
      EXPECT_GT(stream.count(Outcome::kKept), 5U) << stats.describe();
      EXPECT_GT(stream.count(Outcome::kBadStamp), 0U) << stats.describe();
    }
  }

  void expectReadable() const {
    const Recording recording = Recording::open(scratch_ / "recording");
    EXPECT_TRUE(recording.origin().allFinite());
    for (std::size_t i = 0; i < recording.tiles().size(); ++i) EXPECT_TRUE(recording.readPoints(i).allFinite());
    for (const RecordedCamera& camera : recording.cameras()) {
      EXPECT_LE(1e-6 * camera.intrinsics.width * camera.intrinsics.height, kMaxImageSize);
    }
    for (const View& view : recording.views()) {
      EXPECT_TRUE(view.map_from_camera.matrix().allFinite());
      EXPECT_NEAR(view.map_from_camera.linear().determinant(), 1, 1e-6);
    }
  }

  ScratchDirectory scratch_;
  CollectorParams params_;
};

TEST_F(FuzzTest, CollectorCountsEveryMessageAndThrowsNothing) {
  Recorder recorder(scratch_ / "recording", "map", params_.record);
  Collector collector(recorder, params_, {});
  collector.addTransforms(testing_ros::SmallDrive::fixedFrames(), true);
  struct {
    Collector& to;
    void operator()(const PointCloud2& m) { to.addCloud(boost::make_shared<PointCloud2>(m)); }
    void operator()(const TFMessage& m) { to.addTransforms(m, false); }
    void operator()(const CameraInfo& m) { to.addCameraInfo(camera, boost::make_shared<CameraInfo>(m)); }
    void operator()(const Image& m) { to.addImage(camera, boost::make_shared<Image>(m)); }
    void operator()(const CompressedImage& m) { to.addImage(camera, boost::make_shared<CompressedImage>(m)); }
    std::size_t camera = 0;
  } add{collector};
  giveMutated(1, 17000, [&](const std::string& topic, const auto& message, double) {
    add.camera = topic.rfind("/camera_1", 0) == 0 ? 1 : 0;
    ASSERT_NO_THROW(add(message)) << topic;
    ASSERT_NO_THROW(collector.process()) << topic;
  });
  ASSERT_NO_THROW(collector.finish());
  recorder.flush();
  EXPECT_GT(collector.stats().bad_transforms, 1U);
  EXPECT_GT(collector.stats().cameras[0].count(Outcome::kTooLarge), 1U);
  expectAllCounted(collector.stats());
  expectReadable();
}

TEST_F(FuzzTest, BagIsReadToItsEnd) {
  const std::string file = scratch_ / "bad.bag";
  Mutator mutator(3);
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    bag.write("/tf_static", ros::Time(kStart), testing_ros::SmallDrive::fixedFrames());
    giveMutated(2, 3000, [&](const std::string& topic, const auto& message, double time) {
      ros::Time received(time);
      if (mutator.chance(0.02)) mutator.integer(received.sec);
      bag.write(topic, std::max(received, ros::TIME_MIN), message);
    });
  }
  BagSource source({file});
  Recorder recorder(scratch_ / "recording", "map", params_.record);
  Collector collector(recorder, params_, {});
  ASSERT_NO_THROW(source.play(guessRig(source.topics()), 2, collector, {}));
  recorder.flush();
  expectAllCounted(collector.stats());
  expectReadable();
}

TEST_F(FuzzTest, DamagedMasksAreReadOrNamed) {
  const std::string whole = readText(params_.cameras[1].mask);
  Recorder recorder(scratch_ / "recording", "map", params_.record);
  Mutator mutator(4);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> bytes(whole.begin(), whole.end());
    mutator.bytes(bytes);
    writeText(params_.cameras[1].mask, {bytes.begin(), bytes.end()});
    try {
      Collector collector(recorder, params_, {});
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(params_.cameras[1].mask), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace cloud_colorizer
