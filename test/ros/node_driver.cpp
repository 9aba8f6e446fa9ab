// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Drives colorizer_node over a real roscore: messages in, services, maps out, signals.

#include <cloud_colorizer/ColorizeStatus.h>
#include <cloud_colorizer/SaveMap.h>
#include <diagnostic_msgs/DiagnosticArray.h>
#include <gtest/gtest.h>
#include <nav_msgs/Path.h>
#include <ros/ros.h>
#include <signal.h>
#include <std_srvs/Trigger.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <topic_tools/shape_shifter.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "cloud_colorizer/cloud/cloud_io.hpp"
#include "cloud_colorizer/recording/recorder.hpp"
#include "cloud_colorizer/ros/bag_source.hpp"
#include "cloud_colorizer/ros/conversions.hpp"
#include "cloud_colorizer/ros/params.hpp"
#include "ros/livox_messages.hpp"
#include "ros/small_bag.hpp"

namespace cloud_colorizer {
namespace {

using Args = std::vector<std::string>;
using testing_ros::SmallDrive;

std::string nodeProgram() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "colorizer_node";
}

/// A colorizer_node as a child process; its output goes to a file.
class NodeProcess {
 public:
  NodeProcess(const Args& args, const std::string& log) : log_(log) {
    pid_ = fork();
    if (pid_ != 0) return;
    std::vector<std::string> all = {nodeProgram(), "__name:=colorizer"};
    all.insert(all.end(), args.begin(), args.end());
    std::vector<char*> argv;
    for (std::string& arg : all) argv.push_back(arg.data());
    argv.push_back(nullptr);
    if (freopen(log.c_str(), "a", stdout) == nullptr || dup2(STDOUT_FILENO, STDERR_FILENO) < 0) _exit(126);
    setenv("ROSCONSOLE_STDOUT_LINE_BUFFERED", "1", 1);  // or the log is a buffer behind
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~NodeProcess() {
    if (pid_ > 0) stop(SIGKILL);
  }

  int stop(int signal_number) {
    kill(pid_, signal_number);
    return wait();
  }
  int wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  void sendSignal(int signal_number) const { kill(pid_, signal_number); }

  std::string log() const {
    std::ifstream file(log_);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

 private:
  pid_t pid_;
  std::string log_;
};

/// Waits up to `seconds` until `condition` holds.
bool waitFor(const std::function<bool()>& condition, double seconds = 60) {
  for (int i = 0; i < seconds / 0.02; ++i) {
    if (condition()) return true;
    ros::spinOnce();
    ros::WallDuration(0.02).sleep();
  }
  return condition();
}

class NodeTest : public testing::Test {
 protected:
  NodeTest() {
    char name[] = "/tmp/node_test_XXXXXX";
    directory_ = mkdtemp(name);
    cloud_ = node_.advertise<sensor_msgs::PointCloud2>("cloud_in", 10);
    tf_ = node_.advertise<tf2_msgs::TFMessage>("/tf", 100);
    static_tf_ = node_.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
    static_tf_.publish(SmallDrive::fixedFrames());
    status_ = node_.subscribe("colorizer/status", 10, &NodeTest::onStatus, this);
  }
  ~NodeTest() override {
    process_.reset();
    ros::param::del("/colorizer");  // else the next node would find them
    std::filesystem::remove_all(directory_);
  }

  void onStatus(const ColorizeStatus& status) {
    last_status_ = status;
    stages_.insert(status.stage);
  }

  /// Both cameras with images of one kind.
  void startNode(bool compressed, Args args = {}) {
    compressed_ = compressed;
    for (int i = 0; i < 2; ++i) {
      const std::string camera = "camera_" + std::to_string(i);
      info_[i] = node_.advertise<sensor_msgs::CameraInfo>(camera + "/camera_info", 10);
      image_[i] = compressed ? node_.advertise<sensor_msgs::CompressedImage>(camera + "/image/compressed", 10)
                             : node_.advertise<sensor_msgs::Image>(camera + "/image", 10);
    }
    args.insert(args.begin(),
                {"_num_cameras:=2", std::string("_image_transport:=") + (compressed ? "compressed" : "raw"),
                 "_recording_dir:=" + directory_ + "/recording", "_voxel_size:=0.08"});
    process_ = std::make_unique<NodeProcess>(args, directory_ + "/log");
    ASSERT_TRUE(waitFor([this] { return connected(); })) << process_->log();
  }

  bool connected() {
    return cloud_.getNumSubscribers() > 0 && tf_.getNumSubscribers() > 0 && static_tf_.getNumSubscribers() > 0 &&
           image_[0].getNumSubscribers() > 0 && image_[1].getNumSubscribers() > 0 && info_[0].getNumSubscribers() > 0 &&
           info_[1].getNumSubscribers() > 0 && ros::service::exists("colorizer/colorize", false);
  }

  void publishFrame(std::size_t i, bool tf_last = false) {
    if (!tf_last) tf_.publish(drive_.pose(i));
    cloud_.publish(drive_.cloud(i));
    for (int camera = 0; camera < 2; ++camera) {
      info_[camera].publish(drive_.cameraInfo(i, camera));
      if (compressed_) {
        auto image = testing_ros::encoded(drive_.picture(camera), "jpg");
        image.header = drive_.cameraInfo(i, camera).header;
        image_[camera].publish(image);
      } else {
        image_[camera].publish(drive_.rawImage(i, camera));
      }
    }
    if (!tf_last) return;
    ros::WallDuration(0.05).sleep();
    tf_.publish(drive_.pose(i));
  }

  void publishDrive(bool tf_last = false) {
    for (std::size_t i = 0; i < drive_.num_frames; ++i) {
      publishFrame(i, tf_last);
      ros::WallDuration(0.02).sleep();
    }
  }

  bool waitForViews(std::size_t views) {
    return waitFor([&] { return last_status_.views >= views; });
  }

  std_srvs::Trigger::Response call(const std::string& name) {
    std_srvs::Trigger trigger;
    EXPECT_TRUE(ros::service::call("colorizer/" + name, trigger)) << process_->log();
    return trigger.response;
  }
  SaveMap::Response save(const std::string& path, bool overwrite = false) {
    SaveMap map;
    map.request.path = path;
    map.request.overwrite = overwrite;
    EXPECT_TRUE(ros::service::call("colorizer/save_map", map)) << process_->log();
    return map.response;
  }

  /// Walls must have the colours of the pictures: red at y = 4, blue at y = -4.
  static void expectColouredWalls(const Cloud& cloud) {
    const auto colors = findField(cloud.fields, "rgb");
    ASSERT_TRUE(colors);
    const std::size_t record = recordSize(cloud.fields);
    std::size_t red = 0, blue = 0, wrong = 0;
    for (Eigen::Index i = 0; i < cloud.positions.cols(); ++i) {
      std::uint32_t rgb;
      std::memcpy(&rgb, &cloud.records[static_cast<std::size_t>(i) * record + colors->offset], 4);
      const int r = rgb >> 16U & 255U, b = rgb & 255U;
      if (std::abs(r - b) < 50) continue;  // not seen
      const bool is_red = cloud.positions(1, i) > 0;
      ++(is_red == (r > b) ? (is_red ? red : blue) : wrong);
    }
    EXPECT_GT(red, 500U);
    EXPECT_GT(blue, 500U);
    EXPECT_EQ(wrong, 0U);
  }

  SmallDrive drive_;
  std::string directory_;
  bool compressed_ = false;
  ros::NodeHandle node_;
  ros::Publisher cloud_, tf_, static_tf_, info_[2], image_[2];
  ros::Subscriber status_;
  ColorizeStatus last_status_;
  std::set<std::string> stages_;
  std::unique_ptr<NodeProcess> process_;
};

TEST_F(NodeTest, RawImagesColourPublishAndSave) {
  startNode(false);
  sensor_msgs::PointCloud2ConstPtr map, preview;
  nav_msgs::PathConstPtr path;
  const auto map_subscriber =
      node_.subscribe<sensor_msgs::PointCloud2>("colored_map", 1, [&](const auto& m) { map = m; });
  const auto preview_subscriber =
      node_.subscribe<sensor_msgs::PointCloud2>("colored_map_preview", 1, [&](const auto& m) { preview = m; });
  const auto path_subscriber = node_.subscribe<nav_msgs::Path>("camera_path", 1, [&](const auto& m) { path = m; });
  publishDrive();
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  EXPECT_TRUE(waitFor([&] { return preview && path && path->poses.size() == drive_.num_frames; }));

  const auto response = call("colorize");
  ASSERT_TRUE(response.success) << response.message << process_->log();
  ASSERT_TRUE(waitFor([&] { return map != nullptr; }));
  EXPECT_EQ(map->header.frame_id, "map");
  std::vector<std::string> names;
  for (const auto& field : map->fields) names.push_back(field.name);
  EXPECT_EQ(names, (Args{"x", "y", "z", "intensity", "rgb", "view_count", "color_stddev", "moving"}));
  expectColouredWalls(cloudFromMessage(*map));
  EXPECT_TRUE(waitFor([&] { return last_status_.colored_points > 1000; }));

  for (const std::string name : {"map.ply", "map.pcd"}) {
    const auto saved = save(directory_ + "/" + name);
    EXPECT_TRUE(saved.success) << saved.message;
    EXPECT_EQ(CloudReader(directory_ + "/" + name).numPoints(), map->width);
  }
  const auto missing = save(directory_ + "/no/such/place.ply");
  EXPECT_FALSE(missing.success);
  EXPECT_NE(missing.message.find("no/such"), std::string::npos) << missing.message;
  const auto unknown = save(directory_ + "/map.e57");
  EXPECT_FALSE(unknown.success);
  EXPECT_NE(unknown.message.find("las"), std::string::npos) << unknown.message;
  EXPECT_EQ(process_->stop(SIGINT), 0) << process_->log();
}

TEST_F(NodeTest, CloudsOfLivoxDriversAreRecorded) {
  cloud_.shutdown();
  topic_tools::ShapeShifter livox;
  livox.morph("e4d6829bdfe657cb6c21a746c86b21a6", "livox_ros_driver2/CustomMsg", "Header header\n", "");
  cloud_ = livox.advertise(node_, "cloud_in", 10);
  startNode(false);
  for (std::size_t i = 0; i < drive_.num_frames; ++i) {
    tf_.publish(drive_.pose(i));
    const sensor_msgs::PointCloud2 cloud = drive_.cloud(i);
    auto bytes = testing_ros::livoxMessage(cloud.header, cloudFromMessage(cloud).positions);
    ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    livox.read(stream);
    cloud_.publish(livox);
    ros::WallDuration(0.02).sleep();
  }
  EXPECT_TRUE(waitFor([&] { return last_status_.points > 1000; })) << process_->log();
}

/// A bag replayed by rosbag through the node gives the recording that the collector makes of the bag directly.
TEST_F(NodeTest, ReplayedBagGivesTheRecordingOfTheBag) {
  for (ros::Publisher* publisher : {&cloud_, &tf_, &static_tf_}) publisher->shutdown();
  const std::string bag = directory_ + "/drive.bag";
  drive_.period = 0.5;
  drive_.write(bag);
  BagSource source({bag});
  const AllParams params = paramsFromText({{"num_cameras", "2"}, {"voxel_size", "0.08"}});
  Recorder recorder(directory_ + "/direct", "map", params.core.record);
  Collector collector(recorder, params.node.collector, {});
  source.play(guessRig(source.topics()), 2, collector, {});
  const Recording direct = recorder.snapshot();
  ASSERT_EQ(direct.views().size(), 2 * drive_.num_frames);

  process_ = std::make_unique<NodeProcess>(
      Args{"_num_cameras:=2", "_camera_0/image_transport:=compressed", "_voxel_size:=0.08",
           "_recording_dir:=" + directory_ + "/recording", "cloud_in:=/points"},
      directory_ + "/log");
  ASSERT_TRUE(waitFor([] { return ros::service::exists("colorizer/colorize", false); })) << process_->log();
  ASSERT_EQ(std::system(("rosbag play --quiet --delay 1 --clock --rate 2 " + bag + " > /dev/null").c_str()), 0);
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  EXPECT_EQ(process_->stop(SIGINT), 0);
  const Recording replayed = Recording::open(directory_ + "/recording");
  ASSERT_EQ(replayed.numPoints(), direct.numPoints());
  ASSERT_EQ(replayed.tiles().size(), direct.tiles().size());
  for (std::size_t tile = 0; tile < direct.tiles().size(); ++tile) {
    EXPECT_EQ(replayed.readPoints(tile), direct.readPoints(tile));
  }
  EXPECT_EQ(process_->log().find("WARN"), std::string::npos) << process_->log();
}

TEST_F(NodeTest, SavingColoursWhatIsNewFirst) {
  startNode(true);
  for (std::size_t i = 0; i < 4; ++i) publishFrame(i);
  ASSERT_TRUE(waitForViews(8)) << process_->log();
  ASSERT_TRUE(save("map.ply").success) << process_->log();
  for (std::size_t i = 4; i < drive_.num_frames; ++i) publishFrame(i);
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  ASSERT_TRUE(save("map.ply").success) << process_->log();
  const Recording recording = Recording::open(directory_ + "/recording");
  EXPECT_EQ(CloudReader(directory_ + "/map.ply").numPoints(), recording.numPoints());
}

TEST_F(NodeTest, FilesOfOthersAreReplacedOnlyWhenAskedAndOnlyInTheSaveDirectory) {
  startNode(true);
  publishDrive();
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  std::ofstream(directory_ + "/other.ply") << "dear";
  EXPECT_FALSE(save("other.ply").success);
  EXPECT_EQ(std::filesystem::file_size(directory_ + "/other.ply"), 4U);
  const auto replaced = save("other.ply", true), own_by_now = save("other.ply");
  EXPECT_TRUE(replaced.success) << replaced.message;
  EXPECT_TRUE(own_by_now.success) << own_by_now.message;
  const auto outside = save("/tmp/node_test_outside.ply");
  EXPECT_FALSE(outside.success);
  EXPECT_NE(outside.message.find("~save_dir"), std::string::npos) << outside.message;
  EXPECT_FALSE(std::filesystem::exists("/tmp/node_test_outside.ply"));
  // As README and demo call it: the field that is left out is false.
  EXPECT_EQ(std::system(("rosservice call /colorizer/save_map \"path: '" + directory_ +
                         "/called.ply'\" | grep -q 'success: True'")
                            .c_str()),
            0);
}

TEST_F(NodeTest, ResetWhileImagesAreEncodedLosesNothing) {
  drive_.width = 960;
  drive_.height = 720;
  drive_.noisy = true;
  startNode(false, {"_raw_image_format:=png"});
  publishDrive();
  ASSERT_TRUE(waitForViews(1)) << process_->log();
  const auto reset = call("reset");
  ASSERT_TRUE(reset.success) << reset.message;
  for (std::size_t i = drive_.num_frames; i < drive_.num_frames + 8; ++i) publishFrame(i);
  ASSERT_TRUE(waitForViews(2 * 8)) << process_->log();
  const auto response = call("colorize");
  EXPECT_TRUE(response.success) << response.message;
  const Recording fresh = Recording::open(directory_ + "/recording");
  for (std::size_t tile = 0; tile < fresh.tiles().size(); ++tile) {
    EXPECT_GT(fresh.readPoints(tile).colwise().norm().minCoeff(), 1.F) << "points that nobody measured";
  }
  EXPECT_EQ(process_->stop(SIGINT), 0) << process_->log();
}

TEST_F(NodeTest, DeletedRecordingIsAnErrorUntilReset) {
  startNode(true);
  for (std::size_t i = 0; i < 4; ++i) publishFrame(i);
  ASSERT_TRUE(waitForViews(8)) << process_->log();
  diagnostic_msgs::DiagnosticStatus diagnostic;
  const auto subscriber = node_.subscribe<diagnostic_msgs::DiagnosticArray>(
      "/diagnostics", 10, [&](const auto& message) { diagnostic = message->status.at(0); });
  std::filesystem::remove_all(directory_ + "/recording");
  ASSERT_TRUE(waitFor([&] { return last_status_.stage == "error"; }));
  EXPECT_NE(last_status_.message.find("deleted"), std::string::npos) << last_status_.message;
  EXPECT_TRUE(waitFor([&] { return diagnostic.level == diagnostic_msgs::DiagnosticStatus::ERROR; }));
  EXPECT_FALSE(call("colorize").success);
  EXPECT_TRUE(call("reset").success);
  publishDrive();
  EXPECT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  EXPECT_TRUE(call("colorize").success);
  std::filesystem::remove_all(directory_ + "/recording");
  EXPECT_EQ(process_->stop(SIGINT), 1) << process_->log();
}

TEST_F(NodeTest, FullDiskIsReportedAndTheMapStays) {
  const std::string small = directory_ + "/small";
  std::filesystem::create_directory(small);
  if (mount("tmpfs", small.c_str(), "tmpfs", 0, "size=16k") != 0) GTEST_SKIP() << "mounting a tmpfs needs root";
  startNode(true);
  publishDrive();
  waitForViews(2 * drive_.num_frames);
  const auto full = save(small + "/map.ply");
  EXPECT_FALSE(full.success);
  EXPECT_NE(full.message.find("space"), std::string::npos) << full.message;
  EXPECT_TRUE(std::filesystem::is_empty(small));
  umount(small.c_str());
  EXPECT_TRUE(save(directory_ + "/map.ply").success);
}

TEST_F(NodeTest, CompressedImagesLateTfAndSaveOnShutdown) {
  startNode(true, {"_save_path:=" + directory_ + "/map.ply"});
  publishDrive(true);
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  EXPECT_EQ(process_->stop(SIGTERM), 0) << process_->log();
  CloudReader reader(directory_ + "/map.ply");
  EXPECT_GT(reader.numPoints(), 1000U);
}

TEST_F(NodeTest, LoopedBagIsRecordedFurther) {
  startNode(true);
  publishDrive();
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  publishDrive();
  EXPECT_TRUE(waitForViews(4 * drive_.num_frames - 4)) << process_->log();
  EXPECT_NE(process_->log().find("time jumped back"), std::string::npos);
}

TEST_F(NodeTest, KilledRecordingIsContinuedAndColoured) {
  startNode(true);
  for (std::size_t i = 0; i < 4; ++i) publishFrame(i);
  ASSERT_TRUE(waitForViews(8)) << process_->log();
  ros::WallDuration(1.2).sleep();  // a crash may lose the last second
  process_->stop(SIGKILL);
  EXPECT_GE(Recording::open(directory_ + "/recording").views().size(), 8U);

  ASSERT_TRUE(waitFor([this] { return cloud_.getNumSubscribers() == 0; }));
  last_status_ = {};
  startNode(true);
  for (std::size_t i = 4; i < drive_.num_frames; ++i) publishFrame(i);
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  const auto response = call("colorize");
  EXPECT_TRUE(response.success) << response.message;
}

TEST_F(NodeTest, ResetKeepsTheOldRecordingAndPauseStopsRecording) {
  startNode(true);
  publishDrive();
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  const auto reset = call("reset");
  EXPECT_TRUE(reset.success) << reset.message;
  ASSERT_TRUE(waitFor([&] { return last_status_.views == 0; }));
  std::size_t kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory_)) {
    if (entry.path().filename().string().rfind("recording.", 0) != 0) continue;
    kept = Recording::open(entry.path()).views().size();
  }
  EXPECT_EQ(kept, 2 * drive_.num_frames);

