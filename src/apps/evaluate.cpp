// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// evaluate tables|ablations|heldout|score|visibility|visible|city ...: the paper's tables, and scores of any result.
#include <cstdio>
#include <map>
#include <string>

#include "apps/command_line.hpp"
#include "apps/evaluate_commands.hpp"

namespace {

const char* const kHelp =
    "usage: evaluate COMMAND ...\n"
    "\n"
    "  tables      the paper's tables 1 and 2 and figure 4\n"
    "  ablations   what matters: one parameter at a time\n"
    "  heldout     scores a recording by the images that were left out\n"
    "  score       compares two coloured clouds\n"
    "  visibility  scores a map of the simulated street against the true line of sight\n"
    "  visible     what a camera certainly saw: the share that got a colour\n"
    "  city        scores a map of `simulate city` of any size\n"
    "  appearance  how well sheen is told from colours, on a ball whose colours and sheen are known\n"
    "\n"
    "`evaluate COMMAND --help` tells more. Exit codes: 0 done, 1 failed, 2 bad command line.\n";

}  // namespace

int main(int argc, char** argv) {
  using namespace cloud_colorizer;
  const std::map<std::string, int (*)(int, char**)> commands = {
#ifdef CLOUD_COLORIZER_ROS
      {"visible", runVisible},
#endif
      {"tables", runTables},         {"ablations", runAblations}, {"heldout", runHeldout},      {"score", runScore},
      {"visibility", runVisibility}, {"city", runCity},           {"appearance", runAppearance}};
  const std::string command = argc > 1 ? argv[1] : "";
  if (command == "--help" || command == "-h") {
    std::fputs(kHelp, stdout);
    return 0;
  }
  if (command == "--version") {
    std::puts(versionText());
    return 0;
  }
  const auto found = commands.find(command);
  if (found == commands.end()) {
    std::fprintf(stderr, "evaluate: %s '%s'\n%s", command.empty() ? "no command" : "unknown command", command.c_str(),
                 kHelp);
    return 2;
  }
  return found->second(argc - 1, argv + 1);
}
