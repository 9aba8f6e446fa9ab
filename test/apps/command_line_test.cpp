// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

#include "apps/command_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

#include "cloud_colorizer/base/check.hpp"

namespace cloud_colorizer {
namespace {

CommandSpec exampleSpec() {
  CommandSpec spec;
  spec.program = "colorize_bag";
  spec.summary = "Colours.";
  spec.positionals = "A.bag [B.bag ...]";
  spec.min_positionals = 1;
  spec.max_positionals = 2;
  spec.options = {{"output", "FILE", "the map", true}, {"config", "FILE", "the rig", false}, {"force", "", "", false}};
  return spec;
}

CommandLine parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "program");
  return parseCommandLine(static_cast<int>(arguments.size()), arguments.data(), exampleSpec());
}

int run(std::vector<const char*> arguments, const std::function<void(const CommandLine&, const Callbacks&)>& body) {
  arguments.insert(arguments.begin(), "program");
  return runMain(static_cast<int>(arguments.size()), arguments.data(), exampleSpec(), body);
}

std::string errorOf(const std::vector<const char*>& arguments) {
  try {
    parse(arguments);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(CommandLine, OptionsPositionalsAndParametersInAnyOrder) {
  const CommandLine line =
      parse({"voxel_size=0.2", "--output", "m.ply", "a.bag", "--config=r.yaml", "b.bag", "--force"});
  EXPECT_EQ(line.positionals, (std::vector<std::string>{"a.bag", "b.bag"}));
  EXPECT_EQ(line.option("output"), "m.ply");
  EXPECT_EQ(line.option("config"), "r.yaml");
  EXPECT_TRUE(line.has("force"));
  EXPECT_EQ(line.params.record.voxel_size, 0.2);
}

TEST(CommandLine, FileNameWithEqualSignIsGivenAsPath) {
  EXPECT_EQ(parse({"--output", "m.ply", "./a=b.bag"}).positionals[0], "./a=b.bag");
  EXPECT_EQ(parse({"--output", "m.ply", "--", "a=b.bag"}).positionals[0], "a=b.bag");
}

TEST(CommandLine, MistakesAreNamed) {
  EXPECT_NE(errorOf({"a.bag"}).find("--output"), std::string::npos);
  EXPECT_NE(errorOf({"a.bag", "--output"}).find("needs a value"), std::string::npos);
  EXPECT_NE(errorOf({"a.bag", "--output", "m.ply", "--colour"}).find("--colour"), std::string::npos);
  EXPECT_NE(errorOf({"--output", "m.ply"}).find("A.bag"), std::string::npos);
  EXPECT_NE(errorOf({"a", "b", "c", "--output", "m.ply"}).find("unexpected"), std::string::npos);
  EXPECT_NE(errorOf({"a", "--output", "m.ply", "voxel_sice=1"}).find("voxel_size"), std::string::npos);
  EXPECT_NE(errorOf({"a", "--output", "m.ply", "voxel_size=-1"}).find("voxel_size"), std::string::npos);
  EXPECT_NE(errorOf({"a", "--output", "m.ply", "--output", "n.ply"}).find("twice"), std::string::npos);
}

TEST(CommandLine, HelpListsEveryParameterAndNeedsNoOtherArgument) {
  EXPECT_TRUE(parse({"--help"}).help);
  const std::string help = helpText(exampleSpec());
  for (const ParamText& param : describeParams(Params{})) EXPECT_NE(help.find(param.name + "="), std::string::npos);
}

TEST(CommandLine, HelpShowsTheMainParametersBeforeTheOthers) {
  std::vector<std::string> main;
  Params params;
  visitMainParams(params, [&](const char* name, const auto&, const char*) { main.emplace_back(name); });
  EXPECT_EQ(main.size(), static_cast<std::size_t>(kNumMainParams));
  const std::string help = helpText(exampleSpec());
  const std::size_t further = help.find("Further parameters");
  ASSERT_NE(further, std::string::npos);
  for (const ParamText& param : describeParams(Params{})) {
    const bool is_main = std::find(main.begin(), main.end(), param.name) != main.end();
    EXPECT_EQ(help.find("\n  " + param.name + "=") < further, is_main) << param.name;
  }
}

TEST(CommandLine, OptionsAreReadAsValues) {
  CommandLine line;
  line.options = {{"size", "960x540"}, {"eye", "1,-2.5,inf"}, {"every", "8"}, {"bad", "8m"}};
  EXPECT_EQ(line.list<int>("size", "", 'x', 2), (std::vector<int>{960, 540}));
  EXPECT_EQ(line.list<double>("eye", "", ',', 3)[1], -2.5);
  EXPECT_EQ(line.list<double>("target", "1,2", ',', 0), (std::vector<double>{1, 2}));
  EXPECT_EQ(line.value("every", 3), 8);
  EXPECT_EQ(line.value("missing", 3.5), 3.5);
  EXPECT_THROW(line.value("bad", 1.0), UsageError);
  EXPECT_THROW(line.list<double>("eye", "", ',', 2), UsageError);
}

TEST(CommandLine, VersionNeedsNoOtherArgument) {
  EXPECT_TRUE(parse({"--version"}).version);
  EXPECT_EQ(run({"--version"}, [](auto&, auto&) { FAIL(); }), 0);
}

TEST(CommandLine, ExitCodes) {
  const auto nothing = [](const CommandLine&, const Callbacks&) {};
  EXPECT_EQ(run({"a", "--output", "m.ply"}, nothing), 0);
  EXPECT_EQ(run({"a"}, nothing), 2);
  EXPECT_EQ(run({"a", "--output", "m.ply"}, [](auto&, auto&) { throw std::runtime_error("broken"); }), 1);
  EXPECT_EQ(run({"a", "--output", "m.ply"}, [](auto&, auto&) { throw Cancelled(); }), 130);
}

TEST(CommandLine, ProgressTellsShareRateAndTimeLeft) {
  Progress progress;
  progress.stage = "colour";
  progress.done = 9;
  progress.total = 20;
  progress.points_per_second = 210000;
  progress.seconds_left = 11.2;
  EXPECT_EQ(describeProgress(progress), "colour 45 % (9 of 20), 210000 points/s, 12 s left");
  EXPECT_EQ(describeProgress(progress, true),
            "colour [#########-----------] 45 % (9 of 20), 210000 points/s, 12 s left");
}

TEST(CommandLine, CtrlCAsksTheTaskToStop) {  // last: the flag stays set
  EXPECT_EQ(run({"a", "--output", "m.ply"},
                [](const CommandLine&, const Callbacks& callbacks) {
                  EXPECT_FALSE(callbacks.cancelled());
                  std::raise(SIGINT);
                  if (callbacks.cancelled()) throw Cancelled();
                }),
            130);
}

}  // namespace
}  // namespace cloud_colorizer
