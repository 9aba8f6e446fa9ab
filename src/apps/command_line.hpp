// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// What all command line programs share: arguments, --help, --version, progress on the terminal, Ctrl-C, exit codes. No
/// ROS.
///
///   int main(int argc, char** argv) {
///     CommandSpec spec{"colorize", "Colours a recording.", "RECORDING", 1, 1, {{"output", "FILE", "the map", true}}};
///     return runMain(argc, argv, spec, [](const CommandLine& line, const Callbacks& callbacks) {
///       colorize(Recording::open(line.positionals[0]), line.params, callbacks);
///     });
///   }
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/param_text.hpp"
#include "cloud_colorizer/map/params.hpp"

namespace cloud_colorizer {

/// `--name VALUE` or `--name=VALUE`; a flag without a value where `value` is empty.
struct OptionSpec {
  std::string name;   ///< without the dashes
  std::string value;  ///< placeholder in the help, e.g. "FILE"; empty: a flag
  std::string help;
  bool required = false;
};

struct CommandSpec {
  std::string program;
  std::string summary;      ///< one sentence
  std::string positionals;  ///< as the usage line shows them, e.g. "DRIVE.bag [DRIVE2.bag ...]"
  std::size_t min_positionals = 0, max_positionals = 0;
  std::vector<OptionSpec> options;
  Params defaults;                      ///< what a program starts from, where it is not Params{}
  std::vector<ParamText> other_params;  ///< further parameters of this program; they arrive in CommandLine::others
  bool takes_params = true;             ///< `name=value` sets a parameter; the help lists them all
};

/// A command line that is not understood; the message says what and how to get help.
struct UsageError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Nothing, or next to nothing, could be coloured, or not rightly; the message says why and what to do. Exit code 3.
struct NothingColored : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What --fail-if asked about is so. Exit code 4.
struct ConditionHolds : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct CommandLine {
  std::vector<std::string> positionals;
  std::map<std::string, std::string> options;  ///< by name; a given flag is "true"
  Params params;
  std::map<std::string, std::string> others;  ///< given values of other_params, and of all names `camera_<i>/...`
  bool help = false, version = false;
  std::vector<std::string> arguments;  ///< all, as they were given
  bool quiet = false;                  ///< -q: warnings and errors only
  bool verbose = false;                ///< -v: also what each stage took; a report names files with their folders

  bool has(const std::string& name) const { return options.count(name) != 0; }
  std::string option(const std::string& name, const std::string& otherwise = "") const;

  /// An option as a number, a word or what else parseValue() knows. Throws UsageError.
  template <class T>
  T value(const std::string& name, const T& otherwise) const {
    return has(name) ? list<T>(name, "", '\0', 1).front() : otherwise;
  }
  /// Values between separators; `count` of them, or any number where it is 0. Throws UsageError.
  template <class T>
  std::vector<T> list(const std::string& name, const std::string& otherwise, char separator, std::size_t count) const {
    const std::string text = option(name, otherwise);
    try {
      std::vector<T> values = parseList<T>("option --" + name, text, separator);
      require<UsageError>(count == 0 || values.size() == count, "option --", name, " = '", text, "' must be ", count,
                          " values with '", separator, "' between");
      return values;
    } catch (const std::invalid_argument& error) {
      throw UsageError(error.what());
    }
  }
};

/// Throws UsageError: unknown option, missing value or required option, wrong number of positionals, or a parameter
/// that Params refuses. An argument is a parameter where it reads `name=`, so a file like that is given as `./a=b`.
CommandLine parseCommandLine(int argc, const char* const* argv, const CommandSpec& spec);

/// Usage, options, parameters with defaults (those that matter most first), exit codes.
std::string helpText(const CommandSpec& spec);

/// What --version tells.
const char* versionText();

/// One line: "colour 45 % (9 of 20), 210000 points/s, 12 s left"; with a bar, "colour [#########-----------] 45 % ...".
std::string describeProgress(const Progress& progress, bool with_bar = false);

/// Progress and log on stderr (one line with a bar that is rewritten on a terminal; a line every tenth elsewhere);
/// cancelled() after the first SIGINT or SIGTERM. The second signal ends the process at once.
Callbacks terminalCallbacks();

/// Parses, runs `body`, prints what it throws. Returns 0, 1 (failed), 2 (bad command line) or 130 (cancelled).
int runMain(int argc, const char* const* argv, const CommandSpec& spec,
            const std::function<void(const CommandLine&, const Callbacks&)>& body);

}  // namespace cloud_colorizer