  EXPECT_TRUE(call("pause").success);
  publishFrame(6);
  ASSERT_TRUE(waitFor([&] { return last_status_.stage == "paused"; }));
  EXPECT_EQ(last_status_.views, 0U);
  EXPECT_TRUE(call("resume").success);
  publishFrame(7);
  EXPECT_TRUE(waitForViews(2)) << process_->log();
}

TEST_F(NodeTest, NothingToColourIsExplained) {
  startNode(true);
  const auto response = call("colorize");
  EXPECT_FALSE(response.success);
  EXPECT_FALSE(response.message.empty());
  EXPECT_TRUE(waitFor([this] { return process_->log().find("no message for 5 s on:") != std::string::npos; }));
  EXPECT_NE(process_->log().find("/camera_1/image/compressed"), std::string::npos);
}

TEST_F(NodeTest, ColouringStartsAfterSilence) {
  startNode(true, {"_colorize_after:=1"});
  publishDrive();
  EXPECT_TRUE(waitFor([&] { return last_status_.colored_points > 1000; })) << process_->log();
}

/// A second name for the raw plugin stands for the plugins that a distribution may have.
TEST_F(NodeTest, NamedTransportIsReadByItsPlugin) {
  std::filesystem::create_directory(directory_ + "/twin");
  std::ofstream(directory_ + "/twin/package.xml")
      << "<package><name>twin</name><version>1.0.0</version><description>a "
         "transport</description><license>BSD</license>"
      << "<maintainer email=\"no@body.invalid\">nobody</maintainer><run_depend>image_transport</run_depend>"
      << "<export><image_transport plugin=\"${prefix}/plugins.xml\"/></export></package>";
  std::ofstream(directory_ + "/twin/plugins.xml")
      << "<library path=\"libimage_transport_plugins\"><class name=\"image_transport/twin_sub\" "
      << "type=\"image_transport::RawSubscriber\" base_class_type=\"image_transport::SubscriberPlugin\"/></library>";
  const char* before = getenv("ROS_PACKAGE_PATH");
  const std::string path = before == nullptr ? "/usr/share" : before;
  setenv("ROS_PACKAGE_PATH", (directory_ + "/twin:" + path).c_str(), 1);
  setenv("ROS_CACHE_TIMEOUT", "0", 1);  // of the list of packages
  startNode(false, {"_camera_0/image_transport:=twin"});
  publishDrive();
  EXPECT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  setenv("ROS_PACKAGE_PATH", path.c_str(), 1);
  unsetenv("ROS_CACHE_TIMEOUT");
}

TEST_F(NodeTest, TransportWithoutAPluginStopsTheStart) {
  NodeProcess process({"_num_cameras:=1", "_image_transport:=sonar"}, directory_ + "/log");
  EXPECT_EQ(process.wait(), 1);
  EXPECT_NE(process.log().find("image_transport = \"sonar\" of camera_0: there are compressed, raw"), std::string::npos)
      << process.log();
}

TEST_F(NodeTest, StatusGoesOnWhileColouringAfterSilence) {
  drive_.num_frames = 60;
  startNode(true, {"_colorize_after:=1", "_voxel_size:=0", "_solver:=spqr", "_num_threads:=1"});
  publishDrive();
  EXPECT_TRUE(waitFor([&] { return last_status_.colored_points > 1000; }, 120)) << process_->log();
  EXPECT_GT(stages_.size(), 2U) << "besides idle and recording, the stages of colouring";
}

TEST_F(NodeTest, StopWhileColouringEndsSoonAndCleanly) {
  drive_.num_frames = 60;
  startNode(true, {"_voxel_size:=0.02", "_num_threads:=1"});
  publishDrive();
  ASSERT_TRUE(waitForViews(2 * drive_.num_frames)) << process_->log();
  std::thread client([] {
    std_srvs::Trigger trigger;
    ros::service::call("colorizer/colorize", trigger);
  });
  EXPECT_TRUE(waitFor([&] { return process_->log().find("points/s") != std::string::npos; })) << process_->log();
  const ros::WallTime before = ros::WallTime::now();
  EXPECT_EQ(process_->stop(SIGINT), 0) << process_->log();
  EXPECT_LT((ros::WallTime::now() - before).toSec(), 10);
  client.join();
  EXPECT_NE(process_->log().find("cancelled"), std::string::npos) << process_->log();
}

TEST_F(NodeTest, UnknownParameterStopsTheStart) {
  NodeProcess process({"_voxel_sise:=0.1"}, directory_ + "/log");
  EXPECT_EQ(process.wait(), 1);
  EXPECT_NE(process.log().find("unknown parameter ~voxel_sise"), std::string::npos) << process.log();
  EXPECT_NE(process.log().find("voxel_size"), std::string::npos);
}

TEST_F(NodeTest, ParameterOutOfRangeStopsTheStart) {
  NodeProcess process({"_voxel_size:=-3"}, directory_ + "/log");
  EXPECT_EQ(process.wait(), 1);
  EXPECT_NE(process.log().find("voxel_size = -3"), std::string::npos) << process.log();
}

TEST_F(NodeTest, SavePathThatCannotBeWrittenStopsTheStart) {
  NodeProcess process({"_save_path:=/no/such/place.ply"}, directory_ + "/log");
  EXPECT_EQ(process.wait(), 1);
  EXPECT_NE(process.log().find("FATAL"), std::string::npos) << process.log();
  EXPECT_NE(process.log().find("/no/such"), std::string::npos) << process.log();
}

}  // namespace
}  // namespace cloud_colorizer

int main(int argc, char** argv) {
  ros::init(argc, argv, "node_driver");
  testing::InitGoogleTest(&argc, argv);
  ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
